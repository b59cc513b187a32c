//! The files of a folder of results that a reader may want: what a page links to and a package holds.

use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result};
use maud::{Markup, html};
use program::relative;

use crate::survey::{Survey, entries, name};

/// What files are for, in the order in which they are listed: the group, and the ends of their names.
const GROUPS: [(&str, &[&str]); 5] = [
    ("for the printer", &[".3mf", ".stl", ".ini"]),
    ("for the bench", &["cast.html", ".svg", "exploded.png", "assembled.png"]),
    ("numbers", &["curve.csv", "history.jsonl", "pressures.toml", "parameters.toml"]),
    ("what was found", &["report.json", "plan.json", "mold.json", "cast.json", ".checks.txt"]),
    ("the body", &["design.msh", "model.stl", "model.json"]),
];

/// A file that a reader may want.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Content {
    /// Where it is.
    pub path: PathBuf,
    /// What it is for.
    pub group: &'static str,
}

/// All files that a reader may want, sorted by group and then by path.
pub fn all(survey: &Survey) -> Result<Vec<Content>> {
    let mut paths: Vec<(usize, PathBuf)> = Vec::new();
    let mut add = |folder: &Path, wanted: &dyn Fn(usize, &str) -> bool| -> Result<()> {
        for path in entries(folder)?.into_iter().filter(|path| path.is_file()) {
            let name = name(&path);
            let group = GROUPS.iter().position(|(_, ends)| ends.iter().any(|e| name.ends_with(e)));
            paths.extend(group.filter(|&g| wanted(g, &name)).map(|g| (g, path)));
        }
        Ok(())
    };
    add(&survey.folder, &|group, _| group != 0)?;
    let runs = survey.runs.iter().map(|run| &run.folder);
    for folder in runs.chain(survey.designs.iter().map(|design| &design.folder)) {
        // of a folder of results no pictures and surfaces
        add(folder, &|group, _| group >= 2)?;
    }
    for folder in &survey.molds {
        add(folder, &|_, _| true)?;
        if folder.join("reference").is_dir() {
            add(&folder.join("reference"), &|group, _| group == 0)?;
        }
    }
    for report in survey.reports.iter().filter(|path| name(path) == "model.json") {
        add(parent(report)?, &|_, name| name.starts_with("model."))?;
    }
    for plan in survey.reports.iter().filter(|path| name(path) == "plan.json") {
        add(parent(plan)?, &|group, _| group != 0)?;
    }
    for path in &survey.checks {
        paths.push((3, path.clone()));
    }
    // surfaces that are not to be printed are of the body
    for (group, path) in &mut paths {
        if name(path) == "model.stl" || path.parent().is_some_and(|p| p.ends_with("reference")) {
            *group = GROUPS.len() - 1;
        }
    }
    paths.sort_unstable();
    paths.dedup();
    Ok(paths.into_iter().map(|(g, path)| Content { path, group: GROUPS[g].0 }).collect())
}

fn parent(path: &Path) -> Result<&Path> {
    path.parent().with_context(|| path.display().to_string())
}

/// Links to all of them from a page that lies at `page`, with their sizes.
pub fn links(survey: &Survey, page: &Path) -> Result<Markup> {
    let all = all(survey)?;
    let here = page.parent().filter(|p| !p.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let link = |path: &Path| {
        let seen = system::portable(path.strip_prefix(&survey.folder).unwrap_or(path));
        let size = std::fs::metadata(path).map_or(0, |m| m.len());
        html! { a href=(address(&relative(path, here))) { (seen) } " " span.size { (bytes(size)) } }
    };
    Ok(html! {
        @if !all.is_empty() {
            section #files {
                h2 { "Files" }
                p { "The links lead to files beside this page: keep it in its folder." }
                @for (group, _) in GROUPS {
                    @let of = || all.iter().filter(|c| c.group == group);
                    @if of().next().is_some() {
                        h3 { (group) }
                        ul.files { @for content in of() { li { (link(&content.path)) } } }
                    }
                }
            }
        }
    })
}

/// A relative address, in which nothing but the slash has a meaning.
fn address(path: &Path) -> String {
    let mut address = String::from("./");
    for byte in path.to_string_lossy().bytes() {
        match byte {
            b'a'..=b'z' | b'A'..=b'Z' | b'0'..=b'9' | b'.' | b'_' | b'~' | b'-' | b'/' => {
                address.push(char::from(byte));
            }
            _ => address += &format!("%{byte:02X}"),
        }
    }
    address
}

/// A size as people read it.
fn bytes(size: u64) -> String {
    match size {
        0..1_000 => format!("{size} B"),
        1_000..1_000_000 => format!("{:.0} kB", size as f64 / 1e3),
        _ => format!("{:.1} MB", size as f64 / 1e6),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn addresses_lead_nowhere_else() {
        assert_eq!(address(Path::new("mold/a b.stl")), "./mold/a%20b.stl");
        assert_eq!(address(Path::new("javascript:alert(1)")), "./javascript%3Aalert%281%29");
        assert_eq!(address(Path::new("\"><b>?#")), "./%22%3E%3Cb%3E%3F%23");
    }
}
