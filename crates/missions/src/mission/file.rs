//! The mission as people write it: one TOML table per component, units in the keys.
//!
//! Degrees are allowed here and nowhere else. Unknown keys are refused. Every field has a default
//! that works; [`Mission::template`](crate::Mission::template) lists them all with their documents. What is written
//! here is only relied on after [`Mission`](crate::Mission) has checked it.

mod tags;

use serde::{Deserialize, Deserializer, Serialize};

pub use tags::{TagFollowingFile, TagReadersFile, TagsFile};

/// A whole mission file.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct MissionFile {
    /// `[mission]`: what it is called and how long it may take.
    pub mission: HeadFile,
    /// `[world]`: walls, rooms, things, people.
    pub world: WorldFile,
    /// `[[devices]]`: what the smart environment can sense and do.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub devices: Vec<DeviceFile>,
    /// `[[robots]]`: who drives.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub robots: Vec<RobotFile>,
    /// `[pheromones]`: the trail and its server; absent: there is no server.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pheromones: Option<PheromonesFile>,
    /// `[tags]`: tags in the floor with a trail in them; absent: there are none.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tags: Option<TagsFile>,
    /// `[decision]`: the decision program; absent: goals come from events only.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub decision: Option<DecisionFile>,
    /// `[[events]]`: what happens at which time.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub events: Vec<EventFile>,
    /// `[success]`: what counts as success.
    pub success: SuccessFile,
}

/// `[mission]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct HeadFile {
    /// Short name: small letters, digits, `-`.
    pub name: String,
    /// One line for people.
    pub title: String,
    /// What happens and what to look at.
    pub about: String,
    /// The run ends at this time at the latest, seconds.
    pub duration_max_s: f64,
    /// Seed used unless another is asked for.
    pub seed: u64,
}

impl Default for HeadFile {
    fn default() -> Self {
        Self {
            name: "untitled".into(),
            title: String::new(),
            about: String::new(),
            duration_max_s: 120.0,
            seed: 1,
        }
    }
}

/// `[world]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct WorldFile {
    /// Lower left and upper right corner of what is drawn: x0, y0, x1, y1 (m).
    pub bounds_m: [f64; 4],
    /// A map whose walls are added: a file relative to the mission's, or its text, if it has lines.
    #[serde(skip_serializing_if = "Option::is_none", alias = "map_file")]
    pub map: Option<String>,
    /// What cells of the map that nobody knows are, and what is outside of it: `wall` or `free`.
    pub unknown: String,
    /// Where the map's own frame lies: x, y (m), yaw (degrees).
    pub map_at: [f64; 3],
    /// Side of a cell where the map does not say it (Moving AI), m; absent: 1 there.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_cell_m: Option<f64>,
    /// Walls.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub walls: Vec<WallFile>,
    /// Names of rooms, for people.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub rooms: Vec<RoomFile>,
    /// Furniture, boxes, doors.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub things: Vec<ThingFile>,
    /// People and the routes they walk.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub people: Vec<PersonFile>,
    /// Boxes put down at random by the seed.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub random_boxes: Vec<RandomBoxesFile>,
}

impl Default for WorldFile {
    fn default() -> Self {
        Self {
            bounds_m: [-5.0, -5.0, 5.0, 5.0],
            map: None,
            unknown: "wall".into(),
            map_at: [0.0; 3],
            map_cell_m: None,
            walls: Vec::new(),
            rooms: Vec::new(),
            things: Vec::new(),
            people: Vec::new(),
            random_boxes: Vec::new(),
        }
    }
}

/// `[[world.walls]]`: a line of wall through two or more corners.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct WallFile {
    /// Corners, x and y (m).
    pub line_m: Vec<[f64; 2]>,
    /// Whether the last corner is joined to the first.
    pub closed: bool,
    /// Material, which decides how sound comes back.
    pub material: String,
}

impl Default for WallFile {
    fn default() -> Self {
        Self { line_m: Vec::new(), closed: false, material: "plaster".into() }
    }
}

/// `[[world.rooms]]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct RoomFile {
    /// The room's name.
    pub name: String,
    /// Where the name is written, x and y (m).
    pub at_m: [f64; 2],
}

/// `[[world.things]]`: a rectangle that stands on the floor.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct ThingFile {
    /// Unique name.
    pub name: String,
    /// `furniture`, `box` or `door`.
    pub kind: String,
    /// Material.
    pub material: String,
    /// Centre, x and y (m).
    pub at_m: [f64; 2],
    /// Turned counter-clockwise by, degrees.
    pub yaw_deg: f64,
    /// Length along x and y before turning (m).
    pub size_m: [f64; 2],
}

impl Default for ThingFile {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: "furniture".into(),
            material: "wood".into(),
            at_m: [0.0, 0.0],
            yaw_deg: 0.0,
            size_m: [0.4, 0.4],
        }
    }
}

/// `[[world.people]]`: somebody who walks along a route.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct PersonFile {
    /// Unique name.
    pub name: String,
    /// Corners of the route, x and y (m); the person stands at the first until it starts.
    pub route_m: Vec<[f64; 2]>,
    /// Walking speed, m/s.
    pub speed_mps: f64,
    /// Up to this much is added to the speed at random, m/s.
    pub speed_spread_mps: f64,
    /// Starts at, seconds.
    pub starts_at_s: f64,
    /// Up to this much is added to the start at random, seconds.
    pub starts_spread_s: f64,
    /// Whether the route is walked to and fro for ever.
    pub repeats: bool,
    /// Whether the person stops for a robot in front.
    pub yields: bool,
    /// Radius of the body, m.
    pub radius_m: f64,
}

impl Default for PersonFile {
    fn default() -> Self {
        Self {
            name: String::new(),
            route_m: Vec::new(),
            speed_mps: 0.8,
            speed_spread_mps: 0.0,
            starts_at_s: 0.0,
            starts_spread_s: 0.0,
            repeats: false,
            yields: true,
            radius_m: 0.25,
        }
    }
}

/// `[[world.random_boxes]]`: boxes placed by the seed, along the trail or in an area.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct RandomBoxesFile {
    /// Name; a number is added when there is more than one.
    pub name: String,
    /// How many.
    pub count: usize,
    /// Sides (m).
    pub size_m: [f64; 2],
    /// Material.
    pub material: String,
    /// Between these arc lengths of the first trail (m); empty: anywhere in `area_m`.
    pub along_trail_m: Vec<f64>,
    /// Greatest distance of the centre from the trail, to either side (m).
    pub offset_max_m: f64,
    /// Lower left and upper right corner of the area (m); used when `along_trail_m` is empty.
    pub area_m: Vec<f64>,
    /// Least free width beside the box, on at least one side, so that a robot can pass (m).
    pub passage_m: f64,
    /// Least distance to other things, people and robots (m).
    pub clearance_m: f64,
}

impl Default for RandomBoxesFile {
    fn default() -> Self {
        Self {
            name: "box".into(),
            count: 1,
            size_m: [0.3, 0.3],
            material: "cardboard".into(),
            along_trail_m: Vec::new(),
            offset_max_m: 0.1,
            area_m: Vec::new(),
            passage_m: 0.9,
            clearance_m: 0.6,
        }
    }
}

/// `[[devices]]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct DeviceFile {
    /// Unique name, used by events and success.
    pub name: String,
    /// `button`, `motion`, `latch` or `lamp`.
    pub kind: String,
    /// What people read.
    pub label: String,
    /// Where it is drawn, x and y (m).
    pub at_m: [f64; 2],
    /// What a motion detector watches: corners, x and y (m).
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub area_m: Vec<[f64; 2]>,
    /// Digital input of the decision program (`button`, `motion`), 0 to 15.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub input: Option<u8>,
    /// Digital output of the decision program (`latch`, `lamp`), 0 to 15.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub output: Option<u8>,
    /// What it does while no program drives it (`latch`, `lamp`): `off`, `on` or `hold`.
    pub failsafe: String,
}

impl Default for DeviceFile {
    fn default() -> Self {
        Self {
            name: String::new(),
            kind: "button".into(),
            label: String::new(),
            at_m: [0.0, 0.0],
            area_m: Vec::new(),
            input: None,
            output: None,
            failsafe: "off".into(),
        }
    }
}

/// `[[robots]]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct RobotFile {
    /// Unique name.
    pub name: String,
    /// Model from the catalogue.
    pub model: String,
    /// Where it starts: x, y (m), yaw (degrees).
    pub start: [f64; 3],
    /// How many; more than one are laid out in rows from `start`.
    pub count: usize,
    /// Distance between neighbours when there are many: along x and y (m).
    pub spacing_m: [f64; 2],
    /// Robots in a row when there are many.
    pub row_length: usize,
    /// `[robots.odometry]`: how its dead reckoning errs.
    pub odometry: OdometryFile,
    /// `[robots.sonar]`: what its sonars return.
    pub sonar: SonarFile,
    /// `[robots.link]`: the line between the robot and its navigation node.
    pub link: LinkFile,
    /// `[robots.navigator]`: the methods of the navigation node.
    pub navigator: NavigatorFile,
    /// `[robots.tag_readers]`: readers of tags in the floor; absent: none, unless it follows tags.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tag_readers: Option<TagReadersFile>,
    /// `[robots.teleoperator]`: a person who drives it by hand; absent: nobody does.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub teleoperator: Option<TeleoperatorFile>,
}

impl Default for RobotFile {
    fn default() -> Self {
        Self {
            name: "robot".into(),
            model: "pioneer3dx".into(),
            start: [0.0; 3],
            count: 1,
            spacing_m: [1.5, 1.5],
            row_length: 32,
            odometry: OdometryFile::default(),
            sonar: SonarFile::default(),
            link: LinkFile::default(),
            navigator: NavigatorFile::default(),
            tag_readers: None,
            teleoperator: None,
        }
    }
}

/// `[robots.teleoperator]`: a person who sees the robot and drives it along a path by hand.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct TeleoperatorFile {
    /// Corners of the path over the floor, x and y (m).
    pub path_m: Vec<[f64; 2]>,
    /// How often the path is driven; more than once only when it ends where it begins.
    pub laps: u32,
    /// Radius of the arcs around its corners (m).
    pub corner_radius_m: f64,
    /// Speed along it, m/s.
    pub speed_mps: f64,
    /// When the person takes the stick, seconds.
    pub starts_at_s: f64,
}

impl Default for TeleoperatorFile {
    fn default() -> Self {
        Self {
            path_m: Vec::new(),
            laps: 1,
            corner_radius_m: 0.4,
            speed_mps: 0.08,
            starts_at_s: 1.0,
        }
    }
}

/// `[robots.odometry]`: errors of dead reckoning; the defaults are perfect.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct OdometryFile {
    /// True left wheel diameter over the nominal one.
    pub left_diameter_ratio: f64,
    /// True right wheel diameter over the nominal one.
    pub right_diameter_ratio: f64,
    /// True wheelbase over the nominal one.
    pub wheelbase_ratio: f64,
    /// What the robot truly turns without noticing, counter-clockwise positive, degrees per metre of way; it
    /// widens the difference of the diameters.
    pub drift_degpm: f64,
    /// Direction in which the wheels roll, seen from the robot's front, counter-clockwise, degrees.
    pub misalignment_deg: f64,
    /// Encoder pulses that are counted as one step.
    pub encoder_coarsening_ticks: u32,
    /// Time between two readings of the encoders, ms; 0: every step.
    pub encoder_period_ms: f64,
    /// Standard deviation of wheel slip, as a ratio of the distance rolled.
    pub slip_std_ratio: f64,
    /// Bumps while it moves, per second.
    pub bump_rate_hz: f64,
    /// Standard deviation of the way that a bump adds to one wheel, m.
    pub bump_std_m: f64,
}

impl Default for OdometryFile {
    fn default() -> Self {
        Self {
            left_diameter_ratio: 1.0,
            right_diameter_ratio: 1.0,
            wheelbase_ratio: 1.0,
            drift_degpm: 0.0,
            misalignment_deg: 0.0,
            encoder_coarsening_ticks: 1,
            encoder_period_ms: 0.0,
            slip_std_ratio: 0.0,
            bump_rate_hz: 0.0,
            bump_std_m: 0.0,
        }
    }
}

/// `[robots.sonar]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct SonarFile {
    /// Where the sonars are: `model` (as the robot has them), `five`, `eight` or `own`.
    pub ring: String,
    /// Place (x, y, m) and bearing (degrees) of each, for `ring = "own"`.
    pub ring_at: Vec<[f64; 3]>,
    /// Time between two pings of a chain, ms; 0: as the ring has it.
    pub ring_period_ms: u32,
    /// Sonars that fire one after another; 0: as the ring has it.
    pub ring_chain: usize,
    /// Nearer things read as this, m.
    pub range_min_m: f64,
    /// Greatest range, m.
    pub range_max_m: f64,
    /// Readings are whole numbers of these, m; 0: as fine as measured.
    pub range_step_m: f64,
    /// Half the opening of the cone, degrees.
    pub half_angle_deg: f64,
    /// Rays per cone.
    pub n_rays: usize,
    /// Standard deviation of a range that does not grow with it, m.
    pub range_std_m: f64,
    /// Standard deviation that grows with the range, as a ratio of it.
    pub range_std_ratio: f64,
    /// Probability that a mirrored ray is followed to a ghost.
    pub ghost_prob: f64,
    /// Probability that an echo is missed.
    pub dropout_prob: f64,
    /// Probability that another sensor is heard instead.
    pub crosstalk_prob: f64,
}

impl Default for SonarFile {
    fn default() -> Self {
        Self {
            ring: "model".into(),
            ring_at: Vec::new(),
            ring_period_ms: 0,
            ring_chain: 0,
            range_min_m: 0.15,
            range_max_m: 5.0,
            range_step_m: 0.0,
            half_angle_deg: 15.0,
            n_rays: 9,
            range_std_m: 0.005,
            range_std_ratio: 0.005,
            ghost_prob: 0.5,
            dropout_prob: 0.01,
            crosstalk_prob: 0.001,
        }
    }
}

/// A byte link between two nodes.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct LinkFile {
    /// `memory`, `direct`, `tcp` or `serial`.
    pub kind: String,
    /// Bits per second, 10 bits a byte; 0: no limit.
    pub baud: u32,
    /// Delay of each byte, ms.
    pub latency_ms: f64,
    /// Up to this much is added to the delay at random, ms.
    pub jitter_ms: f64,
    /// Probability that a byte is lost.
    pub loss_prob: f64,
    /// Probability that a byte is corrupted.
    pub corruption_prob: f64,
    /// `tcp`: host and port.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub address: String,
    /// `serial`: the device.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub device: String,
}

impl Default for LinkFile {
    fn default() -> Self {
        Self {
            kind: "memory".into(),
            baud: 9600,
            latency_ms: 2.0,
            jitter_ms: 0.0,
            loss_prob: 0.0,
            corruption_prob: 0.0,
            address: String::new(),
            device: String::new(),
        }
    }
}

impl LinkFile {
    /// A radio modem: a line that takes longer than a cable.
    fn radio() -> Self {
        Self { latency_ms: 5.0, ..Self::default() }
    }
}

/// The keys of a link as far as they are written.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LinkKeys {
    kind: Option<String>,
    baud: Option<u32>,
    latency_ms: Option<f64>,
    jitter_ms: Option<f64>,
    loss_prob: Option<f64>,
    corruption_prob: Option<f64>,
    address: Option<String>,
    device: Option<String>,
}

/// A link whose other keys are those of a radio modem, and not those of a cable.
fn radio_link<'de, D: Deserializer<'de>>(from: D) -> Result<LinkFile, D::Error> {
    let keys = LinkKeys::deserialize(from)?;
    let radio = LinkFile::radio();
    Ok(LinkFile {
        kind: keys.kind.unwrap_or(radio.kind),
        baud: keys.baud.unwrap_or(radio.baud),
        latency_ms: keys.latency_ms.unwrap_or(radio.latency_ms),
        jitter_ms: keys.jitter_ms.unwrap_or(radio.jitter_ms),
        loss_prob: keys.loss_prob.unwrap_or(radio.loss_prob),
        corruption_prob: keys.corruption_prob.unwrap_or(radio.corruption_prob),
        address: keys.address.unwrap_or(radio.address),
        device: keys.device.unwrap_or(radio.device),
    })
}

/// `[robots.navigator]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct NavigatorFile {
    /// How it gets to a goal: `trail` (pheromones), `direct` (a straight line), `path` or `tags` (in the floor).
    pub route: String,
    /// Corners of the path that `route = "path"` follows to its goal, from start to goal.
    pub path_m: Vec<[f64; 2]>,
    /// The steering law on that path: `fuzzy`, `carrot`, `pure_pursuit` or `stanley`.
    pub path_controller: String,
    /// The steering law on the trail: `fuzzy` (three sets), `fuzzy_fine` (five),
    /// `listing`, `bio_mimetic`, `fuzzy_angle` or `pure_pursuit`.
    pub trail_controller: String,
    /// What it does about obstacles: `checked`, `rebound` or `off`.
    pub avoidance: String,
    /// When it aims at its target again after a rebound: `visibility` or `detour`.
    pub rebound: String,
    /// Cruising speed, m/s.
    pub speed_mps: f64,
    /// Time between two control steps, ms.
    pub control_period_ms: u32,
    /// What the wheels are told to accelerate with, m/s².
    pub acceleration_mps2: f64,
    /// Whether it turns in place towards the trail before it drives off, and at sharp corners.
    pub turn_first: bool,
    /// Whether on a trail it slows down for bends and the goal, and widens the sets of `fuzzy` and `fuzzy_fine` above
    /// 0.3 m/s (the other laws have none); otherwise
    /// the law is as printed and the speed constant, as in the thesis.
    pub fit_to_speed: bool,
    /// How long it waits for an obstacle to go away, s; 0: not at all.
    pub wait_s: f64,
    /// How much of the way that its scout found it shows ahead, m; 0: it follows its antennas alone, also at junctions.
    pub preview_m: f64,
    /// Within this distance of the goal it leaves the trail for a straight line, m.
    pub approach_m: f64,
    /// Attempts on one obstacle before it gives up.
    pub attempts_max: u32,
    /// How near to the goal it must stand, m.
    pub goal_within_m: f64,
    /// How well it must look the goal's way, degrees.
    pub goal_within_deg: f64,
    /// `[robots.navigator.fuzzy]`: sets and rules of the fuzzy laws on the trail.
    pub fuzzy: FuzzyFile,
    /// `[robots.navigator.tags]`: how it follows tags in the floor.
    pub tags: TagFollowingFile,
}

impl Default for NavigatorFile {
    fn default() -> Self {
        Self {
            route: "trail".into(),
            path_m: Vec::new(),
            path_controller: "fuzzy".into(),
            trail_controller: "fuzzy".into(),
            avoidance: "checked".into(),
            rebound: "visibility".into(),
            speed_mps: 0.3,
            control_period_ms: 200,
            acceleration_mps2: 0.3,
            turn_first: true,
            fit_to_speed: true,
            wait_s: 2.5,
            preview_m: 4.0,
            approach_m: 0.7,
            attempts_max: 10,
            goal_within_m: 0.06,
            goal_within_deg: 4.0,
            fuzzy: FuzzyFile::default(),
            tags: TagFollowingFile::default(),
        }
    }
}

/// `[robots.navigator.fuzzy]`: for `trail_controller` `fuzzy`, `fuzzy_fine` and `listing`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct FuzzyFile {
    /// ME: the error from which on the outermost set is fully true, in units of intensity.
    pub error_full: u32,
    /// MED: the same for the change of the error between two steps.
    pub change_full: u32,
    /// L as a ratio of M, the cruising speed.
    pub slow_ratio: f64,
    /// H as a ratio of M.
    pub fast_ratio: f64,
    /// M of `listing`, which has its own speeds, mm/s.
    pub listing_mean_mmps: u32,
    /// The rules: `antisymmetric`, `literal_mirror`, `table_5_1` or `own`.
    pub table: String,
    /// Rules of the left wheel for `table = "own"`: nine letters L, M, H.
    pub left_rules: String,
    /// Rules of the right wheel.
    pub right_rules: String,
}

impl Default for FuzzyFile {
    fn default() -> Self {
        Self {
            error_full: 50,
            change_full: 25,
            slow_ratio: 0.5,
            fast_ratio: 1.5,
            listing_mean_mmps: 300,
            table: "antisymmetric".into(),
            left_rules: String::new(),
            right_rules: String::new(),
        }
    }
}

/// `[pheromones]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct PheromonesFile {
    /// Trails as lines of corners, x and y (m).
    pub trails_m: Vec<Vec<[f64; 2]>>,
    /// Cells marked across the trail: 1, 3 or 5.
    pub width_cells: usize,
    /// Value of a marked cell, 1 to 127.
    pub value: u8,
    /// Matrix file, relative to the mission file, instead of trails.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map_file: Option<String>,
    /// The text of such a matrix.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub map: Option<String>,
    /// Side of a cell, m.
    pub cell_m: f64,
    /// Columns; the grid is centred on the origin.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// Perception radius, m.
    pub sigma_m: f64,
    /// Distance between the two antennas, m.
    pub antenna_spacing_m: f64,
    /// What the server multiplies intensities with before it sends them as bytes, 0.001 to 1; 0.5 or
    /// less for trails three cells wide, whose sum exceeds a byte.
    pub scale_ratio: f64,
    /// `scalar_sum`, `vector_atan2` or `listing`.
    pub perception: String,
    /// `[pheromones.link]`: the radio modem to the server.
    #[serde(deserialize_with = "radio_link")]
    pub link: LinkFile,
}

impl Default for PheromonesFile {
    fn default() -> Self {
        Self {
            trails_m: Vec::new(),
            width_cells: 1,
            value: 1,
            map_file: None,
            map: None,
            cell_m: 0.2,
            width: 61,
            height: 61,
            sigma_m: 0.6,
            antenna_spacing_m: 0.38,
            scale_ratio: 1.0,
            perception: "scalar_sum".into(),
            link: LinkFile::radio(),
        }
    }
}

/// `[decision]`.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct DecisionFile {
    /// Program file, relative to the mission file.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub program_file: Option<String>,
    /// The program itself.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub program: Option<String>,
    /// `corrected` or `listing`.
    pub mode: String,
    /// Robot that MOVE commands; empty: none (the decision rig alone).
    pub robot: String,
    /// Digital input that is 1 from a MOVE until its end is known.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub busy_input: Option<u8>,
    /// Digital input that is 1 when the robot stands where the last MOVE sent it; also `done_input`.
    #[serde(alias = "done_input", skip_serializing_if = "Option::is_none")]
    pub arrived_input: Option<u8>,
    /// Digital input that is 1 when the last MOVE will not be done.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub failed_input: Option<u8>,
    /// How these two appear: `level`, until the next MOVE, or `pulse`, in one scan.
    pub completion: String,
    /// How long the ground waits for the robot's answers before a MOVE counts as failed, s; the way
    /// there and back over the link comes on top.
    pub answer_within_s: f64,
    /// Whether a robot that is on its way for a MOVE stops when the program does.
    pub failsafe_stops_robot: bool,
    /// The node's clock when the run begins: `07:30`, or with a date `2026-03-01 07:30:00`.
    pub clock: String,
    /// After this time the watchdog restarts a program whose loop stands still, s; 0: never.
    pub watchdog_s: f64,
    /// `[decision.link]`: the radio modem to the robot.
    #[serde(deserialize_with = "radio_link")]
    pub link: LinkFile,
}

impl Default for DecisionFile {
    fn default() -> Self {
        Self {
            program_file: None,
            program: None,
            mode: "corrected".into(),
            robot: String::new(),
            busy_input: None,
            arrived_input: None,
            failed_input: None,
            completion: "level".into(),
            answer_within_s: 5.0,
            failsafe_stops_robot: true,
            clock: "2000-01-01 00:00:00".into(),
            watchdog_s: 2.0,
            link: LinkFile::radio(),
        }
    }
}

/// `[[events]]`.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct EventFile {
    /// When, seconds.
    pub at_s: f64,
    /// `press`, `release`, `goal`, `stop`, `place_box`, `remove`, `cut_link`, `restore_link`, `stop_program`,
    /// `run_program`, `stall_program`, `test_link`, `report_sonar` or `restart`.
    #[serde(rename = "do")]
    pub action: String,
    /// `press`, `release`: the device.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub device: String,
    /// `goal`, `stop`, `cut_link`, `restore_link`, `test_link`, `report_sonar`, `restart`: the robot.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub robot: String,
    /// `goal`: x, y (m), yaw (degrees).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose: Option<[f64; 3]>,
    /// `goal`: x, y (m) and yaw (degrees) relative to where each robot started.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose_from_start: Option<[f64; 3]>,
    /// `goal`: sent as soon as the robot arrives at the goal before, not before `at_s`.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub after_arrival: bool,
    /// `place_box`: where, x and y (m).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_m: Option<[f64; 2]>,
    /// `place_box`: side, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub size_m: Option<f64>,
    /// `remove`, `place_box`: the thing's name.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub thing: String,
    /// `cut_link`, `restore_link`: `robot`, `pheromones` or `ground`, the other end of the line of the
    /// robot's navigation node.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub line: String,
    /// `cut_link`, `restore_link`: `both` unless given; one way `to_robot` or `from_robot`,
    /// `to_server` or `from_server`, `to_ground` or `from_ground`, by the line.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub direction: String,
    /// `stall_program`: how long the loop of the decision node stands still, s.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub for_s: Option<f64>,
}

/// `[success]`: every requirement must hold.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct SuccessFile {
    /// No robot touches anything.
    pub no_contact: bool,
    /// The decision program sends exactly this many MOVE.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub moves_sent: Option<u64>,
    /// `EVENT` writes exactly this many entries into the decision node's log.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub events_logged: Option<u64>,
    /// The watchdog restarts the decision program exactly so often.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub watchdog_resets: Option<u64>,
    /// Every robot keeps at least this distance from everything, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub clearance_min_m: Option<f64>,
    /// Root mean square distance of the first robot from the trail at most, m.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cross_track_rms_max_m: Option<f64>,
    /// `[[success.arrived]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub arrived: Vec<ArrivedFile>,
    /// `[[success.switched_on]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub switched_on: Vec<SwitchedOnFile>,
    /// `[[success.stayed]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub stayed: Vec<StayedFile>,
    /// `[[success.gave_up]]`.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub gave_up: Vec<GaveUpFile>,
}

/// `[[success.arrived]]`: a robot reports arrival and truly stands there.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct ArrivedFile {
    /// The robot; for many robots of one name, all of them.
    pub robot: String,
    /// x, y (m), yaw (degrees).
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose: Option<[f64; 3]>,
    /// The same relative to where each robot started.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pose_from_start: Option<[f64; 3]>,
    /// Allowed distance, m.
    pub within_m: f64,
    /// Allowed heading error, degrees.
    pub within_deg: f64,
    /// Deadline, seconds; 0: the end of the mission.
    pub by_s: f64,
    /// Part of the robots of that name that must arrive.
    pub min_ratio: f64,
}

impl Default for ArrivedFile {
    fn default() -> Self {
        Self {
            robot: String::new(),
            pose: None,
            pose_from_start: None,
            within_m: 0.3,
            within_deg: 15.0,
            by_s: 0.0,
            min_ratio: 1.0,
        }
    }
}

/// `[[success.switched_on]]`: a latch opens or a lamp is lit.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct SwitchedOnFile {
    /// The device.
    pub device: String,
    /// Deadline, seconds; 0: the end of the mission.
    pub by_s: f64,
}

/// `[[success.gave_up]]`: a robot reports that it gave up, and truly stands.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct GaveUpFile {
    /// The robot; for many robots of one name, all of them.
    pub robot: String,
    /// Why it must have given up, such as `link_lost` or `server_silent`; empty: whatever the reason.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub reason: String,
    /// How far it may drive after one of its lines was last cut, until its next order, m; 0: any way.
    pub way_max_m: f64,
    /// Deadline, seconds; 0: the end of the mission.
    pub by_s: f64,
}

/// `[[success.stayed]]`: a robot never leaves its start.
#[derive(Clone, Debug, PartialEq, Deserialize, Serialize)]
#[serde(deny_unknown_fields, default)]
pub struct StayedFile {
    /// The robot.
    pub robot: String,
    /// Allowed distance from the start, m.
    pub within_m: f64,
}

impl Default for StayedFile {
    fn default() -> Self {
        Self { robot: String::new(), within_m: 0.05 }
    }
}
