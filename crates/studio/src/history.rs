//! What a run has been through, for pages that come late: the ways driven and the curves of the plots.
//!
//! Samples are taken at first every 0.1 s of the run's time; when there are as many as may be kept, every second one
//! is dropped and the time between two doubles. So memory is bounded and the whole past is there, however long.

use axum::extract::ws::Utf8Bytes;
use missions::{Run, Signal, ViewRobot};
use serde_json::{Map, Value, json};

use crate::protocol::Edge;

/// Steps between two samples at first.
const N_STEPS_FIRST: u64 = 10;
/// Samples kept for one robot; fewer for many, so that the message stays below half a megabyte.
const N_SAMPLES_MAX: usize = 3000;
/// Changes of the decision program's booleans that are kept.
const N_EDGES_MAX: usize = 400;
/// What a millimetre is to the page: no more digits are sent.
const DIGITS: f64 = 1e3;

/// The past of a run.
#[derive(Debug, Default)]
pub(crate) struct History {
    n_steps: u64,
    n_max: usize,
    t_s: Vec<f32>,
    /// By robot: x and y, true and believed, m.
    ways: Vec<Vec<[f32; 4]>>,
    /// Of the first robot: its signals that have a curve, by sample; NaN where there is none.
    curves: Vec<Vec<f32>>,
    edges: std::collections::VecDeque<Edge>,
    /// The message as it was made last, and from how many samples.
    told: Option<(usize, Utf8Bytes)>,
}

impl History {
    /// The past of a run that begins, with so many robots told in full.
    pub(crate) fn new(n_robots: usize) -> Self {
        Self {
            n_steps: N_STEPS_FIRST,
            n_max: 4 * N_SAMPLES_MAX / (n_robots + 3),
            ways: vec![Vec::new(); n_robots],
            ..Self::default()
        }
    }

    /// Looks at a run after a step.
    pub(crate) fn look(&mut self, run: &Run) {
        if run.steps().is_multiple_of(self.n_steps) {
            let view = run.view_of_first(self.ways.len());
            self.take(view.t_s, &view.robots);
        }
    }

    /// Keeps changes of the decision program's booleans.
    pub(crate) fn keep_edges(&mut self, edges: &[Edge]) {
        let last_s = self.edges.back().map_or(f64::NEG_INFINITY, |edge| edge.0);
        self.edges.extend(edges.iter().filter(|edge| edge.0 > last_s).cloned());
        let surplus = self.edges.len().saturating_sub(N_EDGES_MAX);
        self.edges.drain(..surplus);
    }

    fn take(&mut self, t_s: f64, robots: &[ViewRobot]) {
        self.t_s.push(t_s as f32);
        for (way, robot) in self.ways.iter_mut().zip(robots) {
            let (truth, estimate) = (robot.truth, robot.estimate);
            way.push([truth.x_m, truth.y_m, estimate.x_m, estimate.y_m].map(|value| value as f32));
        }
        if let Some(robot) = robots.first() {
            let values = Signal::of_robots().zip(&robot.signals);
            let drawn = values.filter(|(signal, _)| signal.curve.is_some());
            self.curves
                .push(drawn.map(|(_, value)| value.map_or(f32::NAN, |v| v as f32)).collect());
        }
        if self.t_s.len() > self.n_max {
            self.thin();
        }
    }

    /// Drops every second sample.
    fn thin(&mut self) {
        fn every_second<T>(list: &mut Vec<T>) {
            let mut index = 0;
            list.retain(|_| {
                index += 1;
                index % 2 == 0
            });
        }
        self.n_steps *= 2;
        // The same number of samples comes again with other contents.
        self.told = None;
        every_second(&mut self.t_s);
        self.ways.iter_mut().for_each(every_second);
        every_second(&mut self.curves);
    }

    /// The message for a page that comes late; made once for all pages that come at the same time.
    pub(crate) fn text(&mut self) -> Utf8Bytes {
        let n = self.t_s.len();
        if let Some((n_told, text)) = &self.told
            && *n_told == n
        {
            return text.clone();
        }
        let text = Utf8Bytes::from(self.message().to_string());
        self.told = Some((n, text.clone()));
        text
    }

    fn message(&self) -> Value {
        let way = |(id, way): (usize, &Vec<[f32; 4]>)| {
            let numbers = |at: usize| -> Vec<Value> {
                way.iter().flat_map(|p| [number(p[at]), number(p[at + 1])]).collect()
            };
            json!({ "id": id, "truth": numbers(0), "estimate": numbers(2) })
        };
        let curve =
            |index: usize| -> Vec<Value> { self.curves.iter().map(|c| number(c[index])).collect() };
        let drawn = Signal::of_robots().filter(|signal| signal.curve.is_some());
        let n_known = self.curves.first().map_or(0, Vec::len);
        let columns: Map<_, _> = drawn
            .enumerate()
            .take(n_known)
            .map(|(index, signal)| (signal.id.to_owned(), json!(curve(index))))
            .collect();
        json!({
            "type": "history",
            "t_s": self.t_s.iter().map(|&t_s| number(t_s)).collect::<Vec<_>>(),
            "robots": self.ways.iter().enumerate().map(way).collect::<Vec<_>>(),
            "columns": columns,
            "edges": self.edges,
        })
    }
}

/// Rounded for the page; nothing where it is no number.
fn number(value: f32) -> Value {
    let value = f64::from(value);
    if value.is_finite() { json!((value * DIGITS).round() / DIGITS) } else { Value::Null }
}

#[cfg(test)]
mod tests {
    use missions::Pose;

    use super::*;

    fn at(x_m: f64) -> ViewRobot {
        let truth = Pose { x_m, y_m: 0.5, yaw_rad: 0.0 };
        let signals = Signal::of_robots()
            .map(|signal| (signal.id == "clearance_m").then_some(0.25))
            .collect();
        ViewRobot { truth, signals, ..ViewRobot::default() }
    }

    /// An hour at ten samples a second: the first and the newest are there, and no more than may be kept.
    #[test]
    fn the_whole_past_is_kept_in_bounded_memory() {
        let mut history = History::new(1);
        let mut n_taken = 0;
        for step in (0_u64..360_000).filter(|step| step % 10 == 0) {
            if step.is_multiple_of(history.n_steps) {
                history.take(step as f64 / 100.0, &[at(step as f64 / 1000.0)]);
                n_taken += 1;
            }
        }
        assert!(n_taken < 20_000, "{n_taken} looks");
        let n = history.t_s.len();
        assert!((N_SAMPLES_MAX / 2..=N_SAMPLES_MAX).contains(&n), "{n}");
        assert!(history.t_s[0] < 5.0 && history.t_s[n - 1] > 3590.0);
        assert!(history.ways[0].len() == n && history.curves.len() == n);
        for (t_s, way) in history.t_s.iter().zip(&history.ways[0]) {
            assert!((way[0] - t_s / 10.0).abs() < 1e-3, "thinned alike");
        }
        assert!(history.text().len() < 300_000, "{} bytes", history.text().len());
    }

    #[test]
    fn many_robots_share_the_room() {
        let mut history = History::new(12);
        let robots: Vec<_> = (0..12).map(|i| at(f64::from(i) + 0.123_456)).collect();
        for step in 0_u64..40_000 {
            if step.is_multiple_of(history.n_steps) {
                history.take(step as f64 / 100.0, &robots);
            }
        }
        assert!(history.text().len() < 500_000, "{} bytes", history.text().len());
        let mut pair = History::new(2);
        let mut other = at(2.0);
        other.signals = vec![Some(9.0); other.signals.len()];
        pair.take(0.0, &[at(1.0), other]);
        assert_eq!(pair.message()["columns"]["clearance_m"], json!([0.25]), "of the first");
    }

    #[test]
    fn what_is_not_known_is_null_and_edges_are_kept_once() {
        let mut history = History::new(1);
        history.take(0.0, &[at(1.0)]);
        let edge = |t_s: f64| (t_s, "I0".to_owned(), true);
        history.keep_edges(&[edge(1.0), edge(2.0)]);
        history.keep_edges(&[edge(1.0), edge(2.0), edge(3.0)]);
        let message = history.message();
        assert_eq!(message["columns"]["cross_track_m"][0], Value::Null);
        assert_eq!(message["columns"]["clearance_m"][0], 0.25);
        for Signal { id, curve, .. } in Signal::of_robots() {
            assert_eq!(message["columns"].get(*id).is_some(), curve.is_some(), "{id}");
        }
        assert_eq!(message["robots"][0]["truth"], json!([1.0, 0.5]));
        assert_eq!(message["edges"].as_array().unwrap().len(), 3);
    }
}
