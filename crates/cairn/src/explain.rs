//! `cairn explain`: what a code of the decision language means.

use std::process::ExitCode;

use anyhow::bail;
use decision::Code;
use serde_json::json;

use crate::output::{self, Format, say, say_raw};

/// Explains a problem of a decision program: what it means, a failing program, the corrected one
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:\n  cairn explain R2001\n  cairn explain")]
pub(crate) struct Args {
    /// The code that `cairn rdpl` printed, such as R2001; left out, the list of all
    code: Option<String>,
    /// How it is printed
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    match &args.code {
        Some(id) => {
            let Some(code) = Code::by_id(&id.to_ascii_uppercase()) else {
                bail!(
                    "there is no code `{id}`; codes look like R2001, and `cairn explain` lists them"
                );
            };
            match args.format {
                Format::Text => say_raw!("{}", code.page()),
                Format::Json => {
                    let mut object = as_json(code);
                    object["page"] = json!(code.page());
                    say!("{object}");
                }
            }
        }
        None => match args.format {
            Format::Text => {
                let row = |code: &Code| {
                    let severity = code.severity().to_string();
                    vec![code.id().to_owned(), severity, code.title().to_owned()]
                };
                output::table(&Code::ALL.iter().map(row).collect::<Vec<_>>());
            }
            Format::Json => {
                let codes: Vec<_> = Code::ALL.iter().map(|&code| as_json(code)).collect();
                say!("{}", json!({ "codes": codes }));
            }
        },
    }
    Ok(ExitCode::SUCCESS)
}

fn as_json(code: Code) -> serde_json::Value {
    json!({"code": code.id(), "severity": code.severity().to_string(), "title": code.title()})
}
