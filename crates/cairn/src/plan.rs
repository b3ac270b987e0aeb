//! `cairn plan`: the way from one place to another on a map.

mod scenario;

use std::{
    path::{Path, PathBuf},
    process::ExitCode,
    time::Instant,
};

use anyhow::{Context as _, bail};
use clap::builder::{PossibleValuesParser, TypedValueParser as _};
use files::{Kind, Outputs};
use geometry::{Se2, Vec2};
use grid_maps::{
    Cell, CellBox, Window,
    files::{GreyImage, write_png},
    squared_distances,
};
use missions::{Floor, Mission};
use path_planning::{Budget, FreeFloor, GridMethod, GridOutcome, GridPath, GridSearch};
use robot_models::RobotModel;
use serde_json::{Value, json};
use settings::Choice as _;

use crate::{
    output::{Format, complain, say, table},
    parse, world_map,
};

/// Plans the way from one place to another on a map, or runs a scenario of queries with known lengths
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  cairn plan doorbell --from \"living room\" --to study --robot pioneer3dx --svg way.svg\n  \
    cairn plan building.yaml --from 1,2 --to 14,7 --radius 0.25 --format json\n  \
    cairn plan --scenario den520d.map.scen --method jps\n\n\
    Exit code 0: there is a way, or every length of the scenario is met; 1: there is none, or a length is not met;\n\
    2: the map or a place cannot be used."
)]
pub(crate) struct Args {
    /// A map (a ROS map's .yaml; .map of ActivMedia or Moving AI), a mission file (.toml), or the name of a shipped
    /// mission; with --scenario the scenario's own map unless given
    #[arg(required_unless_present = "scenario")]
    map: Option<String>,
    /// Where the way begins: x and y in metres, or the name of a room
    #[arg(
        long,
        value_name = "X,Y|NAME",
        allow_hyphen_values = true,
        required_unless_present = "scenario"
    )]
    from: Option<String>,
    /// Where it ends: x and y in metres, or the name of a room
    #[arg(
        long,
        value_name = "X,Y|NAME",
        allow_hyphen_values = true,
        required_unless_present = "scenario"
    )]
    to: Option<String>,
    /// Runs the queries of a Moving AI scenario (.scen) and checks each length
    #[arg(long, value_name = "FILE", conflicts_with_all = ["from", "to", "robot", "radius", "svg", "cell"])]
    scenario: Option<PathBuf>,
    /// How it is looked for
    #[arg(long, value_name = "METHOD", default_value = GridMethod::default().key(), value_parser = methods(), help = method_help())]
    method: GridMethod,
    /// Room for a robot of the catalogue: the way keeps its outline's radius away from what is solid
    #[arg(long, value_name = "MODEL", value_parser = parse::model, conflicts_with = "radius")]
    robot: Option<String>,
    /// Room for a disc of this radius, m; 0: a point
    #[arg(long, value_name = "M", default_value_t = 0.0, value_parser = radius_m)]
    radius: f64,
    /// Side of a cell, m; the map's own unless given, or 0.05 m where it has none
    #[arg(long, value_name = "M", value_parser = cell_m)]
    cell: Option<f64>,
    /// Draws map and way
    #[arg(long, value_name = "FILE.svg")]
    svg: Option<PathBuf>,
    /// Replaces a drawing that is there already
    #[arg(long, requires = "svg")]
    force: bool,
    /// How the result is printed
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

fn methods() -> impl clap::builder::TypedValueParser<Value = GridMethod> {
    PossibleValuesParser::new(GridMethod::ALL.iter().map(|method| method.key())).map(|word| {
        GridMethod::ALL.iter().copied().find(|method| method.key() == word).unwrap_or_default()
    })
}

fn method_help() -> String {
    let lines =
        GridMethod::ALL.iter().map(|method| format!("{}: {}", method.key(), method.about()));
    format!("How it is looked for; {}", lines.collect::<Vec<_>>().join("; "))
}

fn radius_m(text: &str) -> Result<f64, String> {
    number(text, 0.0..=100.0, "from 0 to 100 m")
}

fn cell_m(text: &str) -> Result<f64, String> {
    number(text, 0.001..=100.0, "from 0.001 to 100 m")
}

fn number(text: &str, range: std::ops::RangeInclusive<f64>, allowed: &str) -> Result<f64, String> {
    text.parse().ok().filter(|value| range.contains(value)).ok_or_else(|| allowed.to_owned())
}

/// What a query is about, resolved.
struct Query {
    floor: Floor,
    from: Vec2,
    to: Vec2,
    radius_m: f64,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    if let Some(scenario) = &args.scenario {
        return scenario::main(scenario, args.map.as_deref(), args.method, args.format);
    }
    let (Some(map), Some(from), Some(to)) = (&args.map, &args.from, &args.to) else {
        bail!("a map, --from and --to are needed");
    };
    let outputs = Outputs::new(args.force).keeping([Path::new(map)]);
    if let Some(path) = &args.svg {
        outputs.check(path, Kind::SVG)?;
    }
    let mission = world_map::mission(map)?;
    let query = query(args, &mission, from, to).with_context(|| map.clone())?;
    let radius_cells = query.radius_m / query.floor.cell_m;
    let free = FreeFloor::of_solid_for_disc(&query.floor.solid, radius_cells)
        .context("the map has too many cells")?;
    let mut search = GridSearch::new(free);
    let [start, goal] = [query.from, query.to].map(|place| query.floor.cell_of(place));
    let begun = Instant::now();
    let outcome = search.find(start, goal, args.method, Budget::UNLIMITED);
    let time_ms = begun.elapsed().as_secs_f64() * 1e3;
    let found = Found { query: &query, search: &search, outcome: &outcome, time_ms };
    if let (Some(path), GridOutcome::Found(way)) = (&args.svg, &outcome) {
        outputs.write(path, Kind::SVG, drawn(&query, way)?.as_bytes())?;
    }
    match args.format {
        Format::Text => found.print(args, map),
        Format::Json => say!("{}", found.as_json(args, map)),
    }
    Ok(ExitCode::from(u8::from(!matches!(outcome, GridOutcome::Found(_)))))
}

fn query(args: &Args, mission: &Mission, from: &str, to: &str) -> anyhow::Result<Query> {
    let floor = Floor::of_mission(mission, args.cell)?;
    let place = |option: &str, text: &str| {
        let numbers = text.split(',').map(|n| n.trim().parse::<f64>());
        if let Ok(numbers) = numbers.collect::<Result<Vec<_>, _>>()
            && let [x, y] = numbers[..]
            && x.is_finite()
            && y.is_finite()
        {
            return Ok(Vec2::new(x, y));
        }
        let named = floor.places.iter().find(|(name, _)| name.eq_ignore_ascii_case(text.trim()));
        named.map(|(_, at)| *at).with_context(|| {
            let names: Vec<&str> = floor.places.iter().map(|(name, _)| name.as_str()).collect();
            let known = if names.is_empty() {
                "the map names no rooms".to_owned()
            } else {
                format!("rooms are {}", names.join(", "))
            };
            format!("{option} {text}: give two numbers, such as 1.5,-2 (m), or the name of a room; {known}")
        })
    };
    let (from, to) = (place("--from", from)?, place("--to", to)?);
    let radius_m = match &args.robot {
        Some(name) => RobotModel::by_name(name)?.bounding_radius_m(),
        None => args.radius,
    };
    Ok(Query { floor, from, to, radius_m })
}

/// What was found, to be told.
struct Found<'a> {
    query: &'a Query,
    search: &'a GridSearch,
    outcome: &'a GridOutcome,
    time_ms: f64,
}

impl Found<'_> {
    fn print(&self, args: &Args, map: &str) {
        let GridOutcome::Found(way) = self.outcome else {
            complain!("cairn: {map}: {}", self.why_not());
            return;
        };
        let floor = &self.query.floor;
        let turns: Vec<String> =
            self.places(way).map(|p| format!("({:.2}, {:.2})", p.x, p.y)).collect();
        let rows = [
            [
                "length",
                &format!(
                    "{:.2} m in {} pieces",
                    way.length_cells * floor.cell_m,
                    way.turns.len() - 1
                ),
            ],
            ["clearance", &format!("{:.2} m at least", self.clearance_min_m(way))],
            ["over", &turns.join(" ")],
            [
                "cells",
                &format!(
                    "{} × {} of {} m",
                    floor.solid.width(),
                    floor.solid.height(),
                    floor.cell_m
                ),
            ],
            [
                "searched",
                &format!(
                    "{} cells expanded in {:.3} ms ({})",
                    self.search.effort().n_expanded,
                    self.time_ms,
                    args.method.key()
                ),
            ],
        ];
        table(&rows.map(|row| row.map(str::to_owned).to_vec()));
    }

    fn as_json(&self, args: &Args, map: &str) -> Value {
        let place = |p: Vec2| json!([p.x, p.y]);
        let floor = &self.query.floor;
        let mut told = json!({
            "map": map,
            "method": args.method.key(),
            "from": place(self.query.from),
            "to": place(self.query.to),
            "radius_m": self.query.radius_m,
            "cell_m": floor.cell_m,
            "n_expanded": self.search.effort().n_expanded,
            "time_ms": self.time_ms,
        });
        let more = match self.outcome {
            GridOutcome::Found(way) => json!({
                "outcome": "found",
                "length_m": way.length_cells * floor.cell_m,
                "clearance_min_m": self.clearance_min_m(way),
                "cells": way.n_cells(),
                "points": self.places(way).map(place).collect::<Vec<_>>(),
            }),
            outcome => json!({
                "outcome": outcome_word(outcome),
                "why": self.why_not(),
                "nearest": self.nearest().map(place),
            }),
        };
        if let (Some(told), Value::Object(more)) = (told.as_object_mut(), more) {
            told.extend(more);
        }
        told
    }

    /// The way's turns (m); its ends are where they were asked for.
    fn places(&self, way: &GridPath) -> impl Iterator<Item = Vec2> {
        let last = way.turns.len() - 1;
        let Query { floor, from, to, .. } = self.query;
        way.turns.iter().enumerate().map(move |(i, &cell)| match i {
            0 => *from,
            i if i == last => *to,
            _ => floor.place_of(cell),
        })
    }

    fn nearest(&self) -> Option<Vec2> {
        match self.outcome {
            GridOutcome::GoalBlocked { nearest } | GridOutcome::Unreachable { nearest } => {
                Some(self.query.floor.place_of(*nearest))
            }
            _ => None,
        }
    }

    /// Least distance from the middles of the way's cells to a solid one, m; infinite where nothing is solid.
    fn clearance_min_m(&self, way: &GridPath) -> f64 {
        let solid = &self.query.floor.solid;
        let area = CellBox { min: Cell::new(0, 0), width: solid.width(), height: solid.height() };
        let Ok(mut cells) = Window::filled(area, false) else { return f64::NAN };
        for row in 0..solid.height() as i32 {
            for (column, value) in (0..).zip(cells.row_mut(row)) {
                *value = solid.is_solid(Cell::new(column, row));
            }
        }
        let squared = squared_distances(&cells, |is_solid| is_solid);
        let least = way.cells().filter_map(|cell| squared.get(cell)).min();
        match least {
            None | Some(grid_maps::NO_OBSTACLE) => f64::INFINITY,
            Some(least) => ((f64::from(least).sqrt() - 0.5) * self.query.floor.cell_m).max(0.0),
        }
    }

    /// Why there is no way, and what could be done.
    fn why_not(&self) -> String {
        let Query { floor, from, to, radius_m } = self.query;
        let state = |place: &Vec2| {
            let cell = floor.cell_of(*place);
            let inside = (0..floor.solid.width() as i32).contains(&cell.column)
                && (0..floor.solid.height() as i32).contains(&cell.row);
            if !inside {
                "is outside of the map".to_owned()
            } else if floor.solid.is_solid(cell) {
                "is solid".to_owned()
            } else {
                format!("has no room for a radius of {radius_m:.2} m")
            }
        };
        let nearest = self.nearest().map_or_else(String::new, |p| {
            format!("; the nearest place that can be reached is ({:.2}, {:.2})", p.x, p.y)
        });
        match self.outcome {
            GridOutcome::StartBlocked => {
                format!("the start ({:.2}, {:.2}) {}", from.x, from.y, state(from))
            }
            GridOutcome::GoalBlocked { .. } => {
                format!("the goal ({:.2}, {:.2}) {}{nearest}", to.x, to.y, state(to))
            }
            GridOutcome::Unreachable { .. } => {
                let room = if *radius_m > 0.0 {
                    format!(" with a radius of {radius_m:.2} m")
                } else {
                    String::new()
                };
                format!("no way leads to ({:.2}, {:.2}){room}{nearest}", to.x, to.y)
            }
            GridOutcome::BudgetSpent | GridOutcome::Found(_) => {
                "the search was given up".to_owned()
            }
        }
    }
}

fn outcome_word(outcome: &GridOutcome) -> &'static str {
    match outcome {
        GridOutcome::Found(_) => "found",
        GridOutcome::StartBlocked => "start_blocked",
        GridOutcome::GoalBlocked { .. } => "goal_blocked",
        GridOutcome::Unreachable { .. } => "unreachable",
        GridOutcome::BudgetSpent => "budget_spent",
    }
}

/// The map and the way, as SVG; a map that lies turned in the world is drawn in its own frame.
fn drawn(query: &Query, way: &GridPath) -> anyhow::Result<String> {
    let floor = &query.floor;
    let solid = &floor.solid;
    let grey = |cell: Cell| if solid.is_solid(cell) { 96 } else { 255 };
    let rows = (0..solid.height() as i32).rev();
    let pixels =
        rows.flat_map(|row| (0..solid.width() as i32).map(move |column| Cell::new(column, row)));
    let picture = GreyImage::new(solid.width(), solid.height(), pixels.map(grey).collect(), None)?;
    let Se2 { x_m, y_m, yaw_rad } = floor.world_from_floor;
    let low = Vec2::new(x_m, y_m);
    let size = floor.cell_m * Vec2::new(solid.width() as f64, solid.height() as f64);
    let turned_back = Se2::new(x_m, y_m, 0.0).compose(floor.world_from_floor.inverse());
    let last = way.turns.len() - 1;
    let place = |(i, &cell): (usize, &Cell)| {
        turned_back.transform_point(match i {
            0 => query.from,
            i if i == last => query.to,
            _ => floor.place_of(cell),
        })
    };
    let line = way.turns.iter().enumerate().map(place).collect();
    let frame = if yaw_rad == 0.0 { "" } else { ", in the map's own frame" };
    let length_m = way.length_cells * floor.cell_m;
    let picture = figures::Picture { png: write_png(&picture)?, low, high: low + size };
    let figure = figures::Floor {
        picture: Some(picture),
        driven: vec![(format!("{length_m:.2} m{frame}"), line)],
        ..figures::Floor::default()
    };
    Ok(figures::floor(&figure)?)
}
