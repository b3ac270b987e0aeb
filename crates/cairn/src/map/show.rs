//! `cairn map --show`: the mapping page of the studio.

use std::process::ExitCode;

use studio::Exhibit;
use surveys::SurveyConfig;

use super::{args::Args, inputs::Inputs};
use crate::{interrupt::Interrupt, output::say};

/// Shows how the map of a recording grows, or the page without one, until the program is interrupted.
pub(super) fn main(
    args: &Args,
    inputs: Option<Inputs>,
    config: SurveyConfig,
) -> anyhow::Result<ExitCode> {
    let exhibit = match inputs {
        Some(inputs) => {
            let prior = Inputs::prior(args, &config)?;
            let Inputs { name, format, recording, known, complaints, .. } = inputs;
            let format = format.to_string();
            Some(Exhibit { name, format, recording, known, prior, complaints, config })
        }
        None => None,
    };
    let interrupt = Interrupt::listen()?;
    let on_ready = |address| {
        say!("The mapping page is at http://{address}; Ctrl-C ends it.");
    };
    studio::serve_survey_until(exhibit, args.port, on_ready, interrupt.wait())?;
    Ok(ExitCode::SUCCESS)
}
