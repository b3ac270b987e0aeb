//! One line of `cargo test` that no harness swallows: how many tests have no measured data to replay.
//!
//! A test that finds no data says so, but what a passing test says is not shown. This program has no harness; it counts
//! in the sources which tests ask for data, directly or through a function of their file.
#![expect(
    clippy::print_stdout,
    clippy::expect_used,
    reason = "it is here to speak, and a repository that cannot be read must fail it"
)]

use std::{
    collections::BTreeSet,
    fs,
    path::{Path, PathBuf},
};

fn main() {
    counted_as_it_should();
    let mut n_tests = 0;
    for file in sources(&testkit::workspace_root().join("crates")) {
        n_tests +=
            tests_with_data(&fs::read_to_string(&file).expect("a source of this repository"));
    }
    assert!(n_tests > 10, "only {n_tests} tests were found that replay measured data");
    match testkit::data_root() {
        Some(_) => println!("\nmeasured data: here; {n_tests} tests replay them, 0 skipped\n"),
        None => println!(
            "\nskipped: {n_tests} tests replay measured data, which are not here (CAIRN_DATA names their folder); \
             all others ran\n"
        ),
    }
}

/// Rust files below a folder, sorted; not this one.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).expect("a folder of this repository").flatten() {
        let path = entry.path();
        if path.is_dir() {
            found.extend(sources(&path));
        } else if path.extension().is_some_and(|e| e == "rs") && !path.ends_with("measured_data.rs")
        {
            found.push(path);
        }
    }
    found.sort();
    found
}

/// How many tests of a source ask for measured data.
fn tests_with_data(text: &str) -> usize {
    let functions = functions(text);
    let mut asking = BTreeSet::from(["data_folder"]);
    loop {
        let more: Vec<&str> = functions
            .iter()
            .filter(|f| !asking.contains(f.name) && asking.iter().any(|a| calls(f.body, a)))
            .map(|f| f.name)
            .collect();
        if more.is_empty() {
            break;
        }
        asking.extend(more);
    }
    functions.iter().filter(|f| f.is_test && asking.contains(f.name)).count()
}

fn calls(body: &str, name: &str) -> bool {
    let whole = |at: usize| !body[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
    body.match_indices(&format!("{name}(")).any(|(at, _)| whole(at))
}

#[derive(Debug)]
struct Function<'a> {
    is_test: bool,
    name: &'a str,
    /// The text up to the next function.
    body: &'a str,
}

fn functions(text: &str) -> Vec<Function<'_>> {
    let begins_a_line = |at: usize| {
        let line = text[..at].rsplit('\n').next().unwrap_or_default().trim();
        line.is_empty() || line.starts_with("pub")
    };
    let all = text.match_indices("fn ").map(|(at, _)| at);
    let starts: Vec<usize> = all.filter(|&at| begins_a_line(at)).collect();
    let ends = starts.iter().skip(1).copied().chain([text.len()]);
    let function = |(&start, end): (&usize, usize)| {
        let rest = &text[start + 3..end];
        let name = rest.split(|c: char| !c.is_alphanumeric() && c != '_').next().unwrap_or("");
        let above = text[..start].trim_end().lines().rev().map(str::trim);
        let mut attributes =
            above.take_while(|line| line.starts_with('#') || line.starts_with("//"));
        Function {
            is_test: attributes.any(|line| line == "#[test]"),
            name,
            body: &rest[name.len()..],
        }
    };
    starts.iter().zip(ends).map(function).collect()
}

fn counted_as_it_should() {
    let text = "fn log() -> Log { testkit::data_folder(\"x\") }\n\n#[test]\nfn a() { log(); }\n\n\
        #[test]\nfn b() { catalog(); }\n\n    #[test]\n    // Why.\n    fn c() { let x = data_folder(\"y\"); }\n";
    assert_eq!(tests_with_data(text), 2, "{:?}", functions(text));
}
