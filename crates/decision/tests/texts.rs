//! Texts as they come from people's computers: what they are made of is read, or named with its
//! line. `tests/cases/` has files that failed.

#![cfg(test)]

use std::{fs, path::Path};

use decision::{Compilation, Mode, SOURCE_BYTES_MAX, compile, compile_bytes};

fn case(name: &str) -> Compilation {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cases").join(name);
    compile_bytes(&fs::read(path).expect("a case"), Mode::Corrected)
}

fn bytes(text: &[u8]) -> Compilation {
    compile_bytes(text, Mode::Corrected)
}

/// Mnemonics and lines of the functions.
fn functions(compilation: &Compilation) -> Vec<String> {
    let program = compilation.program.as_ref().expect("a program");
    program.functions().iter().map(|f| format!("{} in {}", f.mnemonic, f.line)).collect()
}

/// Codes and places of the problems.
fn problems(compilation: &Compilation) -> Vec<String> {
    let shown = |d: &decision::Diagnostic| format!("{} {}:{}", d.code, d.line, d.column);
    compilation.diagnostics.iter().map(shown).collect()
}

const TWO: [&str; 2] = ["AND in 1", "OR in 2"];

#[test]
fn bom_rdpl_is_read() {
    let compilation = case("bom.rdpl");
    assert_eq!(
        (functions(&compilation), problems(&compilation).len()),
        (TWO.map(str::to_owned).to_vec(), 0)
    );
    assert_eq!(compilation.n_lines, 2);
}

#[test]
fn latin1_rdpl_is_read_and_its_line_is_named() {
    let compilation = case("latin1.rdpl");
    assert_eq!(
        (functions(&compilation), problems(&compilation)),
        (TWO.map(str::to_owned).to_vec(), vec!["R1013 1:1".to_owned()])
    );
    assert!(compilation.listing().contains("latin1 üä"));
    // Outside a comment, such a character is wrong where it stands.
    let wrong = bytes(b"AND O0,I0,1L,1L,1L\r\nOR O\xFC,I0,0L,0L,0L");
    assert_eq!(problems(&wrong), ["R1013 2:1", "R1007 2:4"]);
}

#[test]
fn cr_only_rdpl_has_two_lines() {
    let compilation = case("cr-only.rdpl");
    assert_eq!(
        (functions(&compilation), compilation.n_lines),
        (TWO.map(str::to_owned).to_vec(), 2)
    );
    let mixed = bytes(
        b"AND O0,I0,1L,1L,1L\r\rOR O1,I0,0L,0L,0L\r\nNOR O2,I0,0L,0L,0L\n\rXOR O3,I0,0L,0L,0L",
    );
    assert_eq!(functions(&mixed), ["AND in 1", "OR in 3", "NOR in 4", "XOR in 6"]);
    // A comment ends with its line, whatever ends that.
    let comments = bytes(b"; one\rAND O0,I0,1L,1L,1L ; two\rOR O1,I0,0L,0L,0L");
    assert_eq!(functions(&comments), ["AND in 2", "OR in 3"]);
    let listed = compilation.listing().lines().filter(|line| line.contains("O1,I1")).count();
    assert_eq!(listed, 1);
}

#[test]
fn sixth_operand_rdpl_warns_on_both_lines() {
    let compilation = case("sixth-operand.rdpl");
    assert_eq!(functions(&compilation), ["AND in 1", "AND in 2"]);
    assert_eq!(problems(&compilation), ["R1010 1:20", "R1011 2:20"]);
}

#[test]
fn a_comment_without_its_sign_is_told_from_a_slip() {
    let found = |rest: &str| problems(&compile(&format!("N EQU 3\nOR O0,I0,0L,0L,0L {rest}")));
    for comment in ["the lamp", "and so on", "or what", "move along", "x", "; I4", "lamp I4"] {
        assert_eq!(found(comment), [""; 0], "{comment}");
    }
    for operand in ["I4", "y3 too", "3", "$1F", "n", "RISE", "'a'"] {
        assert_eq!(found(operand), ["R1010 2:19"], "{operand}");
    }
    for function in ["AND O1,I0,I1,1L,1L", "L: FF Y0,I0,I1,0", "so FF Y0 I0 I1 0", "A EQU 3"] {
        assert_eq!(found(function).len(), 1, "{function}");
        assert!(found(function)[0].starts_with("R1011 2:"), "{function}");
    }
    assert_eq!(problems(&compile("N EQU 3 4")), ["R1010 1:9"]);
    assert_eq!(problems(&compile("N EQU 3 stands for three\nAND O0,I0,1L,1L,1L")), [""; 0]);
    assert_eq!(problems(&compile("FF Y0,I0,I1,0 OR O2,Y0,0L,0L,0L")), ["R1005 1:15"]);
}

#[test]
fn blanks_bytes_and_ends_of_every_kind() {
    let blanks = bytes(b"\tAND\x0CO0\x0B,I0,\t1L 1L,,1L\t; \x00 \x07 odd bytes in a comment");
    assert_eq!((functions(&blanks), problems(&blanks).len()), (vec!["AND in 1".to_owned()], 0));
    assert_eq!(problems(&bytes(b"AND O0,I0,1L,1L,1L\nOR\0O1,I0,0L,0L,0L")), ["R1007 2:1"]);
    let no_break = problems(&bytes("AND\u{A0}O0,I0,1L,1L,1L".as_bytes()));
    assert_eq!(no_break, ["R1007 1:1"]);
    // The end of the file as DOS wrote it, with and without something behind.
    assert_eq!(problems(&bytes(b"AND O0,I0,1L,1L,1L\r\n\x1A\x1A\0\0")), [""; 0]);
    let cut = bytes(b"AND O0,I0,1L,1L,1L\r\n\x1AOR O1,I0,0L,0L,0L");
    assert_eq!(
        (functions(&cut), problems(&cut)),
        (vec!["AND in 1".to_owned()], vec!["R1014 1:1".to_owned()])
    );
    let wide: Vec<u8> = "AND O0,I0,1L,1L,1L\r\nOR O1,I0,0L,0L,0L"
        .encode_utf16()
        .flat_map(u16::to_le_bytes)
        .collect();
    let wide = bytes(&wide);
    assert_eq!(
        (functions(&wide), problems(&wide)),
        (TWO.map(str::to_owned).to_vec(), vec!["R1013 1:1".to_owned()])
    );
}

#[test]
fn a_long_line_is_one_line() {
    let long = format!("AND O0,I0,1L,1L,1L ; {}\nOR O1,I0,0L,0L,0L", "x".repeat(1_000_000));
    assert_eq!(functions(&compile(&long)), TWO);
    let longest = "Q".repeat(1_000_000);
    let wrong = compile(&longest);
    assert!(wrong.diagnostics.iter().all(|d| d.message.len() < 200), "the message quotes it all");
}

#[test]
fn more_than_four_megabytes_are_no_program() {
    let line = "AND O0,I0,1L,1L,1L ; so wide\n";
    let full = line.repeat(SOURCE_BYTES_MAX / line.len());
    assert!(full.len() <= SOURCE_BYTES_MAX);
    let over = format!("{full}{line}");
    for compilation in [compile(&over), bytes(over.as_bytes())] {
        assert_eq!(
            (problems(&compilation), compilation.n_lines),
            (vec!["R1012 1:1".to_owned()], 0)
        );
        assert!(compilation.listing().len() < 400);
    }
}

/// Work is counted in allocations and in bytes allocated; anything that goes over the text again
/// for every line, or over a list for every entry, shows in the latter.
#[test]
fn compiling_and_listing_are_linear_in_the_lines() {
    let programs: [fn(usize) -> String; 3] = [
        |n| "lamp: AND O0,I0,NI1,1L,1L ; on\n".replace("lamp: ", "").repeat(n),
        |n| (0..n).fold(String::new(), |text, i| text + "N" + &i.to_string() + " EQU 7\n"),
        |n| "QQQQ ZZZZ,RRRR\r".repeat(n),
    ];
    for (which, program) in programs.iter().enumerate() {
        let cost = |n: usize| {
            let source = program(n);
            let mut listing = String::new();
            let counted = allocation_counter::measure(|| {
                listing = compile_bytes(source.as_bytes(), Mode::Corrected).listing();
            });
            assert!(listing.lines().count() > n);
            [counted.count_total as f64, counted.bytes_total as f64, counted.bytes_max as f64]
        };
        let (once, eight) = (cost(2000), cost(16_000));
        for (one, many) in once.into_iter().zip(eight) {
            let growth = many / one;
            println!(
                "program {which}: {one} for 2000 lines, {growth:.2} times that for 8 times as many"
            );
            assert!(growth < 8.8, "program {which} grows {growth:.1} times with 8 times the lines");
        }
    }
}
