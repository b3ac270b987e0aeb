//! Published pose graphs reach their published optima.

#![expect(clippy::unwrap_used, reason = "a test may stop where its promise is broken")]

use std::io::Read as _;

use least_squares::{Config, Outcome, PoseGraph, Start, Workspace, g2o, optimise};

/// Name, vertices, edges, Σ eᵀΩe at the optimum.
const PUBLISHED: [(&str, usize, usize, f64); 4] = [
    ("intel", 1728, 2512, 45.0042),
    ("CSAIL", 1045, 1172, 40.5509),
    ("manhattan", 3500, 5453, 3549.04),
    ("city10000", 10000, 20687, 511.987),
];

fn graph(name: &str) -> Option<PoseGraph> {
    let path = testkit::data_folder("g2o")?.join(format!("{name}.g2o.gz"));
    let mut text = Vec::new();
    flate2::read::GzDecoder::new(std::fs::File::open(path).unwrap())
        .read_to_end(&mut text)
        .unwrap();
    let (graph, _, damage) = g2o::read(&text).unwrap();
    assert!(damage.is_empty(), "{name}: {damage}");
    Some(graph)
}

#[test]
fn every_start_leads_to_the_published_optimum() {
    for (name, n_vertices, n_edges, optimum) in PUBLISHED {
        let Some(given) = graph(name) else { return };
        assert_eq!((given.poses().len(), given.edges().len()), (n_vertices, n_edges));
        let mut scratch = Workspace::new();
        for start in [Start::Auto, Start::Given, Start::Odometry, Start::Chordal] {
            let mut graph = given.clone();
            let config = Config { start, ..Config::default() };
            let report = optimise(&mut graph, &config, &mut scratch);
            assert_eq!(report.outcome, Outcome::Converged, "{name} {start:?}");
            let off = (report.chi2_after - optimum) / optimum;
            assert!(off.abs() < 1e-3, "{name} from {start:?}: {}", report.chi2_after);
            assert!(start != Start::Auto || report.iterations <= 5, "{name}: {report:?}");
        }
    }
}

#[test]
fn an_optimised_graph_survives_writing() {
    let Some(mut graph) = graph("intel") else { return };
    optimise(&mut graph, &Config::default(), &mut Workspace::new());
    let text = g2o::write(&graph, &g2o::Ids::consecutive(graph.poses().len()));
    let (again, _, damage) = g2o::read(text.as_bytes()).unwrap();
    assert!(damage.is_empty());
    assert_eq!(again, graph);
    assert_eq!(again.chi2().to_bits(), graph.chi2().to_bits());
}
