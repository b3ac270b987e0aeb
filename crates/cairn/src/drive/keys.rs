//! The keys of a terminal as a hand on the wheel.
//!
//! Most terminals tell of a pressed key again and again while it is held, and never of its release. So a key counts
//! until it has not been heard of for a while; terminals that tell of releases are believed at once.

use std::{
    io::{IsTerminal as _, Write as _},
    time::{Duration, Instant},
};

use anyhow::{Context, ensure};
use crossterm::{
    event::{
        self, Event, KeyCode, KeyEvent, KeyEventKind, KeyModifiers, KeyboardEnhancementFlags,
        PopKeyboardEnhancementFlags, PushKeyboardEnhancementFlags,
    },
    execute, terminal,
};

/// Silence after which the first press of a key counts no more: systems begin to repeat after 0.25 to 0.5 s.
const FIRST_SILENCE: Duration = Duration::from_millis(600);
/// The same once it is repeated: ten and more times a second.
const REPEAT_SILENCE: Duration = Duration::from_millis(250);
/// Share of the greatest speed at first, and the step of a change.
const PACE_FIRST: f64 = 0.4;
const PACE_STEP: f64 = 0.1;

/// The keyboard, for as long as this lives.
pub(super) struct Keys {
    hand: HeldKeys,
    pace: f64,
    is_precise: bool,
}

/// Keys are read from a terminal or not at all.
pub(super) fn ensure_terminal() -> anyhow::Result<()> {
    ensure!(
        std::io::stdin().is_terminal() && std::io::stdout().is_terminal(),
        "there is no terminal whose keys could be read; give a script: --script FILE, or --script - for \
         standard input"
    );
    Ok(())
}

/// Shows a line in place of the one before.
pub(super) fn show(line: &str) {
    let mut out = std::io::stdout().lock();
    // A terminal that is gone shows in the keys.
    drop(write!(out, "\r{line}\x1b[K").and_then(|()| out.flush()));
}

impl Keys {
    /// Takes the terminal's keys one by one, and gives it back when dropped.
    pub(super) fn open() -> anyhow::Result<Self> {
        terminal::enable_raw_mode().context("the terminal does not hand over its keys")?;
        let is_precise = terminal::supports_keyboard_enhancement().unwrap_or(false)
            && execute!(
                std::io::stdout(),
                PushKeyboardEnhancementFlags(KeyboardEnhancementFlags::REPORT_EVENT_TYPES)
            )
            .is_ok();
        Ok(Self { hand: HeldKeys::default(), pace: PACE_FIRST, is_precise })
    }

    /// Takes the keys that were pressed; `false` when the person wants to end.
    pub(super) fn read(&mut self, now: Instant) -> anyhow::Result<bool> {
        while event::poll(Duration::ZERO).context("the terminal is gone")? {
            let Event::Key(key) = event::read().context("the terminal is gone")? else { continue };
            let is_press = key.kind != KeyEventKind::Release;
            let ends = matches!(key.code, KeyCode::Esc | KeyCode::Char('x' | 'X'))
                || (key.code == KeyCode::Char('c')
                    && key.modifiers.contains(KeyModifiers::CONTROL));
            match key.code {
                _ if ends => return Ok(false),
                KeyCode::Char('+' | '=') if is_press => {
                    self.pace = (self.pace + PACE_STEP).min(1.0);
                }
                KeyCode::Char('-') if is_press => {
                    self.pace = (self.pace - PACE_STEP).max(PACE_STEP);
                }
                _ => self.hand.take(key, self.is_precise, now),
            }
        }
        Ok(true)
    }

    /// Forwards and to the left, each from −1 to 1.
    pub(super) fn wanted(&mut self, now: Instant) -> (f64, f64) {
        self.hand.wanted(now)
    }

    /// Share of the greatest speeds.
    pub(super) fn pace(&self) -> f64 {
        self.pace
    }
}

impl Drop for Keys {
    fn drop(&mut self) {
        if self.is_precise {
            drop(execute!(std::io::stdout(), PopKeyboardEnhancementFlags));
        }
        drop(terminal::disable_raw_mode());
        println_end();
    }
}

/// What follows stands on a line of its own.
fn println_end() {
    let mut out = std::io::stdout().lock();
    drop(writeln!(out).and_then(|()| out.flush()));
}

/// Which keys are held, as far as can be told.
#[derive(Debug, Default)]
struct HeldKeys {
    held: Vec<KeyCode>,
    last: Option<Instant>,
    is_repeated: bool,
}

/// Forwards and to the left.
fn direction(code: KeyCode) -> Option<(f64, f64)> {
    Some(match code {
        KeyCode::Up | KeyCode::Char('w' | 'W') => (1.0, 0.0),
        KeyCode::Down | KeyCode::Char('s' | 'S') => (-1.0, 0.0),
        KeyCode::Left | KeyCode::Char('a' | 'A') => (0.0, 1.0),
        KeyCode::Right | KeyCode::Char('d' | 'D') => (0.0, -1.0),
        KeyCode::Char('q' | 'Q') => (1.0, 0.6),
        KeyCode::Char('e' | 'E') => (1.0, -0.6),
        _ => return None,
    })
}

impl HeldKeys {
    /// Any key that is none of the wheel's stops.
    fn take(&mut self, key: KeyEvent, is_precise: bool, now: Instant) {
        if direction(key.code).is_none() {
            if key.kind != KeyEventKind::Release {
                self.held.clear();
            }
            return;
        }
        if key.kind == KeyEventKind::Release {
            self.held.retain(|held| *held != key.code);
            return;
        }
        self.is_repeated = self.held.contains(&key.code);
        self.last = Some(now);
        if !is_precise {
            // Only the last key is repeated: what was held before cannot be told from what was let go.
            self.held.clear();
        }
        if !self.held.contains(&key.code) {
            self.held.push(key.code);
        }
    }

    fn wanted(&mut self, now: Instant) -> (f64, f64) {
        let silence = if self.is_repeated { REPEAT_SILENCE } else { FIRST_SILENCE };
        if self.last.is_none_or(|last| now.saturating_duration_since(last) > silence) {
            self.held.clear();
        }
        let sum = |axis: fn((f64, f64)) -> f64| {
            let all = self.held.iter().filter_map(|code| direction(*code)).map(axis);
            all.sum::<f64>().clamp(-1.0, 1.0)
        };
        (sum(|(forwards, _)| forwards), sum(|(_, left)| left))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn event(code: KeyCode, kind: KeyEventKind) -> KeyEvent {
        KeyEvent::new_with_kind(code, KeyModifiers::NONE, kind)
    }

    const W: KeyCode = KeyCode::Char('w');
    const A: KeyCode = KeyCode::Char('a');

    #[test]
    fn a_key_of_which_nothing_is_heard_any_more_counts_no_more() {
        let begin = Instant::now();
        let at = |ms: u64| begin + Duration::from_millis(ms);
        let mut keys = HeldKeys::default();
        assert_eq!(keys.wanted(at(0)), (0.0, 0.0));
        keys.take(event(W, KeyEventKind::Press), false, at(0));
        assert_eq!(keys.wanted(at(590)), (1.0, 0.0), "the first repetition is late");
        assert_eq!(keys.wanted(at(610)), (0.0, 0.0));
        for ms in (1000..2000).step_by(50) {
            keys.take(event(W, KeyEventKind::Press), false, at(ms));
        }
        assert_eq!(keys.wanted(at(2190)), (1.0, 0.0));
        assert_eq!(keys.wanted(at(2210)), (0.0, 0.0), "0.25 s after the last repetition at 1950");
    }

    #[test]
    fn releases_count_at_once_and_two_keys_make_an_arc() {
        let now = Instant::now();
        let mut keys = HeldKeys::default();
        keys.take(event(W, KeyEventKind::Press), true, now);
        keys.take(event(A, KeyEventKind::Press), true, now);
        assert_eq!(keys.wanted(now), (1.0, 1.0));
        keys.take(event(W, KeyEventKind::Release), true, now);
        assert_eq!(keys.wanted(now), (0.0, 1.0));
        keys.take(event(KeyCode::Char(' '), KeyEventKind::Press), true, now);
        assert_eq!(keys.wanted(now), (0.0, 0.0), "any other key stops");
        let mut plain = HeldKeys::default();
        plain.take(event(W, KeyEventKind::Press), false, now);
        plain.take(event(KeyCode::Right, KeyEventKind::Press), false, now);
        assert_eq!(plain.wanted(now), (0.0, -1.0), "without releases the last key counts");
    }
}
