//! A script in place of a hand: a line for each piece of the drive.

use std::{
    fs::File,
    io::{BufRead, BufReader, Read as _},
    sync::mpsc,
    time::Duration,
};

use anyhow::{Context, anyhow, ensure};

/// Longest script, bytes.
const BYTES_MAX: u64 = 1 << 20;
/// How long is waited for a line at a time.
const PATIENCE: Duration = Duration::from_millis(50);
/// Lines that may wait.
const N_WAITING: usize = 64;

/// A piece of the drive.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    /// Where it stands, from 1.
    pub(super) line: usize,
    pub(super) seconds: f64,
    pub(super) speed_mps: f64,
    pub(super) turn_rate_radps: f64,
}

/// What a script says next.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Next {
    Piece(Piece),
    /// Nothing at the moment; whoever waits has waited for a moment.
    Nothing,
    End,
}

/// The pieces, as they come.
pub(super) struct Script {
    pieces: mpsc::Receiver<anyhow::Result<Piece>>,
}

impl Script {
    /// Begins to read a file, or standard input for `-`.
    pub(super) fn open(name: &str) -> anyhow::Result<Self> {
        let (source, shown): (Box<dyn std::io::Read + Send>, String) = match name {
            "-" => (Box::new(std::io::stdin()), "standard input".to_owned()),
            name => {
                let file = File::open(name).with_context(|| format!("{name}: cannot be read"))?;
                let about = file.metadata().with_context(|| format!("{name}: cannot be read"))?;
                ensure!(
                    about.len() <= BYTES_MAX,
                    "{name}: {} bytes are no script of a drive; at most {BYTES_MAX}",
                    about.len()
                );
                (Box::new(file), name.to_owned())
            }
        };
        let (give, pieces) = mpsc::sync_channel(N_WAITING);
        std::thread::Builder::new()
            .name("script".to_owned())
            .spawn(move || {
                // A byte more shows that there is more than that.
                let mut left = BufReader::new(source).take(BYTES_MAX + 1);
                for line in 1.. {
                    let mut text = String::new();
                    let piece = match left.read_line(&mut text) {
                        Ok(0) => break,
                        Ok(_) if left.limit() == 0 => Some(Err(anyhow!(
                            "{shown}:{line}: the script of a drive is at most {BYTES_MAX} bytes: give the rest \
                             to another drive"
                        ))),
                        Ok(_) => piece(&shown, line, &text).transpose(),
                        Err(error) => Some(Err(anyhow!("{shown}:{line}: cannot be read: {error}"))),
                    };
                    let Some(piece) = piece else { continue };
                    let is_wrong = piece.is_err();
                    if give.send(piece).is_err() || is_wrong {
                        break;
                    }
                }
            })
            .context("cannot read the script beside driving")?;
        Ok(Self { pieces })
    }

    /// A script of the command line.
    pub(super) fn of(pieces: &[String]) -> anyhow::Result<Self> {
        let (give, receive) = mpsc::sync_channel(pieces.len());
        for (line, text) in (1..).zip(pieces) {
            let piece = piece("--piece", line, &text.replace(',', " "))?;
            let piece = piece.with_context(|| format!("--piece {line} is empty"))?;
            // There is room for all of them.
            drop(give.send(Ok(piece)));
        }
        Ok(Self { pieces: receive })
    }

    /// What comes next, waited for or not.
    pub(super) fn next(&mut self, waits: bool) -> anyhow::Result<Next> {
        let next = if waits {
            self.pieces.recv_timeout(PATIENCE).map_err(|none| match none {
                mpsc::RecvTimeoutError::Timeout => mpsc::TryRecvError::Empty,
                mpsc::RecvTimeoutError::Disconnected => mpsc::TryRecvError::Disconnected,
            })
        } else {
            self.pieces.try_recv()
        };
        match next {
            Ok(piece) => Ok(Next::Piece(piece?)),
            Err(mpsc::TryRecvError::Empty) => Ok(Next::Nothing),
            Err(mpsc::TryRecvError::Disconnected) => Ok(Next::End),
        }
    }
}

/// Reads a line; `None` for an empty one.
fn piece(shown: &str, line: usize, text: &str) -> anyhow::Result<Option<Piece>> {
    let text = text.split('#').next().unwrap_or_default();
    let words: Vec<&str> = text.split_whitespace().collect();
    if words.is_empty() {
        return Ok(None);
    }
    let numbers: Option<Vec<f64>> = words
        .iter()
        .map(|word| word.parse().ok().filter(|value: &f64| value.is_finite()))
        .collect();
    let Some([seconds, speed_mps, turn_rate_radps]) = numbers.as_deref() else {
        return Err(anyhow!(
            "{shown}:{line}: `{}`: must be three numbers: seconds, m/s and rad/s, such as 2 0.3 0",
            text.trim()
        ));
    };
    ensure!(
        (0.01..=3600.0).contains(seconds),
        "{shown}:{line}: {seconds} s: must be from 0.01 to 3600 s"
    );
    ensure!(
        speed_mps.abs() <= 10.0 && turn_rate_radps.abs() <= 20.0,
        "{shown}:{line}: {speed_mps} m/s and {turn_rate_radps} rad/s: must be within 10 m/s and 20 rad/s"
    );
    let (seconds, speed_mps, turn_rate_radps) = (*seconds, *speed_mps, *turn_rate_radps);
    Ok(Some(Piece { line, seconds, speed_mps, turn_rate_radps }))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_pieces_and_remarks_are_not() {
        let read = |text: &str| piece("x.txt", 3, text).map_err(|error| error.to_string());
        assert_eq!(read("  # nothing\n"), Ok(None));
        let found = Piece { line: 3, seconds: 2.0, speed_mps: 0.3, turn_rate_radps: -0.5 };
        assert_eq!(read("2 0.3\t-0.5 # an arc\n"), Ok(Some(found)));
        for wrong in ["2 0.3", "2 0.3 0 1", "a b c", "2 inf 0", "2 0.3 NaN"] {
            let said = read(wrong).unwrap_err();
            assert!(said.starts_with("x.txt:3: ") && said.contains("2 0.3 0"), "{said}");
        }
        assert!(read("0 0.3 0").unwrap_err().contains("0.01 to 3600 s"));
        assert!(read("2 99 0").unwrap_err().contains("within 10 m/s"));
    }
}
