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
    /// How the list, or the mission, is printed
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    if let Some(name) = &args.mission {
        if let Some(text) = Mission::shipped_file(name) {
            match args.format {
                Format::Text => say_raw!("{text}"),
                Format::Json => say!("{}", json!({"name": name, "text": text})),
            }
            return Ok(ExitCode::SUCCESS);
        }
        if !Mission::shipped().contains(&name.as_str()) {
            let all = Mission::shipped().into_iter().chain(Mission::shipped_files());
            let meant = settings::did_you_mean(name, all);
            let meant = meant.map(|meant| format!("did you mean `{meant}`? ")).unwrap_or_default();
            bail!(
                "no mission called `{name}` is shipped; {meant}there are {} and the programs {}",
                Mission::shipped().join(", "),
                Mission::shipped_files().join(", ")
            );
        }
        let mission = Mission::load(name, &[])?;
        match args.format {
            Format::Text => say_raw!("{}", mission.to_toml()),
            Format::Json => say!(
                "{}",
                json!({
                    "name": mission.name(),
                    "title": mission.title(),
                    "about": mission.about(),
                    "toml": mission.to_toml(),
                })
            ),
        }
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
