//! The thread that plays a recording into one or two surveys, as fast as the page asks for.
//!
//! Surveys live on this thread and take whole scans; the clock only decides how many. A frame takes
//! as many as fit into it, so requests are answered even while a long log is mapped as fast as possible.

use std::{
    sync::{Arc, mpsc},
    time::{Duration, Instant},
};

use tokio::sync::{OwnedMutexGuard, oneshot};

use super::{
    board::Board,
    job::Job,
    parameters::parameters,
    protocol::{Request, Source, State},
    run::{Finishing, Phase, Run},
    source::Loaded,
    stage::{N_SLOTS, Stage},
};
use crate::description::{self, SurveyHas};

/// Time between two published states.
const FRAME: Duration = Duration::from_nanos(33_333_333);
/// How late a frame may be and still be made up for.
const LATE_MAX: Duration = Duration::from_millis(150);
/// Speeds that the page may ask for.
const SPEED_RATIO: std::ops::RangeInclusive<f64> = 0.1..=200.0;
/// The speed at the start.
const SPEED_RATIO_FIRST: f64 = 10.0;
/// Pauses of a recording longer than this, in the page's time, are skipped, s.
const GAP_MAX_S: f64 = 1.0;
/// Time over which the achieved ratio is averaged, s.
const RATIO_MEMORY_S: f64 = 0.5;

/// The answer to a request: a sentence for the person at the page if it cannot be carried out.
pub(crate) type Answer = oneshot::Sender<Result<(), String>>;

/// What the player is asked for.
#[derive(Debug)]
pub(crate) enum Ask {
    /// By a page.
    Page(Request, Answer),
    /// A file is being read.
    Reading(String),
    /// It was read; and the right to read the next one, given back when this one is taken.
    Load(Box<Loaded>, Option<OwnedMutexGuard<()>>),
    /// It could not be read.
    Unreadable {
        /// Its name.
        name: String,
        /// Why.
        problem: String,
    },
}

/// Plays, paints and answers.
#[derive(Debug)]
pub(crate) struct Player {
    stage: Stage,
    asks: mpsc::Receiver<Ask>,
    source: Source,
    loaded: Option<Arc<Loaded>>,
    /// The recording that gave way to the one that is being read.
    put_away: Option<String>,
    runs: Vec<Run>,
    n_runs: u32,
    finishing: Finishing,
    playing: bool,
    /// As fast as possible until so many scans are done.
    goal: Option<usize>,
    speed_ratio: f64,
    achieved_ratio: f64,
    /// Time of the recording that has been played, s.
    clock_s: f64,
    advanced_at: Option<Instant>,
    /// Parameters in which two runs differ.
    differences: Vec<[String; 3]>,
}

impl Player {
    /// A player without a recording.
    pub(crate) fn new(stage: Stage, asks: mpsc::Receiver<Ask>) -> Self {
        Self {
            stage,
            asks,
            source: Source {
                phase: "empty",
                offer: description::of_survey(SurveyHas::default()),
                ..Source::default()
            },
            loaded: None,
            put_away: None,
            runs: Vec::new(),
            n_runs: 0,
            finishing: Finishing::default(),
            playing: false,
            goal: None,
            speed_ratio: SPEED_RATIO_FIRST,
            achieved_ratio: SPEED_RATIO_FIRST,
            clock_s: 0.0,
            advanced_at: None,
            differences: Vec::new(),
        }
    }

    /// Plays until nobody can ask any more or `stop` says so.
    pub(crate) fn drive(mut self, stop: impl Fn() -> bool) {
        self.stage.show_source(&self.source);
        self.publish();
        let mut frame_begins = Instant::now();
        while !stop() {
            let mut has_news = self.take_back();
            if self.playing {
                self.advance();
                has_news = true;
            }
            if has_news {
                self.publish();
            }
            frame_begins += FRAME;
            let now = Instant::now();
            if now.saturating_duration_since(frame_begins) > LATE_MAX {
                frame_begins = now;
            }
            if !self.listen(frame_begins) {
                break;
            }
        }
    }

    /// Carries out what is asked for until the frame ends; `false` when nobody can ask any more.
    fn listen(&mut self, frame_ends: Instant) -> bool {
        loop {
            let rest = frame_ends.saturating_duration_since(Instant::now());
            match self.asks.recv_timeout(rest) {
                Ok(Ask::Page(request, answer)) => {
                    let outcome = self.carry_out(request);
                    self.publish();
                    // A page that left does not wait for its answer.
                    drop(answer.send(outcome));
                }
                Ok(Ask::Reading(name)) => {
                    self.make_room();
                    self.source.phase = "reading";
                    self.source.name = name;
                    self.source.problem = None;
                    self.stage.show_source(&self.source);
                }
                Ok(Ask::Load(loaded, _reading)) => self.load(*loaded),
                Ok(Ask::Unreadable { name, problem }) => self.refuse(name, problem),
                Err(mpsc::RecvTimeoutError::Timeout) => return true,
                Err(mpsc::RecvTimeoutError::Disconnected) => return false,
            }
            if Instant::now() >= frame_ends {
                return true;
            }
        }
    }

    /// Takes back runs that were finished.
    fn take_back(&mut self) -> bool {
        self.runs.iter_mut().filter_map(|run| run.take_back().then_some(())).count() > 0
    }

    /// Puts a large recording of a page away before the next one comes: there is no room for both.
    fn make_room(&mut self) {
        let Some(loaded) = self.loaded.take_if(|loaded| loaded.gives_way()) else { return };
        self.put_away = Some(loaded.name.clone());
        self.runs.clear();
        self.stage.take_boards();
        self.source.recording = None;
    }

    /// What was there before stays, unless it had to make room.
    fn refuse(&mut self, name: String, mut problem: String) {
        if let Some(before) = self.put_away.take() {
            problem = format!("{problem}; {before} was put away to make room, open it again");
        }
        self.source.phase = if self.loaded.is_some() { "ready" } else { "empty" };
        self.source.name = self.loaded.as_ref().map_or(name, |loaded| loaded.name.clone());
        self.source.problem = Some(problem);
        self.stage.show_source(&self.source);
    }

    fn load(&mut self, loaded: Loaded) {
        let loaded = Arc::new(loaded);
        match Job::start(&loaded, &loaded.values) {
            Ok(job) => {
                let info = loaded.info();
                let has = SurveyHas { sonar: info.rig == "sonar", truth: info.has_truth };
                self.source = Source {
                    phase: "ready",
                    name: loaded.name.clone(),
                    problem: None,
                    recording: Some(info),
                    parameters: parameters(),
                    offer: description::of_survey(has),
                };
                self.loaded = Some(loaded);
                self.put_away = None;
                self.runs.clear();
                self.stage.take_boards();
                self.add_run(job, None);
                self.stage.show_source(&self.source);
                self.goal = None;
                self.play_on();
                self.publish();
            }
            Err(problem) => self.refuse(loaded.name.clone(), problem),
        }
    }

    /// Adds a run behind the one that stays, if any, with its board.
    fn add_run(&mut self, job: Job, keep: Option<usize>) {
        self.keep_only(keep);
        self.n_runs += 1;
        let (run, board) = Run::begin(self.n_runs, job);
        let [kept, _] = self.stage.take_boards();
        let boards = if kept.is_some() { [kept, Some(board)] } else { [Some(board), None] };
        self.stage.set_boards(boards);
        self.runs.push(run);
        self.differences = self.differences();
    }

    /// Drops every run but one, which moves to the first slot.
    fn keep_only(&mut self, keep: Option<usize>) {
        let mut boards = self.stage.take_boards();
        let kept = keep.filter(|&slot| slot < self.runs.len());
        let board = kept.and_then(|slot| boards.get_mut(slot)?.take());
        self.stage.set_boards([board, None]);
        let runs = std::mem::take(&mut self.runs);
        self.runs.extend(kept.and_then(|slot| runs.into_iter().nth(slot)));
        self.differences.clear();
    }

    fn play_on(&mut self) {
        self.playing = self.runs.iter().any(Run::goes_on);
        self.achieved_ratio = self.speed_ratio;
        self.advanced_at = None;
        self.clock_s = self
            .runs
            .iter()
            .filter(|run| run.goes_on())
            .map(Run::t_s)
            .fold(f64::INFINITY, f64::min);
    }

    fn carry_out(&mut self, request: Request) -> Result<(), String> {
        let Some(loaded) = self.loaded.clone() else {
            return Err("there is no recording yet; open a log first".to_owned());
        };
        match request {
            Request::Play => {
                self.goal = None;
                self.play_on();
            }
            Request::Pause => {
                self.playing = false;
                self.goal = None;
            }
            Request::Step => self.step_once(),
            Request::Speed { ratio } => {
                if !SPEED_RATIO.contains(&ratio) {
                    return Err(format!("the speed must be from 0.1 to 200, not {ratio}"));
                }
                self.speed_ratio = ratio;
                self.achieved_ratio = ratio;
                self.advanced_at = None;
            }
            Request::Seek { scan } => {
                // The run that stays for comparison may be ahead; it is not begun again for that.
                if self.runs.last().is_some_and(|run| run.n_done() > scan) {
                    self.rewind(&loaded)?;
                }
                self.play_on();
                self.goal = Some(scan);
            }
            Request::Rewind => {
                self.rewind(&loaded)?;
                self.goal = None;
                self.play_on();
            }
            Request::Run { values, keep } => {
                let job = Job::start(&loaded, &values)?;
                self.add_run(job, Some(keep));
                self.goal = None;
                self.play_on();
            }
            Request::Keep { slot } => {
                if slot >= self.runs.len() {
                    return Err(format!("there is no run in slot {slot}"));
                }
                self.keep_only(Some(slot));
                self.playing &= self.runs.iter().any(Run::goes_on);
            }
            // Made outside of this thread, and then loaded.
            Request::Sample { name } => return Err(format!("there is no sample `{name}`")),
        }
        Ok(())
    }

    /// Every run from its first scan, with the parameters that it has.
    fn rewind(&mut self, loaded: &Arc<Loaded>) -> Result<(), String> {
        let jobs: Result<Vec<_>, String> =
            self.runs.iter().map(|run| Job::start(loaded, &run.values)).collect();
        let jobs = jobs?;
        self.stage.take_boards();
        let mut boards: [Option<Board>; N_SLOTS] = Default::default();
        for ((run, job), board) in self.runs.iter_mut().zip(jobs).zip(&mut boards) {
            self.n_runs += 1;
            let (begun, fresh) = Run::begin(self.n_runs, job);
            (*run, *board) = (begun, Some(fresh));
        }
        self.stage.set_boards(boards);
        Ok(())
    }

    fn step_once(&mut self) {
        self.playing = false;
        self.goal = None;
        if let Some(run) = self.next_to_step(|_| true) {
            run.step();
        } else {
            self.finish_one();
        }
    }

    /// The run that lags behind most, of those that have scans left and are `wanted`.
    fn next_to_step(&mut self, wanted: impl Fn(&Run) -> bool) -> Option<&mut Run> {
        let going = |run: &&mut Run| {
            run.phase == Phase::UnderWay && run.next_t_s().is_some() && wanted(run)
        };
        self.runs.iter_mut().filter(going).min_by_key(|run| run.n_done())
    }

    /// Takes the scans of one frame, and no more than fit into it.
    fn advance(&mut self) {
        let begins = Instant::now();
        let t_before_s = self.clock_s;
        if self.goal.is_none() {
            self.clock_s += FRAME.as_secs_f64() * self.speed_ratio;
            let next_s = self.runs.iter().filter_map(Run::next_t_s).fold(f64::INFINITY, f64::min);
            if next_s.is_finite() && next_s - self.clock_s > GAP_MAX_S * self.speed_ratio {
                self.clock_s = next_s;
            }
        }
        let (clock_s, goal) = (self.clock_s, self.goal);
        let due = move |run: &Run| match goal {
            Some(scan) => run.n_done() < scan,
            None => run.next_t_s().is_some_and(|t_s| t_s <= clock_s),
        };
        let mut reached_s = None;
        loop {
            let Some(run) = self.next_to_step(due) else {
                self.settle();
                break;
            };
            run.step();
            reached_s = Some(run.t_s());
            if begins.elapsed() > FRAME.mul_f64(0.9) {
                // Behind: the rest is dropped, and the page sees the ratio that was achieved.
                self.clock_s = run.t_s();
                break;
            }
        }
        let played_s = if goal.is_none() { self.clock_s } else { reached_s.unwrap_or(t_before_s) };
        self.clock_s = played_s;
        self.measure(begins, (played_s - t_before_s).max(0.0));
    }

    /// Nothing is due any more: finishes runs whose scans are all in, and holds when there is nothing left to do.
    fn settle(&mut self) {
        let finished_one = self.finish_one();
        let any_left = self.runs.iter().any(|run| match self.goal {
            Some(scan) => run.phase == Phase::UnderWay && run.n_done() < scan,
            None => run.goes_on(),
        });
        let finishing = self.runs.iter().any(|run| run.phase == Phase::Finishing);
        if !any_left && !finishing && !finished_one {
            self.playing = false;
            self.goal = None;
        }
    }

    /// Sees to one run whose scans are all in: it is announced, and finished beside this thread.
    fn finish_one(&mut self) -> bool {
        let all_in = |run: &Run| {
            run.phase == Phase::Finishing
                || (run.phase == Phase::UnderWay && run.next_t_s().is_none())
        };
        let Some(slot) = self.runs.iter().position(all_in) else { return false };
        if self.runs[slot].phase != Phase::Finishing {
            self.runs[slot].phase = Phase::Finishing;
            self.publish();
        }
        self.runs[slot].finish(slot, &self.stage, &self.finishing);
        true
    }

    /// Brings the achieved ratio up to date: time played by the time since the last frame.
    fn measure(&mut self, frame_begins: Instant, played_s: f64) {
        if let Some(before) = self.advanced_at.replace(frame_begins) {
            let passed_s = frame_begins.duration_since(before).as_secs_f64().max(1e-3);
            let weight = (passed_s / RATIO_MEMORY_S).min(1.0);
            self.achieved_ratio += weight * (played_s / passed_s - self.achieved_ratio);
        }
    }

    /// Paints what changed and tells the pages.
    fn publish(&mut self) {
        for (slot, run) in self.runs.iter_mut().enumerate() {
            run.paint(slot, &self.stage, !self.playing);
        }
        let state = State {
            playing: self.playing,
            hurrying: self.playing && self.goal.is_some(),
            speed_ratio: self.speed_ratio,
            achieved_ratio: if self.playing { self.achieved_ratio } else { 0.0 },
            runs: self
                .runs
                .iter()
                .enumerate()
                .map(|(slot, run)| run.state(slot, &self.stage))
                .collect(),
            differences: self.differences.clone(),
        };
        self.stage.show_state(&state);
    }

    /// Parameters in which the two runs differ.
    fn differences(&self) -> Vec<[String; 3]> {
        let [a, b] = self.runs.as_slice() else { return Vec::new() };
        let keys = self.source.parameters.iter().map(|parameter| parameter.key);
        keys.map(|key| [key.to_owned(), a.value(key), b.value(key)])
            .filter(|[_, a, b]| a != b)
            .collect()
    }
}
