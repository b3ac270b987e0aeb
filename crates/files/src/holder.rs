//! Who holds the lock of a file.

use std::fs::File;

/// The process that holds the lock of `file`, for people. Linux tells its number and name; elsewhere it is just
/// another program.
pub(crate) fn holder(file: &File) -> String {
    known(file).unwrap_or_else(|| "another running program".to_owned())
}

#[cfg(target_os = "linux")]
fn known(file: &File) -> Option<String> {
    use std::os::unix::fs::MetadataExt as _;
    let number = file.metadata().ok()?.ino();
    let table = std::fs::read_to_string("/proc/locks").ok()?;
    let process = process_of(&table, number)?;
    let name = std::fs::read_to_string(format!("/proc/{process}/comm")).unwrap_or_default();
    match name.trim() {
        "" => Some(format!("process {process}")),
        name => Some(format!("process {process} ({name})")),
    }
}

#[cfg(not(target_os = "linux"))]
fn known(_file: &File) -> Option<String> {
    None
}

/// Lines are `1: FLOCK  ADVISORY  WRITE 4242 fd:01:131074 0 EOF`; the number of the file ends the sixth word.
///
/// Source: Linux kernel documentation, filesystems/proc, `/proc/locks`.
#[cfg(target_os = "linux")]
fn process_of(table: &str, file_number: u64) -> Option<u32> {
    table.lines().find_map(|line| {
        let mut words = line.split_whitespace().filter(|word| *word != "->");
        let process = words.nth(4)?.parse().ok()?;
        let found: u64 = words.next()?.rsplit(':').next()?.parse().ok()?;
        (found == file_number).then_some(process)
    })
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::process_of;

    #[test]
    fn the_table_of_locks_names_the_process() {
        let table = "1: POSIX  ADVISORY  READ 12 08:01:7 0 EOF\n\
            2: FLOCK  ADVISORY  WRITE 4242 fd:01:131074 0 EOF\n";
        assert_eq!(process_of(table, 131_074), Some(4242));
        assert_eq!(process_of(table, 7), Some(12));
        assert_eq!(process_of(table, 8), None);
        assert_eq!(process_of("nonsense\n", 8), None);
    }
}
