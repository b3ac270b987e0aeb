//! Reading along on a SICK's line.

use super::{Decoder, Item, Reply, Request, ScanReply, Side, write_telegram};
use crate::{Reader, Take, Towards};

/// Reads along in one direction.
pub(crate) fn reader(towards: Towards) -> Box<dyn Reader> {
    let side = match towards {
        Towards::Robot => Side::FromHost,
        Towards::Client => Side::FromDevice,
    };
    Box::new(SickReader { decoder: Decoder::new(side), side, n_skipped: 0 })
}

#[derive(Debug)]
struct SickReader {
    decoder: Decoder,
    side: Side,
    n_skipped: u64,
}

impl Reader for SickReader {
    fn push(&mut self, bytes: &[u8], take: Take<'_>) {
        self.decoder.push(bytes);
        while let Some(item) = self.decoder.next_item() {
            match item {
                Item::Ack => take(vec![super::ACK], "ACK".to_owned()),
                Item::Nak => take(vec![super::NAK], "NAK: wrong checksum".to_owned()),
                Item::Telegram { address, payload } => {
                    let mut raw = Vec::new();
                    write_telegram(address, payload, &mut raw);
                    take(raw, describe(self.side, payload));
                }
            }
        }
        let n_skipped = self.decoder.n_bytes_skipped();
        let n_new = n_skipped.saturating_sub(std::mem::replace(&mut self.n_skipped, n_skipped));
        if n_new > 0 {
            take(Vec::new(), format!("{n_new} bytes outside of any telegram"));
        }
    }
}

/// A line of text that says what a telegram means.
fn describe(side: Side, payload: &[u8]) -> String {
    if side == Side::FromHost {
        return match Request::decode(payload) {
            Request::Installation(_) => "INSTALLATION mode".to_owned(),
            Request::Continuous => "SCANS wanted without end".to_owned(),
            Request::OnRequest => "SCANS on request only".to_owned(),
            Request::Baud(baud) => format!("BAUD {} wanted", baud.bits_per_s()),
            Request::OneScan => "one SCAN wanted".to_owned(),
            Request::Type => "TYPE wanted".to_owned(),
            Request::ReadConfig => "CONFIGURATION wanted".to_owned(),
            Request::WriteConfig(_) => "CONFIGURATION to be written".to_owned(),
            request => format!("{request:?}"),
        };
    }
    match Reply::decode(payload) {
        Some((Reply::Scan(scan), _)) => describe_scan(&scan),
        Some((Reply::PowerOn(text) | Reply::Type(text), _)) => {
            // Strings come from strangers: escaped, they stay on their line.
            format!("TYPE {}", text.escape_ascii())
        }
        Some((Reply::Mode(0), _)) => "MODE changed".to_owned(),
        Some((Reply::Mode(_) | Reply::Refused, _)) => "REFUSED".to_owned(),
        Some((Reply::Config(_), _)) => "CONFIGURATION".to_owned(),
        Some((reply, _)) => format!("{reply:?}"),
        None => "an answer that is too short".to_owned(),
    }
}

fn describe_scan(scan: &ScanReply<'_>) -> String {
    let metres = scan.unit.metres();
    let nearest = scan.bits().map(|bits| bits & 0x1FFF).filter(|&bits| bits > 0).min();
    let nearest_m = nearest.map_or(0.0, |bits| f64::from(bits) * metres);
    format!("SCAN of {} readings, the shortest {nearest_m:.2} m", scan.len())
}
