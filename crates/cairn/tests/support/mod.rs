//! What the end-to-end tests share: the real binary, run in a folder of its own.
#![allow(clippy::allow_attributes, dead_code, reason = "each test file uses a part of it")]
#![expect(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a failing helper fails its test"
)]

use std::{
    fs,
    io::{BufRead as _, BufReader},
    path::{Path, PathBuf},
    process::{Child, ChildStdout, Command, Stdio},
};

use serde_json::Value;
use tempfile::TempDir;

/// A temporary folder in which the program is run.
pub(crate) struct Place(TempDir);

/// How a run of the program ended.
pub(crate) struct Ended {
    pub(crate) code: i32,
    pub(crate) out: String,
    pub(crate) err: String,
}

impl Place {
    pub(crate) fn new() -> Self {
        Self(TempDir::new().unwrap())
    }

    pub(crate) fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    pub(crate) fn write(&self, name: &str, text: &str) {
        fs::write(self.path(name), text).unwrap();
    }

    pub(crate) fn read(&self, name: &str) -> String {
        fs::read_to_string(self.path(name)).unwrap()
    }

    pub(crate) fn command(&self) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_cairn"));
        command.current_dir(self.0.path()).stdin(Stdio::null());
        command
    }

    /// Runs `cairn` with blank-separated arguments.
    pub(crate) fn cairn(&self, arguments: &str) -> Ended {
        Self::ended(self.command().args(arguments.split_whitespace()))
    }

    /// Runs `cairn` with `input` on its standard input.
    pub(crate) fn piped(&self, arguments: &str, input: &str) -> Ended {
        self.write("input", input);
        let mut command = self.command();
        command.args(arguments.split_whitespace());
        command.stdin(Stdio::from(fs::File::open(self.path("input")).unwrap()));
        Self::ended(&mut command)
    }

    pub(crate) fn ended(command: &mut Command) -> Ended {
        let output = command.output().unwrap();
        Ended {
            code: output.status.code().unwrap_or(-1),
            out: String::from_utf8(output.stdout).unwrap(),
            err: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Starts a server; gives it back with the address that it printed.
    pub(crate) fn serve(&self, arguments: &str) -> Server {
        self.serve_several(arguments, 1).0
    }

    /// Starts a server that prints `n` addresses, a line each.
    pub(crate) fn serve_several(&self, arguments: &str, n: usize) -> (Server, Vec<String>) {
        let mut command = self.command();
        command.args(arguments.split_whitespace()).stdout(Stdio::piped()).stderr(Stdio::null());
        let mut process = command.spawn().unwrap();
        let mut out = BufReader::new(process.stdout.take().unwrap());
        let addresses: Vec<String> = (0..n)
            .map(|_| {
                let mut line = String::new();
                out.read_line(&mut line).unwrap();
                let address =
                    line.split("connect to ").nth(1).and_then(|rest| rest.split(';').next());
                address.expect("an address in the line").to_owned()
            })
            .collect();
        (Server { address: addresses[0].clone(), process, out }, addresses)
    }
}

impl Ended {
    pub(crate) fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}: {}{}", self.out, self.err))
    }

    /// Ended with `code`, and said each of `words` on standard error.
    pub(crate) fn refused(&self, code: i32, words: &[&str]) {
        assert_eq!(self.code, code, "{}{}", self.out, self.err);
        for word in words {
            assert!(self.err.contains(word), "`{word}` is missing in: {}", self.err);
        }
    }

    /// Ended well.
    pub(crate) fn fine(self) -> Self {
        assert_eq!(self.code, 0, "{}{}", self.out, self.err);
        self
    }
}

/// A running server, ended when dropped.
pub(crate) struct Server {
    pub(crate) address: String,
    process: Child,
    out: BufReader<ChildStdout>,
}

impl Server {
    /// The next line that it prints.
    pub(crate) fn line(&mut self) -> String {
        let mut line = String::new();
        self.out.read_line(&mut line).unwrap();
        line
    }

    /// Most memory that it ever used, bytes; `None` where the system does not say.
    pub(crate) fn memory_bytes_max(&self) -> Option<u64> {
        let status = fs::read_to_string(format!("/proc/{}/status", self.process.id())).ok()?;
        let line = status.lines().find(|line| line.starts_with("VmHWM:"))?;
        Some(1024 * line.split_whitespace().nth(1)?.parse::<u64>().ok()?)
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        self.process.kill().unwrap();
        self.process.wait().unwrap();
    }
}

/// A mission of a few seconds whose verdict is known: a straight drive of a metre.
pub(crate) fn short_drive(within_m: f64) -> String {
    format!(
        "[mission]\nname = \"short-drive\"\nduration_max_s = 12.0\nseed = 5\n\
         [world]\nbounds_m = [-1.0, -1.0, 3.0, 1.0]\n\
         [[world.walls]]\nline_m = [[-1.0, -1.0], [3.0, -1.0], [3.0, 1.0], [-1.0, 1.0]]\nclosed = true\n\
         [[robots]]\nname = \"robot\"\n[robots.mind]\nhow.method = \"straight\"\n\
         [[events]]\nat_s = 1.0\ndo = \"goal\"\nrobot = \"robot\"\npose = [1.0, 0.0, 0.0]\n\
         [[success.arrived]]\nrobot = \"robot\"\npose = [1.0, 0.0, 0.0]\nwithin_m = {within_m}\n\
         within_deg = 15.0\n"
    )
}

/// The folder of the shipped missions.
pub(crate) fn shipped(name: &str) -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../missions").join(name).display().to_string()
}
