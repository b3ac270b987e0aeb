//! One robot's mind: a pure function of time from observations to commands.
//!
//! [`Navigator::step`] is called every 10 ms or so with what was sensed and received since, and
//! appends what shall be done. It reads no clock, touches no wire, draws no random number, and
//! allocates nothing once it runs; equal inputs give equal commands. Whoever owns it connects it to a
//! real robot or to a simulated one, and it cannot tell which.
//!
//! A goal is reached by one of four [`Method`]s. On a pheromone trail the robot asks the server
//! about its own pose every control period and steers by the difference of two antennas (the
//! thesis, 5.3 and 7.4). Before it sets out a *scout* asks about places at which nobody is: it
//! walks the network of trails branch by branch, so that the robot knows the shortest way although
//! it has no map, and which branch to take where its antennas smell several. Obstacles are passed by
//! the nine-state machine of crate `obstacle_avoidance`, and the trail is taken up again behind them.
//!
//! A trail may also lie in the floor, as intensities in radio tags: a part of its own follows it by two readers, without
//! server and scout, and corrects the robot's pose by the coordinates that the tags store.
//!
//! Every phase has a limit, and running into one is visible: [`Report::Failed`](messages::Report::Failed) with a
//! [`FailureReason`](messages::FailureReason). When not to use it: it plans no path off the trails and knows no map of obstacles.
//!
//! Source: the thesis (Susnea, c. 2009, Univ. Galati), 1.2, 5.3, 6.3, 7.4, 7.5 and its Annex C;
//! the scout, waiting before persons and the check of detours against remembered echoes are
//! extensions. Tests drive it in a closed loop against a world of segments and ideal sonars.

mod ahead;
mod along_path;
mod arrive;
mod avoid;
mod config;
mod guard;
mod inquiry;
mod navigator;
mod scout;
mod speed;
mod steer;
mod tag_fix;
mod tag_trail;
mod tags;
mod trail;
mod view;

pub use config::{Avoidance, ConfigError, Method, NavigatorConfig, NavigatorSettings, PoseMethod};
pub use navigator::Navigator;
pub use path_following::{PathController, TrailController};
pub use scout::Scouting;
pub use tags::{N_TAG_READERS_MAX, TagController, TagSettings};
pub use view::{NavigatorView, Phase};
