//! What a server tells of its clients: a line for people, or an object a line for programs.

use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};

use crate::output::{Format, note};

/// Time between two complaints that time was lost.
const COMPLAINT_PERIOD: Duration = Duration::from_secs(10);

/// Where events are told.
pub(crate) struct Log {
    format: Format,
    began: Instant,
    lost: Duration,
    complained: Option<Instant>,
}

impl Log {
    pub(crate) fn new(format: Format) -> Self {
        Self { format, began: Instant::now(), lost: Duration::ZERO, complained: None }
    }

    /// Tells that `kind` of thing happened at the line called `name`; `facts` is an object.
    pub(crate) fn event(&self, name: &str, kind: &str, text: &str, facts: Value) {
        match self.format {
            Format::Text if name.is_empty() => note(format_args!("{text}")),
            Format::Text => note(format_args!("{name}: {text}")),
            Format::Json => {
                let mut object = Map::new();
                object.insert("event".to_owned(), json!(kind));
                object
                    .insert("after_start_s".to_owned(), json!(self.began.elapsed().as_secs_f64()));
                if !name.is_empty() {
                    object.insert("robot".to_owned(), json!(name));
                }
                if let Value::Object(facts) = facts {
                    object.extend(facts);
                }
                object.insert("text".to_owned(), json!(text));
                note(format_args!("{}", Value::Object(object)));
            }
        }
    }

    /// Time was lost: told at once, and then every ten seconds at most.
    pub(super) fn lost(&mut self, lost: Duration) {
        self.lost += lost;
        let is_due = self.complained.is_none_or(|at| at.elapsed() >= COMPLAINT_PERIOD);
        if self.lost.is_zero() || !is_due {
            return;
        }
        let seconds = std::mem::take(&mut self.lost).as_secs_f64();
        self.complained = Some(Instant::now());
        let text = format!(
            "the computer was busy or asleep: {seconds:.1} s of time are lost \
             (up to {} s at once are made up)",
            super::pace::MADE_UP_MAX.as_secs()
        );
        self.event("", "time_lost", &text, json!({"lost_s": seconds}));
    }
}
