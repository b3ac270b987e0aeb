//! The mapping page: plays a recording into a survey, and shows the map as it grows.
//!
//! A [`player::Player`] on a thread of its own steps the surveys and paints what they know on a [`stage::Stage`];
//! every page is told what it has not seen yet. The survey is a run's only judge: nothing is computed here.

mod board;
mod cells;
mod job;
mod pack;
mod parameters;
mod player;
mod protocol;
mod routes;
mod run;
mod source;
mod stage;

use std::sync::{Arc, mpsc};

use tokio::sync::{Mutex, OwnedMutexGuard, oneshot};

use crate::door::Pages;

use self::{
    player::Ask,
    protocol::{FormatInfo, Hello, PROTOCOL, Request, SampleInfo},
    stage::Stage,
};

pub(crate) use player::Player;
pub(crate) use routes::routes;
pub use source::Exhibit;

/// Requests to the player that may wait. A page has one at a time, so they are never this many.
const N_ASKS_MAX: usize = 64;

/// Recordings that can be made on the spot.
const SAMPLES: [SampleInfo; 3] = [
    SampleInfo {
        name: source::LASER_ROOM,
        title: "A room with a laser",
        about: "A robot drives twice through a furnished room of 8 m × 6 m; its odometry turns by 2° per metre.",
    },
    SampleInfo {
        name: "artemic-e1",
        title: "A room with five sonars",
        about: "ARTEMIC drives through a simulated room with five sonars and drifting odometry.",
    },
    SampleInfo {
        name: "artemic-e3",
        title: "Two joined areas with five sonars",
        about: "The same robot is driven twice through two areas, of which one is open beyond the sonars' reach.",
    },
];

/// The pages' side of the player. Cloning gives another handle to it.
#[derive(Clone, Debug)]
pub(crate) struct Mapping {
    stage: Stage,
    asks: mpsc::SyncSender<Ask>,
    pages: Pages,
    /// Held while a recording is read or made: one at a time.
    reading: Arc<Mutex<()>>,
}

impl Mapping {
    /// A player without a recording, and its pages' side. The player ends when every handle is gone.
    pub(crate) fn new(has_mission: bool, pages: Pages) -> (Self, Player) {
        let hello = Hello {
            protocol: PROTOCOL,
            cairn: env!("CARGO_PKG_VERSION"),
            server: std::process::id(),
            has_mission,
            upload_max_bytes: source::UPLOAD_BYTES_MAX,
            samples: SAMPLES.to_vec(),
            formats: FormatInfo::all(),
        };
        let stage = Stage::new(&hello);
        let (asks, asked) = mpsc::sync_channel(N_ASKS_MAX);
        let player = Player::new(stage.clone(), asked);
        (Self { stage, asks, pages, reading: Arc::default() }, player)
    }

    /// Hands a request to the player, in the order in which this is called. The answer comes when it is
    /// carried out: a sentence for the person at the page if it cannot be.
    fn ask(&self, request: Request) -> impl Future<Output = Result<(), String>> + Send + 'static {
        let sample = match &request {
            Request::Sample { name } => SAMPLES.iter().find(|sample| sample.name == name),
            _ => None,
        };
        let (answer, answered) = oneshot::channel();
        let mapping = self.clone();
        let told = match sample {
            Some(_) => Ok(()),
            None => self.tell(Ask::Page(request, answer)),
        };
        async move {
            told?;
            match sample {
                Some(sample) => {
                    let reading = mapping.begin_reading()?;
                    let name = sample.title.to_owned();
                    mapping.load(reading, name, || source::sample(sample)).await
                }
                None => answered.await.unwrap_or_else(|_gone| Err(GONE.to_owned())),
            }
        }
    }

    /// The right to bring or make a recording, kept until it is dropped: one at a time.
    ///
    /// # Errors
    ///
    /// A sentence for the person at the page when somebody else has it.
    fn begin_reading(&self) -> Result<OwnedMutexGuard<()>, String> {
        self.reading
            .clone()
            .try_lock_owned()
            .map_err(|_taken| "another recording is being read; wait until it is there".to_owned())
    }

    /// Makes a recording with `read` on another thread and gives it to the player.
    ///
    /// # Errors
    ///
    /// A sentence for the person at the page, who also sees it in place of the map.
    async fn load(
        &self,
        reading: OwnedMutexGuard<()>,
        name: String,
        read: impl FnOnce() -> Result<source::Loaded, String> + Send + 'static,
    ) -> Result<(), String> {
        self.tell(Ask::Reading(name.clone()))?;
        let mapping = self.clone();
        // A task of its own: it ends with a word to the player even when the page that asked has left.
        let loading = tokio::spawn(async move {
            let read = tokio::task::spawn_blocking(read).await;
            let read = read.unwrap_or_else(|_panic| {
                Err(format!("{name}: reading it failed by a fault of ours"))
            });
            match read {
                Ok(loaded) => mapping.tell(Ask::Load(Box::new(loaded), Some(reading))),
                Err(problem) => mapping
                    .tell(Ask::Unreadable { name, problem: problem.clone() })
                    .and(Err(problem)),
            }
        });
        loading.await.unwrap_or_else(|_gone| Err(GONE.to_owned()))
    }

    /// Gives the player a recording that was read already.
    pub(crate) fn show(&self, exhibit: Exhibit) {
        // The player lives as long as its handles.
        drop(self.tell(Ask::Load(Box::new(exhibit.into()), None)));
    }

    fn tell(&self, ask: Ask) -> Result<(), String> {
        self.asks.try_send(ask).map_err(|error| match error {
            mpsc::TrySendError::Full(_) => "too much is asked for at once; try again".to_owned(),
            mpsc::TrySendError::Disconnected(_) => GONE.to_owned(),
        })
    }
}

const GONE: &str = "the program is ending";
