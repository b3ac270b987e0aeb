//! `cairn missions`: what is shipped.

use std::process::ExitCode;

use anyhow::bail;
use missions::Mission;
use serde_json::json;

use crate::output::{self, Format, say, say_raw};

/// Lists the shipped missions, or prints one as a file to start from
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  cairn missions\n  cairn missions doorbell > my-flat.toml\n  cairn run my-flat.toml\n  \
    cairn missions doorbell.rdpl > my-bell.rdpl"
)]
pub(crate) struct Args {
    /// Print this mission, with everything it needs inlined, or this decision program of one
    mission: Option<String>,
    /// How the list is printed
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    if let Some(name) = &args.mission {
        if let Some(text) = Mission::shipped_file(name) {
            say_raw!("{text}");
            return Ok(ExitCode::SUCCESS);
        }
        if !Mission::shipped().contains(&name.as_str()) {
            bail!(
                "no mission called `{name}` is shipped; there are {} and the programs {}",
                Mission::shipped().join(", "),
                Mission::shipped_files().join(", ")
            );
        }
        say_raw!("{}", Mission::load(name, &[])?.to_toml());
        return Ok(ExitCode::SUCCESS);
    }
    let infos = Mission::shipped_infos();
    match args.format {
        Format::Text => {
            let row = |info: &missions::ShippedInfo| vec![info.name.clone(), info.title.clone()];
            output::table(&infos.iter().map(row).collect::<Vec<_>>());
        }
        Format::Json => {
            let item = |i: &missions::ShippedInfo| json!({"name": i.name, "title": i.title, "about": i.about});
            say!("{}", json!({"missions": infos.iter().map(item).collect::<Vec<_>>()}));
        }
    }
    Ok(ExitCode::SUCCESS)
}
