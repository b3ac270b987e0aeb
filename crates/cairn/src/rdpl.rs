//! `cairn rdpl`: checks and compiles decision programs.

use std::{
    fs,
    io::{self, IsTerminal as _},
    path::{Path, PathBuf},
    process::ExitCode,
};

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use anyhow::{Context, bail};
use decision::{Diagnostic, Severity};
use serde_json::json;

use crate::output::{Format, say};

/// Compiles a decision program (RDPL): problems with line and column, then image and listing
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  cairn rdpl doorbell.src\n  cairn rdpl doorbell.src --check --format json\n  \
    cairn rdpl doorbell.src --check --gates doorbell.svg\n\n\
    Exit code 0: no errors (there may be warnings); 1: errors, and no image is left; 2: a file cannot\n\
    be read or written. `cairn explain CODE` says more about a problem."
)]
pub(crate) struct Args {
    /// The source; `.rdpl` and `.src` are tried when the name has no extension
    source: PathBuf,
    /// Only check; write nothing
    #[arg(long)]
    check: bool,
    /// Where the image (.bin) and the listing (.lst) go; beside the source unless given
    #[arg(short, long, value_name = "DIR")]
    output: Option<PathBuf>,
    /// Draws the program as a diagram of gates (SVG)
    #[arg(long, value_name = "FILE.svg")]
    gates: Option<PathBuf>,
    /// How problems are printed
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    let path = source_path(&args.source);
    let source = fs::read_to_string(&path)
        .with_context(|| format!("cannot read the program {}", path.display()))?;
    let compilation = decision::compile(&source);
    let renderer = if io::stderr().is_terminal() { Renderer::styled() } else { Renderer::plain() };
    match args.format {
        Format::Text => {
            for diagnostic in &compilation.diagnostics {
                eprintln!("{}\n", rendered(diagnostic, &source, &path, &renderer));
            }
        }
        Format::Json => say!("{}", as_json(&compilation)),
    }
    let folder =
        args.output.clone().or_else(|| path.parent().map(PathBuf::from)).unwrap_or_default();
    let beside = |extension: &str| {
        let mut name = path.file_stem().unwrap_or(path.as_os_str()).to_owned();
        name.push(extension);
        folder.join(name)
    };
    let (image_path, listing_path) = (beside(".bin"), beside(".lst"));
    if !args.check {
        if [&image_path, &listing_path].contains(&&path) {
            bail!(
                "{} would be overwritten by what is compiled from it: give the source another \
                 extension, such as .src",
                path.display()
            );
        }
        let listing = compilation.listing();
        fs::write(&listing_path, listing)
            .with_context(|| format!("cannot write the listing {}", listing_path.display()))?;
        match &compilation.program {
            Some(program) => fs::write(&image_path, program.image())
                .with_context(|| format!("cannot write the image {}", image_path.display()))?,
            // An image of an earlier version must not be taken for this one.
            None if image_path.exists() => fs::remove_file(&image_path)
                .with_context(|| format!("cannot remove the outdated {}", image_path.display()))?,
            None => {}
        }
    }
    if let Some(path) = &args.gates
        && let Some(program) = &compilation.program
    {
        fs::write(path, decision::gate_view(program))
            .with_context(|| format!("cannot write the drawing {}", path.display()))?;
    }
    if args.format == Format::Text {
        let written = (image_path.as_path(), listing_path.as_path());
        print_closing(&compilation, (!args.check).then_some(written));
        if let Some(path) = args.gates.as_ref().filter(|_| compilation.program.is_some()) {
            say!("Gates: {}", path.display());
        }
    }
    Ok(if compilation.n_errors == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn source_path(given: &Path) -> PathBuf {
    if given.extension().is_none() && !given.exists() {
        let rdpl = given.with_extension("rdpl");
        if rdpl.exists() { rdpl } else { given.with_extension("src") }
    } else {
        given.to_owned()
    }
}

fn print_closing(compilation: &decision::Compilation, written: Option<(&Path, &Path)>) {
    say!("Lines compiled: {}. Total errors {}.", compilation.n_lines, compilation.n_errors);
    if let Some(program) = &compilation.program {
        let estimate = program.estimate();
        say!(
            "{} functions, {} bytes, {:.1} ms a scan on the thesis's controller.",
            estimate.n_functions,
            estimate.bytes,
            estimate.scan_ms
        );
        if let Some((image, listing)) = written {
            say!("Image: {}\nListing: {}", image.display(), listing.display());
        }
    }
}

fn rendered(diagnostic: &Diagnostic, source: &str, path: &Path, renderer: &Renderer) -> String {
    let level = match diagnostic.severity {
        Severity::Error => Level::ERROR,
        Severity::Warning => Level::WARNING,
    };
    let origin = path.display().to_string();
    let span = diagnostic.span.start.min(source.len())..diagnostic.span.end.min(source.len());
    let snippet = Snippet::source(source)
        .path(&origin)
        .line_start(1)
        .annotation(AnnotationKind::Primary.span(span));
    let id = diagnostic.code.id();
    let mut report = vec![level.primary_title(&diagnostic.message).id(id).element(snippet)];
    if let Some(hint) = &diagnostic.hint {
        report.push(Group::with_title(Level::HELP.secondary_title(hint)));
    }
    renderer.render(&report)
}

fn as_json(compilation: &decision::Compilation) -> serde_json::Value {
    let diagnostic = |d: &Diagnostic| {
        json!({
            "code": d.code.id(),
            "severity": d.severity.to_string(),
            "line": d.line,
            "column": d.column,
            "message": d.message,
            "hint": d.hint,
        })
    };
    json!({
        "lines": compilation.n_lines,
        "errors": compilation.n_errors,
        "diagnostics": compilation.diagnostics.iter().map(diagnostic).collect::<Vec<_>>(),
        "image_bytes": compilation.program.as_ref().map(|p| p.image().len()),
    })
}
