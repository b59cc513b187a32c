//! A `tags.toml` that exists, with which the page begins.
//!
//! The page shows tags that are made of faces of the body. All else that the file holds is kept as it
//! is written, and goes into the file that the page saves.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use anyhow::{Context as _, Result, bail, ensure};
use program::{KeyPath, Keys, Names, Picked, Recognized, Settings, fits, misfit, read_table};
use serde::{Deserialize, Serialize};
use toml::{Table, Value};

use super::body::Body;

/// The surface of the model, as the page names it.
const SURFACE: &str = "../model.stl";

/// The number that the page has for a face without a tag.
const NONE: i64 = -1;

/// What the page begins with.
#[derive(Clone, Debug, Default, Serialize)]
pub struct Given {
    /// Tags in the order of the file.
    pub list: Vec<Tag>,
    /// Number of the tag of each face, or -1.
    pub of: Vec<i64>,
    /// Lines that go before all tags.
    pub head: String,
    /// Tables that go behind all tags.
    pub tail: String,
    /// What a person should know of it.
    pub remarks: Vec<String>,
}

/// A tag as the page has it.
#[derive(Clone, Debug, Serialize)]
pub struct Tag {
    /// What people call it.
    pub name: String,
    /// Whether it is the wall of a chamber.
    pub chamber: bool,
    /// Whether plugs close that chamber.
    pub plug: bool,
    /// The table as TOML, if the page cannot show what the tag selects.
    pub kept: Option<String>,
    /// Names of such tags among those that hold its opening.
    pub rim: Vec<String>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    epsilon: Option<Value>,
    relative_epsilon: Option<Value>,
    surface: Option<String>,
    /// The page has that of the body.
    #[serde(rename = "split")]
    _split: Option<Value>,
    #[serde(default)]
    faces: BTreeMap<String, Picked>,
    #[serde(default)]
    tag: Vec<Table>,
    #[serde(default)]
    volume: Vec<Table>,
}

/// What the page reads of a `[[tag]]` whose patches are faces.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Faces {
    name: String,
    patch: Names,
    #[serde(default)]
    pressure: bool,
    #[serde(default)]
    rim: Option<Names>,
    #[serde(default)]
    plug: bool,
    #[serde(default)]
    inside: bool,
}

impl Given {
    /// Reads a tag file for a body.
    pub fn read(path: &Path, body: &Body) -> Result<Self> {
        let settings = Settings::read(path, &[], Keys::default())?;
        settings.checked(|settings| Self::of(settings.parse()?, body))
    }

    fn of(file: File, body: &Body) -> Result<Self> {
        let mut given = Self { of: vec![NONE; body.faces.len()], ..Self::default() };
        let recognized = Recognized::new(&file.faces, body.measured());
        let mut rims = Vec::new();
        for (i, table) in file.tag.into_iter().enumerate() {
            let at = || KeyPath::list("tag").number(i + 1);
            let name = name_of(&table).with_context(at)?;
            ensure!(
                given.list.iter().all(|tag| tag.name != name),
                at().key("name").told(format!("the name `{name}` is used twice"))
            );
            let shown = || format!("[[tag]] `{name}` cannot be shown");
            let rim =
                given.add(table, body, &recognized).map_err(|what| at().around(shown(), &what))?;
            rims.push(rim);
        }
        ensure!(!given.list.is_empty(), "no [[tag]]: there is nothing to begin with");
        for (tag, rim) in rims.into_iter().enumerate() {
            given.hold(tag, rim, body);
        }
        given.remark_on_faces(&recognized, body);
        for (key, value) in [("epsilon", file.epsilon), ("relative_epsilon", file.relative_epsilon)]
        {
            given.head.extend(value.map(|value| format!("{key} = {value}\n")));
        }
        if let Some(other) = file.surface.filter(|surface| surface != SURFACE) {
            given.remarks.push(format!("surface = {other:?} of the file becomes {SURFACE:?}."));
        }
        for volume in &file.volume {
            given.remarks.push(format!("[[volume]] {} is kept as it is.", name_of(volume)?));
            given.tail += &format!("\n{}", written("volume", volume)?);
        }
        Ok(given)
    }

    /// Says which faces may be others than those that were picked, and which are new.
    fn remark_on_faces(&mut self, recognized: &Recognized, body: &Body) {
        let tag_of = |file: &str| {
            let face = body.faces.iter().position(|face| face.file.as_deref() == Some(file));
            face.and_then(|face| usize::try_from(self.of[face]).ok())
        };
        let doubted = recognized.doubts().into_iter().filter_map(|(name, doubt)| {
            let tag = tag_of(recognized.file(name).ok()?)?;
            Some(format!("{} may mean another face now: {doubt}.", self.list[tag].name))
        });
        let mut found: Vec<String> = doubted.collect();
        let new = recognized.new_faces(|file| tag_of(file).is_some());
        found.extend(new.map(|new| format!("{new}.")));
        self.remarks.extend(found);
    }

    /// Adds a tag, and gives its faces to it which no tag before it has; returns its rim. A face that is not there any
    /// more is told.
    fn add(&mut self, table: Table, body: &Body, recognized: &Recognized) -> Result<Vec<String>> {
        if !has_faces(&table) {
            let kept = Some(written("tag", &table)?);
            let chamber = table.get("pressure").and_then(Value::as_bool).unwrap_or(false);
            let name = name_of(&table)?;
            self.list.push(Tag { name, chamber, plug: false, kept, rim: Vec::new() });
            return Ok(Vec::new());
        }
        let Faces { name, patch, pressure, rim, plug, inside } = read_table(&table)?;
        let own = i64::try_from(self.list.len())?;
        for pattern in patch.all() {
            let file = match recognized.file(pattern) {
                Ok(file) => file,
                Err(gone) => {
                    self.remarks.push(format!("{name}: {gone}."));
                    continue;
                }
            };
            for face in faces(file, body)? {
                ensure!(
                    body.faces[face].inside == inside,
                    misfit!(
                        KeyPath::of("inside"),
                        " = {inside}, and {} lies {} the body",
                        body.faces[face].name,
                        if inside { "on" } else { "in" }
                    )
                );
                if self.of[face] == NONE {
                    self.of[face] = own;
                }
            }
        }
        self.list.push(Tag { name, chamber: pressure, plug, kept: None, rim: Vec::new() });
        Ok(rim.map_or_else(Vec::new, |rim| rim.all().to_vec()))
    }

    /// What holds the opening of a chamber: the page finds tags around its faces by itself.
    fn hold(&mut self, tag: usize, rim: Vec<String>, body: &Body) {
        if self.list[tag].kept.is_some() || !self.list[tag].chamber || self.list[tag].plug {
            return;
        }
        let kept = |name: &String| self.list.iter().any(|t| t.kept.is_some() && t.name == *name);
        let (kept, shown): (Vec<String>, Vec<String>) = rim.into_iter().partition(kept);
        let around = self.around(tag, body);
        if shown.iter().map(String::as_str).collect::<BTreeSet<_>>() != around {
            let list =
                |names: Vec<&str>| if names.is_empty() { "none".into() } else { names.join(", ") };
            let (from, to) = (
                list(shown.iter().map(String::as_str).collect()),
                list(around.into_iter().collect()),
            );
            let name = &self.list[tag].name;
            self.remarks.push(format!("The rim of {name} was {from}; by its faces it is {to}."));
        }
        self.list[tag].rim = kept;
    }

    /// Names of the tags whose faces meet those of one.
    fn around(&self, tag: usize, body: &Body) -> BTreeSet<&str> {
        let own = |face: usize| usize::try_from(self.of[face]).ok();
        let other = |[a, b]: [usize; 2]| match (own(a), own(b)) {
            (Some(a), Some(b)) if a == tag && b != tag => Some(b),
            (Some(a), Some(b)) if b == tag && a != tag => Some(a),
            _ => None,
        };
        let found = body.borders.iter().filter_map(|border| other(border.faces));
        found.map(|i| self.list[i].name.as_str()).collect()
    }
}

fn name_of(table: &Table) -> Result<String> {
    let name = table.get("name").and_then(Value::as_str).filter(|name| !name.is_empty());
    Ok(name.context("`name` is missing")?.to_owned())
}

/// Whether a tag is made of patches in the folder of the body.
fn has_faces(table: &Table) -> bool {
    let plain = |value: &Value| value.as_str().is_some_and(|name| !name.contains(['/', '\\']));
    match table.get("patch") {
        Some(Value::Array(names)) => names.iter().all(plain),
        Some(name) => plain(name),
        None => false,
    }
}

/// The faces whose files a pattern means.
fn faces(pattern: &str, body: &Body) -> Result<Vec<usize>> {
    let files = body.faces.iter().enumerate();
    let files = files.filter_map(|(i, face)| Some((i, face.file.as_deref()?)));
    let found: Vec<usize> =
        files.clone().filter(|(_, file)| fits(file, pattern)).map(|(i, _)| i).collect();
    if found.is_empty() {
        let names: Vec<&str> = files.map(|(_, file)| file).collect();
        bail!(KeyPath::word(pattern).told(format!(
            "no face of {} is called {pattern}; it has {} faces: {}; load the tags with the body that \
             they are of",
            body.source,
            names.len(),
            names.join(", ")
        )));
    }
    Ok(found)
}

/// A table of a list as TOML, with its name first and each value on one line.
fn written(list: &str, table: &Table) -> Result<String> {
    let bare = |key: &str| key.chars().all(|c| c.is_ascii_alphanumeric() || "_-".contains(c));
    if let Some(key) = table.keys().find(|key| !bare(key)) {
        bail!("unknown key {key:?}");
    }
    let name = table.get_key_value("name");
    let others = table.iter().filter(|(key, _)| *key != "name");
    let lines = name.into_iter().chain(others).map(|(key, value)| format!("{key} = {value}\n"));
    Ok(format!("[[{list}]]\n{}", lines.collect::<String>()))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::body::tests::{body_with_air, hollow};
    use super::*;

    fn given(text: &str, body: &Body) -> Result<Given> {
        Given::of(Settings::of_text(text).parse()?, body)
    }

    #[test]
    fn tags_of_faces_are_shown_and_all_else_is_kept() {
        let folder = hollow();
        let body = Body::read(folder.path()).unwrap();
        let text = "epsilon = 2e-4\nsurface = \"../model.stl\"\n\
            [[tag]]\nname = \"seat\"\nplane = { point = [0, 0, 0], normal = [-1, 0, 0] }\n\
            [[tag]]\nname = \"air\"\npatch = [\"f6.stl\", \"f7.stl\", \"f8.stl\", \"f9.stl\", \"f1*.stl\"]\n\
            pressure = true\nrim = [\"seat\", \"skin\"]\n\
            [[tag]]\nname = \"skin\"\npatch = \"f*.stl\"\n\
            [[volume]]\nname = \"stiff\"\nbox = { min = [0, 0, 0], max = [1e-2, 1, 1] }\n";
        let found = given(text, &body).unwrap();
        assert_eq!(found.of, [2, 1, 2, 2, 2, 2, 1, 1, 1, 1, 1, 1], "the first that has it");
        assert_eq!(found.head, "epsilon = 0.0002\n");
        let kept = found.list[0].kept.as_deref().unwrap();
        assert_eq!(
            kept,
            "[[tag]]\nname = \"seat\"\nplane = { normal = [-1, 0, 0], point = [0, 0, 0] }\n"
        );
        assert!(
            found.tail.starts_with("\n[[volume]]\nname = \"stiff\"\nbox = {"),
            "{}",
            found.tail
        );
        assert_eq!(
            (found.list[1].chamber, &found.list[1].rim[..]),
            (true, &["seat".to_owned()][..])
        );
        // f1 lies outside, among faces of the skin
        assert_eq!(found.remarks, ["[[volume]] stiff is kept as it is."]);
    }

    #[test]
    fn faces_are_found_by_what_they_measure() {
        let folder = hollow();
        let body = Body::read(folder.path()).unwrap();
        let line = |(name, face): &(String, mesh::faces::Face), shift: f64| {
            let (middle, normal) = (face.middle + mesh::Vec3::x() * shift, face.normal);
            format!(
                "\"old-{name}\" = {{ area = {}, middle = {:?}, normal = {:?} }}\n",
                face.area,
                middle.as_slice(),
                normal.as_slice()
            )
        };
        let measured = body.measured();
        assert!(measured.iter().all(|(_, face)| face.beside.len() == 4));
        let lines: String = measured[..11].iter().map(|face| line(face, 0.0)).collect();
        let far = line(&measured[11], 1.0);
        let text = format!(
            "split = 40\n[[tag]]\nname = \"seat\"\npatch = \"old-f3.stl\"\n\
             [[tag]]\nname = \"lost\"\npatch = [\"old-f11.stl\", \"f4.stl\"]\n[faces]\n{lines}{far}"
        );
        let found = given(&text, &body).unwrap();
        assert_eq!((found.of[3], found.of[4], found.of[11]), (0, 1, NONE));
        let remarks = found.remarks.join("\n");
        assert!(remarks.contains("lost: no face is like old-f11.stl any more"), "{remarks}");
        assert!(remarks.contains("have no tag: f11.stl of"), "{remarks}");
    }

    #[test]
    fn another_rim_and_another_surface_are_told() {
        let folder = body_with_air(-5.0);
        let body = Body::read(folder.path()).unwrap();
        let lid = body.faces.iter().position(|f| f.normal == Some(-mesh::Vec3::x())).unwrap();
        let text = format!(
            "surface = \"skin.stl\"\n[[tag]]\nname = \"seat\"\npatch = \"f{lid}.stl\"\n\
             [[tag]]\nname = \"rest\"\npatch = \"f*.stl\"\npressure = true\n"
        );
        let found = given(&text, &body).unwrap();
        let expected = [
            "The rim of rest was none; by its faces it is seat.",
            "surface = \"skin.stl\" of the file becomes \"../model.stl\".",
        ];
        assert_eq!(found.remarks, expected);
    }

    #[test]
    fn what_is_not_of_the_body_is_refused_with_its_faces() {
        let folder = hollow();
        let body = Body::read(folder.path()).unwrap();
        let tag = |more: &str| format!("[[tag]]\nname = \"seat\"\n{more}\n");
        for (text, expected) in [
            (String::new(), "no [[tag]]"),
            ("fixed = 1\n".into(), "unknown field `fixed`"),
            ("[[tag]]\npatch = \"f1.stl\"\n".into(), "`name` is missing"),
            (tag("patch = \"face-9.stl\""), "it has 12 faces: f0.stl, f1.stl"),
            (tag("patch = \"f1.stl\"\nbox = 1"), "unknown field `box`"),
            (tag("patch = \"f1.stl\"\ninside = true"), "f1 lies on the body"),
            (tag("patch = \"f1.stl\"").repeat(2), "`seat` is used twice"),
        ] {
            let error = format!("{:#}", given(&text, &body).unwrap_err());
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
