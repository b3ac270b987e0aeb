//! The sonar mapping of the thesis on ARTEMIC (chapters 4 and 5): its environments, its experiments, and
//! continuous localisation measured against the truth.
//!
//! The thesis shows pictures and no numbers, and the pictures are lost; what can be compared is what it
//! says of them. Environments E1 to E4 are missions with measures of ours where it gives none (only E4 has
//! some). Each setting drives the mission anew, with seeds of its own; odometry turns away by 1° per metre,
//! to the left in one run and to the right in the next, or not at all, and slips at random in both.

mod findings;
mod method;
mod results;
mod room;
mod sections;
mod task;
mod words;

use std::sync::atomic::{AtomicUsize, Ordering};

use continuous_localisation::Maturity;
use missions::sense;
use rayon::prelude::*;
use recordings::Recording;
use run_context::RunSeed;

use crate::{ExperimentError, Options, Progress, Report};
use method::{Judged, Method, thesis};
use results::Results;
use room::{ROOMS, Room};
use task::{EIGHT, FIVE, Task, Timing};

/// What systematic drift the table of targets asks for, degrees per metre.
const DRIFT_DEGPM: f64 = 1.0;
/// The document's method tries every candidate on whole windows and takes more than ten times as long as ours: it
/// is given one run of so many, at least one.
const RUNS_PER_DESCRIBED: usize = 5;
/// Half of the missions' speed: twice the readings on the same way.
const HALF_SPEED_MPS: f64 = 0.04;
/// Seeds of the first visits lie so far from those of the runs.
const FIRST_VISIT: u64 = 1_000_000;
pub(crate) fn run(options: &Options, progress: Progress<'_>) -> Result<Report, ExperimentError> {
    let scope = Scope { rooms: &ROOMS, rings: &[FIVE, EIGHT], duration_max_s: f64::INFINITY };
    let results = measure(scope, options, progress)?;
    let times = time(&results, options)?;
    Ok(Report {
        title: "Sonar maps and continuous localisation (the thesis on ARTEMIC, 4 and 5)".to_owned(),
        preamble: format!(
            "{} runs per setting, seeds {} to {}. Each is a drive through the mission: a person steers by \
             sight, five (or eight) EZ0 sonars with cones of 30° take turns, dead reckoning comes from \
             encoders that slip at random (0.3 % over a metre) and, where said, turn away by 1° per metre, to \
             the left and to the right in turns. The recording is mapped in cells of 35 mm. Errors are \
             distances from the true position, RMS over the drive, without fitting one trajectory to the \
             other; a cell counts as wall from p = 0.7. The document's method takes more than ten times as long as \
             ours and is given the first {} of the runs.",
            options.n_runs,
            options.seed.0,
            options.seed.0 + u64::from(options.n_runs) - 1,
            (options.n_runs as usize).div_ceil(RUNS_PER_DESCRIBED)
        ),
        sections: vec![
            sections::targets(&results),
            sections::maps(&results),
            sections::limits(&results),
            sections::drives(&results)?,
            sections::odometry_alone(&results),
            sections::search_spaces(&results)?,
            sections::open_area(&results),
            sections::prior_map(&results)?,
            sections::joined_areas(&results),
            sections::corridor(&results),
            sections::times(&times),
            findings::comparison(&results),
        ],
    })
}

/// Where to drive, with what, and how long at most.
#[derive(Clone, Copy, Debug)]
struct Scope {
    rooms: &'static [(&'static str, &'static str)],
    rings: &'static [&'static str],
    duration_max_s: f64,
}

/// All drives, mapped and judged.
fn measure(
    scope: Scope,
    options: &Options,
    progress: Progress<'_>,
) -> Result<Results, ExperimentError> {
    let first_visit = RunSeed(options.seed.0.wrapping_add(FIRST_VISIT));
    let rooms = scope
        .rings
        .par_iter()
        .flat_map_iter(|&ring| scope.rooms.iter().map(move |&room| (room, ring)))
        .map(|(room, ring)| Room::new(room, ring, scope.duration_max_s, first_visit))
        .collect::<Result<Vec<_>, _>>()?;
    let tasks = tasks(&rooms);
    let n_runs = options.n_runs as usize;
    let n_described = n_runs.div_ceil(RUNS_PER_DESCRIBED);
    let total = tasks.len() * n_runs;
    let done = AtomicUsize::new(0);
    let mut judged = (0..total)
        .into_par_iter()
        .with_max_len(1)
        .map(|index| {
            let (task, j) = (&tasks[index / n_runs], index % n_runs);
            let recording = drive(task, &rooms[task.room], j, options)?;
            let judge = |method: &Method| -> Result<Judged, ExperimentError> {
                let room = &rooms[task.room];
                method.estimate(&recording, room)?.judge(&recording, room, j == 0)
            };
            let is_asked = |method: &&Method| j < n_described || !method.is_described();
            let judged =
                task.methods.iter().filter(is_asked).map(judge).collect::<Result<Vec<_>, _>>();
            progress(done.fetch_add(1, Ordering::Relaxed) + 1, total);
            judged
        })
        .collect::<Result<Vec<_>, _>>()?
        .into_iter();
    let judged = (0..tasks.len()).map(|_| judged.by_ref().take(n_runs).collect()).collect();
    Ok(Results { rooms, tasks, judged })
}

/// What the robot sensed in run j of a task.
fn drive(
    task: &Task,
    room: &Room,
    j: usize,
    options: &Options,
) -> Result<Recording, ExperimentError> {
    let sign = if j.is_multiple_of(2) { 1.0 } else { -1.0 };
    let mut more = Vec::new();
    if task.is_half_speed {
        more.push(format!("robots.teleoperator.speed_mps={HALF_SPEED_MPS}"));
        more.push(format!("mission.duration_max_s={:?}", 2.0 * room.duration_s));
    }
    let mission = room.mission(sign * task.drift_degpm, &more)?;
    let seed = RunSeed(options.seed.0.wrapping_add(j as u64));
    Ok(sense(mission, seed)?.recordings.remove(0).1)
}

/// Every room with both rings and both kinds of drift, and the experiments that each is for.
fn tasks(rooms: &[Room]) -> Vec<Task> {
    let mut tasks = Vec::new();
    for (index, room) in rooms.iter().enumerate() {
        for drift_degpm in [DRIFT_DEGPM, 0.0] {
            let drifts = drift_degpm > 0.0;
            let mut methods = vec![Method::Odometry, Method::Localised, Method::SecondLook];
            if drifts {
                methods.push(Method::TruePoses);
            }
            // The document's own experiments are with five sonars.
            if room.ring == FIVE {
                methods.push(thesis(3));
                match (room.name, drifts) {
                    ("E1", true) => methods.extend(searched().into_iter().chain(scored())),
                    ("E2", true) => {
                        methods.extend(searched().into_iter().chain(scored()).chain(matured()));
                    }
                    ("E1" | "E2", false) => methods.extend(searched()),
                    ("E3", true) => methods.extend(doubled()),
                    _ => {}
                }
            }
            // Those that are not given every run come last, so that the others keep their places.
            methods.sort_by_key(|method| method.is_described());
            tasks.push(Task { room: index, drift_degpm, is_half_speed: false, methods });
        }
        if room.ring == FIVE && room.name == "E3" {
            let methods = vec![Method::Odometry, Method::Localised, Method::SecondLook, thesis(3)];
            tasks.push(Task {
                room: index,
                drift_degpm: DRIFT_DEGPM,
                is_half_speed: true,
                methods,
            });
        }
    }
    tasks
}

/// X2: search spaces; ±3° of the document is mapped anyway.
fn searched() -> Vec<Method> {
    vec![Method::Grids(1), Method::Grids(3), Method::Grids(6), thesis(1), thesis(6)]
}

/// X2 and X4, with drift only.
fn scored() -> [Method; 3] {
    [Method::PriorMap, Method::Program, Method::Evidence]
}

/// X3: short-term maps until so many readings, scans or seconds; 45 readings are what the text says,
/// the others of each method last about equally long where walls are near.
fn matured() -> Vec<Method> {
    let of_document = [Maturity::Readings(45), Maturity::Readings(100), Maturity::Seconds(5.0)]
        .map(|maturity| Method::Thesis(3, maturity));
    let ours = [
        Maturity::Readings(120),
        Maturity::Scans(50),
        Maturity::Seconds(12.5),
        Maturity::Distance(1.0),
    ]
    .map(Method::Matured);
    of_document.into_iter().chain(ours).collect()
}

/// V1b: short-term maps of twice the length.
fn doubled() -> [Method; 2] {
    [Method::Thesis(3, Maturity::Scans(40)), Method::Matured(Maturity::Distance(2.0))]
}

/// The first drive of E1 once more, method by method, nothing beside it.
#[expect(
    clippy::disallowed_methods,
    reason = "computing time is what is measured; nothing else depends on it"
)]
fn time(results: &Results, options: &Options) -> Result<Vec<Timing>, ExperimentError> {
    let Some(task) = results.tasks.first() else { return Ok(Vec::new()) };
    let room = &results.rooms[task.room];
    let recording = drive(task, room, 0, options)?;
    let methods = [Method::Odometry, Method::Grids(1), Method::Grids(3), Method::Grids(6)]
        .into_iter()
        .chain([Method::Localised, Method::SecondLook, thesis(1), thesis(3), thesis(6)]);
    methods
        .map(|method| {
            let mut took_s = f64::INFINITY;
            let mut n_maps = 0;
            // The least of three is the one that was disturbed least; slow ones are disturbed evenly.
            for _ in 0..if method.is_described() { 1 } else { 3 } {
                let start = std::time::Instant::now();
                n_maps = method.estimate(&recording, room)?.n_maps();
                took_s = took_s.min(start.elapsed().as_secs_f64());
            }
            let drive_s = recording.duration().as_secs_f64();
            Ok(Timing { label: method.label(), took_s, drive_s, n_maps })
        })
        .collect()
}

#[cfg(test)]
mod tests;
