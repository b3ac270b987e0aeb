//! Queries with known lengths, one after the other.

use std::{
    io::Read as _,
    path::{Path, PathBuf},
    process::ExitCode,
    time::Instant,
};

use anyhow::{Context as _, bail};
use flate2::read::MultiGzDecoder;
use grid_maps::{Cell, State, files::moving_ai};
use path_planning::{
    Budget, FreeFloor, GridMethod, GridOutcome, GridSearch,
    scenario::{self, Query},
};
use serde_json::json;
use settings::Choice as _;

use crate::output::{Format, complain, say, table};

/// Wrong lengths that are printed one by one.
const N_SHOWN_MAX: usize = 5;

/// What all queries together took and gave.
#[derive(Default)]
struct Tally {
    times_us: Vec<f64>,
    n_expanded: u64,
    wrong: Vec<String>,
}

pub(super) fn main(
    file: &Path,
    map: Option<&str>,
    method: GridMethod,
    format: Format,
) -> anyhow::Result<ExitCode> {
    let queries = scenario::parse(&text(file, "the scenario")?)
        .with_context(|| file.display().to_string())?;
    let Some(first) = queries.first() else { bail!("{} has no queries", file.display()) };
    let map = map.map_or_else(|| beside(file, first), |map| Ok(PathBuf::from(map)))?;
    let states =
        moving_ai::read(&text(&map, "the map")?).with_context(|| map.display().to_string())?;
    let begun = Instant::now();
    let floor = FreeFloor::new(&states, |state| state != State::Free)
        .context("the map has too many cells")?;
    let mut search = GridSearch::new(floor);
    let prepare_ms = begun.elapsed().as_secs_f64() * 1e3;
    let mut tally = Tally::default();
    for query in &queries {
        ask(&mut search, query, method, &mut tally).with_context(|| file.display().to_string())?;
    }
    tally.times_us.sort_by(f64::total_cmp);
    let n = queries.len();
    let mean_us = tally.times_us.iter().sum::<f64>() / n as f64;
    let at = |ratio: f64| tally.times_us[((ratio * n as f64).ceil() as usize).clamp(1, n) - 1];
    let n_wrong = tally.wrong.len();
    let n_expanded_mean = tally.n_expanded as f64 / n as f64;
    match format {
        Format::Text => {
            let rows = [
                [
                    "map",
                    &format!(
                        "{} ({} × {})",
                        map.display(),
                        search.floor().width(),
                        search.floor().height()
                    ),
                ],
                ["method", method.key()],
                ["instances", &n.to_string()],
                ["wrong", &n_wrong.to_string()],
                [
                    "time",
                    &format!(
                        "{mean_us:.1} µs on average, {:.1} median, {:.1} p99, {:.1} at most",
                        at(0.5),
                        at(0.99),
                        at(1.0)
                    ),
                ],
                ["expanded", &format!("{n_expanded_mean:.1} cells on average")],
                ["prepared", &format!("in {prepare_ms:.1} ms")],
            ];
            table(&rows.map(|row| row.map(str::to_owned).to_vec()));
            tally.wrong.iter().take(N_SHOWN_MAX).for_each(|wrong| complain!("{wrong}"));
            if n_wrong > N_SHOWN_MAX {
                complain!("and {} more", n_wrong - N_SHOWN_MAX);
            }
        }
        Format::Json => say!(
            "{}",
            json!({
                "scenario": file.display().to_string(), "map": map.display().to_string(), "method": method.key(),
                "instances": n, "wrong": n_wrong, "mean_us": mean_us, "p50_us": at(0.5), "p99_us": at(0.99),
                "max_us": at(1.0), "n_expanded_mean": n_expanded_mean, "prepare_ms": prepare_ms,
                "wrong_queries": tally.wrong,
            })
        ),
    }
    Ok(ExitCode::from(u8::from(n_wrong > 0)))
}

fn ask(
    search: &mut GridSearch,
    query: &Query,
    method: GridMethod,
    tally: &mut Tally,
) -> anyhow::Result<()> {
    let (width, height) = (search.floor().width(), search.floor().height());
    let inside = |[x, y]: [usize; 2]| x < width && y < height;
    if query.size != [width, height] || !inside(query.start) || !inside(query.goal) {
        bail!(
            "line {}: it is for a map of {} × {} cells; this one has {width} × {height}: name the right one",
            query.line,
            query.size[0],
            query.size[1]
        );
    }
    // Rows are counted from above there.
    let cell = |[x, y]: [usize; 2]| Cell::new(x as i32, (height - 1 - y) as i32);
    let begun = Instant::now();
    let found = search.find(cell(query.start), cell(query.goal), method, Budget::UNLIMITED);
    tally.times_us.push(begun.elapsed().as_secs_f64() * 1e6);
    tally.n_expanded += search.effort().n_expanded;
    let wrong = match found {
        // Straight lines may be shorter than the printed length, and are never longer.
        GridOutcome::Found(way) if method == GridMethod::AnyAngle => {
            let over = way.length_cells - query.optimal_cells;
            (over > query.tolerance_cells).then(|| format!("{:.5}", way.length_cells))
        }
        GridOutcome::Found(way) => {
            let off = (way.length_cells - query.optimal_cells).abs();
            (off > query.tolerance_cells).then(|| format!("{:.5}", way.length_cells))
        }
        _ => Some("no way".to_owned()),
    };
    if let Some(found) = wrong {
        tally
            .wrong
            .push(format!("line {}: found {found}, expected {}", query.line, query.optimal_cells));
    }
    Ok(())
}

/// The scenario's map: its name without `.scen`, or the one that its first line names, in the same folder.
fn beside(file: &Path, first: &Query) -> anyhow::Result<PathBuf> {
    let name = file.file_name().unwrap_or_default().to_string_lossy();
    let stem = name.strip_suffix(".gz").unwrap_or(&name);
    let stem = stem.strip_suffix(".scen").unwrap_or(stem);
    let named = first.map.rsplit(['/', '\\']).next().unwrap_or_default();
    let ends_in_map = |name: &str| {
        let ends = Path::new(name).extension().is_some_and(|end| end.eq_ignore_ascii_case("map"));
        if ends { name.to_owned() } else { format!("{name}.map") }
    };
    let names = [ends_in_map(stem), ends_in_map(named)];
    let candidates = names.iter().flat_map(|name| [name.clone(), format!("{name}.gz")]);
    let candidates: Vec<PathBuf> = candidates.map(|name| file.with_file_name(name)).collect();
    let found = candidates.iter().find(|path| path.is_file());
    found.cloned().with_context(|| {
        format!(
            "neither {} nor {} is beside {}: name the map before --scenario",
            names[0],
            names[1],
            file.display()
        )
    })
}

/// The text of a file, packed or not.
fn text(path: &Path, what: &str) -> anyhow::Result<String> {
    let bytes = crate::input::read(path, what)?;
    if !bytes.starts_with(&[0x1f, 0x8b]) {
        return Ok(String::from_utf8_lossy(&bytes).into_owned());
    }
    let mut text = Vec::new();
    let limit = files::Limit::LOG.bytes_max();
    MultiGzDecoder::new(bytes.as_slice())
        .take(limit)
        .read_to_end(&mut text)
        .with_context(|| format!("{} cannot be unpacked", path.display()))?;
    Ok(String::from_utf8_lossy(&text).into_owned())
}
