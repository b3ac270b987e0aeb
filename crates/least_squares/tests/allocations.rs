//! Iterations and questions about covariances do not allocate once the structure is known.

#![expect(clippy::unwrap_used, reason = "a test may stop where its promise is broken")]

use geometry::Se2;
use least_squares::{Config, Edge, Kernel, Marginals, PoseGraph, Workspace, optimise};
use nalgebra::Matrix3;

/// A grid of poses that see their neighbours.
fn grid(side: usize) -> PoseGraph {
    let mut graph = PoseGraph::new();
    let at = |i: usize| ((i % side) as f64, (i / side) as f64);
    for i in 0..side * side {
        let (x, y) = at(i);
        graph.add_vertex(Se2::new(1.1 * x + 0.1 * y.sin(), 0.9 * y, 0.1 * x.sin()));
    }
    for i in 0..side * side {
        for j in [i + 1, i + side] {
            if j < side * side && (j != i + 1 || j % side != 0) {
                let (a, b) = (at(i), at(j));
                let z = Se2::new(b.0 - a.0 + 0.01 * (i as f64).sin(), b.1 - a.1, 0.0);
                let edge = Edge::new(i, j, z, Matrix3::identity() * 50.0);
                graph.add_edge(edge.with_kernel(Kernel::Huber { width_ratio: 1.0 })).unwrap();
            }
        }
    }
    graph
}

#[test]
fn nothing_is_allocated_after_the_first_optimisation() {
    let given = grid(20);
    let mut graph = given.clone();
    let mut scratch = Workspace::new();
    let config = Config { iterations_max: 5, tolerance_ratio: 0.0, ..Config::default() };
    optimise(&mut graph, &config, &mut scratch);
    for (vertex, pose) in given.poses().iter().enumerate() {
        graph.set_pose(vertex, *pose).unwrap();
    }
    let counted = allocation_counter::measure(|| {
        let report = optimise(&mut graph, &config, &mut scratch);
        assert!(report.iterations >= 2 && report.chi2_after < report.chi2_before);
    });
    assert_eq!(counted.count_total, 0);

    let mut marginals = Marginals::new(&graph, &mut scratch).unwrap();
    let counted = allocation_counter::measure(|| {
        for vertex in [3, 4, 250] {
            assert!(marginals.relative(vertex, 399).unwrap().trace() > 0.0);
        }
    });
    assert_eq!(counted.count_total, 0);
}
