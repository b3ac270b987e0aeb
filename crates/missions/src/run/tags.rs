//! Tags in the floor of a run, and a robot's readers over them.

use geometry::Vec2;
use messages::{Observations, Sensed, TagRead};
use path_following::Path;
use pheromones::{TagTrail, amplified};
use rand_core::Rng;
use run_context::{RandomStream, RunSeed, Stamp, StateHash};
use sensor_models::{TagHint, TagMemory, TagReader};
use simulator::{BodyId, FloorTags, World};

use crate::mission::plan::{TagReadersPlan, TagsPlan};

/// A tag is amplified once when a robot passes: not again while it is among the last so many of its reader.
const N_AMPLIFIED: usize = 3;

/// Lays the tags: what each stores follows from the trail, and the seed says which do not answer.
pub(super) fn floor(plan: &TagsPlan, seed: RunSeed) -> Option<FloorTags> {
    let lines = plan.trails.clone();
    let trail = TagTrail::new(lines, plan.width_cells, plan.pitch_m, plan.peak);
    let paths: Vec<Path> =
        plan.trails.iter().filter_map(|line| Path::polyline(line).ok()).collect();
    let mut rng = seed.stream("tags/missing");
    let memory = |in_map: Vec2| {
        // Drawn for every place, so that other trails leave the same tags silent.
        let answers = uniform(&mut rng) >= plan.missing_ratio;
        let strength = trail.strength_at(in_map);
        let stores_hints = strength > 0 && plan.look_ahead_m > 0.0;
        let hints = stores_hints.then(|| hints(&paths, in_map, plan.look_ahead_m));
        let hints = hints.flatten().map_or([None; 2], |hints| hints.map(Some));
        answers.then_some(TagMemory { in_map, strength, hints })
    };
    // The area was checked with the mission.
    FloorTags::new(plan.area_m, plan.pitch_m, memory).ok()
}

/// The look-ahead points in the two directions of the nearest trail.
fn hints(paths: &[Path], in_map: Vec2, look_ahead_m: f64) -> Option<[TagHint; 2]> {
    let projections = paths.iter().map(|path| (path, path.project(in_map)));
    let away = |(path, seen): &(&Path, path_following::Projection)| {
        (path.point_at(seen.arc_length_m) - in_map).norm_squared()
    };
    let (path, seen) = projections.min_by(|a, b| away(a).total_cmp(&away(b)))?;
    let hint = |at_m: f64, end_m: f64| TagHint {
        look_ahead_in_map: path.point_at(at_m.clamp(0.0, path.length_m())),
        end_in_map: path.point_at(end_m),
    };
    let at_m = seen.arc_length_m;
    Some([hint(at_m + look_ahead_m, path.length_m()), hint(at_m - look_ahead_m, 0.0)])
}

/// An even draw from [0, 1).
fn uniform(rng: &mut RandomStream) -> f64 {
    // 53 bits are what an f64 in [0, 1) can hold.
    (rng.next_u64() >> 11) as f64 * 2.0_f64.powi(-53)
}

/// The readers of one robot, wired to its navigation node.
#[derive(Debug)]
pub(super) struct TagReaders {
    readers: Vec<(Vec2, TagReader, [Option<u32>; N_AMPLIFIED])>,
    amplify: u8,
    rng: RandomStream,
    places: Vec<u32>,
    /// What the robot writes in this step: places and intensities.
    writes: Vec<(u32, u8)>,
    /// Every read so far, in order.
    read: StateHash,
    n_reads: u64,
}

impl TagReaders {
    pub(super) fn new(plan: &TagReadersPlan, rng: RandomStream) -> Self {
        let reader = |at: &Vec2| (*at, TagReader::new(plan.model), [None; N_AMPLIFIED]);
        Self {
            readers: plan.in_base.iter().map(reader).collect(),
            amplify: plan.amplify,
            rng,
            places: Vec::with_capacity(64),
            writes: Vec::with_capacity(4),
            read: StateHash::new(),
            n_reads: 0,
        }
    }

    /// One step of every reader over the floor as it is now.
    pub(super) fn sense(
        &mut self,
        now: Stamp,
        world: &World,
        body: BodyId,
        observations: &mut Observations,
    ) {
        self.writes.clear();
        let Some(tags) = world.floor_tags() else { return };
        let world_from_base = world.body(body).world_from_base.se2();
        for (index, (at, reader, amplified_last)) in (0..).zip(&mut self.readers) {
            let centre = world_from_base.transform_point(*at);
            tags.in_area(centre, reader.model().range_m, &mut self.places);
            let Some(place) = reader.step(now, &self.places, &mut self.rng) else { continue };
            let Some(memory) = tags.tag(place) else { continue };
            self.n_reads += 1;
            self.read.absorb_u64(now.as_nanos());
            self.read.absorb_u64(
                u64::from(index) << 40 | u64::from(place) << 8 | u64::from(memory.strength),
            );
            let read = TagRead { reader: index, tag: place, memory: *memory };
            observations.push(now, Sensed::Tag(read));
            if self.amplify > 0 && !amplified_last.contains(&Some(place)) {
                amplified_last.rotate_right(1);
                amplified_last[0] = Some(place);
                self.writes.push((place, amplified(memory.strength, self.amplify)));
            }
        }
    }

    /// Writes what was amplified.
    pub(super) fn apply(&self, world: &mut World) {
        for (place, strength) in &self.writes {
            world.write_tag_strength(*place, *strength);
        }
    }

    /// Reads so far.
    pub(super) fn n_reads(&self) -> u64 {
        self.n_reads
    }

    pub(super) fn absorb_state(&self, hash: &mut StateHash) {
        hash.absorb_u64(self.read.value());
    }
}
