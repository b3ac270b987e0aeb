//! The user's documents keep their word: the failing program on every page of `docs/problems/`
//! fails with that problem and no other, the corrected one is clean, and every program in the
//! guide compiles to what the guide says.

#![cfg(test)]

use std::{collections::BTreeSet, fs, path::PathBuf};

use decision::{Code, Machine, Mnemonic, Mode, compile, decode};

fn docs() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../docs")
}

/// A fenced block: what stands behind the fence, and the text within.
fn blocks(page: &str) -> Vec<(String, String)> {
    let mut found = Vec::new();
    let mut lines = page.lines();
    while let Some(line) = lines.next() {
        if let Some(info) = line.strip_prefix("```") {
            let body = lines.by_ref().take_while(|line| *line != "```");
            let text = body.fold(String::new(), |text, line| text + line + "\n");
            found.push((info.to_owned(), text));
        }
    }
    found
}

/// The codes of everything wrong with a block.
fn codes(info: &str, text: &str) -> BTreeSet<Code> {
    if info == "image" {
        let bytes = text.split_whitespace().map(|b| u8::from_str_radix(b, 16).expect("hex"));
        let bytes: Vec<u8> = bytes.collect();
        let mut machine = Machine::from_image(&bytes, Mode::Corrected);
        machine.scan();
        let fault = machine.fault().map(|fault| fault.code);
        return decode(&bytes)
            .err()
            .map(decision::ImageError::code)
            .into_iter()
            .chain(fault)
            .collect();
    }
    let n_times = info.strip_prefix("rdpl repeat=").map_or(1, |n| n.parse().expect("a number"));
    compile(&text.repeat(n_times)).diagnostics.iter().map(|d| d.code).collect()
}

/// No program on a page can show these; their pages say why.
const WITHOUT_PROGRAM: [Code; 6] = [
    Code::SourceTooLarge,
    Code::OtherEncoding,
    Code::TextAfterEnd,
    Code::WatchdogReset,
    Code::ScanOverrun,
    Code::ImageMismatch,
];

#[test]
fn every_problem_has_a_page_that_is_right() {
    for &code in Code::ALL {
        let page = code.page();
        assert!(page.starts_with(&format!("# {code}\n\n{}\n", code.title())), "{code}: heading");
        let blocks = blocks(page);
        if WITHOUT_PROGRAM.contains(&code) {
            assert!(blocks.is_empty() && page.contains("There is no program to show"));
            continue;
        }
        let [(wrong_info, wrong), (right_info, right)] = &blocks[..] else {
            panic!("{code}: two programs expected, {} found", blocks.len());
        };
        let mut found = codes(wrong_info, wrong);
        if code == Code::TooManyProblems {
            found.remove(&Code::UnknownMnemonic);
        }
        assert_eq!(found, BTreeSet::from([code]), "{code}: the wrong program");
        assert_eq!(codes(right_info, right), BTreeSet::new(), "{code}: the right program");
    }
}

#[test]
fn every_page_belongs_to_a_problem() {
    let pages = fs::read_dir(docs().join("problems")).expect("the folder of pages");
    let names: BTreeSet<String> = pages
        .map(|page| page.expect("readable").file_name().to_string_lossy().into_owned())
        .collect();
    let expected: BTreeSet<String> = Code::ALL.iter().map(|code| format!("{code}.md")).collect();
    assert_eq!(names, expected);
    for &code in Code::ALL {
        assert_eq!(Code::by_id(&code.id().to_lowercase()), Some(code));
    }
    assert_eq!(Code::by_id("R0000"), None);
}

#[test]
fn every_program_in_the_guide_compiles() {
    let guide = fs::read_to_string(docs().join("guide/rdpl.md")).expect("the guide");
    let blocks = blocks(&guide);
    let programs: Vec<_> = blocks.iter().filter(|(info, _)| info == "rdpl").collect();
    assert!(programs.len() >= 20, "only {} programs", programs.len());
    for (_, text) in &programs {
        let found: Vec<_> = compile(text).diagnostics.iter().map(ToString::to_string).collect();
        assert_eq!(found, [""; 0], "in the guide:\n{text}");
    }
    // The hexadecimal block is the image of the program that comes before it.
    let at = blocks.iter().position(|(info, _)| info == "image").expect("an image");
    let before = blocks[..at].iter().rev().find(|(info, _)| info == "rdpl").expect("a program");
    let image = compile(&before.1).program.expect("correct").image().to_vec();
    let hex: Vec<String> = image.iter().map(|byte| format!("{byte:02X}")).collect();
    assert_eq!(blocks[at].1.split_whitespace().collect::<Vec<_>>(), hex);
}

#[test]
fn the_guide_lists_every_function_and_problem_group() {
    let guide = fs::read_to_string(docs().join("guide/rdpl.md")).expect("the guide");
    let mut table = "| function | opcode | bytes | |\n| --- | --- | --- | --- |\n".to_owned();
    for mnemonic in Mnemonic::ALL {
        let syntax = format!("`{}`", mnemonic.syntax());
        assert!(guide.contains(&syntax), "the guide lacks {syntax}");
        let (opcode, size, about) = (mnemonic.opcode(), mnemonic.size_bytes(), mnemonic.about());
        let row = format!("| `{mnemonic}` | {opcode:02X} | {size} | {about} |\n");
        table.push_str(&row);
    }
    // UPDATE_EXPECT=1 brings the table up to date.
    let (begin, end) = ("<!-- functions -->\n", "<!-- end of functions -->\n");
    let (before, rest) = guide.split_once(begin).expect("where the table begins");
    let (_, after) = rest.split_once(end).expect("where the table ends");
    expect_test::expect_file![docs().join("guide/rdpl.md")]
        .assert_eq(&format!("{before}{begin}{table}{end}{after}"));
}
