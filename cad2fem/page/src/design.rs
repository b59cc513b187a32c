//! The history of an optimisation, and the shapes that it has left.
//!
//! `level-N.msh` is the shape that level N began with, `design.msh` the one that the last level
//! ended with; with several bodies there is one file for each, `level-N.BODY.msh`.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use mesh::Vec3;
use mesh::io::read_tets;
use reports::Iteration;
use serde_json::{Value, json};

use crate::Shown;
use crate::reported::{Design, read_lines};
use crate::solid::{Solid, TagsByPlace};
use crate::store::Store;
use crate::survey::{Reported, name};

/// History and shapes of an optimisation.
pub fn packed(found: &Reported<Design>, shown: Shown, store: &mut Store) -> Result<Value> {
    let Reported { folder, report: Design { status, designed } } = found;
    let history: Vec<Iteration> = read_lines(&folder.join("history.jsonl"))?;
    let mut shapes = Vec::new();
    let mut files = shape_files(folder)?;
    if shown == Shown::Last {
        let level = |path: &PathBuf| level_and_part(&name(path)).0;
        let last = files.last().map(level);
        files.retain(|path| Some(level(path)) == last);
    }
    for path in files {
        let file = read_tets(&path)?;
        let mut tags = TagsByPlace::default();
        tags.add(&file, None, &Vec3::zeros());
        let (level, part) = level_and_part(&name(&path));
        shapes.push(json!({
            "file": name(&path),
            "level": level,
            "part": part,
            "body": Solid::of_mesh(&file).packed(&tags, store),
        }));
    }
    Ok(json!({
        "name": name(folder),
        "history": history,
        "shapes": shapes,
        "status": status,
        "levels": designed.as_ref().map(|designed| &designed.levels),
    }))
}

/// Shapes in the order in which they were made.
fn shape_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let place = || folder.display().to_string();
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).with_context(place)? {
        let path = entry.with_context(place)?.path();
        let name = name(&path);
        if name.ends_with(".msh") && (name.starts_with("level-") || name.starts_with("design.")) {
            found.push(path);
        }
    }
    found.sort_by_key(|path| {
        let (level, part) = level_and_part(&name(path));
        (level.unwrap_or(usize::MAX), part)
    });
    Ok(found)
}

/// Level and part of `level-2.gripper.msh`: 2 and `gripper`; of `design.msh`: neither.
fn level_and_part(file: &str) -> (Option<usize>, Option<String>) {
    let stem = file.strip_suffix(".msh").unwrap_or(file);
    let (first, part) = stem.split_once('.').map_or((stem, None), |(a, b)| (a, Some(b.to_owned())));
    (first.strip_prefix("level-").and_then(|n| n.parse().ok()), part)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_of_shapes_tell_level_and_part() {
        let part = |name: &str| Some(name.to_owned());
        assert_eq!(level_and_part("level-12.msh"), (Some(12), None));
        assert_eq!(level_and_part("level-2.left.arm.msh"), (Some(2), part("left.arm")));
        assert_eq!(level_and_part("design.msh"), (None, None));
        assert_eq!(level_and_part("design.gripper.msh"), (None, part("gripper")));
    }
}
