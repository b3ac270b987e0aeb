//! A whole recording through the step of [`Localiser`].

use recordings::{Recording, Rig, StampedPose};

use crate::{
    config::{ConfigError, LocaliserConfig},
    localiser::Localiser,
    registration::Registration,
};

/// What a run over a recording found.
#[derive(Clone, Debug)]
pub struct SonarRun {
    /// The localiser at the end, with map and walls.
    pub localiser: Localiser,
    /// One pose for each row that has odometry, as known when the row came.
    pub online: Vec<StampedPose>,
    /// One pose for each row that was used, corrected by the registration of its short-term map.
    pub hindsight: Vec<StampedPose>,
    /// All registrations in order.
    pub registrations: Vec<Registration>,
}

/// Why a recording cannot be run.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum RunError {
    /// The recording is of a laser.
    #[error("this is a laser's recording: continuous localisation needs a ring of sonars")]
    NotARing,
    /// A parameter cannot be used.
    #[error(transparent)]
    Config(#[from] ConfigError),
}

/// Runs over all rows; odometry of higher rate than the rows' is used where the recording has it.
///
/// # Errors
///
/// [`RunError`] for a laser's recording or a parameter outside its range. A recording without rows
/// gives an empty map.
pub fn run(recording: &Recording, config: LocaliserConfig) -> Result<SonarRun, RunError> {
    let Rig::Ring(ring) = &recording.rig else { return Err(RunError::NotARing) };
    let localiser = Localiser::new(ring, config)?;
    Ok(run_on(localiser, recording))
}

/// Runs twice: the second time knows from the first metre what odometry misses, as
/// [`Localiser::again`] does. For recordings: what was drawn before the drift was known is not smeared.
/// The trajectory is then no longer one that the robot could have had while it drove.
///
/// # Errors
///
/// As [`run`].
pub fn run_twice(recording: &Recording, config: LocaliserConfig) -> Result<SonarRun, RunError> {
    let first = run(recording, config)?;
    Ok(run_on(first.localiser.again()?, recording))
}

/// The same as [`run`] with a localiser that may have a prior map or pose.
pub fn run_on(mut localiser: Localiser, recording: &Recording) -> SonarRun {
    let mut online = Vec::with_capacity(recording.scans.len());
    let mut hindsight = Vec::with_capacity(recording.scans.len());
    let mut registrations = Vec::new();
    let mut odometry = recording.odometry.iter().peekable();
    for scan in &recording.scans {
        while let Some(between) = odometry.next_if(|pose| pose.stamp < scan.stamp) {
            localiser.add_odometry(between.stamp, between.pose);
        }
        let registration = localiser.step(scan);
        if let (Some(_), Some(pose)) = (scan.odom_from_base, localiser.map_from_base()) {
            online.push(StampedPose { stamp: scan.stamp, pose });
        }
        keep(registration, &mut hindsight, &mut registrations);
    }
    let last = localiser.finish();
    keep(last, &mut hindsight, &mut registrations);
    SonarRun { localiser, online, hindsight, registrations }
}

fn keep(
    registration: Option<Registration>,
    hindsight: &mut Vec<StampedPose>,
    registrations: &mut Vec<Registration>,
) {
    if let Some(registration) = registration {
        hindsight.extend_from_slice(&registration.poses);
        registrations.push(registration);
    }
}
