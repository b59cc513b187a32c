//! Files in TOML: with what they include, what was set from outside, and errors with their place.
//!
//! Each file, and each `--set`, is a [`Source`]. The sources lie one after the other in one
//! imaginary text, so that the range of a key or value says from which of them it came.

mod change;
mod key_path;
mod magnitude;
mod merge;
mod place;
mod reading;
mod version;

use std::ops::Range;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, bail, ensure};
use mesh::io::read_text;
use serde::Deserialize as _;
use serde::de::DeserializeOwned;
use toml::Spanned;
use toml::de::{DeTable, DeValue, Deserializer};

pub use change::{Change, Changes};
pub use key_path::{KeyPath, Meaning, Misfit};
pub use reading::{read_key, read_table};
pub use version::VERSION;

use crate::InputFile;

/// How deep files may include each other, and how many there may be.
const DEPTH: usize = 8;
const MOST_FILES: usize = 100;

/// Endings of files that are given in place of settings by mistake.
const SHAPES: [&str; 10] = ["msh", "stl", "obj", "ply", "off", "3mf", "vtu", "step", "stp", "geo"];

/// What a format says of its keys, besides their types.
#[derive(Clone, Copy, Debug, Default)]
pub struct Keys {
    /// Keys whose values are paths, relative to the file that has them.
    pub paths: &'static [&'static str],
    /// Tables whose keys are names that people choose: `--set` replaces values there, and adds none.
    pub named: &'static [&'static str],
    /// What errors of crates that know no settings mean.
    pub meaning: Option<Meaning>,
}

/// A file as it was read. What it holds is [`Settings::parse`]d from it.
#[derive(Clone, Debug)]
pub struct Settings {
    keys: Keys,
    /// What was included, in the order of reading; the file; what was set.
    sources: Vec<Source>,
    /// Index of the file.
    own: usize,
    /// Values that a program gives, in place of all texts.
    values: Option<toml::Table>,
}

/// A text that settings come from.
#[derive(Clone, Debug)]
struct Source {
    origin: Origin,
    text: String,
    /// Where it begins in the imaginary text.
    start: usize,
    sha256: String,
}

impl Source {
    /// The range in the imaginary text, with a place behind its end.
    fn range(&self) -> Range<usize> {
        self.start..self.start + self.text.len() + 1
    }
}

#[derive(Clone, Debug)]
enum Origin {
    File {
        path: PathBuf,
        /// The folder, as seen from that of the file that was asked for.
        folder: PathBuf,
        /// What it includes.
        includes: Vec<usize>,
    },
    Change(Change),
}

impl Settings {
    /// Reads a file and all that it includes, with changes from outside.
    pub fn read(path: &Path, changes: &[Change], keys: Keys) -> Result<Self> {
        let mut settings = Self { keys, sources: Vec::new(), own: 0, values: None };
        settings.own = settings.add_file(path, Path::new(""), &mut Vec::new())?;
        for change in changes {
            settings.add(Origin::Change(change.clone()), change.text());
        }
        settings.require_use()?;
        Ok(settings)
    }

    /// A text in place of a file.
    ///
    /// It includes nothing.
    pub fn of_text(text: &str) -> Self {
        let mut settings =
            Self { keys: Keys::default(), sources: Vec::new(), own: 0, values: None };
        let origin =
            Origin::File { path: PathBuf::new(), folder: PathBuf::new(), includes: Vec::new() };
        settings.add(origin, text);
        settings
    }

    /// Values that a program gives: errors have the keys that lead there, and no line. They include no files.
    pub fn of_values(mut values: toml::Table, keys: Keys) -> Result<Self> {
        if let Some(version) = values.remove("puffer") {
            version::check(version.as_str()).map_err(Placed)?;
        }
        Ok(Self { keys, values: Some(values), ..Self::of_text("") })
    }

    /// Everything as a `T`.
    pub fn parse<T: DeserializeOwned>(&self) -> Result<T> {
        let read = |table| magnitude::check(table).and_then(|()| read_table(table));
        if let Some(values) = &self.values {
            return read(values).map_err(|misfit| Placed(in_words(&misfit)).into());
        }
        let tree = self.tree()?;
        let root = Spanned::new(self.whole(), tree.clone());
        let table = toml::Table::deserialize(Deserializer::from(root))
            .map_err(|error| self.refused(error.message(), error.span()))?;
        read(&table).map_err(|misfit| {
            self.refused(&misfit.to_string(), place::of_path(&tree, &misfit.path))
        })
    }

    /// What `read` makes of it; its errors have their place, as for [`Settings::place`].
    pub fn checked<T>(&self, read: impl FnOnce(&Self) -> Result<T>) -> Result<T> {
        read(self).map_err(|error| self.place(error))
    }

    /// An error in what the settings mean, with its place: that of the [`KeyPath`]s that it carries.
    pub fn place(&self, error: anyhow::Error) -> anyhow::Error {
        if error.chain().any(|cause| cause.is::<Placed>() || cause.is::<crate::Unusable>()) {
            return error;
        }
        let misfit = KeyPath::told_by(&error, self.keys.meaning);
        if self.values.is_some() {
            return Placed(misfit.to_string()).into();
        }
        let (text, name) = (misfit.to_string(), self.name_of(self.own));
        let what = text.strip_prefix(&format!("{name}: ")).unwrap_or(&text);
        match self.tree().ok().and_then(|tree| place::of_path(&tree, &misfit.path)) {
            Some(place) => self.refused(what, Some(place)),
            None if name.is_empty() || text.contains(&name) => error,
            None => error.context(name),
        }
    }

    /// What states depend on: the hash of the file, those of what it includes, and the changes.
    pub fn hash(&self) -> String {
        if let Some(values) = &self.values {
            return crate::sha256(values.to_string().as_bytes());
        }
        let mut all = vec![self.sources[self.own].sha256.clone()];
        for (i, source) in self.sources.iter().enumerate() {
            match &source.origin {
                Origin::File { .. } if i == self.own => {}
                Origin::File { .. } => all.push(source.sha256.clone()),
                Origin::Change(change) => all.push(change.text().to_owned()),
            }
        }
        // alone as it was before files could include others
        if all.len() == 1 { all.remove(0) } else { crate::sha256(all.join("\n").as_bytes()) }
    }

    /// The file itself, as it was given.
    pub fn file(&self) -> InputFile {
        self.file_hash(self.own).expect("it is a file")
    }

    /// What it includes, as seen from the working directory.
    pub fn included(&self) -> Vec<InputFile> {
        (0..self.sources.len())
            .filter(|i| *i != self.own)
            .filter_map(|i| self.file_hash(i))
            .collect()
    }

    /// What was set from outside, as it was written.
    pub fn changes(&self) -> Vec<String> {
        let change = |source: &Source| match &source.origin {
            Origin::Change(change) => Some(change.to_string()),
            Origin::File { .. } => None,
        };
        self.sources.iter().filter_map(change).collect()
    }

    fn file_hash(&self, index: usize) -> Option<InputFile> {
        let source = &self.sources[index];
        let Origin::File { path, .. } = &source.origin else { return None };
        Some(InputFile { path: path.clone(), sha256: source.sha256.clone() })
    }

    fn add(&mut self, origin: Origin, text: &str) -> usize {
        let start = self.sources.last().map_or(0, |last| last.range().end);
        let sha256 = crate::sha256(text.as_bytes());
        let text = text.trim_start_matches('\u{feff}').to_owned();
        self.sources.push(Source { origin, text, start, sha256 });
        self.sources.len() - 1
    }

    /// Reads a file after all that it includes. `above` are those that include it.
    fn add_file(&mut self, path: &Path, folder: &Path, above: &mut Vec<PathBuf>) -> Result<usize> {
        ensure!(
            self.sources.len() < MOST_FILES,
            "{MOST_FILES} files are included, no more are read"
        );
        let extension = mesh::io::extension(path);
        ensure!(
            !SHAPES.contains(&extension.as_str()),
            "{}: a .{extension} file is a shape or a mesh, and a file with settings is needed here, \
             such as sim.toml",
            path.display()
        );
        let text = read_text(path)?;
        // such as the environment of a process, of which nothing is shown
        ensure!(
            !text.contains('\0'),
            "{}: it has characters without meaning (NUL), and a file with settings is needed here",
            path.display()
        );
        let canonical = system::canonical(path).with_context(|| path.display().to_string())?;
        ensure!(
            !above.contains(&canonical) && above.len() < DEPTH,
            "{}: included by itself, or {DEPTH} files deep",
            path.display()
        );
        above.push(canonical);
        let mut includes = Vec::new();
        for name in included(&text) {
            let beside = path.parent().unwrap_or(Path::new("")).join(&name);
            let there = match name.parent() {
                Some(parent) if parent.is_absolute() => parent.to_path_buf(),
                Some(parent) => folder.join(parent),
                None => folder.to_path_buf(),
            };
            let index = self.add_file(&beside, &there, above);
            includes.push(index.with_context(|| format!("{}: include", path.display()))?);
        }
        above.pop();
        let origin = Origin::File { path: path.into(), folder: folder.into(), includes };
        Ok(self.add(origin, &text))
    }

    /// Range of everything.
    fn whole(&self) -> Range<usize> {
        0..self.sources.last().map_or(0, |last| last.range().end)
    }

    /// The file over what it includes, with the changes.
    fn tree(&self) -> Result<DeTable<'_>> {
        let mut tree = self.file_tree(self.own)?;
        for source in &self.sources {
            if let Origin::Change(change) = &source.origin {
                let (path, value) = change
                    .parsed(&source.text, source.start)
                    .map_err(|what| self.refused(&what, Some(source.range())))?;
                change::apply(&mut tree, &path, value, self.keys.named)
                    .map_err(|(what, span)| self.refused(&what, Some(span)))?;
            }
        }
        Ok(tree)
    }

    fn file_tree(&self, index: usize) -> Result<DeTable<'_>> {
        let source = &self.sources[index];
        let start = source.start;
        let own = DeTable::parse(&source.text).map_err(|error| {
            let span = error.span().map(|span| start + span.start..start + span.end);
            self.refused(error.message(), span)
        })?;
        let mut own = merge::shifted(own.into_inner(), start);
        let Origin::File { folder, includes, .. } = &source.origin else { bail!("not a file") };
        if let Some(version) = own.remove("puffer") {
            version::check(version.get_ref().as_str())
                .map_err(|what| self.refused(&what, Some(version.span())))?;
        }
        if let Some(include) = own.remove("include") {
            paths(&include).map_err(|what| self.refused(&what, Some(include.span())))?;
        }
        if !folder.as_os_str().is_empty() {
            merge::move_paths(&mut own, self.keys.paths, folder);
        }
        let mut tree = DeTable::new();
        for include in includes {
            merge::overlay(&mut tree, self.file_tree(*include)?, &|span| self.is_inline(span));
        }
        merge::overlay(&mut tree, own, &|span| self.is_inline(span));
        Ok(tree)
    }

    /// Refuses a file of which nothing is used: who includes it expects otherwise.
    fn require_use(&self) -> Result<()> {
        let tree = self.tree()?;
        for (i, source) in self.sources.iter().enumerate() {
            let Origin::File { path, .. } = &source.origin else { continue };
            let again = self.sources[i + 1..].iter().any(|s| s.sha256 == source.sha256);
            if i != self.own
                && !again
                && has_own(&source.text)
                && !merge::uses(&tree, &source.range())
            {
                let (own, other) = (self.name_of(self.own), path.display());
                bail!(
                    "{own}: nothing of {other} is used, as {own} or a later file gives all of it \
                     again: take it out there, or include both in a third file, {other} last"
                );
            }
        }
        Ok(())
    }

    fn is_inline(&self, span: &Range<usize>) -> bool {
        let source = self.source_at(span.start);
        let text = source.and_then(|source| source.text.get(span.start - source.start..));
        text.is_some_and(|text| text.starts_with('{'))
    }

    fn source_at(&self, position: usize) -> Option<&Source> {
        self.sources.iter().rev().find(|source| source.start <= position)
    }

    fn name_of(&self, index: usize) -> String {
        match &self.sources[index].origin {
            Origin::File { path, .. } => path.display().to_string(),
            Origin::Change(change) => format!("--set {change}"),
        }
    }

    /// The error at a place.
    fn refused(&self, what: &str, place: Option<Range<usize>>) -> anyhow::Error {
        let found = place.and_then(|place| Some((self.source_at(place.start)?, place)));
        let Some((source, place)) = found else {
            let name = self.name_of(self.own);
            let what = what.trim_end();
            let named = if name.is_empty() { what.into() } else { format!("{name}: {what}") };
            return Placed(named).into();
        };
        let text = source.text.as_str();
        let place = place.start - source.start..place.end.saturating_sub(source.start);
        match &source.origin {
            Origin::File { path, .. } => {
                Placed(place::shown(&path.display().to_string(), text, place, what)).into()
            }
            Origin::Change(change) => {
                let name = format!("{}: --set {change}", self.name_of(self.own));
                let mut shown = place::shown_alone(&name, text, place, what);
                if self.keys.paths.contains(&"scene") {
                    shown += &format!("\n  for a key of its scene: --set scene.{change}");
                }
                Placed(shown).into()
            }
        }
    }
}

/// An error that says where it is.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
struct Placed(String);

/// A message with the keys in front, which some messages name themselves.
fn in_words(misfit: &Misfit) -> String {
    let (keys, text) = (misfit.path.words(), misfit.to_string());
    match keys.is_empty() || text.starts_with('[') {
        true => text,
        false => format!("{keys}: {text}"),
    }
}

/// Keys of every file.
const OWN_KEYS: [&str; 2] = ["puffer", "include"];

/// Whether a text has keys besides those of every file.
fn has_own(text: &str) -> bool {
    let keys = |tree: &DeTable| tree.keys().any(|key| !OWN_KEYS.contains(&key.get_ref().as_ref()));
    DeTable::parse(text).is_ok_and(|tree| keys(tree.get_ref()))
}

/// The files that a text includes; none of one that is no TOML, which is refused later.
fn included(text: &str) -> Vec<PathBuf> {
    let tree = DeTable::parse(text).ok();
    let value = tree.as_ref().and_then(|tree| tree.get_ref().get("include"));
    value.and_then(|value| paths(value).ok()).unwrap_or_default()
}

fn paths(include: &Spanned<DeValue>) -> Result<Vec<PathBuf>, String> {
    let path = |value: &DeValue| value.as_str().map(PathBuf::from);
    let found = match include.get_ref() {
        DeValue::Array(list) => list.iter().map(|item| path(item.get_ref())).collect(),
        one => path(one).map(|path| vec![path]),
    };
    found.ok_or_else(|| "include: expected the name of a file, or a list of names".to_owned())
}

/// Reads a file in TOML that takes no changes.
pub fn read_toml<T: DeserializeOwned>(path: &Path) -> Result<T> {
    Settings::read(path, &[], Keys::default())?.parse()
}

#[cfg(test)]
mod tests;
