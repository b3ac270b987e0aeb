//! Recordings: a run as an MCAP file that stands alone.
//!
//! | topic | encoding | content |
//! | --- | --- | --- |
//! | `/cairn/head` | JSON | version, seed, resolved mission as TOML; the first message |
//! | `/cairn/interventions` | JSON | what a person did, before which step |
//! | `/cairn/hash` | 16 bytes, little endian | step and state hash after every step |
//! | `/cairn/state` | JSON | what a screen shows, ten times a second |
//! | `/cairn/log` | JSON | events in words |
//! | `/cairn/rig/<robot>` | JSON | what its ranges mean; before the first step |
//! | `/cairn/scan/<robot>` | `cairn.scan.v1` | a row of its ring with dead reckoning and truth |
//! | `/cairn/rig/<robot>/<laser>`, `/cairn/scan/<robot>/<laser>` | as above | the same of each of its lasers |
//! | `/cairn/end` | JSON | steps taken and the verdict; absent when the recording was cut off |
//! | `/tf`, `/scene`, `/log`, `/<robot>/…` | JSON with public schemas | what viewers draw by themselves: [`viewers`] |
//!
//! After every piece stands a check record ([`recordings::mcap_file`]) with the checksum of everything before it; a piece
//! is half a second of the run, and reaches the file in one go. So a program that is killed loses no more than that,
//! and every byte of what it leaves can be relied on or is known to be damaged.
//!
//! Log times are virtual; a scan is published at the time that it is about. The last two topics are those of
//! [`recordings::cairn_mcap`], so that a recorded run can be mapped like any other log. The file is written beside its final name and renamed at the end, so that a name
//! always means a whole recording; what a crash leaves behind (`….part`) replays as far as it goes.

use std::{
    collections::BTreeMap,
    path::{Path, PathBuf},
};

use files::{Kind, Live, Outputs, Refusal};
use mcap::{WriteOptions, Writer, records::MessageHeader};
use recordings::{
    Rig,
    cairn_mcap::{RIG_ENCODING, SCAN_ENCODING, encode_rig, encode_scan, rig_topic, scan_topic},
    mcap_file::{CHECK_OPCODE, LIBRARY_MARK},
};
use run_context::Stamp;
use serde::{Deserialize, Serialize};
use serde_json::{Value, json};

use crate::{
    intervention::InterventionRecord,
    mission::plan::LaserPlan,
    run::{Run, Signal, laser_rig, rig},
    sensing::sensor_name,
    view::{LogItem, Pose, SceneThing, ViewDecision, ViewRobot, ViewState},
};

mod sink;
mod viewers;

use sink::Sink;
use viewers::Viewers;

/// Version of the recording's layout; 1 had no rigs and scans, 2 no check records and no build.
pub(crate) const FORMAT: u32 = 3;
/// The layouts that can be replayed.
pub(crate) const FORMATS_READ: std::ops::RangeInclusive<u32> = 1..=FORMAT;
/// Steps between two recorded views.
const VIEW_STEPS: u64 = 10;
/// Steps collected before they are written out: half a second, the most that is lost when the program is killed.
const PIECE_STEPS: u64 = 50;
/// Which sources the program was built from: the same build repeats the same bits.
pub(crate) const BUILD: &str = env!("CAIRN_BUILD");

pub(crate) const HEAD: &str = "/cairn/head";
pub(crate) const INTERVENTIONS: &str = "/cairn/interventions";
pub(crate) const HASH: &str = "/cairn/hash";
pub(crate) const STATE: &str = "/cairn/state";
pub(crate) const LOG: &str = "/cairn/log";
pub(crate) const END: &str = "/cairn/end";

/// The first message.
#[derive(Clone, Debug, Deserialize, Serialize)]
pub(crate) struct Head {
    pub(crate) format: u32,
    pub(crate) cairn: String,
    /// Of the program that wrote it; empty in layouts before 3.
    #[serde(default)]
    pub(crate) build: String,
    pub(crate) seed: u64,
    pub(crate) mission: String,
}

/// The last message.
#[derive(Debug, Deserialize, Serialize)]
pub(crate) struct EndRecord {
    pub(crate) steps: u64,
    pub(crate) passed: Option<bool>,
    pub(crate) text: String,
}

/// A recording that cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum RecordError {
    /// The file may not be written.
    #[error(transparent)]
    Refused(#[from] Refusal),
    /// The file system refuses.
    #[error("{}: cannot be written: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// Why.
        source: std::io::Error,
    },
    /// The format's writer refuses.
    #[error("{}: cannot be recorded: {source}", path.display())]
    Mcap {
        /// The file.
        path: PathBuf,
        /// Why.
        source: mcap::McapError,
    },
}

/// Writes a run to a file, step by step.
///
/// ```no_run
/// # use missions::{Mission, Recorder, Run};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let mission = Mission::load("doorbell", &[])?;
/// let seed = mission.seed();
/// let mut run = Run::new(mission, seed)?;
/// let mut recorder = Recorder::create("doorbell.mcap".as_ref(), &run, &files::Outputs::new(false))?;
/// while run.finished().is_none() {
///     run.step();
///     let log = run.drain_log();
///     recorder.record(&run, &log)?;
/// }
/// recorder.finish(&run)?;
/// # Ok(())
/// # }
/// ```
pub struct Recorder {
    live: Live,
    writer: Writer<Sink>,
    sink: Sink,
    /// Step after which everything was written out last.
    written_at: u64,
    channels: [u16; 6],
    /// For each robot: of its ring, if it has one, and of its lasers.
    scan_channels: Vec<(Option<u16>, Vec<u16>)>,
    viewers: Viewers,
    n_interventions: usize,
    sequence: u32,
    scratch: Vec<u8>,
}

impl std::fmt::Debug for Recorder {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Recorder").field("path", &self.live.path()).finish_non_exhaustive()
    }
}

impl Recorder {
    /// Begins a recording of a run that has not been stepped yet, at a path that `outputs` allow.
    ///
    /// # Errors
    ///
    /// [`RecordError`] when the file may not or cannot be written.
    pub fn create(path: &Path, run: &Run, outputs: &Outputs) -> Result<Self, RecordError> {
        let live = outputs.begin(path, Kind::RECORDING)?;
        let part = live.part().to_owned();
        let refuse = |source| RecordError::Mcap { path: part.clone(), source };
        let sink = Sink::new();
        let options = WriteOptions::new()
            .compression(None)
            .profile("cairn")
            .library(format!("cairn {}{LIBRARY_MARK}", env!("CARGO_PKG_VERSION")))
            .disable_seeking(true)
            .chunk_size(None);
        let mut writer = options.create(sink.clone()).map_err(refuse)?;
        let mut channels = [0; 6];
        for (id, topic) in channels.iter_mut().zip([HEAD, INTERVENTIONS, HASH, STATE, LOG, END]) {
            let encoding = if topic == HASH { "cairn.hash.v1" } else { "json" };
            *id = writer.add_channel(0, topic, encoding, &BTreeMap::new()).map_err(refuse)?;
        }
        let mut recorder = Self {
            live,
            writer,
            sink,
            written_at: run.steps(),
            channels,
            scan_channels: Vec::with_capacity(run.mission().n_robots()),
            viewers: Viewers::default(),
            n_interventions: 0,
            sequence: 0,
            scratch: Vec::new(),
        };
        let head = Head {
            format: FORMAT,
            cairn: env!("CARGO_PKG_VERSION").to_owned(),
            build: BUILD.to_owned(),
            seed: run.seed().0,
            mission: run.mission().to_toml(),
        };
        // A disk that is full or read-only is found out before the run.
        let begun = recorder
            .write_json(HEAD, run, &json!(head))
            .and_then(|()| recorder.write_rigs(run))
            .and_then(|()| recorder.begin_viewers(run))
            .and_then(|()| recorder.flush());
        match begun {
            Ok(()) => Ok(recorder),
            Err(error) => {
                recorder.live.discard();
                Err(error)
            }
        }
    }

    /// The name that the recording will have.
    pub fn path(&self) -> &Path {
        self.live.path()
    }

    /// The name that it has until it is finished, and keeps when the program is killed.
    pub fn part(&self) -> &Path {
        self.live.part()
    }

    /// What programs that were killed left beside it; it is kept as it is.
    pub fn left_behind(&self) -> &[PathBuf] {
        self.live.left_behind()
    }

    /// Writes what the last step brought; call it after every [`Run::step`], with the log entries
    /// drained since.
    ///
    /// # Errors
    ///
    /// [`RecordError`] when the file cannot be written.
    pub fn record(&mut self, run: &Run, log: &[LogItem]) -> Result<(), RecordError> {
        self.interventions(run)?;
        let mut bytes = [0; 16];
        bytes[..8].copy_from_slice(&run.steps().to_le_bytes());
        bytes[8..].copy_from_slice(&run.state_hash().value().to_le_bytes());
        self.write(HASH, run, &bytes)?;
        if run.steps().is_multiple_of(VIEW_STEPS) {
            let view = run.view();
            self.write_json(STATE, run, &view_json(&view))?;
            self.for_viewers(run, |viewers, now, tell| viewers.view(now, &view, tell))?;
        }
        self.write_scans(run)?;
        for item in log {
            let t_s = item.step as f64 * 0.01;
            let value = json!({"t_s": t_s, "level": item.level.name(), "text": item.text});
            self.write_json(LOG, run, &value)?;
            self.for_viewers(run, |viewers, now, tell| viewers.log(now, item, tell))?;
        }
        if run.steps().saturating_sub(self.written_at) >= PIECE_STEPS {
            self.written_at = run.steps();
            self.flush()?;
        }
        Ok(())
    }

    /// Writes out everything that was recorded; done by itself after every half second of the run. A program that
    /// steps the run slower than real time calls it once a second. The bytes are then with the operating system: they
    /// survive the end of the program, not a power failure ([`Recorder::finish`] waits for the disk).
    ///
    /// # Errors
    ///
    /// [`RecordError`] when the disk is full; the file then ends with the last whole piece.
    pub fn flush(&mut self) -> Result<(), RecordError> {
        let part = self.live.part().to_owned();
        let refuse = |source| RecordError::Mcap { path: part.clone(), source };
        self.writer.flush().map_err(refuse)?;
        if self.sink.is_empty() {
            return Ok(());
        }
        let check = self.sink.check();
        #[expect(clippy::default_trait_access, reason = "the set's own crate is not among ours")]
        let outside_chunks = Default::default();
        self.writer.write_private_record(CHECK_OPCODE, &check, outside_chunks).map_err(refuse)?;
        let io = |source| RecordError::Io { path: part.clone(), source };
        self.sink.write_out(self.live.file()).map_err(io)
    }

    /// Ends the recording and gives the file its name.
    ///
    /// # Errors
    ///
    /// [`RecordError`] when the file cannot be written; what there is stays under `….part`.
    pub fn finish(mut self, run: &Run) -> Result<PathBuf, RecordError> {
        self.interventions(run)?;
        let verdict = run.finished();
        let end = EndRecord {
            steps: run.steps(),
            passed: verdict.map(|v| v.passed),
            text: verdict.map_or_else(|| "not finished".to_owned(), |v| v.text.clone()),
        };
        self.write_json(END, run, &json!(end))?;
        self.flush()?;
        let part = self.live.part().to_owned();
        let refuse = |source| RecordError::Mcap { path: part.clone(), source };
        self.writer.finish().map_err(refuse)?;
        let io = |source| RecordError::Io { path: part.clone(), source };
        self.sink.write_out(self.live.file()).map_err(io)?;
        Ok(self.live.finish()?)
    }

    /// Each robot's rig, and a channel for its scans.
    fn write_rigs(&mut self, run: &Run) -> Result<(), RecordError> {
        let part = self.live.part().to_owned();
        let refuse = |source| RecordError::Mcap { path: part.clone(), source };
        let now = run.now();
        for plan in &run.mission().parts().robots {
            let mut begin = |name: &str, rig: &Rig| {
                let mut add = |topic: &str, encoding: &str| {
                    self.writer.add_channel(0, topic, encoding, &BTreeMap::new()).map_err(refuse)
                };
                let rig_channel = add(&rig_topic(name), RIG_ENCODING)?;
                let scan_channel = add(&scan_topic(name), SCAN_ENCODING)?;
                self.write_to(rig_channel, now, now, &encode_rig(rig)).map(|()| scan_channel)
            };
            // A robot that has lasers alone is not asked for its ring.
            let has_ring = !plan.model.sonars.is_empty() || plan.lasers.is_empty();
            let ring = has_ring.then(|| begin(&plan.name, &rig(plan))).transpose()?;
            let laser =
                |laser: &LaserPlan| begin(&sensor_name(&plan.name, &laser.name), &laser_rig(laser));
            let lasers = plan.lasers.iter().map(laser).collect::<Result<Vec<u16>, _>>()?;
            self.scan_channels.push((ring, lasers));
        }
        Ok(())
    }

    /// The channels of viewers, and what stays where it is.
    fn begin_viewers(&mut self, run: &Run) -> Result<(), RecordError> {
        let part = self.live.part().to_owned();
        let refuse = |source| RecordError::Mcap { path: part.clone(), source };
        let mut schemas = [0; viewers::SCHEMAS.len()];
        for (place, id) in schemas.iter_mut().enumerate() {
            let (name, encoding, text) = viewers::schema(place);
            *id = self.writer.add_schema(&name, encoding, text.as_bytes()).map_err(refuse)?;
        }
        let scene = run.scene();
        let mut channels = Vec::new();
        for (topic, schema) in Viewers::wanted(&scene) {
            let (schema, encoding) = (schemas[schema], viewers::ENCODING);
            let channel = self.writer.add_channel(schema, &topic, encoding, &BTreeMap::new());
            channels.push(channel.map_err(refuse)?);
        }
        self.viewers = Viewers::new(scene, &channels);
        self.for_viewers(run, Viewers::begin)
    }

    fn for_viewers(
        &mut self,
        run: &Run,
        put: impl FnOnce(
            &mut Viewers,
            Stamp,
            &mut viewers::Tell<'_, RecordError>,
        ) -> Result<(), RecordError>,
    ) -> Result<(), RecordError> {
        let mut viewers = std::mem::take(&mut self.viewers);
        let now = run.now();
        let done =
            put(&mut viewers, now, &mut |channel, data| self.write_to(channel, now, now, data));
        self.viewers = viewers;
        done
    }

    /// The rows that became whole in the last step.
    fn write_scans(&mut self, run: &Run) -> Result<(), RecordError> {
        let mut data = std::mem::take(&mut self.scratch);
        for (robot, sensed) in run.sensed().enumerate() {
            for row in sensed.rows {
                data.clear();
                encode_scan(&row.to_scan(), row.report.world_from_base, &mut data);
                let (Some(ring), _) = self.scan_channels[robot] else { continue };
                self.write_to(ring, run.now(), row.report.stamp, &data)?;
            }
            for row in sensed.scans {
                data.clear();
                encode_scan(&row.to_scan(), row.world_from_base, &mut data);
                let channel = self.scan_channels[robot].1[row.laser];
                self.write_to(channel, run.now(), row.stamp, &data)?;
                self.for_viewers(run, |viewers, _, tell| viewers.scan(robot, row, tell))?;
            }
        }
        self.scratch = data;
        Ok(())
    }

    fn interventions(&mut self, run: &Run) -> Result<(), RecordError> {
        for new in &run.interventions()[self.n_interventions..] {
            self.write_json(INTERVENTIONS, run, &json!(InterventionRecord::from(new)))?;
        }
        self.n_interventions = run.interventions().len();
        Ok(())
    }

    fn write_json(&mut self, topic: &str, run: &Run, value: &Value) -> Result<(), RecordError> {
        self.write(topic, run, value.to_string().as_bytes())
    }

    fn write(&mut self, topic: &str, run: &Run, data: &[u8]) -> Result<(), RecordError> {
        let topics = [HEAD, INTERVENTIONS, HASH, STATE, LOG, END];
        let place = topics.iter().position(|&t| t == topic).unwrap_or(0);
        self.write_to(self.channels[place], run.now(), run.now(), data)
    }

    fn write_to(
        &mut self,
        channel_id: u16,
        now: Stamp,
        about: Stamp,
        data: &[u8],
    ) -> Result<(), RecordError> {
        self.sequence = self.sequence.wrapping_add(1);
        let header = MessageHeader {
            channel_id,
            sequence: self.sequence,
            log_time: now.as_nanos(),
            publish_time: about.as_nanos(),
        };
        let refuse = |source| RecordError::Mcap { path: self.live.part().to_owned(), source };
        self.writer.write_to_known_channel(&header, data).map_err(refuse)
    }
}

fn pose(p: Pose) -> Value {
    json!([p.x_m, p.y_m, p.yaw_rad])
}

/// A view in the studio's terms.
fn view_json(view: &ViewState) -> Value {
    let person = |p: &crate::view::ViewPerson| json!({"name": p.name, "at": pose(p.at), "radius_m": p.radius_m});
    json!({
        "t_s": view.t_s,
        "step": view.step,
        "robots": view.robots.iter().map(robot_json).collect::<Vec<_>>(),
        "people": view.people.iter().map(person).collect::<Vec<_>>(),
        "things": view.things.iter().map(thing_json).collect::<Vec<_>>(),
        "devices": view.devices_on,
        "decision": view.decision.as_ref().map(decision_json),
        "figures": signals_json(Signal::of_run(), &view.signals),
    })
}

/// Signals by name.
fn signals_json<'s>(signals: impl Iterator<Item = &'s Signal>, values: &[Option<f64>]) -> Value {
    signals.zip(values).map(|(signal, value)| (signal.id.to_owned(), json!(value))).collect()
}

fn robot_json(r: &ViewRobot) -> Value {
    json!({
        "truth": pose(r.truth),
        "estimate": pose(r.estimate),
        "wheels_mps": r.wheels_mps,
        "sonar_m": r.sonar_m,
        "phase": r.phase,
        "avoider_state": r.avoider_state,
        "goal": r.goal.map(pose),
        "touching": r.touching,
        "signals": signals_json(Signal::of_robots(), &r.signals),
    })
}

fn thing_json(t: &SceneThing) -> Value {
    let corners: Vec<[f64; 2]> = t.corners_m.iter().map(|c| [c.x, c.y]).collect();
    json!({"id": t.id, "name": t.name, "kind": t.kind, "corners_m": corners})
}

fn decision_json(d: &ViewDecision) -> Value {
    let resources: BTreeMap<&str, u8> = d.resources.iter().map(|(n, v)| (n.as_str(), *v)).collect();
    let (last_move, move_state) = d.last_move;
    json!({
        "scans": d.scans,
        "resources": resources,
        "run": d.run,
        "outputs": d.outputs,
        "drives_outputs": d.drives_outputs,
        "fault": d.fault,
        "clock": d.clock,
        "watchdog_resets": d.n_watchdog_resets,
        "events": d.n_events,
        "last_move": last_move,
        "move_state": move_state,
    })
}
