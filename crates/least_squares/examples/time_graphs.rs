//! Optimises g2o files and prints what it took: `time_graphs FILE.g2o …`.
//!
//! Each file is read and optimised from scratch (`reading` is part of `all`); the times are medians
//! of nine runs, in milliseconds, on one thread. The starts are tried one by one.
#![expect(clippy::print_stdout, reason = "the output of a program for people")]
#![expect(clippy::unwrap_used, reason = "an example may stop where a file is bad")]
#![expect(clippy::disallowed_methods, reason = "it measures time")]

use std::{env, fs, time::Instant};

use least_squares::{Config, Marginals, Start, Workspace, g2o, optimise};

fn main() {
    println!(
        "{:<28}{:>9}{:>9} {:>14}{:>14}{:>14}{:>12}{:>6}{:>9}{:>9}{:>9}",
        "file",
        "vertices",
        "edges",
        "start",
        "chi2 start",
        "chi2 end",
        "outcome",
        "iter",
        "reading",
        "all",
        "again"
    );
    for path in env::args().skip(1) {
        let text = fs::read(&path).unwrap();
        for start in [Start::Auto, Start::Given, Start::Odometry, Start::Chordal] {
            show(&path, &text, start);
        }
        time_marginals(&text);
    }
}

fn show(path: &str, text: &[u8], start: Start) {
    let config = Config { start, ..Config::default() };
    let (mut reading, mut all, mut again) = (Vec::new(), Vec::new(), Vec::new());
    let mut last = None;
    for _ in 0..9 {
        let begin = Instant::now();
        let (mut graph, _, _) = g2o::read(text).unwrap();
        reading.push(begin.elapsed().as_secs_f64() * 1e3);
        let given = graph.clone();
        let mut workspace = Workspace::new();
        let report = optimise(&mut graph, &config, &mut workspace);
        all.push(begin.elapsed().as_secs_f64() * 1e3);
        // The same once more with everything that depends on the structure alone.
        let mut graph = given;
        let begin = Instant::now();
        optimise(&mut graph, &config, &mut workspace);
        again.push(begin.elapsed().as_secs_f64() * 1e3);
        last = Some((graph, report));
    }
    let (graph, report) = last.unwrap();
    println!(
        "{:<28}{:>9}{:>9} {:>14}{:>14.6e}{:>14.4}{:>12}{:>6}{:>9.2}{:>9.2}{:>9.2}",
        path.rsplit('/').next().unwrap(),
        graph.poses().len(),
        graph.edges().len(),
        format!("{start:?}>{:?}", report.start),
        report.chi2_at_start,
        report.chi2_after,
        format!("{:?}", report.outcome),
        report.iterations,
        median(&mut reading),
        median(&mut all),
        median(&mut again),
    );
}

fn time_marginals(text: &[u8]) {
    let (mut graph, _, _) = g2o::read(text).unwrap();
    let mut workspace = Workspace::new();
    optimise(&mut graph, &Config { start: Start::Auto, ..Config::default() }, &mut workspace);
    let begin = Instant::now();
    let mut marginals = Marginals::new(&graph, &mut workspace).unwrap();
    let factor_ms = begin.elapsed().as_secs_f64() * 1e3;
    let n = graph.poses().len();
    let begin = Instant::now();
    for vertex in 0..n - 1 {
        marginals.relative(vertex, n - 1).unwrap();
    }
    let each_us = begin.elapsed().as_secs_f64() * 1e6 / (n - 1) as f64;
    println!("    marginals: {factor_ms:.2} ms once, {each_us:.1} µs for a relative covariance");
}

fn median(times: &mut [f64]) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}
