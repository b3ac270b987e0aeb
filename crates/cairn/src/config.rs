//! `cairn config`: every key of a mission file, with its default and what it means.

use std::process::ExitCode;

use anyhow::bail;
use missions::Mission;

use crate::output::{self, say_raw};

/// Prints a mission file with every key, its default and a sentence on it
#[derive(Debug, clap::Args)]
#[command(
    after_help = "Examples:\n  cairn config > reference.toml\n  cairn config robots.mind.how.method"
)]
pub(crate) struct Args {
    /// A key that chooses among a few, such as `robots.mind.how.method`, or the end of one: prints its words and what they are
    key: Option<String>,
}

pub(crate) fn main(args: &Args) -> anyhow::Result<ExitCode> {
    match &args.key {
        None => say_raw!("{}", Mission::template()),
        Some(key) => words(key)?,
    }
    Ok(ExitCode::SUCCESS)
}

/// Prints the words of the keys that end so.
fn words(key: &str) -> anyhow::Result<()> {
    let lists = Mission::word_lists();
    let is_meant = |full: &str| full == key || full.ends_with(&format!(".{key}"));
    let meant: Vec<_> = lists.iter().filter(|list| is_meant(list.key)).collect();
    if meant.is_empty() {
        let keys = lists.iter().map(|list| list.key);
        // The last two names say as much as the whole key, and are sooner written.
        let ends = keys.clone().filter_map(|key| {
            let (before, _) = key.rsplit_once('.')?;
            Some(before.rsplit_once('.').map_or(key, |(tables, _)| &key[tables.len() + 1..]))
        });
        let like = settings::did_you_mean(key, keys.clone().chain(ends));
        let like = like.map(|like| format!("did you mean `{like}`? ")).unwrap_or_default();
        let all: Vec<&str> = keys.collect();
        bail!("no key called `{key}` chooses among a few; {like}those that do: {}", all.join(", "));
    }
    for list in meant {
        let row = |(word, about): &(String, String)| {
            vec![list.key.to_owned(), word.clone(), about.clone()]
        };
        output::table(&list.words.iter().map(row).collect::<Vec<_>>());
    }
    Ok(())
}
