//! What optimisation, starts and marginals promise, against a dense solver that shares no code with
//! them: derivatives by differences of composed poses, factorisation and inverse by nalgebra.

use std::f64::consts::PI;

use geometry::{Se2, wrap_to_pi};
use nalgebra::{DMatrix, DVector, Matrix3, Matrix6, Vector3};
use proptest::prelude::*;

use crate::{
    Config, Edge, GraphError, Kernel, Marginals, Outcome, PoseGraph, Report, Start, Workspace,
    chordal_start, odometry_start, optimise,
};

/// Σ eᵀΩe with its derivatives by all poses: half the Hessian of Gauss–Newton, half the gradient.
fn dense_normal_equations(graph: &PoseGraph) -> (DMatrix<f64>, DVector<f64>) {
    let n = 3 * graph.poses().len();
    let mut h = DMatrix::zeros(n, n);
    let mut g = DVector::zeros(n);
    for edge in graph.edges() {
        let error = |poses: &[Se2]| {
            let e = edge
                .to_in_from
                .inverse()
                .compose(poses[edge.from].inverse().compose(poses[edge.to]));
            Vector3::new(e.x_m, e.y_m, e.yaw_rad)
        };
        let at = error(graph.poses());
        let mut j = DMatrix::zeros(3, n);
        for vertex in [edge.from, edge.to] {
            for axis in 0..3 {
                let moved = |by: f64| {
                    let mut poses = graph.poses().to_vec();
                    let p = &mut poses[vertex];
                    *p = Se2::new(
                        p.x_m + if axis == 0 { by } else { 0.0 },
                        p.y_m + if axis == 1 { by } else { 0.0 },
                        p.yaw_rad + if axis == 2 { by } else { 0.0 },
                    );
                    let mut e = error(&poses) - at;
                    e.z = wrap_to_pi(e.z);
                    e
                };
                let slope = (moved(1e-5) - moved(-1e-5)) / 2e-5;
                j.view_mut((0, 3 * vertex + axis), (3, 1)).copy_from(&slope);
            }
        }
        let weight = edge.kernel.cost_and_weight(at.dot(&(edge.information * at))).1;
        let information = edge.information * weight;
        h += j.transpose() * information * &j;
        g += j.transpose() * information * at;
    }
    (h, g)
}

/// The rows and columns of all vertices but `held`.
fn without(h: &DMatrix<f64>, held: &[usize]) -> DMatrix<f64> {
    let gone: Vec<usize> = held.iter().flat_map(|v| 3 * v..3 * v + 3).collect();
    h.clone().remove_rows_at(&gone).remove_columns_at(&gone)
}

/// Gauss–Newton with vertex 0 held, until nothing moves.
fn dense_optimum(graph: &PoseGraph) -> PoseGraph {
    let mut graph = graph.clone();
    for _ in 0..60 {
        let (h, g) = dense_normal_equations(&graph);
        let step = without(&h, &[0]).cholesky().unwrap().solve(&-g.remove_rows(0, 3));
        for vertex in 1..graph.poses().len() {
            let (p, s) = (graph.poses()[vertex], &step.as_slice()[3 * vertex - 3..3 * vertex]);
            let moved = Se2::new(p.x_m + s[0], p.y_m + s[1], p.yaw_rad + s[2]);
            graph.set_pose(vertex, moved).unwrap();
        }
        if step.amax() < 1e-12 {
            break;
        }
    }
    graph
}

fn information(values: [f64; 6]) -> Matrix3<f64> {
    let [a, b, c, d, e, f] = values;
    let l = Matrix3::new(1.0 + a, 0.0, 0.0, b, 1.0 + c, 0.0, d, e, 1.0 + f);
    10.0 * l * l.transpose()
}

/// A loop that turns left, with closures and noisy measurements; poses start off the truth.
fn noisy_loop(noise: &[f64], n: usize) -> PoseGraph {
    let mut noise = noise.iter().copied().cycle();
    let mut next = move || noise.next().unwrap_or(0.0);
    let mut graph = PoseGraph::new();
    let mut truth = Se2::IDENTITY;
    for i in 0..n {
        let off = if i == 0 { 0.0 } else { 0.1 };
        graph.add_vertex(Se2::new(
            truth.x_m + off * next(),
            truth.y_m + off * next(),
            truth.yaw_rad + off * next(),
        ));
        truth = truth.compose(Se2::new(1.0, 0.1, 2.0 * PI / n as f64));
    }
    let truth_of = |i: usize| {
        let step = Se2::new(1.0, 0.1, 2.0 * PI / n as f64);
        (0..i).fold(Se2::IDENTITY, |p, _| p.compose(step))
    };
    let closures = [(n - 1, 0), (0, n / 2), (n / 3, n - 2), (n / 2, 0)];
    for (from, to) in (1..n).map(|i| (i - 1, i)).chain(closures) {
        let z = truth_of(from).inverse().compose(truth_of(to));
        let z = Se2::new(z.x_m + 0.05 * next(), z.y_m + 0.05 * next(), z.yaw_rad + 0.05 * next());
        let information =
            information([next(), next(), next(), next(), next(), next()].map(f64::abs));
        graph.add_edge(Edge::new(from, to, z, information)).unwrap();
    }
    graph
}

fn run(graph: &mut PoseGraph) -> Report {
    let config = Config { tolerance_ratio: 1e-14, ..Config::default() };
    optimise(graph, &config, &mut Workspace::new())
}

fn distance(a: Se2, b: Se2) -> f64 {
    (a.x_m - b.x_m).abs().max((a.y_m - b.y_m).abs()).max(wrap_to_pi(a.yaw_rad - b.yaw_rad).abs())
}

fn farthest(a: &PoseGraph, b: &PoseGraph) -> f64 {
    a.poses().iter().zip(b.poses()).map(|(a, b)| distance(*a, *b)).fold(0.0, f64::max)
}

fn noise() -> impl Strategy<Value = Vec<f64>> {
    proptest::collection::vec(-1.0..1.0, 37)
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn the_optimum_is_that_of_the_dense_solver(noise in noise(), n in 5_usize..14) {
        let start = noisy_loop(&noise, n);
        let mut graph = start.clone();
        let report = run(&mut graph);
        prop_assert_eq!(report.outcome, Outcome::Converged);
        prop_assert!(farthest(&graph, &dense_optimum(&start)) < 1e-6);
        prop_assert!((report.chi2_before - start.chi2()).abs() <= 1e-12 * start.chi2());
        prop_assert!((report.chi2_after - graph.chi2()).abs() <= 1e-9 * (1.0 + graph.chi2()));
    }

    #[test]
    fn marginals_are_blocks_of_the_dense_inverse(noise in noise(), n in 5_usize..14) {
        let mut graph = noisy_loop(&noise, n);
        graph.set_kernel(0, Kernel::Cauchy { width_ratio: 0.1 }).unwrap();
        run(&mut graph);
        let inverse = without(&dense_normal_equations(&graph).0, &[0]).try_inverse().unwrap();
        let block = |a: usize, b: usize| {
            if a == 0 || b == 0 {
                return Matrix3::zeros();
            }
            inverse.fixed_view::<3, 3>(3 * a - 3, 3 * b - 3).into_owned()
        };
        let mut scratch = Workspace::new();
        let mut marginals = Marginals::new(&graph, &mut scratch).unwrap();
        let scale = inverse.amax();
        for (a, b) in [(1, n - 1), (n - 1, 1), (0, 2), (3, 0), (2, 2), (4, 3), (4, 3), (2, 3)] {
            let mut joint = Matrix6::zeros();
            for (row, p) in [a, b].into_iter().enumerate() {
                for (column, q) in [a, b].into_iter().enumerate() {
                    joint.fixed_view_mut::<3, 3>(3 * row, 3 * column).copy_from(&block(p, q));
                }
            }
            prop_assert!((marginals.joint(a, b).unwrap() - joint).amax() < 1e-6 * scale);
            prop_assert!((marginals.covariance(a).unwrap() - block(a, a)).amax() < 1e-6 * scale);
            let expected = relative_by_differences(&graph, a, b, &joint);
            prop_assert!((marginals.relative(a, b).unwrap() - expected).amax() < 1e-5 * scale);
        }
    }

    #[test]
    fn moving_everything_changes_no_chi2(noise in noise(), x in -50.0..50.0, yaw in -PI..PI) {
        let graph = noisy_loop(&noise, 9);
        let mut moved = graph.clone();
        let motion = Se2::new(x, -x, yaw);
        for vertex in 0..9 {
            moved.set_pose(vertex, motion.compose(graph.poses()[vertex])).unwrap();
        }
        prop_assert!((moved.chi2() - graph.chi2()).abs() < 1e-9 * graph.chi2());
        let (mut a, mut b) = (graph, moved);
        let (here, there) = (run(&mut a), run(&mut b));
        prop_assert!((here.chi2_after - there.chi2_after).abs() < 1e-8 * here.chi2_after);
        for vertex in 0..9 {
            prop_assert!(distance(motion.compose(a.poses()[vertex]), b.poses()[vertex]) < 1e-6);
        }
    }

    #[test]
    fn both_starts_are_exact_where_nothing_is_noisy(n in 5_usize..20, held in 0_usize..5) {
        let mut graph = noisy_loop(&[0.0], n);
        graph.fix(held).unwrap();
        let truth = graph.clone();
        for start in [Start::Odometry, Start::Chordal] {
            for vertex in (0..n).filter(|v| *v != held) {
                graph.set_pose(vertex, Se2::new(9.0, -9.0, 1.0)).unwrap();
            }
            match start {
                Start::Odometry => odometry_start(&mut graph),
                _ => chordal_start(&mut graph, &mut Workspace::new()).unwrap(),
            }
            prop_assert!(farthest(&graph, &truth) < 1e-9, "{start:?}");
        }
    }
}

fn relative_by_differences(
    graph: &PoseGraph,
    a: usize,
    b: usize,
    joint: &Matrix6<f64>,
) -> Matrix3<f64> {
    let mut jacobian = nalgebra::SMatrix::<f64, 3, 6>::zeros();
    for axis in 0..6 {
        let moved = |by: f64| {
            let mut ends = [graph.poses()[a], graph.poses()[b]];
            let p = &mut ends[axis / 3];
            match axis % 3 {
                0 => p.x_m += by,
                1 => p.y_m += by,
                _ => *p = Se2::new(p.x_m, p.y_m, p.yaw_rad + by),
            }
            ends[0].inverse().compose(ends[1])
        };
        let (up, down) = (moved(1e-5), moved(-1e-5));
        jacobian[(0, axis)] = (up.x_m - down.x_m) / 2e-5;
        jacobian[(1, axis)] = (up.y_m - down.y_m) / 2e-5;
        jacobian[(2, axis)] = wrap_to_pi(up.yaw_rad - down.yaw_rad) / 2e-5;
    }
    jacobian * joint * jacobian.transpose()
}

#[test]
fn kernels_reject_a_wrong_loop_closure_and_a_plain_sum_does_not() {
    let clean = {
        let mut graph = noisy_loop(&[0.3, -0.5, 0.1, 0.7, -0.2], 30);
        run(&mut graph);
        graph
    };
    let off_by = |kernel: Kernel| {
        let mut graph = clean.clone();
        let wrong = Edge::new(5, 20, Se2::new(0.2, 0.1, 0.3), Matrix3::identity() * 100.0);
        graph.add_edge(wrong.with_kernel(kernel)).unwrap();
        let report = run(&mut graph);
        assert_eq!(report.outcome, Outcome::Converged, "{kernel:?}");
        assert!(report.cost_after <= report.chi2_after);
        farthest(&graph, &clean)
    };
    assert!(off_by(Kernel::None) > 1.0);
    assert!(off_by(Kernel::Huber { width_ratio: 1.0 }) < 0.8 * off_by(Kernel::None));
    for width_ratio in [1.0, 3.0] {
        assert!(off_by(Kernel::Cauchy { width_ratio }) < 0.5);
        assert!(off_by(Kernel::GemanMcClure { width_ratio }) < 0.01);
        assert!(off_by(Kernel::DynamicCovarianceScaling { width_ratio }) < 0.01);
    }
}

#[test]
fn a_minimum_with_kernels_has_no_slope() {
    let mut graph = noisy_loop(&[0.9, -0.8, 0.6, 0.7, -0.9, 0.2, 0.4], 12);
    for edge in 0..graph.edges().len() {
        graph.set_kernel(edge, Kernel::Cauchy { width_ratio: 0.3 }).unwrap();
    }
    let before = dense_normal_equations(&graph).1.rows(3, 33).amax();
    let report = run(&mut graph);
    let (_, gradient) = dense_normal_equations(&graph);
    assert_eq!(report.outcome, Outcome::Converged);
    assert!(
        gradient.rows(3, 33).amax() < 1e-5 * before,
        "{} of {before}",
        gradient.rows(3, 33).amax()
    );
}

#[test]
fn the_limit_of_iterations_is_seen_and_keeps_the_best_poses() {
    let start = noisy_loop(&[0.9, -0.8, 0.6], 12);
    for iterations_max in [0, 1, 2] {
        let mut graph = start.clone();
        let config = Config { iterations_max, tolerance_ratio: 0.0, ..Config::default() };
        let report = optimise(&mut graph, &config, &mut Workspace::new());
        assert_eq!(report.outcome, Outcome::IterationLimit);
        assert_eq!(report.iterations, iterations_max);
        assert_eq!(graph == start, iterations_max == 0);
        assert!(report.chi2_after <= report.chi2_at_start);
        assert!((report.chi2_after - graph.chi2()).abs() < 1e-9 * graph.chi2());
    }
}

/// A ring whose headings and places are all wrong: plain Gauss–Newton goes uphill.
fn tangled_ring(step_m: f64, yaw_information: f64) -> PoseGraph {
    let mut graph = PoseGraph::new();
    let n = 40;
    for i in 0..n {
        graph.add_vertex(Se2::new((1.3 * i as f64).sin() * 5.0, 0.1 * i as f64, 0.9 * i as f64));
    }
    let stiff = Matrix3::from_diagonal(&Vector3::new(1000.0, 1000.0, yaw_information));
    for i in 0..n {
        let z = Se2::new(step_m, 0.0, 2.0 * PI / n as f64);
        graph.add_edge(Edge::new(i, (i + 1) % n, z, stiff)).unwrap();
    }
    graph
}

#[test]
fn a_step_uphill_is_damped_until_it_goes_down() {
    let mut graph = tangled_ring(1.0, 0.1);
    let first = Config { iterations_max: 1, tolerance_ratio: 0.0, ..Config::default() };
    let mut once = graph.clone();
    let report = optimise(&mut once, &first, &mut Workspace::new());
    assert_eq!(once, graph, "the example has become too easy for Gauss–Newton");
    assert!((report.chi2_after - report.chi2_before).abs() < 1e-9 * report.chi2_before);
    let mut previous = graph.chi2();
    for iterations_max in 2..12 {
        let config = Config { iterations_max, ..first };
        let mut further = tangled_ring(1.0, 0.1);
        let report = optimise(&mut further, &config, &mut Workspace::new());
        assert!(
            report.chi2_after <= previous && report.chi2_after <= further.chi2() * (1.0 + 1e-9)
        );
        previous = report.chi2_after;
    }
    assert!(previous < 0.5 * graph.chi2());
    let config = Config { iterations_max: 2000, ..Config::default() };
    assert_eq!(optimise(&mut graph, &config, &mut Workspace::new()).outcome, Outcome::Converged);
    // The ring may keep a turn too many, which is a minimum of its own: nothing slopes there.
    let (_, gradient) = dense_normal_equations(&graph);
    assert!(gradient.rows_range(3..).amax() < 1.0, "{} at {}", gradient.amax(), graph.chi2());
}

/// Where headings are nearly free, much damping is needed for long, and damped steps promise little.
#[test]
fn damped_steps_do_not_count_as_convergence() {
    let mut graph = tangled_ring(0.01, 1e-6);
    let config = Config { iterations_max: 2000, tolerance_ratio: 0.2, ..Config::default() };
    let report = optimise(&mut graph, &config, &mut Workspace::new());
    assert_eq!(report.outcome, Outcome::Converged);
    assert!(report.chi2_after < 1e-6 * report.chi2_before, "{report:?}");
}

#[test]
fn graphs_with_nothing_to_do_end_normally() {
    let mut empty = PoseGraph::new();
    assert_eq!(run(&mut empty).outcome, Outcome::NothingToMove);
    let mut lonely = PoseGraph::new();
    lonely.add_vertex(Se2::new(1.0, 2.0, 3.0));
    let report = run(&mut lonely);
    assert_eq!((report.outcome, report.n_anchors), (Outcome::NothingToMove, 1));
    assert_eq!(lonely.poses(), [Se2::new(1.0, 2.0, 3.0)]);
    let mut held = noisy_loop(&[0.5, -0.1], 5);
    (0..5).for_each(|v| held.fix(v).unwrap());
    let before = held.clone();
    let report = run(&mut held);
    assert_eq!((report.outcome, report.n_anchors), (Outcome::NothingToMove, 0));
    assert!(held == before && report.chi2_after > 0.0);
    for start in [Start::Auto, Start::Chordal, Start::Odometry] {
        let config = Config { start, ..Config::default() };
        let outcome = optimise(&mut empty, &config, &mut Workspace::new()).outcome;
        assert_eq!(outcome, Outcome::NothingToMove);
    }
    assert!(Marginals::new(&empty, &mut Workspace::new()).unwrap().covariance(0).is_err());
    let mut scratch = Workspace::new();
    let covariance = Marginals::new(&lonely, &mut scratch).unwrap().covariance(0);
    assert_eq!(covariance, Ok(Matrix3::zeros()));
}

#[test]
fn separate_parts_are_each_held_at_their_first_vertex() {
    let part = noisy_loop(&[0.4, -0.6, 0.9], 6);
    let mut both = PoseGraph::new();
    for shift in [0, 6] {
        for pose in part.poses() {
            both.add_vertex(*pose);
        }
        for edge in part.edges() {
            both.add_edge(Edge { from: edge.from + shift, to: edge.to + shift, ..*edge }).unwrap();
        }
    }
    let mut alone = part.clone();
    let alone_report = run(&mut alone);
    let report = run(&mut both);
    assert_eq!((report.outcome, report.n_anchors), (Outcome::Converged, 2));
    assert!((report.chi2_after - 2.0 * alone_report.chi2_after).abs() < 1e-9);
    for vertex in 0..12 {
        assert!(distance(both.poses()[vertex], alone.poses()[vertex % 6]) < 1e-7);
    }
    let mut scratch = Workspace::new();
    let mut marginals = Marginals::new(&both, &mut scratch).unwrap();
    assert_eq!(marginals.relative(1, 7), Err(GraphError::NotConnected { from: 1, to: 7 }));
    assert_eq!(marginals.relative(0, 6), Err(GraphError::NotConnected { from: 0, to: 6 }));
    assert!(marginals.relative(1, 5).is_ok());
    // Two vertices that are fixed on purpose have a known relative pose.
    both.fix(0).unwrap();
    both.fix(6).unwrap();
    let mut marginals = Marginals::new(&both, &mut scratch).unwrap();
    assert_eq!(marginals.relative(0, 6), Ok(Matrix3::zeros()));
    assert!(marginals.relative(1, 7).is_ok());
}

#[test]
fn a_fixed_vertex_stays_and_others_come_to_it() {
    let mut graph = noisy_loop(&[0.4, -0.6, 0.9], 6);
    graph.fix(3).unwrap();
    let third = graph.poses()[3];
    let report = run(&mut graph);
    assert_eq!((report.outcome, report.n_anchors), (Outcome::Converged, 0));
    assert_eq!(graph.poses()[3], third);
}

#[test]
fn directions_that_no_edge_determines_do_not_stop_the_rest() {
    let mut graph = PoseGraph::new();
    for x in [0.0, 1.2, 2.1] {
        graph.add_vertex(Se2::new(x, 0.3, 0.1 * x));
    }
    let no_yaw = Matrix3::from_diagonal(&Vector3::new(4.0, 4.0, 0.0));
    graph.add_edge(Edge::new(0, 1, Se2::new(1.0, 0.0, 0.0), no_yaw)).unwrap();
    graph.add_edge(Edge::new(0, 2, Se2::new(2.0, 0.0, 0.0), no_yaw)).unwrap();
    assert!(matches!(
        Marginals::new(&graph, &mut Workspace::new()).map(|_| ()),
        Err(GraphError::Undetermined)
    ));
    let unsolved = graph.clone();
    assert_eq!(chordal_start(&mut graph, &mut Workspace::new()), Err(GraphError::Undetermined));
    assert_eq!(graph, unsolved);
    let report = run(&mut graph);
    assert_eq!(report.outcome, Outcome::Converged);
    assert!(report.chi2_after < 1e-10 && (graph.poses()[1].x_m - 1.0).abs() < 1e-6);
    // A chordal start that does not exist is replaced, and the report says by what.
    let config = Config { start: Start::Chordal, ..Config::default() };
    let report = optimise(&mut unsolved.clone(), &config, &mut Workspace::new());
    assert_eq!(report.start, Start::Odometry);
}

#[test]
fn poses_that_are_not_finite_are_told_and_left_alone() {
    for bad in [f64::NAN, f64::INFINITY] {
        let mut graph = noisy_loop(&[0.4], 6);
        graph.set_pose(2, Se2 { x_m: bad, y_m: 0.0, yaw_rad: 0.0 }).unwrap();
        let report = run(&mut graph);
        assert_eq!(report.outcome, Outcome::NotFinite);
        assert_eq!(graph.poses()[2].x_m.to_bits(), bad.to_bits());
        let undetermined = Marginals::new(&graph, &mut Workspace::new()).map(|_| ());
        assert_eq!(undetermined.unwrap_err(), GraphError::Undetermined);
    }
    // Finite, but its square is not.
    let mut graph = noisy_loop(&[0.4], 6);
    graph.set_pose(2, Se2 { x_m: 1e200, y_m: 0.0, yaw_rad: 0.0 }).unwrap();
    let report = run(&mut graph);
    assert_eq!(report.outcome, Outcome::NotFinite);
    assert!((graph.poses()[2].x_m / 1e200 - 1.0).abs() < 1e-12);
}

#[test]
fn edges_twice_count_twice() {
    let mut graph = noisy_loop(&[0.4, -0.6, 0.9], 6);
    let single = run(&mut graph.clone());
    let edges = graph.edges().to_vec();
    for edge in edges {
        graph.add_edge(edge).unwrap();
    }
    let double = run(&mut graph);
    assert!((double.chi2_after - 2.0 * single.chi2_after).abs() < 1e-9);
}

#[test]
fn a_workspace_serves_other_graphs_in_between_with_the_same_bits() {
    let config = Config { start: Start::Auto, ..Config::default() };
    let fresh = |graph: &PoseGraph| {
        let mut graph = graph.clone();
        let report = optimise(&mut graph, &config, &mut Workspace::new());
        (graph, report)
    };
    let small = noisy_loop(&[0.4, -0.6, 0.9], 6);
    let mut grown = small.clone();
    grown.add_vertex(Se2::new(3.0, 3.0, 0.0));
    grown.add_edge(Edge::new(2, 6, Se2::new(1.0, 1.0, 0.5), Matrix3::identity())).unwrap();
    let mut held = grown.clone();
    held.fix(4).unwrap();
    let mut scratch = Workspace::new();
    for graph in [&small, &grown, &held, &held, &grown, &small] {
        let mut again = graph.clone();
        let report = optimise(&mut again, &config, &mut scratch);
        assert_eq!((again, report), fresh(graph));
        Marginals::new(graph, &mut scratch).unwrap().joint(1, 3).unwrap();
    }
}

#[test]
fn the_best_start_is_taken() {
    let mut graph = noisy_loop(&[0.4, -0.6, 0.9, 0.2], 30);
    let config = Config { start: Start::Auto, ..Config::default() };
    // Poses far from the truth: one of the made starts is better.
    let away = |i: usize| Se2::new(5.0 * (i as f64).sin(), 3.0, i as f64);
    (1..30).for_each(|v| graph.set_pose(v, away(v)).unwrap());
    let report = optimise(&mut graph, &config, &mut Workspace::new());
    assert!(report.start != Start::Given && report.chi2_at_start < 0.1 * report.chi2_before);
    assert_eq!(report.outcome, Outcome::Converged);
    // The optimum itself: nothing is better than what is given.
    let report = optimise(&mut graph, &config, &mut Workspace::new());
    assert_eq!((report.start, report.outcome), (Start::Given, Outcome::Converged));
}

#[test]
fn a_workspace_keeps_nothing_of_measurements_and_poses() {
    let first = noisy_loop(&[0.4, -0.6, 0.9], 8);
    let mut other = first.clone();
    other.retain_edges(|_, _| false);
    for edge in first.edges() {
        let z = edge.to_in_from;
        let to_in_from = Se2::new(1.1 * z.x_m, z.y_m, z.yaw_rad + 0.2);
        other.add_edge(Edge { to_in_from, ..*edge }).unwrap();
    }
    let config = Config::default();
    let mut scratch = Workspace::new();
    for graph in [&first, &other, &first] {
        let (mut here, mut there) = (graph.clone(), graph.clone());
        let fresh = optimise(&mut there, &config, &mut Workspace::new());
        assert_eq!(optimise(&mut here, &config, &mut scratch), fresh);
        assert_eq!(here, there);
        let covariance = Marginals::new(&here, &mut scratch).unwrap().relative(2, 5);
        let mut empty = Workspace::new();
        assert_eq!(covariance, Marginals::new(&here, &mut empty).unwrap().relative(2, 5));
    }
}

#[test]
fn positions_of_a_chordal_start_are_the_best_for_its_headings() {
    let mut graph = noisy_loop(&[0.9, -0.8, 0.6, 0.7, -0.9], 12);
    let before = dense_normal_equations(&graph).1;
    chordal_start(&mut graph, &mut Workspace::new()).unwrap();
    let slope = dense_normal_equations(&graph).1;
    for index in (3..36).filter(|i| i % 3 != 2) {
        assert!(slope[index].abs() < 1e-6 * before.amax(), "{index}: {}", slope[index]);
    }
}

#[test]
fn an_odometry_start_follows_consecutive_vertices_before_shortcuts() {
    let mut graph = PoseGraph::new();
    for _ in 0..4 {
        graph.add_vertex(Se2::new(7.0, 7.0, 0.0));
    }
    graph.set_pose(0, Se2::IDENTITY).unwrap();
    // The last is against the direction of travel.
    for (from, to, x) in [(0, 3, 30.0), (0, 2, 20.0), (0, 1, 1.0), (1, 2, 1.0), (3, 2, -1.0)] {
        graph.add_edge(Edge::new(from, to, Se2::new(x, 0.0, 0.0), Matrix3::identity())).unwrap();
    }
    odometry_start(&mut graph);
    let x: Vec<f64> = graph.poses().iter().map(|p| p.x_m).collect();
    assert_eq!(x, [0.0, 1.0, 2.0, 3.0]);
}
