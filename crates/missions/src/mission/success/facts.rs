//! What a run tells of itself to the requirements; robots and devices are numbered as in the mission.

use geometry::Se2;
use messages::FailureReason;
use run_context::Stamp;

/// The facts of one step.
pub(crate) trait Facts {
    fn n_robots(&self) -> usize;
    /// `MOVE` that the decision program has sent.
    fn n_moves(&self) -> u64;
    /// Entries that `EVENT` has logged.
    fn n_events(&self) -> u64;
    fn n_watchdog_resets(&self) -> u64;

    fn device_label(&self, device: usize) -> &str;
    /// When a device was on for the first time.
    fn first_on(&self, device: usize) -> Option<Stamp>;

    fn name(&self, robot: usize) -> &str;
    /// Where it started.
    fn start(&self, robot: usize) -> Se2;
    /// Where it truly is; of a robot elsewhere, where it says.
    fn pose(&self, robot: usize) -> Se2;
    /// Whether what it touches and how near it comes to things is known: it is simulated here.
    fn is_simulated(&self, robot: usize) -> bool;
    /// Whether its wheels stand; nothing when nobody knows, which is so of a robot elsewhere that is not heard.
    fn stands(&self, robot: usize) -> Option<bool>;
    /// What it is busy with.
    fn phase_name(&self, robot: usize) -> &'static str;
    /// Why it gave up, in words.
    fn failure(&self, robot: usize) -> Option<String>;
    /// Whether it says that it has arrived.
    fn has_arrived(&self, robot: usize) -> bool;
    /// Whether it gave up for that reason, or for any, and the ground knows.
    fn has_given_up(&self, robot: usize, reason: Option<FailureReason>) -> bool;
    /// Contacts so far.
    fn contacts(&self, robot: usize) -> u64;
    /// Least clearance so far, m; infinite before it was measured.
    fn clearance_min_m(&self, robot: usize) -> f64;
    /// The same where anything was within the 5 m that are looked at.
    fn clearance_seen_m(&self, robot: usize) -> Option<f64>;
    /// Greatest distance from its start, m.
    fn strayed_max_m(&self, robot: usize) -> f64;
    /// Way since a line of it was last cut, until its next order, m.
    fn way_since_cut_m(&self, robot: usize) -> Option<f64>;
    /// Whether it follows a path of its own, and no trail.
    fn has_path(&self, robot: usize) -> bool;
    /// Root mean square distance from what it followed, m; nothing if it never did.
    fn cross_track_rms_m(&self, robot: usize) -> Option<f64>;
    /// Whether it has driven the path that it was given; true without one.
    fn has_driven_all(&self, robot: usize) -> bool;
    /// Way driven along that path, and its length, m.
    fn driven_m(&self, robot: usize) -> (f64, f64);
}
