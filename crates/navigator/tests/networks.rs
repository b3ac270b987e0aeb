//! Random networks of trails, goals at random nodes: whoever can be reached is reached, all others
//! are refused with a reason. Whether one can be reached is decided by a graph of the lines that were
//! drawn, which shares no code with the navigator.
//!
//! `NETWORKS=1000 cargo test --release -p cairn_navigator --test networks -- --nocapture` prints the
//! table of the guide; `NETWORK=free/17` drives one network and tells what happens.

#![expect(clippy::unwrap_used, clippy::print_stdout, reason = "a test")]

mod bed;

use bed::{Bed, wall};
use geometry::{Se2, Segment, Vec2, wrap_to_pi};
use messages::FailureReason;
use navigator::Phase;
use pheromones::Field;
use run_context::RunSeed;

/// Nodes (m) and the trails between them.
struct Network {
    nodes: Vec<Vec2>,
    trails: Vec<(usize, usize)>,
}

struct Dice(run_context::RandomStream);

impl Dice {
    fn of(kind: &str, seed: u64) -> Self {
        Self(RunSeed(seed).stream(kind))
    }

    fn between(&mut self, from: f64, to: f64) -> f64 {
        use rand_core::Rng;
        from + (to - from) * (self.0.next_u64() as f64 / u64::MAX as f64)
    }

    fn chance(&mut self, prob: f64) -> bool {
        self.between(0.0, 1.0) < prob
    }

    fn index(&mut self, n: usize) -> usize {
        (self.between(0.0, n as f64) as usize).min(n - 1)
    }
}

impl Network {
    fn segment(&self, trail: (usize, usize)) -> Segment {
        Segment { a: self.nodes[trail.0], b: self.nodes[trail.1] }
    }

    /// Streets of a town: some are missing; half of the towns are turned.
    fn grid(dice: &mut Dice) -> Self {
        let block_m = dice.between(1.2, 2.4);
        let (n_x, n_y) = (3 + dice.index(3), 3 + dice.index(3));
        let turned = dice.chance(0.5);
        let yaw_rad = if turned { dice.between(0.0, 1.5) } else { 0.0 };
        let centre = Se2::new(dice.between(-0.1, 0.1), dice.between(-0.1, 0.1), yaw_rad);
        let mut network = Self { nodes: Vec::new(), trails: Vec::new() };
        let kept = dice.between(0.45, 0.8);
        for row in 0..n_y {
            for column in 0..n_x {
                let x = (column as f64 - 0.5 * (n_x - 1) as f64) * block_m;
                let y = (row as f64 - 0.5 * (n_y - 1) as f64) * block_m;
                network.nodes.push(centre.transform_point(Vec2::new(x, y)));
                let node = row * n_x + column;
                if column + 1 < n_x && dice.chance(kept) {
                    network.trails.push((node, node + 1));
                }
                if row + 1 < n_y && dice.chance(kept) {
                    network.trails.push((node, node + n_x));
                }
            }
        }
        network
    }

    /// Up to 14 points with trails between near ones, which may cross; angles of 34° or more, and
    /// a metre between what does not meet.
    fn free(dice: &mut Dice) -> Self {
        let mut network = Self { nodes: Vec::new(), trails: Vec::new() };
        for _ in 0..200 {
            let at = Vec2::new(dice.between(-6.0, 6.0), dice.between(-5.0, 5.0));
            let is_far = network.nodes.iter().all(|other| (other - at).norm() > 1.6);
            if is_far && network.nodes.len() < 14 {
                network.nodes.push(at);
            }
        }
        for _ in 0..120 {
            let trail = (dice.index(network.nodes.len()), dice.index(network.nodes.len()));
            if network.may_have(trail) && 4 * network.trails.len() < 5 * network.nodes.len() {
                network.trails.push(trail);
            }
        }
        network
    }

    fn may_have(&self, trail: (usize, usize)) -> bool {
        const ANGLE_LEAST_RAD: f64 = 0.6;
        let segment = self.segment(trail);
        let ends = |t: (usize, usize)| [t.0, t.1];
        let too_long = trail.0 == trail.1 || segment.length() > 4.5;
        let passes_a_node = (0..self.nodes.len())
            .any(|k| !ends(trail).contains(&k) && segment.distance(self.nodes[k]) < 1.0);
        let yaw = |s: Segment| (s.b - s.a).y.atan2((s.b - s.a).x);
        !too_long
            && !passes_a_node
            && self.trails.iter().all(|other| {
                let shared = ends(trail).into_iter().find(|k| ends(*other).contains(k));
                let line = self.segment(*other);
                let turn = wrap_to_pi(yaw(line) - yaw(segment));
                match shared {
                    Some(node) => {
                        // Both as they leave the node they share.
                        let away = |t: (usize, usize)| {
                            if t.0 == node { 0.0 } else { std::f64::consts::PI }
                        };
                        let between = wrap_to_pi(turn + away(*other) - away(trail)).abs();
                        between > ANGLE_LEAST_RAD
                    }
                    None if crossing(segment, line).is_some() => {
                        turn.sin().abs() > ANGLE_LEAST_RAD.sin()
                    }
                    None => segment.distance_to_segment(line) > 1.0,
                }
            })
    }

    /// Shortest ways along the trails from a node to all nodes (m); infinite where none leads.
    fn ways_m(&self, from: usize) -> Vec<f64> {
        // Crossings are nodes, too: each line is cut where another one crosses it.
        let mut points = self.nodes.clone();
        let mut along: Vec<Vec<(f64, usize)>> =
            self.trails.iter().map(|t| vec![(0.0, t.0), (1.0, t.1)]).collect();
        for i in 0..self.trails.len() {
            for j in i + 1..self.trails.len() {
                let (a, b) = (self.trails[i], self.trails[j]);
                let meet = [a.0, a.1].iter().any(|k| [b.0, b.1].contains(k));
                if let Some((t, u)) = crossing(self.segment(a), self.segment(b)).filter(|_| !meet) {
                    points.push(self.segment(a).point_at(t));
                    along[i].push((t, points.len() - 1));
                    along[j].push((u, points.len() - 1));
                }
            }
        }
        let mut edges = Vec::new();
        for line in &mut along {
            line.sort_by(|a, b| a.0.total_cmp(&b.0));
            edges.extend(line.windows(2).map(|pair| (pair[0].1, pair[1].1)));
        }
        let mut ways_m = vec![f64::INFINITY; points.len()];
        ways_m[from] = 0.0;
        for _ in 0..points.len() {
            for (a, b) in &edges {
                let length_m = (points[*a] - points[*b]).norm();
                ways_m[*a] = ways_m[*a].min(ways_m[*b] + length_m);
                ways_m[*b] = ways_m[*b].min(ways_m[*a] + length_m);
            }
        }
        ways_m.truncate(self.nodes.len());
        ways_m
    }

    /// The field with the trails drawn, one cell wide; every seventh trail has a cell missing.
    fn draw(&self, dice: &mut Dice) -> Field {
        let mut field = Field::new(101, 101, 0.2).unwrap();
        for trail in &self.trails {
            field.draw_trail(&[self.nodes[trail.0], self.nodes[trail.1]], 1);
        }
        for trail in &self.trails {
            if dice.chance(0.15) {
                let at = self.segment(*trail).point_at(dice.between(0.3, 0.7));
                let (column, row) = field.cell_at(at).unwrap();
                field.set(column, row, 0).unwrap();
            }
        }
        field
    }

    fn distance_m(&self, point: Vec2) -> f64 {
        let gaps = self.trails.iter().map(|t| self.segment(*t).distance(point));
        gaps.fold(f64::INFINITY, f64::min)
    }

    /// Whether it is beyond doubt that no way leads from `start` to `goal`: other trails are out of
    /// reach where the robot stands, along its trails, and from their ends.
    fn is_clearly_cut_off(&self, start: usize, goal: usize, ways_m: &[f64]) -> bool {
        let (ours, others): (Vec<_>, Vec<_>) =
            self.trails.iter().copied().partition(|t| ways_m[t.0].is_finite());
        let gaps = |from: &[(usize, usize)], point: Vec2| {
            let gaps = from.iter().map(|t| self.segment(*t).distance(point));
            gaps.fold(f64::INFINITY, f64::min)
        };
        let apart = ours.iter().all(|a| {
            others.iter().all(|b| self.segment(*a).distance_to_segment(self.segment(*b)) > 0.99)
        });
        apart && gaps(&ours, self.nodes[goal]) > 1.9 && gaps(&others, self.nodes[start]) > 2.3
    }
}

/// Where two segments cross: how far along each, from 0 to 1.
fn crossing(a: Segment, b: Segment) -> Option<(f64, f64)> {
    let (r, s, q) = (a.b - a.a, b.b - b.a, b.a - a.a);
    let cross = |u: Vec2, v: Vec2| u.x * v.y - u.y * v.x;
    let (t, u) = (cross(q, s) / cross(r, s), cross(q, r) / cross(r, s));
    ((0.0..=1.0).contains(&t) && (0.0..=1.0).contains(&u)).then_some((t, u))
}

#[derive(Default)]
struct Tally {
    n_networks: u32,
    n_reachable: u32,
    n_arrived: u32,
    n_cut_off: u32,
    n_refused: u32,
    n_questions: u64,
    questions_max: u32,
    /// Driven and shortest way, where it arrived (m).
    driven_m: f64,
    shortest_m: f64,
    n_detours: u32,
    astray_max_m: f64,
}

fn try_goal(
    kind: &str,
    seed: u64,
    network: &Network,
    dice: &mut Dice,
    field: &Field,
    tally: &mut Tally,
) {
    let used: Vec<usize> = (0..network.nodes.len())
        .filter(|k| network.trails.iter().any(|t| t.0 == *k || t.1 == *k))
        .collect();
    let (start, goal) = (used[dice.index(used.len())], used[dice.index(used.len())]);
    let ways_m = network.ways_m(start);
    let is_reachable = ways_m[goal].is_finite();
    let far = (network.nodes[goal] - network.nodes[start]).norm() > 1.7;
    if !far || !is_reachable && !network.is_clearly_cut_off(start, goal, &ways_m) {
        return;
    }
    let room = 10.5;
    let walls = vec![
        wall(-room, -room, room, -room),
        wall(room, -room, room, room),
        wall(room, room, -room, room),
        wall(-room, room, -room, -room),
    ];
    let at = network.nodes[start];
    let (x, y) = (at.x + dice.between(-0.1, 0.1), at.y + dice.between(-0.1, 0.1));
    let pose = Se2::new(x, y, dice.between(-3.1, 3.1));
    let mut bed = Bed::new(|s| s, walls, field.clone(), pose, seed);
    bed.trace = std::env::var("TRACE").is_ok();
    let to = network.nodes[goal];
    let figures = bed.run_to(Se2::new(to.x, to.y, dice.between(-3.1, 3.1)), 600.0);
    assert_eq!(figures.n_touched, 0, "{kind} {seed}");
    let scouting = bed.navigator.view().scouting;
    tally.n_questions += u64::from(scouting.n_questions);
    tally.questions_max = tally.questions_max.max(scouting.n_questions);
    let arrived = figures.phase == Phase::Arrived && figures.goal_error_m < 0.25;
    let refused = figures.phase == Phase::Failed(FailureReason::NoTrailToGoal);
    let astray = figures.track.iter().map(|p| network.distance_m(p.position()));
    if is_reachable {
        tally.n_reachable += 1;
        tally.n_arrived += u32::from(arrived);
        if arrived {
            tally.astray_max_m = astray.fold(tally.astray_max_m, f64::max);
            tally.driven_m += figures.way_m;
            tally.shortest_m += ways_m[goal];
            tally.n_detours += u32::from(figures.way_m > 1.1 * ways_m[goal] + 1.0);
        }
    } else {
        tally.n_cut_off += 1;
        tally.n_refused += u32::from(refused && figures.way_m < 0.01);
    }
    let right = if is_reachable { arrived } else { refused };
    if !right || std::env::var("NETWORK").is_ok() {
        println!(
            "{kind}/{seed}: from {:.1} {:.1} to {:.1} {:.1}, way {:.1} m: {:?} after {:.0} s at {:.2?}, driven {:.1} m, {scouting:?}",
            at.x,
            at.y,
            to.x,
            to.y,
            ways_m[goal],
            figures.phase,
            figures.time_s,
            bed.world_from_base,
            figures.way_m,
        );
    }
}

fn check(kind: &str, make: fn(&mut Dice) -> Network) {
    let n_networks = std::env::var("NETWORKS").map_or(60, |n| n.parse().unwrap());
    let only = std::env::var("NETWORK").ok();
    let mut tally = Tally::default();
    for seed in 0..n_networks {
        if only.as_ref().is_some_and(|only| *only != format!("{kind}/{seed}")) {
            continue;
        }
        let mut dice = Dice::of(kind, seed);
        let network = make(&mut dice);
        if network.trails.len() < 3 {
            continue;
        }
        tally.n_networks += 1;
        let field = network.draw(&mut dice);
        for _ in 0..3 {
            try_goal(kind, seed, &network, &mut dice, &field, &mut tally);
        }
    }
    let n_goals = tally.n_reachable + tally.n_cut_off;
    println!(
        "| {kind} | {} | {} of {} | {} of {} | {:.0}, at most {} | {:.2} | {} | {:.2} m |",
        tally.n_networks,
        tally.n_arrived,
        tally.n_reachable,
        tally.n_refused,
        tally.n_cut_off,
        tally.n_questions as f64 / f64::from(n_goals.max(1)),
        tally.questions_max,
        tally.driven_m / tally.shortest_m,
        tally.n_detours,
        tally.astray_max_m,
    );
    if only.is_none() {
        assert!(tally.n_arrived * 100 >= tally.n_reachable * 98, "{kind}: arrived");
        assert_eq!(tally.n_refused, tally.n_cut_off, "{kind}: refused");
        assert!(tally.n_reachable >= 30 && tally.n_cut_off >= 3, "{kind}: too few of a sort");
    }
}

#[test]
fn goals_on_networks_like_streets_are_reached_or_refused() {
    check("grid", Network::grid);
}

#[test]
fn goals_on_free_networks_are_reached_or_refused() {
    check("free", Network::free);
}
