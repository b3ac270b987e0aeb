//! `success.moves_sent`, `events_logged`, `watchdog_resets`: what the decision program does, counted.

use std::sync::Arc;

use decision::Mnemonic;

use super::{
    cast::Cast,
    facts::Facts,
    kind::{About, Progress, Requirement, check},
};
use crate::{
    mission::{check::common::Checked, error::Wrong},
    verdict::Check,
};

/// What is counted.
#[derive(Clone, Copy, Debug)]
pub(super) enum Counted {
    Moves,
    Events,
    WatchdogResets,
}

impl Counted {
    pub(super) const fn about(self) -> About {
        match self {
            Self::Moves => About {
                key: "moves_sent",
                text: "the decision program sends exactly so many MOVE",
                template: "moves_sent = 1           # e.g. the decision program sends exactly so many MOVE\n",
            },
            Self::Events => About {
                key: "events_logged",
                text: "its EVENT functions log exactly so many entries",
                template: "events_logged = 2        # e.g. its EVENT functions log exactly so many entries\n",
            },
            Self::WatchdogResets => About {
                key: "watchdog_resets",
                text: "the watchdog restarts the decision program exactly so often",
                template: "watchdog_resets = 0      # e.g. the watchdog restarts it exactly so often\n",
            },
        }
    }
}

/// So many of them.
#[derive(Debug)]
struct Count {
    of: Counted,
    wanted: u64,
}

pub(super) fn requirements(
    of: Counted,
    wanted: Option<u64>,
    cast: &Cast<'_>,
) -> Checked<Vec<Arc<dyn Requirement>>> {
    let Some(wanted) = wanted else { return Ok(Vec::new()) };
    if cast.decision.is_none() {
        let allowed = "absent, because the mission has no [decision], whose program it counts";
        return Err(Wrong::new(format!("success.{}", of.about().key), wanted, allowed));
    }
    Ok(vec![Arc::new(Count { of, wanted })])
}

impl Requirement for Count {
    fn check(&self, _progress: Progress, facts: &dyn Facts) -> Check {
        let wanted = self.wanted;
        let (name, n, text) = match self.of {
            Counted::Moves => ("moves sent", facts.n_moves(), "MOVE sent"),
            Counted::Events => ("events logged", facts.n_events(), "events logged"),
            Counted::WatchdogResets => {
                ("watchdog", facts.n_watchdog_resets(), "restarts by the watchdog")
            }
        };
        check(name, n == wanted, format!("{n} {text} (wanted {wanted})"))
    }

    fn warnings(&self, cast: &Cast<'_>) -> Vec<String> {
        let lacks = |function: Mnemonic| {
            let has = cast.decision.is_some_and(|plan| plan.has_function(function));
            (!has).then(|| format!("the decision program has no {}", function.name()))
        };
        let why = match self.of {
            _ if self.wanted == 0 => None,
            Counted::Moves => lacks(Mnemonic::Move),
            Counted::Events => lacks(Mnemonic::Event),
            Counted::WatchdogResets => {
                let is_off = cast.decision.is_some_and(|plan| plan.watchdog.is_zero());
                is_off.then(|| "decision.watchdog_s = 0 switches the watchdog off".to_owned())
            }
        };
        let key = self.of.about().key;
        why.map(|why| format!("success.{key}: {why}, so it cannot be met")).into_iter().collect()
    }
}
