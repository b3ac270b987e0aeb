//! `cairn pheromone-server`: the pheromone server as a program of its own.

use std::{
    net::SocketAddr,
    path::PathBuf,
    process::ExitCode,
    time::{Duration, Instant},
};

use anyhow::Context;
use pheromones::{Field, Perception, SenseConfig, Server, ServerConfig, ServerCounters};
use serde_json::json;
use settings::Choice as _;
use virtual_robots::Exchange;

use crate::output::{Format, say};
use crate::parse;
use crate::serve::{self, Door, Log, Peer};

/// How often the line is looked at.
const TICK: Duration = Duration::from_millis(2);

/// Answers robots' pose queries with the pheromone intensities at their two antennas
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  cairn pheromone-server trail.txt\n  \
    cairn pheromone-server trail.txt --serial /dev/ttyUSB0 --baud 9600 --perception listing")]
pub(crate) struct Args {
    /// The map: a matrix of numbers, one per cell, first row on top
    map: PathBuf,
    /// Side of a cell, metres
    #[arg(long, value_name = "M", default_value_t = 0.2, value_parser = parse::length_m, allow_negative_numbers = true)]
    cell_m: f64,
    /// Perception radius, metres
    #[arg(long, value_name = "M", default_value_t = 0.6, value_parser = parse::length_m, allow_negative_numbers = true)]
    sigma_m: f64,
    /// Distance between the antennas, metres
    #[arg(long, value_name = "M", default_value_t = 0.38, value_parser = parse::length_m, allow_negative_numbers = true)]
    antenna_spacing_m: f64,
    /// How contributions add up
    #[arg(long, default_value = Perception::default().key(), value_parser = parse::choice::<Perception>(ALSO))]
    perception: Perception,
    /// Where robots connect
    #[arg(
        long,
        value_name = "ADDRESS:PORT",
        default_value = "127.0.0.1:8200",
        value_parser = parse::address
    )]
    listen: SocketAddr,
    /// Talk over this serial line instead of a TCP port
    #[arg(long, value_name = "DEVICE", conflicts_with = "listen")]
    serial: Option<String>,
    /// Speed of the serial line, bits per second
    #[arg(long, value_name = "BITS", default_value_t = 9600, requires = "serial")]
    baud: u32,
    /// How often the traffic is shown while there is any, seconds from 0.1 to 3600; 0: only when a
    /// client leaves
    #[arg(long, value_name = "S", default_value_t = 10.0, value_parser = parse_traffic_s)]
    traffic_s: f64,
    /// How clients and traffic are told: `json` prints an object a line after the first line
    #[arg(long, value_enum, default_value = "text")]
    format: Format,
}

fn parse_traffic_s(text: &str) -> Result<f64, String> {
    let allowed = |s: &f64| *s == 0.0 || (0.1..=3600.0).contains(s);
    let seconds = text.parse::<f64>().ok().filter(allowed);
    seconds.ok_or_else(|| "must be 0 or from 0.1 to 3600 s".to_owned())
}

/// Other words for ways to perceive.
const ALSO: &[(&str, &str)] = &[("scalar-sum", "scalar_sum"), ("vector", "vector_atan2")];

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    let text = files::read_text(&args.map, "the pheromone map")?;
    let field = Field::from_text(&text, args.cell_m)
        .with_context(|| format!("{} is not a pheromone map", args.map.display()))?;
    let sense = SenseConfig {
        perception: args.perception,
        sigma_m: args.sigma_m,
        antenna_spacing_m: args.antenna_spacing_m,
        // The listing's numbers come with the listing's arithmetic, as in a mission.
        strict: args.perception == Perception::Listing,
    };
    let door = match &args.serial {
        Some(device) => Door::serial(device, args.baud)?,
        None => Door::tcp(args.listen)?,
    };
    say!(
        "{} × {} cells of {} m from {}: connect to {}; Ctrl-C ends it",
        field.width(),
        field.height(),
        field.cell_size_m(),
        args.map.display(),
        door.name()
    );
    let config = ServerConfig { sense, ..ServerConfig::default() };
    let every = Duration::from_secs_f64(args.traffic_s);
    let mut node =
        Node { server: Server::new(config), field, every, told: 0, next: Instant::now() + every };
    serve::forever(vec![door], &mut node, TICK, Log::new(args.format))?;
    Ok(ExitCode::SUCCESS)
}

struct Node {
    server: Server,
    field: Field,
    /// How often its traffic is told.
    every: Duration,
    /// Bytes received when it was told last.
    told: u64,
    next: Instant,
}

/// The server's text screen: characters received and errors (the thesis, Annex B1).
fn traffic(counters: ServerCounters) -> (String, serde_json::Value) {
    let ServerCounters { n_bytes_received, n_bytes_sent, n_requests, n_clamped, .. } = counters;
    let (broken, given_up) = (counters.n_frame_errors, counters.n_frames_dropped);
    let text = format!(
        "{n_bytes_received} characters received in all, {n_requests} questions answered with \
         {n_bytes_sent} characters, {} errors ({broken} broken frames, {given_up} given up, {} no \
         questions), {n_clamped} intensities cut at 255",
        counters.n_errors(),
        counters.n_refused,
    );
    let facts = json!({
        "received_bytes": n_bytes_received,
        "sent_bytes": n_bytes_sent,
        "requests": n_requests,
        "errors": counters.n_errors(),
        "broken_frames": broken,
        "dropped_frames": given_up,
        "refused_frames": counters.n_refused,
        "clamped_intensities": n_clamped,
    });
    (text, facts)
}

impl Peer for Node {
    fn tick(&mut self, exchanges: &mut [Exchange], log: &mut Log) {
        for Exchange { received, out } in exchanges {
            self.server.receive(&self.field, received, out);
        }
        let counters = self.server.counters();
        let is_new = counters.n_bytes_received != self.told;
        if is_new && !self.every.is_zero() && Instant::now() >= self.next {
            self.next = Instant::now() + self.every;
            self.told = counters.n_bytes_received;
            let (text, facts) = traffic(counters);
            log.event("", "traffic", &text, facts);
        }
    }

    fn hang_up(&mut self, _line: usize) {
        // Half a request of the last client must not become the beginning of the next one's.
        self.server.hang_up();
    }

    fn name(&self, _line: usize) -> Option<&str> {
        None
    }

    fn n_heard(&self, _line: usize) -> u64 {
        0
    }

    fn patience(&self, _line: usize) -> Option<Duration> {
        // A robot that stands asks nothing for as long as it likes.
        None
    }

    fn farewell(&self, _line: usize) -> (String, serde_json::Value) {
        let (text, facts) = traffic(self.server.counters());
        (format!("; {text}"), facts)
    }

    fn note_interval(&mut self, _interval: Duration) {}
}
