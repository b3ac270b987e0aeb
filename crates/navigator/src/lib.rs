//! One robot's mind: a pure function of time from observations to commands.
//!
//! [`Navigator::step`] is called every 10 ms or so with what was sensed and received since, and
//! appends what shall be done. It reads no clock, touches no wire, draws no random number, and
//! allocates nothing once it runs; equal inputs give equal commands. Whoever owns it connects it to a
//! real robot or to a simulated one, and it cannot tell which.
//!
//! A goal is reached by one of five [`Method`]s. On a pheromone trail the robot asks the server
//! about its own pose every control period and steers by the difference of two antennas (the
//! thesis, 5.3 and 7.4). Before it sets out a *scout* asks about places at which nobody is: it
//! walks the network of trails branch by branch, so that the robot knows the shortest way although
//! it has no map, and which branch to take where its antennas smell several. Obstacles are passed by
//! the nine-state machine of crate `obstacle_avoidance`, and the trail is taken up again behind them.
//!
//! A trail may also lie in the floor, as intensities in radio tags: a part of its own follows it by two readers, without
//! server and scout, and corrects the robot's pose by the coordinates that the tags store.
//!
//! On a map that it was given it plans the way itself when it gets its goal, as wide as can be had, and drives it as a path.
//!
//! # Seven parts
//!
//! A mind is seven small parts, each in a module of its own with private fields. What passes between them is a named
//! value (module `values`), copied; no part reads another's state, and only `Surroundings` is lent, to be asked.
//!
//! | part | question | takes | gives |
//! | --- | --- | --- | --- |
//! | `where_am_i` | where am I? | odometry, tags | [`PoseEstimate`] |
//! | `around` | what is around? | rings, scans, contacts | answers: what stands on a way, is a turn free |
//! | `where_to` | where to? | orders | `Goal`, the task's clock and progress |
//! | `how` | how? by one of five [`Method`]s | answers of the server, tags | a preview, and a `Leg`: what is to be done next on it, how fast |
//! | `follow` | with which law? | a leg's line, course or scent | a `Motion` of the wheels |
//! | `guard` | may it? | a motion, a way | the same, slowed, stopped or replaced: commands |
//! | `health` | does it still make sense? | link, motors | a reason to give up |
//!
//! `mind` is the order in which they are asked and the [`Phase`] for people; `mind::steps` says what each phase asks.
//! One control step on a trail, traced:
//!
//! ```text
//! observations ► where_am_i ► PoseEstimate ─┐
//!              ► around                     ├─► Situation { now, at, goal, waits }
//!        order ► where_to   ► Goal ─────────┘
//! health.limit_reached?                               ► the task fails, with its reason
//! how.advance, how.way     ► Way                      where the robot has come, and what it is about to drive
//! guard.is_blocked(Way)                               something stands on it
//! how.follow               ► Leg::ByAntennas | Turn | ToGoal | Blocked …
//!   (answer) how.scent     ► the trail, a line, or nothing
//! guard.way_speed, how.speed ► how fast
//! follow.along_trail       ► Motion
//! guard.pass               ► Motion, slowed ► Command
//! ```
//!
//! Every part says in one sentence what it is about and why: [`Navigator::says`]. A new method for a question is
//! a file in the part's folder and a line in its enum.
//!
//! Every phase has a limit, and running into one is visible: [`Report::Failed`](messages::Report::Failed) with a
//! [`FailureReason`](messages::FailureReason). When not to use it: it plans
//! on the map that it was given, and does not plan anew around what is not on it.
//!
//! Source: the thesis (Susnea, c. 2009, Univ. Galati), 1.2, 5.3, 6.3, 7.4, 7.5 and its Annex C;
//! the scout, waiting before persons and the check of detours against remembered echoes are
//! extensions. Tests drive it in a closed loop against a world of segments and ideal sonars.

mod around;
mod config;
mod follow;
mod guard;
mod health;
mod how;
mod mind;
mod phase;
mod says;
mod settings;
mod values;
mod view;
mod where_am_i;
mod where_to;

pub use config::{ConfigError, NavigatorConfig};
pub use how::Scouting;
pub use mind::Navigator;
pub use path_following::{PathController, TrailController};
pub use phase::Phase;
pub use says::{Says, Sentence};
pub use settings::{
    Avoidance, ContactMounts, LaserMount, Method, N_TAG_READERS_MAX, NavigatorSettings, PoseMethod,
    TagController, TagSettings,
};
pub use values::{PoseEstimate, PoseHealth};
pub use view::NavigatorView;
