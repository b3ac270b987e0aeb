//! `cairn rdpl`: checks, compiles and rehearses decision programs.

mod bench;

use std::{
    fs::{self, File},
    io::{Read as _, Seek as _, SeekFrom},
    path::{Path, PathBuf},
    process::ExitCode,
};

use annotate_snippets::{AnnotationKind, Group, Level, Renderer, Snippet};
use anyhow::bail;
use decision::{Compilation, Diagnostic, Mnemonic, Mode, Severity};
use files::{Kind, Outputs};
use serde_json::json;
use settings::Choice as _;

use crate::{
    given,
    output::{self, Format, complain, say},
    parse,
};

/// Compiles a decision program (RDPL): problems with line and column, then image and listing; or runs it alone
#[derive(Debug, clap::Args)]
#[command(after_help = help())]
pub(crate) struct Args {
    /// The source; `.rdpl` and `.src` are tried when the name has no extension
    source: PathBuf,
    /// Only check; write nothing
    #[arg(long)]
    check: bool,
    /// Where the image (.bin) and the listing (.lst) go; beside the source unless given
    #[arg(short, long, value_name = "DIR", conflicts_with_all = ["check", "run"])]
    output: Option<PathBuf>,
    /// Replaces the image, the listing and the drawing of an earlier version
    #[arg(long)]
    force: bool,
    /// Draws the program as a diagram of gates (SVG)
    #[arg(long, value_name = "FILE.svg")]
    gates: Option<PathBuf>,
    /// Whether text and machine behave as this guide or as the thesis's printed listing
    #[arg(long, default_value = Mode::default().key(), value_parser = parse::choice::<Mode>(&[]))]
    mode: Mode,
    /// How problems and the trace are printed
    #[arg(long, value_enum, default_value_t)]
    format: Format,
    #[command(flatten)]
    bench: bench::BenchArgs,
}

const EXAMPLES: &str = "Examples:\n  cairn rdpl doorbell.src\n  cairn rdpl doorbell.src --check --format json\n  \
    cairn rdpl doorbell.src --check --gates doorbell.svg\n  \
    cairn rdpl doorbell.src --run 20 --input \"2 I0=1; 2.5 I0=0\" --points done=4 --move-takes 10\n\n\
    What is there already is replaced only with --force, and only when a listing beside it says that it was\n\
    compiled from the same source (its last line, relative to the listing); the source itself never is.\n\n\
    Exit code 0: no errors (there may be warnings); 1: errors, and no image of this source is left; 2: a file\n\
    cannot be read or written. `cairn explain CODE` says more about a problem.";

/// What stands below the options: examples, and every function of the language.
fn help() -> String {
    let line = |function: &Mnemonic| format!("  {:<31} {}\n", function.syntax(), function.about());
    let functions: String = Mnemonic::ALL.iter().map(line).collect();
    format!("{EXAMPLES}\n\nFunctions (docs/guide/rdpl.md):\n{}", functions.trim_end())
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    let path = source_path(&args.source);
    refuse_foreign(&path)?;
    if args.force && args.gates.is_none() && (args.check || args.bench.run.is_some()) {
        bail!("nothing is written here that --force could replace; leave it out");
    }
    let outputs = Outputs::new(args.force).keeping([&path]);
    let is_rehearsal = args.bench.run.is_some();
    if given::is_stdin(&path) && !args.check && !is_rehearsal {
        bail!("standard input has no name that image and listing could have: --check or --run it");
    }
    let targets = (!args.check && !is_rehearsal).then(|| Targets::of(args, &path));
    refuse(args, targets.as_ref(), &path, &outputs)?;
    let mode = args.mode;
    let compilation = decision::compile_bytes(&read(&path)?, mode);
    let renderer = if output::colour_on_stderr() { Renderer::styled() } else { Renderer::plain() };
    match args.format {
        Format::Text => {
            for diagnostic in &compilation.diagnostics {
                let source = compilation.source();
                complain!("{}\n", rendered(diagnostic, source, &path, &renderer));
            }
        }
        // A rehearsal prints one object of its own.
        Format::Json if is_rehearsal && compilation.n_errors == 0 => {}
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
    if let (true, Some(program)) = (is_rehearsal, &compilation.program) {
        let problems = as_json(&compilation)["diagnostics"].take();
        return bench::main(&args.bench, (program, mode), args.format, problems);
    }
    if args.format == Format::Text {
        print_closing(&compilation, targets.as_ref());
        if let Some(path) = args.gates.as_ref().filter(|_| compilation.program.is_some()) {
            say!("Gates: {}", path.display());
        }
    }
    Ok(if compilation.n_errors == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

/// The bytes of the source, of standard input for `-`. One byte more than a program may have is enough to know that
/// it is too large.
fn read(path: &Path) -> anyhow::Result<Vec<u8>> {
    let bytes_max = decision::SOURCE_BYTES_MAX as u64;
    if given::is_stdin(path) {
        return given::stdin(bytes_max);
    }
    let limit = files::Limit::bytes(bytes_max);
    let bytes = files::read(path, "the program", limit, &mut |_, _| ()).map_err(|error| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let is_shipped = !path.exists() && missions::Mission::shipped_file(&name).is_some();
        let hint = if is_shipped {
            format!("; a program of that name is shipped: cairn missions {name} > {name}")
        } else {
            String::new()
        };
        anyhow::anyhow!("{error}{hint}")
    })?;
    match files::Sort::of(path, &bytes) {
        Some(sort) if sort.is_foreign_to_programs() => {
            bail!("{} is no decision program: it is {sort}", path.display())
        }
        _ => Ok(bytes),
    }
}

/// Files of other kinds, by their names: what they are, and what was probably meant.
fn refuse_foreign(path: &Path) -> anyhow::Result<()> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    let what = match extension.as_str() {
        "toml" => "is a mission or a configuration; `cairn missions NAME` shows its program",
        "bin" => "is an image, which was compiled from a source (.rdpl, .src): give that",
        "lst" => "is a listing, which was made from a source (.rdpl, .src): give that",
        "mcap" | "part" => "is a recording",
        "svg" | "html" | "json" | "png" | "csv" | "tsv" | "yaml" | "pgm" | "md" => "is no program",
        _ => return Ok(()),
    };
    bail!("{} {what}; nothing was read or written", path.display())
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
    let Some(Targets { image, listing }) = targets else { return Ok(()) };
    let Some(there) = [image, listing].into_iter().find(|path| holds_something(path)) else {
        return Ok(());
    };
    let whose = match compiled_from(listing) {
        Some(own) if own == source_name(listing, source) => return Ok(()),
        Some(other) => format!("is of another program, {other},"),
        None => "may be of another program, as no listing beside it names its source,".to_owned(),
    };
    bail!(
        "{} {whose} and is not replaced; choose another folder with -o, or another name for {}, or remove it",
        there.display(),
        source.display()
    );
}

/// Whether something other than an empty file is there.
fn holds_something(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| !found.is_file() || found.len() > 0)
}

/// The last line of a listing: whose it is, the path from the listing's folder to the source.
const SOURCE: &str = "Source: ";

/// Bytes of a listing's end in which its last line is looked for: more than a path may have.
const LAST_LINE_BYTES_MAX: u64 = 16 << 10;

/// The source that a listing says it was compiled from; of the listing, whatever its size, only the end is read.
fn compiled_from(listing: &Path) -> Option<String> {
    let mut file = File::open(listing).ok().filter(|f| f.metadata().is_ok_and(|m| m.is_file()))?;
    let size = file.metadata().ok()?.len();
    file.seek(SeekFrom::Start(size.saturating_sub(LAST_LINE_BYTES_MAX))).ok()?;
    let mut end = Vec::new();
    file.take(LAST_LINE_BYTES_MAX).read_to_end(&mut end).ok()?;
    let end = String::from_utf8_lossy(&end);
    Some(end.lines().next_back()?.strip_prefix(SOURCE)?.to_owned())
}

/// A source as its listing names it: by the path from the listing's folder, links resolved, so that a project may be
/// moved as a whole and two sources of one name are still two.
fn source_name(listing: &Path, source: &Path) -> String {
    let folder = listing.parent().filter(|folder| !folder.as_os_str().is_empty());
    let folder = fs::canonicalize(folder.unwrap_or(Path::new(".")));
    let (Ok(folder), Ok(source)) = (folder, fs::canonicalize(source)) else {
        return source.to_string_lossy().into_owned();
    };
    let n_shared = folder.components().zip(source.components()).take_while(|(a, b)| a == b).count();
    if n_shared == 0 {
        // On another drive.
        return source.to_string_lossy().into_owned();
    }
    let up = folder.components().skip(n_shared).map(|_| "..".into());
    let down = source.components().skip(n_shared);
    let down = down.map(|part| part.as_os_str().to_string_lossy());
    up.chain(down).collect::<Vec<std::borrow::Cow<'_, str>>>().join("/")
}

/// Writes listing and image; a listing alone when there are errors, and then no image of an earlier version of this
/// source may be taken for one of this.
fn write_compiled(
    compilation: &Compilation,
    Targets { image, listing }: &Targets,
    source: &Path,
    outputs: &Outputs,
) -> anyhow::Result<()> {
    let name = source_name(listing, source);
    let text = format!("{}\n{SOURCE}{name}\n", compilation.listing().trim_end());
    outputs.write(listing, Kind::LISTING, text.as_bytes())?;
    match &compilation.program {
        Some(program) => outputs.write(image, Kind::IMAGE, program.image())?,
        // What is there is of an earlier version of this source, or nothing was compiled.
        None => outputs.remove(image, Kind::IMAGE)?,
    }
    Ok(())
}

fn source_path(given: &Path) -> PathBuf {
    if !given::is_stdin(given) && given.extension().is_none() && !given.exists() {
        let rdpl = given.with_extension("rdpl");
        if rdpl.exists() { rdpl } else { given.with_extension("src") }
    } else {
        given.to_owned()
    }
}

fn print_closing(compilation: &Compilation, written: Option<&Targets>) {
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
    let (excerpt, span) = excerpt(source, diagnostic.span.start, diagnostic.span.end);
    let span_start = span.start;
    let snippet = Snippet::source(excerpt)
        .path(&origin)
        .line_start(diagnostic.line)
        .annotation(AnnotationKind::Primary.span(span));
    let id = diagnostic.code.id();
    let is_cut = excerpt[..span_start].chars().count() + 1 < diagnostic.column;
    let message = if is_cut {
        format!("{} (in column {} of a long line)", diagnostic.message, diagnostic.column)
    } else {
        diagnostic.message.clone()
    };
    let mut report = vec![level.primary_title(&message).id(id).element(snippet)];
    if let Some(hint) = &diagnostic.hint {
        report.push(Group::with_title(Level::HELP.secondary_title(hint)));
    }
    renderer.render(&report)
}

/// Bytes shown at most before and after the place of a problem.
const SHOWN_BYTES: usize = 200;

/// The line around a place, without its end, and the place in it. Of a long line only the part around
/// the place, so that what is printed of a problem does not depend on the length of the text.
fn excerpt(source: &str, start: usize, end: usize) -> (&str, std::ops::Range<usize>) {
    let start = source.floor_char_boundary(start);
    let (before, rest) = source.split_at(start);
    let from = before.rfind(['\n', '\r']).map_or(0, |at| at + 1);
    let from = before.ceil_char_boundary(from.max(start.saturating_sub(SHOWN_BYTES)));
    let from =
        if source[from..].starts_with('\u{FEFF}') { from + '\u{FEFF}'.len_utf8() } else { from };
    let len = rest.find(['\n', '\r']).unwrap_or(rest.len());
    let to = start + rest.floor_char_boundary(len.min(SHOWN_BYTES));
    let from = from.min(start);
    let end = source.floor_char_boundary(end.clamp(start, to.max(start)));
    (&source[from..to], start - from..end - from)
}

fn as_json(compilation: &Compilation) -> serde_json::Value {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_excerpt_is_a_line_or_a_piece_of_one() {
        let text = "\u{FEFF}AND é\rOR O1,I0\r\nFF";
        assert_eq!(excerpt(text, 3, 6), ("AND é", 0..3));
        assert_eq!(excerpt(text, 10, 12), ("OR O1,I0", 0..2));
        assert_eq!(excerpt(text, 20, 22), ("FF", 0..2));
        assert_eq!(excerpt(text, 22, 22), ("FF", 2..2));
        // In the middle of a megabyte, and of a character.
        let long = "é".repeat(500_000);
        let (piece, span) = excerpt(&long, 400_001, 900_000);
        assert!(piece.len() <= 2 * SHOWN_BYTES && span.end <= piece.len());
        assert!(piece.chars().all(|c| c == 'é') && piece.is_char_boundary(span.end));
        assert_eq!(excerpt("", 5, 9), ("", 0..0));
    }
}
