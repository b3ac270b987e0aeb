//! From a mature short-term map to a corrected pose and a fuller long-term map.

use geometry::{Se2, wrap_to_pi};
use nalgebra::Matrix3;
use recordings::StampedPose;
use sensor_models::ArcFocus;

use super::{Localiser, StmReading, Waiting};
use crate::{
    chain::{Chain, Start},
    config::WallTrust,
    filter::bearing_rad,
    insertion::{PlacedReading, is_contradicted},
    registration::{Outcome, Registration},
    search::{Evidence, SearchResult, search},
    walls::{self, Arc, Before, Piece},
};

/// Where an echo of a wall is on its arc is known to this, metres to each side.
const FOCUS_M: f64 = 0.07;
/// Before its end a cone may touch what it ends at, metres.
const CONTRADICTION_MARGIN_M: f64 = 0.2;
/// The same for a piece of wall whose pose is not corrected yet, metres.
const MIRROR_MARGIN_M: f64 = 0.35;
/// Readings that may wait; the oldest are judged when there are more.
const WAITING_MAX: usize = 20_000;

/// Straight pieces in the short-term map.
struct FoundPieces {
    of_reading: Vec<Option<usize>>,
    pieces: Vec<Piece>,
}

/// How the short-term map's echoes were explained by walls.
#[derive(Default)]
struct WallFit {
    /// For each reading.
    walls: Vec<Option<usize>>,
    n_echoes: usize,
    squares_m2: f64,
}

impl Localiser {
    pub(super) fn register(&mut self) -> Option<Registration> {
        let mut chain = self.chain.take()?;
        let before = chain.end();
        let mut drawn_end = before;
        // In order of time along the way, whatever order the sensors have in a row.
        self.readings.sort_by(|a, b| {
            let (p, q) = (a.at, b.at);
            p.step.cmp(&q.step).then(p.ratio.total_cmp(&q.ratio)).then(a.sensor.cmp(&b.sensor))
        });
        let found = self.find_walls(&chain);
        let (mut fit, mut result, mut is_grid_used) =
            (WallFit::default(), SearchResult::default(), false);
        if self.config.is_correcting {
            fit = self.replay(&chain, &found);
            if let Some(squareness) = &self.config.squareness {
                self.filter.square_up(squareness);
            }
            chain.end_at(self.filter.map_from_base, self.filter.missed_yaw_radpm);
            drawn_end = chain.end();
            self.draw(&chain);
            result = self.search(&chain);
            is_grid_used = self.learn_from_grids(&chain, &result, fit.n_echoes);
            chain.end_at(self.filter.map_from_base, self.filter.missed_yaw_radpm);
        } else {
            self.draw(&chain);
        }
        let outcome = match (is_grid_used, fit.n_echoes > 0) {
            _ if !self.config.is_correcting => Outcome::SwitchedOff,
            (true, true) => Outcome::ByGridsAndWalls,
            (true, false) => Outcome::ByGrids,
            (false, true) => Outcome::ByWalls,
            (false, false) if result.best.is_some() => Outcome::NotDistinct,
            (false, false) => Outcome::NothingRecognised,
        };
        let rows = self.row_stamps.iter();
        let poses = rows.map(|&stamp| StampedPose { stamp, pose: chain.pose(chain.moment(stamp)) });
        let poses = poses.collect();
        self.settle(&chain, &fit);
        for reading in &self.readings {
            let arc = self.arc(&chain, reading);
            self.last_arcs[reading.sensor] =
                if reading.is_echo { Before::Echo(arc) } else { Before::Silence };
        }

        let end = chain.end();
        let start = Start { map_from_base: end, missed_yaw_radpm: self.filter.missed_yaw_radpm };
        let stamp = chain.end_stamp();
        chain.restart(start);
        self.chain = Some(chain);
        let collected = std::mem::take(&mut self.collected);
        self.readings.clear();
        self.row_stamps.clear();
        let turned = wrap_to_pi(end.yaw_rad - before.yaw_rad);
        Some(Registration {
            stamp,
            collected,
            candidates: result.candidates,
            chosen: result.best,
            n_wall_echoes: fit.n_echoes,
            wall_rms_m: (fit.squares_m2 / fit.n_echoes.max(1) as f64).sqrt(),
            outcome,
            correction: Se2::new(end.x_m - before.x_m, end.y_m - before.y_m, turned),
            drawn_end,
            covariance: self.filter.pose_covariance(),
            missed_yaw_radpm: start.missed_yaw_radpm,
            map_from_odom: self.map_from_odom(),
            poses,
        })
    }

    /// Pieces of walls in the short-term map: for each reading the piece's normal, and its number.
    fn find_walls(&self, chain: &Chain) -> FoundPieces {
        let trust: WallTrust = self.config.walls.unwrap_or_default();
        let mut found =
            FoundPieces { of_reading: vec![None; self.readings.len()], pieces: Vec::new() };
        for sensor in 0..self.ring.base_from_sensors.len() {
            let indices: Vec<usize> = (0..self.readings.len())
                .filter(|&i| {
                    let r = &self.readings[i];
                    r.sensor == sensor && r.is_echo && r.range_m <= trust.range_max_m
                })
                .collect();
            let arcs: Vec<Arc> =
                indices.iter().map(|&i| self.arc(chain, &self.readings[i])).collect();
            let before = self.last_arcs[sensor];
            for piece in walls::pieces(&arcs, before, &trust, self.ring.half_angle_rad) {
                if self.is_mirrored(&arcs[piece.arcs.clone()]) {
                    continue;
                }
                for i in piece.arcs.clone() {
                    found.of_reading[indices[i]] = Some(found.pieces.len());
                }
                found.pieces.push(piece);
            }
        }
        found
    }

    /// Most of a piece's cones go through something occupied: a wall seen in a mirror.
    fn is_mirrored(&self, arcs: &[Arc]) -> bool {
        let through = arcs.iter().filter(|arc| {
            let reading = PlacedReading {
                map_from_sensor: arc.sensor,
                range_m: arc.range_m,
                is_echo: true,
                focus: None,
            };
            let occupied_logodds = self.config.filter.contradiction_logodds;
            is_contradicted(&self.long_term, &reading, MIRROR_MARGIN_M, occupied_logodds)
        });
        2 * through.count() > arcs.len()
    }

    fn arc(&self, chain: &Chain, reading: &StmReading) -> Arc {
        let sensor = chain.pose(reading.at).compose(self.ring.base_from_sensors[reading.sensor]);
        Arc { sensor, range_m: reading.range_m }
    }

    /// Goes along the chain again with the filter, learning from every echo of a wall.
    fn replay(&mut self, chain: &Chain, found: &FoundPieces) -> WallFit {
        let mut fit = WallFit { walls: vec![None; self.readings.len()], ..WallFit::default() };
        let odometry = self.config.odometry;
        // Which wall a piece is of is decided when its first echo comes: then the pose is best known.
        let mut wall_of_piece: Vec<Option<Option<usize>>> = vec![None; found.pieces.len()];
        let (mut step, mut ratio) = (0, 0.0);
        for (i, reading) in self.readings.iter().enumerate() {
            while step < reading.at.step {
                self.filter.predict(chain.twist(step), 1.0 - ratio, &odometry);
                (step, ratio) = (step + 1, 0.0);
            }
            if reading.at.ratio > ratio && step < chain.n_steps() {
                self.filter.predict(chain.twist(step), reading.at.ratio - ratio, &odometry);
                ratio = reading.at.ratio;
            }
            let Some(trust) = self.config.walls.filter(|_| reading.is_echo) else { continue };
            let base_from_sensor = self.ring.base_from_sensors[reading.sensor];
            let wall = if let Some(number) = found.of_reading[i] {
                *wall_of_piece[number].get_or_insert_with(|| {
                    // The piece was found on the chain; bring it to where the filter is.
                    let here = self.filter.map_from_base;
                    let piece = found.pieces[number].moved(chain.pose(reading.at), here);
                    let known = self.filter.wall_of(&piece, &trust);
                    known.or_else(|| self.filter.add_wall(&piece, trust.n_walls_max))
                })
            } else {
                let sensor = self.filter.map_from_base.compose(base_from_sensor);
                self.filter.sighted(sensor, reading.range_m, &trust, self.ring.half_angle_rad)
            };
            let seen = wall.and_then(|wall| {
                self.filter.observe_wall(wall, base_from_sensor, reading.range_m, &trust)
            });
            if let Some(seen) = seen {
                fit.walls[i] = Some(seen.wall);
                fit.n_echoes += 1;
                fit.squares_m2 += seen.residual_m * seen.residual_m;
            }
        }
        while step < chain.n_steps() {
            self.filter.predict(chain.twist(step), 1.0 - ratio, &odometry);
            (step, ratio) = (step + 1, 0.0);
        }
        fit
    }

    /// Draws the short-term map about the end of the chain.
    fn draw(&mut self, chain: &Chain) {
        self.short_term.clear();
        for reading in &self.readings {
            let placed = self.placed(chain, reading, None);
            self.inserter.insert(&mut self.short_term, &placed);
        }
    }

    /// Lays the short-term map on the long-term one at many poses.
    fn search(&self, chain: &Chain) -> SearchResult {
        if self.config.search.is_empty() {
            return SearchResult::default();
        }
        let pivot = chain.end().position();
        let evidence = Evidence::of(&self.short_term, pivot);
        let (levels, score) = (&self.config.search, self.config.score);
        search(&self.long_term, &evidence, pivot, levels, score).unwrap_or_default()
    }

    /// Takes the pose that a search measured, if its minimum is distinct and walls say too little.
    fn learn_from_grids(&mut self, chain: &Chain, result: &SearchResult, n_echoes: usize) -> bool {
        let distinct = &self.config.distinct;
        let asked = n_echoes <= distinct.n_wall_echoes_max;
        let measured: Option<(_, Matrix3<f64>)> = result.measured(distinct).filter(|_| asked);
        measured.is_some_and(|(by, covariance)| {
            let end = chain.end();
            let pose = Se2::new(end.x_m + by[0], end.y_m + by[1], end.yaw_rad + by[2]);
            self.filter.observe_pose(pose, &covariance)
        })
    }

    fn placed(
        &self,
        chain: &Chain,
        reading: &StmReading,
        focus: Option<ArcFocus>,
    ) -> PlacedReading {
        let arc = self.arc(chain, reading);
        let silence_m = self.config.filter.silence_clears_m;
        let range_m = if reading.is_echo { arc.range_m } else { silence_m };
        PlacedReading { map_from_sensor: arc.sensor, range_m, is_echo: reading.is_echo, focus }
    }

    /// Makes the short-term map part of the long-term one: supported echoes at once, the rest has to
    /// wait.
    fn settle(&mut self, chain: &Chain, fit: &WallFit) {
        let found = self.find_walls(chain);
        for i in 0..self.readings.len() {
            let reading = self.readings[i];
            let arc = self.arc(chain, &reading);
            let wall = fit.walls.get(i).copied().flatten().map(|wall| &self.filter.walls[wall]);
            let normal = match (wall, found.of_reading[i]) {
                (Some(wall), _) if wall.is_seen_at(arc.sensor.position()) => Some(wall.normal()),
                (_, Some(piece)) => Some(found.pieces[piece].normal),
                _ => None,
            };
            if let Some(normal) = normal {
                let focus = ArcFocus {
                    bearing_rad: bearing_rad(arc.sensor, normal),
                    half_width_rad: (FOCUS_M / arc.range_m).min(self.ring.half_angle_rad),
                };
                let placed = self.placed(chain, &reading, Some(focus));
                self.inserter.insert(&mut self.long_term, &placed);
                self.counts.n_inserted += 1;
            } else {
                let reading = self.placed(chain, &reading, None);
                self.waiting.push(Waiting { reading, since_m: self.way_m });
            }
        }
        self.judge_waiting(self.way_m - self.config.filter.wait_m);
    }

    /// Inserts or drops what has waited since `until_m` of way or longer.
    pub(super) fn judge_waiting(&mut self, until_m: f64) {
        let filter = self.config.filter;
        let n_old = self.waiting.partition_point(|waiting| waiting.since_m <= until_m);
        let n = n_old.max(self.waiting.len().saturating_sub(WAITING_MAX));
        for Waiting { reading, .. } in self.waiting.drain(..n) {
            let ghost = is_contradicted(
                &self.long_term,
                &reading,
                CONTRADICTION_MARGIN_M,
                filter.contradiction_logodds,
            );
            if ghost {
                self.counts.n_ghosts += 1;
            } else {
                self.inserter.insert(&mut self.long_term, &reading);
                self.counts.n_inserted += 1;
            }
        }
    }
}
