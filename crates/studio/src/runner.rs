//! The thread that steps the run at the speed the page asks for, and publishes what it shows.
//!
//! The run lives on one thread and is stepped in whole steps; the clock only decides how many. What
//! is published is the newest state, so a slow page falls behind in frames, never in time.

use std::{
    path::{Path, PathBuf},
    sync::{Arc, Mutex, PoisonError, mpsc},
    time::{Duration, Instant},
};

use axum::extract::ws::Utf8Bytes;
use geometry::{Se2, Vec2};
use missions::{Direction, Intervention, LogItem as RunLog, LogLevel, Scene};
use run_context::RunSeed;
use serde::Serialize;
use tokio::sync::{broadcast, oneshot, watch};

use crate::{
    convert::{self, Pace},
    crowd,
    edges::Edges,
    history::History,
    library::Library,
    past::Past,
    places,
    protocol::{Log, LogItem, MissionInfo, PastHead, Refusal, Request, Trace},
    session::{Session, Show},
};

/// Time between two published states: 30 per second.
const FRAME: Duration = Duration::from_nanos(33_333_333);
/// Frames per published state when the robots are a crowd: ten states per second.
const FRAMES_PER_STATE_OF_CROWD: u64 = 3;
/// How late a frame may be and still be made up for.
const LATE_MAX: Duration = Duration::from_millis(150);
/// Frames between two times at which what was recorded is written out, whatever the speed: a second.
const FRAMES_PER_FLUSH: u64 = 30;
/// Time over which the achieved ratio is averaged, s.
const RATIO_MEMORY_S: f64 = 0.5;
/// Steps of a run per second of its time.
const STEPS_PER_SECOND: f64 = 100.0;
/// Steps that the button `step` takes: one control period of 200 ms.
const STEPS_PER_CLICK: u64 = 20;
/// Speeds that the page may ask for.
const SPEED_RATIO: std::ops::RangeInclusive<f64> = 0.1..=20.0;
/// Packets sent to the page per frame; more are left out, the newest kept.
const TRACE_ITEMS_MAX: usize = 60;
/// Events kept for a page that connects later.
const LOG_ITEMS_KEPT: usize = 200;
/// Messages that a slow page may lag behind before it misses some.
const NEWS_KEPT: usize = 64;
/// Requests that may wait. A page has one at a time, so they are never this many.
const N_REQUESTS_MAX: usize = 64;
/// Time between a run's beginning and the next one's, for all pages together.
const RESTART_PAUSE: Duration = Duration::from_millis(200);

type Answer = oneshot::Sender<Result<(), String>>;

/// A message as JSON, and the number of the run that it is about: after a restart nothing of the old
/// run may reach a page.
#[derive(Clone, Debug, Default)]
pub(crate) struct Told {
    pub run: u64,
    pub text: Utf8Bytes,
}

/// What has been, of the run of a number.
#[derive(Debug, Default)]
struct Before {
    run: u64,
    history: History,
    /// Of a recording there is none: it is wound to any time.
    states: Option<Past>,
}

/// The page's side of the runner.
#[derive(Clone, Debug)]
pub(crate) struct Remote {
    /// The newest greeting, JSON.
    pub hello: watch::Receiver<Told>,
    /// The newest state, JSON.
    pub state: watch::Receiver<Told>,
    /// The whole event log so far, JSON; for a page that connects.
    pub log: watch::Receiver<Told>,
    /// Traces and events as they come, JSON.
    pub news: broadcast::Sender<Told>,
    /// The past of the run of that number, for pages that connect or look back.
    past: Arc<Mutex<Before>>,
    requests: mpsc::SyncSender<(Request, Answer)>,
    /// When the last run began; held by whoever is about to begin another.
    begun: Arc<tokio::sync::Mutex<Option<tokio::time::Instant>>>,
}

impl Remote {
    /// Hands a request to the run.
    ///
    /// # Errors
    ///
    /// A sentence for the person at the page.
    pub(crate) async fn ask(&self, request: Request) -> Result<(), String> {
        if !matches!(request, Request::Restart { .. }) {
            return self.hand_over(request).await;
        }
        // A run that begins costs more than anything else that a page can ask for.
        let mut begun = self.begun.lock().await;
        if let Some(last) = *begun {
            tokio::time::sleep_until(last + RESTART_PAUSE).await;
        }
        let outcome = self.hand_over(request).await;
        *begun = Some(tokio::time::Instant::now());
        outcome
    }

    /// The past of a run, JSON; empty when another runs by now.
    pub(crate) fn past_of(&self, run: u64) -> Utf8Bytes {
        let mut past = self.past.lock().unwrap_or_else(PoisonError::into_inner);
        if past.run == run { past.history.text() } else { Utf8Bytes::default() }
    }

    /// What a run showed at a time, JSON; empty when another runs by now.
    ///
    /// # Errors
    ///
    /// A sentence for the person at the page.
    pub(crate) fn look_back(&self, run: u64, t_s: f64) -> Result<Utf8Bytes, String> {
        if !t_s.is_finite() {
            return Err("the time to look back to must be a number of seconds".to_owned());
        }
        let past = self.past.lock().unwrap_or_else(PoisonError::into_inner);
        if past.run != run {
            return Ok(Utf8Bytes::default());
        }
        let Some(states) = &past.states else {
            return Err("a recording is wound, not looked back on".to_owned());
        };
        let Some(state) = states.at(t_s) else {
            return Err("nothing has been shown yet".to_owned());
        };
        let head = PastHead { kind: "past", asked_s: t_s, kept: states.kept() };
        let mut text = serde_json::to_string(&head).unwrap_or_default();
        // The state is text already: it takes the place of the brace.
        text.truncate(text.len().saturating_sub(1));
        text.reserve(state.len() + 10);
        text.push_str(",\"state\":");
        text.push_str(state);
        text.push('}');
        Ok(text.into())
    }

    async fn hand_over(&self, request: Request) -> Result<(), String> {
        let (answer, answered) = oneshot::channel();
        let gone = || "the run has been shut down".to_owned();
        self.requests.try_send((request, answer)).map_err(|error| match error {
            mpsc::TrySendError::Full(_) => "too much is asked for at once; try again".to_owned(),
            mpsc::TrySendError::Disconnected(_) => gone(),
        })?;
        answered.await.unwrap_or_else(|_gone| Err(gone()))
    }
}

/// Where the runner publishes.
struct Outlets {
    hello: watch::Sender<Told>,
    state: watch::Sender<Told>,
    log: watch::Sender<Told>,
    news: broadcast::Sender<Told>,
}

/// A run, how it is paced, and who watches.
pub(crate) struct Runner {
    show: Show,
    library: Arc<Mutex<Library>>,
    /// The mission's name in the list.
    mission_name: String,
    past: Arc<Mutex<Before>>,
    session: Session,
    scene: Scene,
    edges: Edges,
    /// Restarts so far.
    run_number: u64,
    /// The recordings that restarts completed.
    recorded: Vec<PathBuf>,
    /// What went wrong with a recording, the first time.
    recording_failed: Option<String>,
    /// What the run said since the last frame.
    said: Vec<RunLog>,
    log: Vec<LogItem>,
    playing: bool,
    speed_ratio: f64,
    achieved_ratio: f64,
    /// When the last frame was, while time runs.
    advanced_at: Option<Instant>,
    /// Steps owed to the page's clock; below one between frames.
    steps_due: f64,
    verdict_seen: bool,
    /// The step of a recording that is looked for.
    seeks: Option<u64>,
    outlets: Outlets,
    requests: mpsc::Receiver<(Request, Answer)>,
}

impl Runner {
    /// Makes a runner and the remote that steers it.
    pub(crate) fn new(
        mut show: Show,
        library: Arc<Mutex<Library>>,
        speed_ratio: f64,
    ) -> Result<(Self, Remote), String> {
        let session = Session::start(&mut show)?;
        // A real robot's time cannot be hurried or slowed.
        let speed_ratio = if session.run().mission().has_real_robot() {
            1.0
        } else {
            speed_ratio.clamp(*SPEED_RATIO.start(), *SPEED_RATIO.end())
        };
        let (hello, hello_out) = watch::channel(Told::default());
        let (state, state_out) = watch::channel(Told::default());
        let (log, log_out) = watch::channel(Told::default());
        let (news, _) = broadcast::channel(NEWS_KEPT);
        let (ask, requests) = mpsc::sync_channel(N_REQUESTS_MAX);
        let past = Arc::default();
        let mission_name = match &show {
            Show::Mission { mission, .. } => in_list(&library).keep(mission),
            Show::Replay(_) => session.run().mission().name().to_owned(),
        };
        let remote = Remote {
            hello: hello_out,
            state: state_out,
            log: log_out,
            news: news.clone(),
            past: Arc::clone(&past),
            requests: ask,
            begun: Arc::default(),
        };
        let mut runner = Self {
            show,
            library,
            mission_name,
            past,
            session,
            scene: Scene::default(),
            edges: Edges::default(),
            run_number: 0,
            recorded: Vec::new(),
            recording_failed: None,
            said: Vec::new(),
            log: Vec::new(),
            playing: true,
            speed_ratio,
            achieved_ratio: speed_ratio,
            advanced_at: None,
            steps_due: 0.0,
            verdict_seen: false,
            seeks: None,
            outlets: Outlets { hello, state, log, news },
            requests,
        };
        runner.greet();
        Ok((runner, remote))
    }

    /// Steps and publishes until every remote is gone or `stop` says so. Gives the paths of the recordings; an
    /// error when one could not be written to its end.
    pub(crate) fn drive(mut self, stop: impl Fn() -> bool) -> Result<Vec<PathBuf>, String> {
        let mut frame_begins = Instant::now();
        self.publish();
        for frame in 0_u64.. {
            if stop() {
                break;
            }
            if self.seeks.is_some() {
                self.seek_on();
            } else if self.playing {
                self.advance();
                if frame.is_multiple_of(self.frames_per_state()) || !self.playing {
                    self.publish();
                }
            }
            if frame.is_multiple_of(FRAMES_PER_FLUSH)
                && let Err(text) = self.session.flush()
            {
                self.recording_fails(text);
            }
            frame_begins += FRAME;
            // A frame that came late is made up for. When the machine cannot keep up at all or was
            // asleep: start anew instead of racing.
            let now = Instant::now();
            if now.saturating_duration_since(frame_begins) > LATE_MAX {
                frame_begins = now;
            }
            if !self.listen(frame_begins) {
                break;
            }
        }
        self.recorded.extend(self.session.finish()?);
        self.recording_failed.map_or(Ok(self.recorded), Err)
    }

    fn frames_per_state(&self) -> u64 {
        let is_crowd = crowd::n_robots_in_full(&self.scene) < self.scene.robots.len();
        if is_crowd { FRAMES_PER_STATE_OF_CROWD } else { 1 }
    }

    /// Carries out what is asked for until the frame ends; `false` when nobody can ask any more.
    ///
    /// What waits already is carried out together and shown in one state: many pages that ask without a pause get
    /// no more states than the frames have.
    fn listen(&mut self, frame_ends: Instant) -> bool {
        let mut answers = Vec::new();
        loop {
            let rest = if answers.is_empty() {
                frame_ends.saturating_duration_since(Instant::now())
            } else {
                Duration::ZERO
            };
            match self.requests.recv_timeout(rest) {
                Ok((request, answer)) => answers.push((answer, self.carry_out(request))),
                Err(mpsc::RecvTimeoutError::Timeout) if answers.is_empty() => return true,
                Err(mpsc::RecvTimeoutError::Timeout) => self.answer(&mut answers),
                Err(mpsc::RecvTimeoutError::Disconnected) => return false,
            }
            if Instant::now() >= frame_ends {
                self.answer(&mut answers);
                return true;
            }
        }
    }

    /// Shows what became of the requests, and answers them.
    fn answer(&mut self, answers: &mut Vec<(Answer, Result<(), String>)>) {
        if answers.is_empty() {
            return;
        }
        // On the way to another time nothing is shown.
        if self.seeks.is_none() {
            self.publish();
        }
        for (answer, outcome) in answers.drain(..) {
            // A page that left does not wait for its answer.
            drop(answer.send(outcome));
        }
    }

    /// Takes the steps of one frame, and no more than fit into it.
    fn advance(&mut self) {
        let begins = Instant::now();
        let wanted = FRAME.as_secs_f64() * self.speed_ratio * STEPS_PER_SECOND;
        self.steps_due += wanted;
        let mut taken = 0.0;
        while self.steps_due >= 1.0 {
            if begins.elapsed() > FRAME.mul_f64(0.9) {
                // Behind: the rest is dropped, and the page sees the ratio that was achieved.
                self.steps_due = 0.0;
                break;
            }
            self.steps_due -= 1.0;
            taken += 1.0;
            if !self.step() {
                break;
            }
        }
        self.measure(begins, taken / STEPS_PER_SECOND);
    }

    /// Brings the achieved ratio up to date: time simulated by the time since the last frame.
    fn measure(&mut self, frame_begins: Instant, simulated_s: f64) {
        if let Some(before) = self.advanced_at.replace(frame_begins) {
            let passed_s = frame_begins.duration_since(before).as_secs_f64().max(1e-3);
            let weight = (passed_s / RATIO_MEMORY_S).min(1.0);
            self.achieved_ratio += weight * (simulated_s / passed_s - self.achieved_ratio);
        }
    }

    /// One step; `false` when time stands still after it: at the verdict, once, so that people see it
    /// (whoever plays on may watch what happens next), and at the end of a recording.
    fn step(&mut self) -> bool {
        let more = match self.session.step(&mut self.said) {
            Ok(more) => more,
            Err(text) => {
                self.recording_fails(text);
                true
            }
        };
        self.edges.look(self.session.run());
        self.remember();
        let verdict_falls = !self.verdict_seen && self.session.run().finished().is_some();
        self.verdict_seen |= verdict_falls;
        if verdict_falls || !more {
            self.playing = false;
            self.steps_due = 0.0;
            self.session.hold();
        }
        more && !verdict_falls
    }

    /// Keeps what pages may want to see later.
    fn remember(&self) {
        let run = self.session.run();
        let mut past = self.past.lock().unwrap_or_else(PoisonError::into_inner);
        past.history.look(run);
        let Some(states) = past.states.as_mut().filter(|states| states.wants(run.steps())) else {
            return;
        };
        let pace = Pace { playing: true, speed_ratio: 1.0, achieved_ratio: 1.0 };
        let state = convert::state(run, &self.scene, pace, Vec::new());
        states.keep(state.t_s, serde_json::to_string(&state).unwrap_or_default());
    }

    /// A recording that cannot go on: said on the page at once, and in the exit code at the end.
    fn recording_fails(&mut self, text: String) {
        self.tell(&Refusal { text: text.clone() });
        let step = self.session.run().steps();
        self.said.push(RunLog { step, level: LogLevel::Bad, text: text.clone() });
        self.recording_failed.get_or_insert(text);
    }

    /// What was achieved before says nothing about what comes.
    fn pace_afresh(&mut self) {
        self.achieved_ratio = self.speed_ratio;
        self.advanced_at = None;
    }

    fn carry_out(&mut self, request: Request) -> Result<(), String> {
        match request {
            Request::Play => {
                self.playing = true;
                self.pace_afresh();
            }
            Request::Pause => {
                self.playing = false;
                self.session.hold();
            }
            Request::Step => {
                self.playing = false;
                for _ in 0..STEPS_PER_CLICK {
                    if !self.step() {
                        break;
                    }
                }
                self.session.hold();
            }
            Request::Speed { ratio } => {
                if !SPEED_RATIO.contains(&ratio) {
                    return Err(format!("the speed must be from 0.1 to 20, not {ratio}"));
                }
                if self.has_real_robot() && (ratio - 1.0).abs() > 1e-9 {
                    return Err("a real robot's time cannot be hurried or slowed".to_owned());
                }
                self.speed_ratio = ratio;
                self.pace_afresh();
            }
            Request::Restart { seed, mission } => self.restart(seed, mission.as_deref())?,
            Request::Place { at_m: [x, y], size_m } => {
                self.session.apply(Intervention::PlaceBox { at: Vec2::new(x, y), size_m })?;
            }
            Request::Remove { id } => {
                self.session.apply(Intervention::RemoveThing { id })?;
            }
            Request::Goal { robot, pose: [x, y, yaw] } => {
                if !(x.is_finite() && y.is_finite() && yaw.is_finite()) {
                    return Err("a goal needs three finite numbers".to_owned());
                }
                if !self.session.is_replay() {
                    let run = self.session.run();
                    places::check_goal(&run.scene(), &run.view().things, Vec2::new(x, y))?;
                }
                self.session
                    .apply(Intervention::SendGoal { robot, goal_in_map: Se2::new(x, y, yaw) })?;
            }
            Request::Stop { robot } => self.session.apply(Intervention::Stop { robot })?,
            Request::Seek { t_s } => self.seek(t_s)?,
            Request::Drive { robot, speed_mps, turn_rate_radps } => {
                self.drive_by_hand(Intervention::Drive { robot, speed_mps, turn_rate_radps })?;
            }
            Request::Past { .. } => {
                return Err("looking back is answered without the run".to_owned());
            }
            Request::Cut { robot, line, cut } => {
                let direction = Direction::Both;
                self.session.apply(if cut {
                    Intervention::CutLink { robot, line, direction }
                } else {
                    Intervention::RestoreLink { robot, line, direction }
                })?;
            }
            Request::Press { device } => {
                self.session.apply(Intervention::PressButton { device })?;
            }
        }
        Ok(())
    }

    /// Begins to look for a time of a recording. Backwards it is run again from its beginning: every step is the same
    /// however it was reached.
    fn seek(&mut self, t_s: f64) -> Result<(), String> {
        let Some(outline) = self.session.outline() else {
            return Err(
                "only a recording can be wound; a run that is live has no other time".to_owned()
            );
        };
        if !t_s.is_finite() {
            return Err("the time to go to must be a number of seconds".to_owned());
        }
        // Casts from floats saturate.
        let step = ((t_s * STEPS_PER_SECOND).round().max(0.0) as u64).min(outline.n_steps);
        if step < self.session.run().steps() {
            self.session.rewind()?;
            self.said.clear();
            self.log.clear();
            self.steps_due = 0.0;
            self.verdict_seen = false;
            self.begin();
            self.say_notes();
        }
        self.seeks = Some(step);
        Ok(())
    }

    /// Goes on to the time that is looked for, as far as a frame allows.
    fn seek_on(&mut self) {
        let begins = Instant::now();
        while self.seeks.is_some_and(|step| self.session.run().steps() < step) {
            if begins.elapsed() > FRAME.mul_f64(0.8) {
                return;
            }
            let (playing, steps) = (self.playing, self.session.run().steps());
            self.step();
            // The verdict holds time when it is played, not when it is passed over.
            self.playing = playing;
            if self.session.run().steps() == steps {
                break;
            }
        }
        self.seeks = None;
        drop(self.session.run_mut().drain_trace());
        self.run_number += 1;
        self.pace_afresh();
        self.announce();
        self.publish();
    }

    /// Nobody steers what is faster than life.
    fn drive_by_hand(&mut self, drive: Intervention) -> Result<(), String> {
        if !self.playing && !self.session.is_replay() {
            return Err("time stands still: press Play to drive".to_owned());
        }
        self.session.apply(drive)?;
        if self.speed_ratio > 1.0 {
            self.speed_ratio = 1.0;
            self.pace_afresh();
        }
        Ok(())
    }

    fn has_real_robot(&self) -> bool {
        self.session.run().mission().has_real_robot()
    }

    fn restart(&mut self, seed: Option<u64>, mission: Option<&str>) -> Result<(), String> {
        if self.has_real_robot() {
            let text = "a run with a real robot holds its line; end the program and start it again";
            return Err(text.to_owned());
        }
        let mut show = self.show.clone();
        if let Some(name) = mission {
            let mission = in_list(&self.library).find(name)?;
            let seed = mission.seed();
            let record = match show {
                Show::Mission { record, .. } => record,
                Show::Replay(_) => None,
            };
            show = Show::Mission { mission: Box::new(mission), seed, record };
        }
        if let Show::Mission { seed: present, .. } = &mut show {
            *present = seed.map_or(*present, RunSeed);
        }
        let ended = std::mem::replace(&mut self.session, Session::start(&mut show)?);
        self.mission_name = mission.map_or_else(|| self.mission_name.clone(), str::to_owned);
        let recorded = ended.finish();
        self.run_number += 1;
        self.show = show;
        self.said.clear();
        self.log.clear();
        self.steps_due = 0.0;
        self.verdict_seen = false;
        self.seeks = None;
        self.playing = true;
        self.pace_afresh();
        self.greet();
        match recorded {
            Ok(path) => self.recorded.extend(path),
            Err(text) => self.recording_fails(text),
        }
        Ok(())
    }

    /// Publishes the greeting of a new run.
    fn greet(&mut self) {
        self.begin();
        self.announce();
        self.say_notes();
    }

    /// What a person should know of what is shown: where it is recorded, or what is wrong with the recording.
    fn say_notes(&mut self) {
        let step = self.session.run().steps();
        let notes = self.session.notes().into_iter();
        self.said.extend(notes.map(|(level, text)| RunLog { step, level, text }));
    }

    /// Looks at a run that begins.
    fn begin(&mut self) {
        let run = self.session.run_mut();
        self.scene = run.scene();
        // A crowd has no links to look at.
        run.set_trace(crowd::n_robots_in_full(&self.scene) == self.scene.robots.len());
        self.edges = Edges::of(run);
        let in_full = crowd::n_robots_in_full(&self.scene);
        let states = !self.session.is_replay();
        {
            let mut past = self.past.lock().unwrap_or_else(PoisonError::into_inner);
            past.history = History::new(in_full);
            past.states = states.then(|| Past::new(in_full < self.scene.robots.len()));
        }
        self.remember();
    }

    /// Greets every page anew, with all that was said so far.
    fn announce(&mut self) {
        self.past.lock().unwrap_or_else(PoisonError::into_inner).run = self.run_number;
        let recording = self.session.recording().and_then(Path::file_name);
        let outline = self.session.outline();
        let seconds = |step: u64| step as f64 / STEPS_PER_SECOND;
        let marks = outline.map_or(&[][..], |outline| &outline.marks);
        let run = self.session.run();
        let mission = run.mission();
        let info = MissionInfo {
            name: self.mission_name.clone(),
            title: mission.title().to_owned(),
            about: mission.about().to_owned(),
            seed: run.seed().0,
            duration_max_s: mission.duration_max().as_secs_f64(),
            kind: if self.show.is_replay() { "replay" } else { "live" },
            recording: recording.map(|name| name.to_string_lossy().into_owned()),
            length_s: outline.map(|outline| seconds(outline.n_steps)),
            marks: marks.iter().map(|m| (seconds(m.step), m.by_person, m.text.clone())).collect(),
        };
        // Differs from every other run of this and of other programs on this port.
        let number = format!("{}-{}", std::process::id(), self.run_number);
        let missions = in_list(&self.library).names();
        let hello = convert::hello(number, info, &missions, &self.scene);
        // The log first: a page that is greeted looks at it at once.
        self.outlets.log.send_replace(self.told(&Log { items: self.log.clone() }));
        self.outlets.hello.send_replace(self.told(&hello));
    }

    fn publish(&mut self) {
        let trace = self.session.run_mut().drain_trace();
        let newest = trace.len().saturating_sub(TRACE_ITEMS_MAX);
        if !trace.is_empty() {
            let items = trace[newest..].iter().map(convert::trace_item).collect();
            self.tell(&Trace { items });
        }
        self.said.extend(self.session.run_mut().drain_log());
        let items: Vec<_> = self.said.drain(..).map(|item| convert::log_item(&item)).collect();
        if !items.is_empty() {
            self.log.extend(items.iter().cloned());
            let surplus = self.log.len().saturating_sub(LOG_ITEMS_KEPT);
            self.log.drain(..surplus);
            self.outlets.log.send_replace(self.told(&Log { items: self.log.clone() }));
            self.tell(&Log { items });
        }
        let pace = Pace {
            playing: self.playing,
            speed_ratio: self.speed_ratio,
            achieved_ratio: if self.playing { self.achieved_ratio } else { 0.0 },
        };
        let edges = self.edges.publish();
        self.past.lock().unwrap_or_else(PoisonError::into_inner).history.keep_edges(&edges);
        let state = convert::state(self.session.run(), &self.scene, pace, edges);
        self.outlets.state.send_replace(self.told(&state));
    }

    /// Tells every page that listens; that none does is no error.
    fn tell(&self, message: &impl Serialize) {
        drop(self.outlets.news.send(self.told(message)));
    }

    /// A message of the present run. Our messages hold strings, finite numbers and lists only, which
    /// always have a text.
    fn told(&self, message: &impl Serialize) -> Told {
        let text = serde_json::to_string(message).unwrap_or_default();
        Told { run: self.run_number, text: text.into() }
    }
}

/// A list that a page damaged while it looked is still a list.
fn in_list(library: &Mutex<Library>) -> std::sync::MutexGuard<'_, Library> {
    library.lock().unwrap_or_else(PoisonError::into_inner)
}
