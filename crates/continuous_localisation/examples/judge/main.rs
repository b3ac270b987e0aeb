//! How well continuous localisation does where the truth is known, and on recordings with injected
//! drift: the tables of the guide.
//!
//! `judge [rooms|bound|recordings|trace WORLD] [seeds]`; the three tables and 20 seeds when nothing is
//! said. Recordings are read from the folder of measured data and left out where there is none.

#![expect(clippy::print_stdout, reason = "the tables are what the program is for")]
#![expect(clippy::expect_used, reason = "a study that cannot be set up has to stop")]

mod recorded;
mod sim;
mod tables;
mod worlds;

fn main() {
    let args: Vec<String> = std::env::args().skip(1).collect();
    let what = args.first().map_or("all", String::as_str);
    let n_seeds = args.last().and_then(|n| n.parse().ok()).unwrap_or(20);
    if matches!(what, "bound" | "all") {
        tables::bound();
    }
    if matches!(what, "rooms" | "all") {
        tables::rooms(n_seeds);
    }
    if matches!(what, "recordings" | "all") {
        recorded::table();
    }
    if what == "trace" {
        tables::trace(args.get(1).map_or("E1", String::as_str));
    }
}
