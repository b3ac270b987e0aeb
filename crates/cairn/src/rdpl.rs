//! `cairn rdpl`: checks and compiles decision programs.

use std::{
    fs,
    path::{Path, PathBuf},
    process::ExitCode,
};

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use anyhow::bail;
use decision::{Diagnostic, Severity};
use files::{Kind, Outputs};
use serde_json::json;

use crate::output::{self, Format, say};

/// Compiles a decision program (RDPL): problems with line and column, then image and listing
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  cairn rdpl doorbell.src\n  cairn rdpl doorbell.src --check --format json\n  \
    cairn rdpl doorbell.src --check --gates doorbell.svg\n\n\
    What is there already is replaced only with --force, and only when its listing says that it was compiled\n\
    from the same source; the source itself never is.\n\n\
    Exit code 0: no errors (there may be warnings); 1: errors, and no image of this source is left; 2: a file\n\
    cannot be read or written. `cairn explain CODE` says more about a problem."
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
    /// Replaces the image, the listing and the drawing of an earlier version
    #[arg(long)]
    force: bool,
    /// Draws the program as a diagram of gates (SVG)
    #[arg(long, value_name = "FILE.svg")]
    gates: Option<PathBuf>,
    /// How problems are printed
    #[arg(long, value_enum, default_value_t)]
    format: Format,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    let path = source_path(&args.source);
    let source = files::read_text(&path, "the program")?;
    let outputs = Outputs::new(args.force).keeping([&path]);
    let targets = (!args.check).then(|| Targets::of(args, &path));
    refuse(args, targets.as_ref(), &path, &outputs)?;
    let compilation = decision::compile(&source);
    let renderer = if output::colour_on_stderr() { Renderer::styled() } else { Renderer::plain() };
    match args.format {
        Format::Text => {
            for diagnostic in &compilation.diagnostics {
                eprintln!("{}\n", rendered(diagnostic, &source, &path, &renderer));
            }
        }
        Format::Json => say!("{}", as_json(&compilation)),
    }
    if let Some(targets) = &targets {
        write_compiled(&compilation, targets, &path, &outputs)?;
    }
    if let Some(path) = &args.gates
        && let Some(program) = &compilation.program
    {
        outputs.write(path, Kind::SVG, decision::gate_view(program).as_bytes())?;
    }
    if args.format == Format::Text {
        print_closing(&compilation, targets.as_ref());
        if let Some(path) = args.gates.as_ref().filter(|_| compilation.program.is_some()) {
            say!("Gates: {}", path.display());
        }
    }
    Ok(if compilation.n_errors == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// Where the compiler's results go.
struct Targets {
    image: PathBuf,
    listing: PathBuf,
}

impl Targets {
    fn of(args: &Args, source: &Path) -> Self {
        let folder =
            args.output.clone().or_else(|| source.parent().map(PathBuf::from)).unwrap_or_default();
        let beside = |extension: &str| {
            let mut name = source.file_stem().unwrap_or(source.as_os_str()).to_owned();
            name.push(extension);
            folder.join(name)
        };
        Self { image: beside(".bin"), listing: beside(".lst") }
    }
}

/// Refuses, before anything is compiled, what must not be written.
fn refuse(
    args: &Args,
    targets: Option<&Targets>,
    source: &Path,
    outputs: &Outputs,
) -> anyhow::Result<()> {
    let mut wanted: Vec<(&Path, Kind)> = Vec::new();
    if let Some(Targets { image, listing }) = targets {
        wanted.extend([(image.as_path(), Kind::IMAGE), (listing.as_path(), Kind::LISTING)]);
    }
    wanted.extend(args.gates.as_deref().map(|path| (path, Kind::SVG)));
    outputs.check_all(&wanted)?;
    if let Some(Targets { listing, .. }) = targets
        && let Some(other) = compiled_from(listing)
        && other != file_name(source)
    {
        bail!(
            "{} is of another program, {other}, and is not replaced; choose another folder with -o, or another \
             name for {}",
            listing.display(),
            source.display()
        );
    }
    Ok(())
}

/// The last line of a listing: whose it is.
const SOURCE: &str = "Source: ";

/// The source that a listing says it was compiled from.
fn compiled_from(listing: &Path) -> Option<String> {
    let text = fs::read_to_string(listing).ok()?;
    Some(text.lines().next_back()?.strip_prefix(SOURCE)?.to_owned())
}

fn file_name(path: &Path) -> String {
    path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned()
}

/// Writes listing and image; a listing alone when there are errors, and then no image of an earlier version of this
/// source may be taken for one of this.
fn write_compiled(
    compilation: &decision::Compilation,
    Targets { image, listing }: &Targets,
    source: &Path,
    outputs: &Outputs,
) -> anyhow::Result<()> {
    let is_own = compiled_from(listing).is_some();
    let text = format!("{}\n{SOURCE}{}\n", compilation.listing().trim_end(), file_name(source));
    outputs.write(listing, Kind::LISTING, text.as_bytes())?;
    match &compilation.program {
        Some(program) => outputs.write(image, Kind::IMAGE, program.image())?,
        None if is_own => outputs.remove(image, Kind::IMAGE)?,
        None if image.exists() => eprintln!(
            "cairn: {} is not of this source, as far as can be seen: it is left as it was",
            image.display()
        ),
        None => {}
    }
    Ok(())
}

fn source_path(given: &Path) -> PathBuf {
    if given.extension().is_none() && !given.exists() {
        let rdpl = given.with_extension("rdpl");
        if rdpl.exists() { rdpl } else { given.with_extension("src") }
    } else {
        given.to_owned()
    }
}

fn print_closing(compilation: &decision::Compilation, written: Option<&Targets>) {
    say!("Lines compiled: {}. Total errors {}.", compilation.n_lines, compilation.n_errors);
    if let Some(program) = &compilation.program {
        let estimate = program.estimate();
        say!(
            "{} functions, {} bytes, {:.1} ms a scan on the thesis's controller.",
            estimate.n_functions,
            estimate.bytes,
            estimate.scan_ms
        );
        if let Some(Targets { image, listing }) = written {
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
