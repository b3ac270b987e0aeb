//! The thesis's method, which looks at whole recordings, behind a survey's face.

use continuous_localisation::classic::{
    Board, ClassicConfig, ClassicLog, ClassicRun, ClassicStep, NINE_SHIFTS, Score, run,
};
use geometry::{Se2, Vec2};
use grid_maps::{Cell, CellBox, Lattice, Window};
use recordings::{Recording, StampedPose};

use crate::{
    clock::Stages,
    config::SurveyConfig,
    drawing::SurveyMap,
    mapper::{Candidate, Counter, Event, Mapper, Registration, SurveyError},
};

/// Runs the method on the whole recording at the first scan, then tells scan by scan what it did.
#[derive(Debug)]
pub(crate) struct ClassicMapper {
    log: ClassicLog,
    config: ClassicConfig,
    done: Option<ClassicRun>,
    map: SurveyMap,
    n_told: usize,
    n_scans: usize,
    stamps: Vec<run_context::Stamp>,
}

impl ClassicMapper {
    pub(crate) fn new(recording: &Recording, config: &SurveyConfig) -> Result<Self, SurveyError> {
        let (log, ring) = ClassicLog::from_recording(recording)?;
        let config = config.values().sonar.classic(ring);
        let lattice = lattice(&config)?;
        let area = CellBox { min: lattice.cell_of(Vec2::zeros()), width: 1, height: 1 };
        Ok(Self {
            log,
            config,
            done: None,
            map: SurveyMap::Board(lattice, Window::filled(area, f64::NAN)?),
            n_told: 0,
            n_scans: 0,
            stamps: recording.scans.iter().map(|scan| scan.stamp).collect(),
        })
    }

    fn pose(&self, row: usize) -> Se2 {
        let poses = self.done.as_ref().map_or(self.log.poses(), |done| &done.poses);
        poses.get(row).map_or(Se2::IDENTITY, |[x_mm, y_mm, deg]| {
            Se2::new(x_mm / 1e3, y_mm / 1e3, deg.to_radians())
        })
    }
}

impl Mapper for ClassicMapper {
    fn step(
        &mut self,
        _recording: &Recording,
        index: usize,
        stages: &mut Stages,
        events: &mut Vec<Event>,
    ) -> Result<(), SurveyError> {
        if self.done.is_none() {
            let done =
                stages.measure("map the whole recording", || run(&self.log, &self.config))?;
            self.map = drawn(&done.world, &self.config)?;
            self.done = Some(done);
        }
        self.n_scans = index + 1;
        let map_from_base = self.pose(index);
        events.push(Event::Placed { scan: index, map_from_base, how: "dead reckoning" });
        if let Some(done) = &self.done {
            let mature = |s: &&ClassicStep| s.first_row + s.n_rows <= index + 1;
            for step in done.steps.iter().skip(self.n_told).take_while(mature) {
                self.n_told += 1;
                events.push(Event::Registered(registration(step, &self.config)));
            }
        }
        Ok(())
    }

    fn finish(
        &mut self,
        _recording: &Recording,
        _stages: &mut Stages,
        _events: &mut Vec<Event>,
    ) -> Result<(), SurveyError> {
        Ok(())
    }

    fn trajectory(&self) -> Vec<StampedPose> {
        let stamps = self.stamps.iter().take(self.n_scans).enumerate();
        stamps.map(|(row, &stamp)| StampedPose { stamp, pose: self.pose(row) }).collect()
    }

    fn map_from_base(&self) -> Option<Se2> {
        self.n_scans.checked_sub(1).map(|last| self.pose(last))
    }

    fn map(&mut self, _recording: &Recording) -> Result<&SurveyMap, SurveyError> {
        Ok(&self.map)
    }

    /// The source's map has the axes of its odometry.
    fn map_from_odom(&self) -> Option<Se2> {
        Some(Se2::IDENTITY)
    }

    fn counters(&self) -> Vec<Counter> {
        let steps = self.done.iter().flat_map(|done| done.steps.iter().take(self.n_told));
        let moved = |s: &&ClassicStep| s.shift != [0, 0] || s.heading_deg != 0.0;
        vec![
            Counter { name: "registrations", label: "short-term maps", n: steps.clone().count() },
            Counter {
                name: "corrections",
                label: "of them moved the robot",
                n: steps.filter(moved).count(),
            },
        ]
    }
}

/// Where the source's cells lie: the robot at the odometry's origin is on the upper border of cell W/2 + n/2 − 40.
fn lattice(config: &ClassicConfig) -> Result<Lattice, SurveyError> {
    let scale_m = config.pose_scale_mm / 1e3;
    let [row, column] = config.cell_of_robot(0.0, 0.0);
    let corner = Vec2::new(-(row as f64) * scale_m, -(column as f64) * scale_m);
    Ok(Lattice::new(corner, scale_m)?)
}

/// The board as a window: its rows lie along x, its columns along y.
fn drawn(board: &Board, config: &ClassicConfig) -> Result<SurveyMap, SurveyError> {
    let lattice = lattice(config)?;
    let (first_row, first_column, n_rows, n_columns) = board.extent();
    // Counted from 1: cell k covers up to k sides from the corner.
    let min = Cell { column: first_row as i32 - 1, row: first_column as i32 - 1 };
    let area = CellBox { min, width: n_rows, height: n_columns };
    let mut window = Window::filled(area, f64::NAN)?;
    for (row, probs) in board.probs().chunks_exact(n_columns.max(1)).enumerate() {
        for (column, &prob) in probs.iter().enumerate() {
            let cell = min.offset(row as i32, column as i32);
            // One half is what nobody looked at.
            if (prob - 0.5).abs() > 0.0
                && let Some(value) = window.get_mut(cell)
            {
                *value = prob;
            }
        }
    }
    Ok(SurveyMap::Board(lattice, window))
}

fn registration(step: &ClassicStep, config: &ClassicConfig) -> Registration {
    let scale_m = config.pose_scale_mm / 1e3;
    let offset = |heading_deg: f64, [row, column]: [i64; 2]| {
        Se2::new(row as f64 * scale_m, column as f64 * scale_m, heading_deg.to_radians())
    };
    let candidate = |(i, score): (usize, &Option<f64>)| Candidate {
        offset: offset(
            config.headings_deg.get(i / NINE_SHIFTS.len()).copied().unwrap_or(0.0),
            NINE_SHIFTS[i % NINE_SHIFTS.len()],
        ),
        score_ratio: *score,
    };
    let moved = step.shift != [0, 0] || step.heading_deg != 0.0;
    let verdict = match (step.chosen, moved) {
        (None, _) => "too little in common: nothing was corrected".to_owned(),
        (Some(_), false) => "dead reckoning fits best".to_owned(),
        (Some(_), true) => format!(
            "moved by {} and {} cells, turned by {}°",
            step.shift[0], step.shift[1], step.heading_deg
        ),
    };
    Registration {
        first_scan: step.first_row,
        last_scan: (step.first_row + step.n_rows).saturating_sub(1),
        candidates: step.scores.iter().enumerate().map(candidate).collect(),
        best: step.chosen,
        applied: moved,
        verdict,
        score: match config.score {
            Score::WholeWindow => "sum of differences over the whole window (less is better)",
            Score::CommonCells { .. } => "mean difference of common cells (less is better)",
            Score::Evidence { .. } => "one minus the correlation of evidence (less is better)",
        },
        correction: moved.then(|| offset(step.heading_deg, step.shift)),
    }
}
