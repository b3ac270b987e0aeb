//! The guide's table of formats is that of the crate; `UPDATE_EXPECT=1` brings it up to date.

#![cfg(test)]

use expect_test::expect_file;
use recordings::{Format, ReadOptions, Ring, Takes, read};

#[test]
fn the_guide_has_every_format() {
    let guide = include_str!("../../../docs/guide/mapping.md");
    let row = |format: &Format| {
        let endings: Vec<String> = format.endings().iter().map(|e| format!("`{e}`")).collect();
        let (endings, known_by, needs) = (endings.join(", "), format.known_by(), format.needs());
        format!("| {format} | {endings} | {known_by} | {needs} |\n")
    };
    let rows = Format::ALL.iter().map(row).collect::<Vec<_>>().concat();
    let head = "| format | usual ending | how Cairn knows it | what it needs |\n| --- | --- | --- | --- |\n";
    let (begin, end) = ("<!-- formats -->\n", "<!-- end of formats -->\n");
    let (before, rest) = guide.split_once(begin).expect("where the table begins");
    let (_, after) = rest.split_once(end).expect("where the table ends");
    expect_file!["../../../docs/guide/mapping.md"]
        .assert_eq(&format!("{before}{begin}{head}{rows}{end}{after}"));
}

/// A file of no known format is answered with all of them; and the fields of the table are sound.
#[test]
fn whoever_gives_something_else_is_told_every_format() {
    let error = read("a.txt", b"hello\n", &ReadOptions::default()).unwrap_err().to_string();
    for format in Format::ALL {
        assert!(error.contains(format.name()), "{error}");
        assert!(format.endings().iter().all(|e| e.starts_with('.') && *e == e.to_lowercase()));
        assert_eq!(format.needs() == "–", format.second().is_none() && format.takes().is_empty());
    }
}

/// What the table says of second files and rings is what the readers do.
#[test]
fn a_format_takes_what_its_row_says() {
    let readings = "10 | 2 | 3 | 4 | 5 \n".repeat(3);
    let options = |poses, ring| ReadOptions { poses, ring, ..ReadOptions::default() };
    let alone = read("x", readings.as_bytes(), &options(None, Ring::File)).unwrap_err();
    assert!(alone.to_string().contains("second file"), "{alone}");
    let poses = "0 0 0 \n".repeat(3);
    let poses = Some(poses.as_bytes());
    let by_itself = read("x", readings.as_bytes(), &options(poses, Ring::File)).unwrap();
    assert_eq!(by_itself.format, Format::ArtemicText);
    assert!(by_itself.format.understands(Takes::Ring));
    // Its rows have five readings, too few for another ring.
    assert!(read("x", readings.as_bytes(), &options(poses, Ring::Listing8)).is_err());
    let log = "FLASER 3 1.5 2.5 81.91 0 0 0 0 0 0 10.25 host 10.25\n";
    let with = |ring| read("x", log.as_bytes(), &options(None, ring)).unwrap().recording;
    assert!(!Format::Carmen.understands(Takes::Ring));
    assert_eq!(with(Ring::File), with(Ring::Listing8));
}
