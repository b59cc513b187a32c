//! Tags as text: `id v0 v1 v2` lines, and their names in a JSON file beside.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::{IoError, read_text, write_atomic};
use crate::Tags;

/// The content of the JSON file, in order of ids. Programs may add what they know.
#[derive(Serialize, Deserialize)]
struct Legend {
    names: Vec<String>,
    /// Numbers of facets, for the reader's eyes only.
    #[serde(default)]
    facets: Vec<usize>,
}

/// Where the names of `tags.txt` are: `tags.json`.
fn legend_path(path: &Path) -> PathBuf {
    path.with_extension("json")
}

/// Writes `id v0 v1 v2` lines to `path` and the names with their numbers of
/// facets to the file beside it with extension `json`.
///
/// # Errors
/// If a file cannot be written.
pub fn write_tags(path: &Path, tags: &Tags) -> Result<(), IoError> {
    let counts = (1..).zip(&tags.names).map(|(id, _)| tags.facets_of(id).len());
    let legend = Legend { names: tags.names.clone(), facets: counts.collect() };
    write_atomic(path, |out| {
        tags.facets.iter().try_for_each(|([a, b, c], id)| writeln!(out, "{id} {a} {b} {c}"))
    })?;
    write_atomic(&legend_path(path), |out| {
        serde_json::to_writer_pretty(&mut *out, &legend)?;
        writeln!(out)
    })
}

/// Reads `id v0 v1 v2` lines. Names come from the file beside with extension
/// `json`; without it every id is called by its number and the ids are renumbered
/// from 1 in ascending order. Lines that repeat a facet with the same id are fine.
///
/// # Errors
/// If a file cannot be read, a line is malformed, a facet has two ids or an id
/// has no name.
pub fn read_tags(path: &Path) -> Result<Tags, IoError> {
    let text = read_text(path)?;
    let mut lines = Vec::new();
    for (i, line) in text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()) {
        lines.push(parse_line(line).ok_or_else(|| {
            let needed = "`id v0 v1 v2`, whole numbers and three different vertices";
            IoError::content(path, format!("line {}: {line:?} is not {needed}", i + 1))
        })?);
    }
    let legend_path = legend_path(path);
    let (names, ids) = if legend_path.exists() {
        let legend: Legend = serde_json::from_str(&read_text(&legend_path)?)
            .map_err(|e| IoError::content(&legend_path, e.to_string()))?;
        let ids = (1..=legend.names.len() as u64).collect();
        (legend.names, ids)
    } else {
        let ids: BTreeSet<u64> = lines.iter().map(|&(id, _)| id).collect();
        (ids.iter().map(u64::to_string).collect(), ids)
    };
    collect(names, &ids, &lines).map_err(|m| IoError::content(path, m))
}

fn collect(
    names: Vec<String>,
    ids: &BTreeSet<u64>,
    lines: &[(u64, [usize; 3])],
) -> Result<Tags, String> {
    let new_id: std::collections::BTreeMap<u64, u32> = ids.iter().copied().zip(1..).collect();
    let mut tags = Tags::new(names);
    for &(id, facet) in lines {
        let Some(&new) = new_id.get(&id) else {
            return Err(format!("facet {facet:?} has id {id}, names exist for 1 to {}", ids.len()));
        };
        if let Some(other) = tags.get(facet).filter(|&other| other != new) {
            let (first, second) = (&tags.names[other as usize - 1], &tags.names[new as usize - 1]);
            return Err(format!("facet {facet:?} is tagged {first:?} and {second:?}"));
        }
        tags.set(facet, new);
    }
    Ok(tags)
}

fn parse_line(line: &str) -> Option<(u64, [usize; 3])> {
    let mut numbers = line.split_whitespace().map(str::parse::<u64>);
    let id = numbers.next()?.ok()?;
    let mut facet = [0; 3];
    for v in &mut facet {
        *v = usize::try_from(numbers.next()?.ok()?).ok()?;
    }
    let [a, b, c] = facet;
    let fine = numbers.next().is_none() && a != b && b != c && c != a;
    fine.then_some((id, facet))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_and_their_names_come_back() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("tags.txt");
        let mut tags = Tags::new(vec!["seat".into(), "empty".into(), "cavity \"Ω\"".into()]);
        tags.set([9, 1, 4], 3);
        tags.set([2, 1, 0], 1);
        write_tags(&path, &tags).expect("writable");
        assert_eq!(read_text(&path).expect("readable"), "1 0 1 2\n3 1 4 9\n");
        assert_eq!(read_tags(&path).expect("what was written"), tags);
        let legend = read_text(&folder.path().join("tags.json")).expect("readable");
        assert!(legend.contains("\"empty\""), "{legend}");
    }

    #[test]
    fn ids_without_names_are_called_by_their_number() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("selections.txt");
        std::fs::write(&path, "2147483647 0 1 2\n7 2 1 3\n7 3 2 1\n\n").expect("writable");
        let tags = read_tags(&path).expect("valid");
        assert_eq!(tags.names, ["7", "2147483647"]);
        assert_eq!((tags.get([0, 1, 2]), tags.get([1, 2, 3])), (Some(2), Some(1)));
    }

    #[test]
    fn bad_lines_are_named() {
        let folder = tempfile::tempdir().expect("a temporary folder");
        let path = folder.path().join("tags.txt");
        let message = |text: &str| {
            std::fs::write(&path, text).expect("writable");
            read_tags(&path).expect_err("bad").to_string()
        };
        for bad in ["1 0 1", "1 0 1 2 3", "1 0 1 1", "-1 0 1 2", "one 0 1 2"] {
            let message = message(&format!("1 5 6 7\n{bad}\n"));
            assert!(message.contains("tags.txt: line 2") && message.contains(bad), "{message}");
        }
        assert!(message("1 0 1 2\n2 2 1 0\n").contains("is tagged \"1\" and \"2\""));
        std::fs::write(folder.path().join("tags.json"), "{\"names\":[\"a\"],\"areas\":[1]}")
            .expect("writable");
        assert!(message("2 0 1 2\n").contains("has id 2, names exist for 1 to 1"));
    }
}
