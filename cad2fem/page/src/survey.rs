//! What a folder holds, told by the files in it and not by its name.

use std::path::{Component, Path, PathBuf};

use anyhow::{Context as _, Result, ensure};

use crate::reported::{Design, Plan, Run, read};

/// Where the parts of a page are; all paths start with the folder that was searched.
#[derive(Clone, Debug, Default)]
pub struct Survey {
    /// What was searched.
    pub folder: PathBuf,
    /// Simulations: `report.json` and states.
    pub runs: Vec<Reported<Run>>,
    /// Optimisations: `history.jsonl`.
    pub designs: Vec<Reported<Design>>,
    /// Plans of molds: `plan.json`.
    pub plans: Vec<Plan>,
    /// Folders of molds: `mold.json`.
    pub molds: Vec<PathBuf>,
    /// Comparisons with measurements: `errors.json`.
    pub validations: Vec<PathBuf>,
    /// Tetrahedral meshes, some of them tagged.
    pub meshes: Vec<PathBuf>,
    /// What programs report of their work.
    pub reports: Vec<PathBuf>,
    /// Results of `fab verify`.
    pub checks: Vec<PathBuf>,
    /// Pictures.
    pub pictures: Vec<PathBuf>,
}

/// A folder of results, and what its report says.
#[derive(Clone, Debug)]
pub struct Reported<T> {
    /// Where it is.
    pub folder: PathBuf,
    /// The report.
    pub report: T,
}

/// A file of a simulation that holds a state.
pub fn is_state(path: &Path) -> bool {
    let name = name(path);
    let step = name.strip_prefix("step_").and_then(|rest| rest.strip_suffix(".vtu"));
    step.is_some() || name == "result.vtu" || name == "not_full_load.vtu"
}

/// The last part of a path.
pub fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

impl Survey {
    /// Looks into a folder and the folders in it.
    pub fn of(folder: &Path) -> Result<Self> {
        let mut found = Self { folder: folder.to_owned(), ..Self::default() };
        found.look(folder)?;
        for below in entries(folder)?.into_iter().filter(|path| path.is_dir()) {
            found.look(&below)?;
        }
        if found.pictures.is_empty() {
            let drawn = |mold: &PathBuf| [mold.join("exploded.png"), mold.join("assembled.png")];
            let drawn = found.molds.iter().flat_map(drawn);
            found.pictures = drawn.filter(|path| path.exists()).collect();
        }
        let known =
            found.runs.len() + found.designs.len() + found.molds.len() + found.validations.len();
        ensure!(
            known > 0,
            "{}: nothing to show: neither it nor a folder in it has report.json with a .vtu file \
             (solver simulate), history.jsonl (solver optimize), mold.json (fab mold) or errors.json (solver validate)",
            folder.display()
        );
        Ok(found)
    }

    /// What the casting sheets say, mold by mold.
    pub fn sheets(&self) -> impl Iterator<Item = PathBuf> {
        self.molds.iter().map(|mold| mold.join("cast.json")).filter(|path| path.exists())
    }

    /// Adds what is in one folder.
    fn look(&mut self, folder: &Path) -> Result<()> {
        let files: Vec<PathBuf> = entries(folder)?.into_iter().filter(|p| p.is_file()).collect();
        let has = |wanted: &str| files.iter().any(|path| name(path) == wanted);
        if has("history.jsonl") {
            self.designs
                .push(Reported { folder: folder.to_owned(), report: Design::read(folder)? });
        } else if has("report.json") && files.iter().any(|path| is_state(path)) {
            let report = read(&folder.join("report.json"))?;
            self.runs.push(Reported { folder: folder.to_owned(), report });
        }
        if has("plan.json") {
            let plan: Plan = read(&folder.join("plan.json"))?;
            // nothing outside of the folder is looked at
            let inside = |f: &&str| {
                let mut parts = Path::new(f).components();
                parts.all(|part| matches!(part, Component::Normal(_) | Component::CurDir))
            };
            let folders = plan.molds.iter().map(|mold| &mold.folder[..]).filter(inside);
            let whole = |f: &str| if f == "." { folder.to_owned() } else { folder.join(f) };
            let folders = folders.map(whole);
            let made: Vec<PathBuf> = folders.filter(|f| f.join("mold.json").exists()).collect();
            self.reports.extend(made.iter().map(|f| f.join("mold.json")));
            self.molds.extend(made);
            self.plans.push(plan);
        }
        for path in files {
            let name = name(&path);
            let extension = path.extension().and_then(|e| e.to_str()).unwrap_or_default();
            if extension == "msh" {
                self.meshes.push(path);
            } else if name == "errors.json" {
                self.validations.push(path);
            } else if name.ends_with("report.json") || name == "model.json" || name == "plan.json" {
                self.reports.push(path);
            } else if name.ends_with(".checks.txt") {
                self.checks.push(path);
            } else if folder.ends_with("pictures") && (extension == "png" || extension == "svg") {
                self.pictures.push(path);
            }
        }
        Ok(())
    }
}

/// The files and folders in a folder, sorted.
pub fn entries(folder: &Path) -> Result<Vec<PathBuf>> {
    let place = || folder.display().to_string();
    let found = std::fs::read_dir(folder).with_context(place)?;
    let mut found: Vec<PathBuf> =
        found.map(|entry| Ok(entry?.path())).collect::<std::io::Result<_>>().with_context(place)?;
    found.sort();
    Ok(found)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    #[test]
    fn folders_are_known_by_what_they_hold() {
        let top = tempfile::tempdir().unwrap();
        let write = |path: &str, text: &str| {
            let path = top.path().join(path);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        };
        let message = Survey::of(top.path()).unwrap_err().to_string();
        assert!(message.contains("nothing to show") && message.contains("history.jsonl"));
        write("a/report.json", "{}");
        assert!(Survey::of(top.path()).is_err(), "a report without a state");
        write("a/step_000.vtu", "");
        write("b/history.jsonl", "");
        write("b/result.vtu", "");
        write("b/report.json", "{}");
        let molds = r#"{"molds": [{"folder": "."}, {"folder": "lid"}, {"folder": "../d"}]}"#;
        write("c/plan.json", molds);
        write("d/mold.json", "{}");
        write("c/lid/mold.json", "{}");
        write("e/errors.json", "{}");
        write("pictures/p.png", "");
        write("model/patches/p.png", "");
        let found = Survey::of(top.path()).unwrap();
        let names = |paths: &[PathBuf]| paths.iter().map(|p| name(p)).collect::<Vec<_>>();
        assert_eq!(found.runs.iter().map(|run| name(&run.folder)).collect::<Vec<_>>(), ["a"]);
        assert_eq!(found.designs.iter().map(|d| name(&d.folder)).collect::<Vec<_>>(), ["b"]);
        assert_eq!(names(&found.molds), ["lid"]);
        assert_eq!(names(&found.validations), ["errors.json"]);
        assert_eq!(names(&found.pictures), ["p.png"]);
        assert!(Survey::of(&top.path().join("nowhere")).is_err());
    }
}
