//! `brdfit merge`: merges the summaries of all shards of a batch.

use std::fs;
use std::path::{Path, PathBuf};

use crate::args::fit::MergeArgs;
use crate::results::documents;
use crate::results::folder::ResultFolder;
use crate::results::shard::Shard;
use crate::results::summary::{self, Summary};
use crate::terminal::console::Console;
use crate::terminal::exit_code::{Outcome, Problem};

pub(crate) fn run(args: &MergeArgs, console: &Console) -> anyhow::Result<Outcome> {
    let folder = ResultFolder::at(&args.folder);
    let shards = find(folder.path())?;
    let mut parts = Vec::with_capacity(shards.len());
    for shard in shards {
        let path = folder.summary(Some(shard));
        parts.push((documents::read(&path, "a batch summary")?, path));
    }
    let whole = join(parts)?;
    let path = summary::write(&folder, None, &whole)?;
    console.note(&format!(
        "{} materials, {} failures: {}",
        whole.materials.len(),
        whole.failures.len(),
        path.display()
    ));
    Ok(Outcome::Done)
}

/// The shards whose summaries lie in a folder, all of them, in order.
fn find(folder: &Path) -> Result<Vec<Shard>, Problem> {
    let failed = |error| Problem::reading(folder, &error);
    let mut found = Vec::new();
    for entry in fs::read_dir(folder).map_err(failed)? {
        found.extend(entry.map_err(failed)?.file_name().to_str().and_then(Shard::of_summary));
    }
    found.sort_by_key(|shard| (shard.count, shard.index));
    let refuse = |why: String| Err(Problem::invalid(format!("{}: {why}", folder.display())));
    let Some(&Shard { count, .. }) = found.first() else {
        return refuse("no summary.I-of-N.json in this folder; fit with --shard I/N first".to_owned());
    };
    if let Some(other) = found.iter().find(|shard| shard.count != count) {
        return refuse(format!("summaries of {count} and of {} shards; remove those of the older batch", other.count));
    }
    if let Some(missing) = (1..=count).find(|&index| found.iter().all(|shard| shard.index != index)) {
        return refuse(format!("summary.{missing}-of-{count}.json is missing; run shard {missing}/{count}"));
    }
    Ok(found)
}

/// Joins summaries that belong together, materials and failures sorted as in the summary of an undivided batch.
fn join(parts: Vec<(Summary, PathBuf)>) -> Result<Summary, Problem> {
    let mut parts = parts.into_iter();
    let Some((mut whole, first)) = parts.next() else {
        return Err(Problem::invalid("no summaries to merge"));
    };
    for (part, path) in parts {
        let same = (&part.program, &part.options) == (&whole.program, &whole.options);
        if !same {
            return Err(Problem::invalid(format!(
                "{}: program version or options differ from {}; fit all shards with the same ones",
                path.display(),
                first.display()
            )));
        }
        whole.materials.extend(part.materials);
        whole.failures.extend(part.failures);
    }
    whole.materials.sort_by(|a, b| a.name.cmp(&b.name));
    whole.failures.sort_by(|a, b| summary::order(a).cmp(&summary::order(b)));
    if let Some(pair) = whole.materials.windows(2).find(|pair| pair[0].name == pair[1].name) {
        return Err(Problem::invalid(format!(
            "{}: the material {} is in two shards; fit all shards of the batch again",
            first.display(),
            pair[0].name
        )));
    }
    Ok(whole)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_are_complete_or_refused() {
        let folder = tempfile::tempdir().unwrap();
        let put = |name: &str| fs::write(folder.path().join(name), "").unwrap();
        let refused = || find(folder.path()).unwrap_err().to_string();
        assert!(refused().contains("no summary.I-of-N.json"));
        put("summary.3-of-3.json");
        put("summary.1-of-3.json");
        put("summary.0-of-3.json");
        put("summary.json");
        assert!(refused().contains("summary.2-of-3.json is missing"), "{}", refused());
        put("summary.2-of-3.json");
        assert_eq!(find(folder.path()).unwrap().iter().map(|shard| shard.index).collect::<Vec<_>>(), [1, 2, 3]);
        put("summary.1-of-2.json");
        assert!(refused().contains("summaries of 2 and of 3 shards"), "{}", refused());
    }
}
