//! Laser SLAM on recordings, with its errors against what is known: one line each, one configuration.
//!
//! ```sh
//! cargo run --release -p cairn_slam --example laser_logs -- logs/csail.clf.gz logs/seattle.clf.gz
//! ```
#![expect(clippy::print_stdout, clippy::disallowed_methods, reason = "it prints and times")]

use std::{error::Error, time::Instant};

use geometry::Se2;
use recordings::{ReadOptions, Rig, read};
use slam::{
    evaluate::{Errors, absolute_errors},
    laser::{LaserConfig, LaserSlam, Tracking},
};

fn main() -> Result<(), Box<dyn Error>> {
    println!("log  scans  keyframes  loops  lost  seconds | mean std max m, mean max deg");
    for name in std::env::args().skip(1) {
        judge(&name)?;
    }
    Ok(())
}

/// A log; the true poses of a simulated one are looked for beside it.
fn judge(name: &str) -> Result<(), Box<dyn Error>> {
    let truth_name = name.replace("_LASER_SIM.txt.gz", ".rawlog.GT.txt");
    let truth = if truth_name == name { None } else { Some(std::fs::read(&truth_name)?) };
    let options = ReadOptions { truth: truth.as_deref(), ..ReadOptions::default() };
    let recording = read(name, &std::fs::read(name)?, &options)?.recording;
    let Rig::Laser(rig) = &recording.rig else { return Err("not taken by a laser".into()) };
    let begun = Instant::now();
    let mut slam = LaserSlam::new(rig.clone(), LaserConfig::default());
    let mut n_lost = 0;
    for scan in &recording.scans {
        n_lost += usize::from(slam.step(scan).tracking == Tracking::Lost);
    }
    slam.finish();
    let seconds = begun.elapsed().as_secs_f64();
    let found: Vec<Se2> = slam.trajectory().iter().map(|p| p.pose).collect();
    let known = if recording.truth.is_empty() { &recording.reference } else { &recording.truth };
    let known: Vec<Se2> = known.iter().map(|p| p.pose).collect();
    let Errors { mean_m, std_m, max_m, mean_rad, max_rad, .. } = absolute_errors(&found, &known);
    let (n_keyframes, n_loops) = (slam.keyframes().len(), slam.closures().len());
    let short = name.rsplit('/').next().unwrap_or(name);
    let (mean_deg, max_deg) = (mean_rad.to_degrees(), max_rad.to_degrees());
    println!(
        "{short}  {}  {n_keyframes}  {n_loops}  {n_lost}  {seconds:.2} | \
         {mean_m:.4} {std_m:.4} {max_m:.4} m, {mean_deg:.3} {max_deg:.2} deg",
        recording.scans.len()
    );
    Ok(())
}
