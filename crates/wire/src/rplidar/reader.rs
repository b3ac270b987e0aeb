//! Reading along on an RPLIDAR's line.

use super::{Answer, Decoder, NODE_LEN, Node, Request, RequestDecoder};
use crate::{Reader, Take, Towards};

/// Reads along in one direction.
pub(crate) fn reader(towards: Towards) -> Box<dyn Reader> {
    match towards {
        Towards::Robot => Box::new(Requests(RequestDecoder::new())),
        Towards::Client => {
            Box::new(Answers { decoder: Decoder::new(), turn: Vec::new(), nearest_m: 0.0 })
        }
    }
}

#[derive(Debug)]
struct Requests(RequestDecoder);

impl Reader for Requests {
    fn push(&mut self, bytes: &[u8], take: Take<'_>) {
        self.0.push(bytes);
        while let Some(request) = self.0.next_request() {
            let mut raw = Vec::new();
            request.encode(&mut raw);
            let text = match request {
                Request::Stop => "STOP".to_owned(),
                Request::Reset => "RESET".to_owned(),
                Request::Scan => "SCAN wanted".to_owned(),
                Request::ForceScan => "SCAN wanted at once".to_owned(),
                Request::Info => "INFO wanted".to_owned(),
                Request::Health => "HEALTH wanted".to_owned(),
                Request::MotorPwm(pwm) => format!("MOTOR {pwm} of 1023"),
                request => format!("{request:?}"),
            };
            take(raw, text);
        }
    }
}

/// Samples are told turn by turn: one line for each of them would be two thousand a second.
#[derive(Debug)]
struct Answers {
    decoder: Decoder,
    turn: Vec<u8>,
    nearest_m: f64,
}

impl Reader for Answers {
    fn push(&mut self, bytes: &[u8], take: Take<'_>) {
        self.decoder.push(bytes);
        while let Some(answer) = self.decoder.next_answer() {
            match answer {
                Answer::Node(node) => self.take_node(node, take),
                Answer::Announced(kind) => {
                    // A new session: only what is asked for now comes.
                    self.turn.clear();
                    take(kind.descriptor().to_vec(), format!("DESCRIPTOR of {kind:?}"));
                }
                Answer::Info(info) => take(info.encode().to_vec(), format!("{info:?}")),
                Answer::Health(health) => take(health.encode().to_vec(), format!("{health:?}")),
                Answer::AdapterFlags(flags) => {
                    take(flags.to_le_bytes().to_vec(), format!("ADAPTER {flags:#010x}"));
                }
                Answer::SampleTimes(times) => take(times.encode().to_vec(), format!("{times:?}")),
            }
        }
    }
}

impl Answers {
    fn take_node(&mut self, node: Node, take: Take<'_>) {
        if node.is_first && !self.turn.is_empty() {
            let n_samples = self.turn.len().checked_div(NODE_LEN).unwrap_or_default();
            let nearest_m = self.nearest_m;
            let text = format!("TURN of {n_samples} samples, the shortest {nearest_m:.2} m");
            take(std::mem::take(&mut self.turn), text);
            self.nearest_m = 0.0;
        }
        let range_m = f64::from(node.distance_q2) / 4000.0;
        if range_m > 0.0 && (self.nearest_m == 0.0 || range_m < self.nearest_m) {
            self.nearest_m = range_m;
        }
        self.turn.extend_from_slice(&node.encode());
    }
}
