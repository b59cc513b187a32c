//! `tags.toml`: an ordered list of selections.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, ensure};
use program::schema::Format;
use program::table;
use program::table::{Range, Table, each, nested};
use program::{Change, KeyPath, Keys, Misfit, Names, Picked, Settings};

use crate::select::{Cuboid, Plane, Point, Selection, ordered};

const KEYS: Keys = Keys { paths: &["patch", "surface", "volume"], named: &[], meaning: None };

table! {
    /// A tag file.
    #[derive(Debug)]
    pub struct Config {
        /// Selection distance ε, which exceeds the envelope of the mesher [m]. By default 4/3 of the envelope in the report
        /// of the mesher beside the mesh, or without a report 1e-3 diagonals.
        epsilon: Option<f64> = None, Range::POSITIVE.unit("m");
        /// The same as a part of the diagonal [1], instead of `epsilon`.
        relative_epsilon: Option<f64> = None, Range::POSITIVE;
        /// File of the whole model surface, which competes with the patches.
        surface: Option<PathBuf> = None;
        /// Angle at which faces of a file of triangles ended when they were picked [deg]; `make` imports the file with it.
        split: Option<f64> = None, Range::above(0.0).below(180.0).unit("°");
        /// All faces of the model as they were when they were picked, by the names of their files. A `patch` is then the face
        /// that is like it now, whatever its name.
        faces: BTreeMap<String, Picked> = BTreeMap::new();
        /// Parts of the surface, each with one selector; the first that holds a facet wins.
        tag: Vec<Tag> = Vec::new(), each(|tag: &Tag| KeyPath::list("tag").named(&tag.name));
        /// Parts of the body, each with one selector, which have no tetrahedra in common.
        volume: Vec<Volume> = Vec::new(), each(|volume: &Volume| KeyPath::list("volume").named(&volume.name));
    }
}

table! {
    /// A part of the surface.
    #[derive(Debug)]
    pub struct Tag {
        /// Its name, unique in the file.
        name: String, is_named;
        /// The file of an open surface (stl, obj, ply), for facets that lie on it, or a list of files; * in a name stands for
        /// anything.
        patch: Option<Names> = None;
        /// The file of a closed surface (stl, obj, ply), for facets inside it.
        volume: Option<PathBuf> = None;
        /// A plane, for facets on or beyond it.
        plane: Option<Plane> = None, nested;
        /// A box, for facets inside it.
        r#box: Option<Cuboid> = None, ordered;
        /// 0 for the outer skin, 1, 2, ... for closed cavities, largest first.
        component: Option<usize> = None;
        /// A point, for the facet nearest to it and those around it up to edges that are sharper than an angle.
        point: Option<Point> = None, nested;
        /// Whether it is the wall of a chamber.
        pressure: bool = false;
        /// Fixed tags or planes of symmetry that hold the rim of a pressure wall that is open.
        rim: Names = Names::Several(Vec::new());
        /// Whether plugs close a pressure wall that is open, so that nothing need hold its rim.
        plug: bool = false;
        /// Whether the patch is a surface inside the body.
        inside: bool = false;
    }
}

table! {
    /// A part of the body.
    #[derive(Debug)]
    pub struct Volume {
        /// Its name, unique in the file.
        name: String, is_named;
        /// The file of a closed surface (stl, obj, ply), for what is inside it.
        volume: Option<PathBuf> = None;
        /// A plane, for what is on or beyond it.
        plane: Option<Plane> = None, nested;
        /// A box, for what is inside it.
        r#box: Option<Cuboid> = None, ordered;
    }
}

/// The schema of a tag file.
pub const FORMAT: Format = Format::of::<Config>("tags", "tags.toml");

#[allow(clippy::ptr_arg, reason = "the rule of a key of this type")]
fn is_named(at: &KeyPath, name: &String) -> Result<(), Misfit> {
    if name.is_empty() { Err(at.clone().says(" is empty")) } else { Ok(()) }
}

impl Config {
    /// Reads and checks a tag file, with changes from outside.
    pub fn read(path: &Path, changes: &[Change]) -> Result<Self> {
        Settings::read(path, changes, KEYS)?.checked(Self::of)
    }

    fn of(settings: &Settings) -> Result<Self> {
        let config: Self = settings.parse()?;
        config.check_ranges(&KeyPath::default())?;
        ensure!(!config.tag.is_empty(), "no [[tag]]: at least one selection is needed");
        ensure!(
            config.epsilon.is_none() || config.relative_epsilon.is_none(),
            "both `epsilon` and `relative_epsilon`: give one of them"
        );
        let names: Vec<&str> = config.tag.iter().map(|tag| tag.name.as_str()).collect();
        for (i, tag) in config.tag.iter().enumerate() {
            let at = || KeyPath::list("tag").number(i + 1);
            require_unique("tag", &names, i)?;
            tag.check(&names).with_context(at)?;
        }
        let names: Vec<&str> = config.volume.iter().map(|volume| volume.name.as_str()).collect();
        for (i, volume) in config.volume.iter().enumerate() {
            require_unique("volume", &names, i)?;
            volume.selection().with_context(|| KeyPath::list("volume").number(i + 1))?;
        }
        Ok(config)
    }

    /// The selection distance that is given, for a mesh with this diagonal [m].
    pub fn epsilon(&self, diagonal: f64) -> Option<f64> {
        self.epsilon.or(self.relative_epsilon.map(|part| part * diagonal))
    }
}

/// Whether a table of a list has a name of its own.
fn require_unique(list: &str, names: &[&str], i: usize) -> Result<()> {
    let what = format!("the name `{}` of a [[{list}]] is used twice", names[i]);
    let at = KeyPath::list(list).number(i + 1).key("name");
    ensure!(!names[..i].contains(&names[i]), at.told(what));
    Ok(())
}

impl Tag {
    /// What it selects.
    pub fn selection(&self) -> Result<Selection<'_>> {
        Selection::only([
            ("patch", self.patch.as_ref().map(|names| Selection::Patch(names.all()))),
            ("volume", self.volume.as_deref().map(Selection::Volume)),
            ("plane", self.plane.as_ref().map(Selection::Plane)),
            ("box", self.r#box.as_ref().map(Selection::Box)),
            ("component", self.component.map(Selection::Component)),
            ("point", self.point.as_ref().map(Selection::Point)),
        ])
    }

    /// The names of its patches, as the file has them.
    pub fn patches(&self) -> &[String] {
        self.patch.as_ref().map_or(&[], Names::all)
    }

    fn check(&self, names: &[&str]) -> Result<()> {
        self.selection()?;
        let rim = self.rim.all();
        let refused = |key: &str, what: &str| KeyPath::of(key).told(what);
        ensure!(rim.is_empty() || self.pressure, refused("rim", "`rim` needs `pressure = true`"));
        ensure!(
            !self.plug || (self.pressure && rim.is_empty()),
            refused("plug", "`plug = true` is for a wall with `pressure = true` and without `rim`")
        );
        ensure!(
            !self.inside || (self.patch.is_some() && !self.pressure),
            refused("inside", "`inside = true` is for a `patch`, without `pressure`")
        );
        for rim in rim {
            let all = names.join(", ");
            let what = format!("rim = \"{rim}\" is not another tag; tags: {all}");
            let is_other = names.contains(&rim.as_str()) && *rim != self.name;
            ensure!(is_other, refused("rim", &what));
        }
        Ok(())
    }
}

impl Volume {
    /// What it selects.
    pub fn selection(&self) -> Result<Selection<'_>> {
        Selection::only([
            ("volume", self.volume.as_deref().map(Selection::Volume)),
            ("plane", self.plane.as_ref().map(Selection::Plane)),
            ("box", self.r#box.as_ref().map(Selection::Box)),
        ])
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn names_what_is_wrong() {
        let cases = [
            ("", "at least one selection"),
            ("sigma = 1\n", "unknown field `sigma`"),
            ("epsilon = -1.0\n[[tag]]\nname = \"a\"\ncomponent = 0\n", "must be positive"),
            (
                "epsilon = 1\nrelative_epsilon = 1\n[[tag]]\nname = \"a\"\ncomponent = 0\n",
                "give one of them",
            ),
            ("[[tag]]\nname = \"a\"\n", "no selector; one of"),
            ("[[tag]]\nname = \"a\"\ncomponent = 0\npatch = \"a\"\n", "exactly one selector"),
            ("[[tag]]\ncomponent = 0\n", "missing field `name`"),
            (
                "[[tag]]\nname = \"a\"\nbox = { min = [0, 0, 0], max = [1, 1, 0] }\n",
                "[[tag]] \"a\": box: min [0.0, 0.0, 0.0] is not below",
            ),
            (
                "[[tag]]\nname = \"a\"\ncomponent = 0\ninside = true\n",
                "`inside = true` is for a `patch`",
            ),
            ("[[tag]]\nname = \"a\"\ncomponent = 0\nrim = \"b\"\n", "needs `pressure = true`"),
            (
                "[[tag]]\nname = \"a\"\ncomponent = 0\npressure = true\nrim = \"b\"\n",
                "not another tag; tags: a",
            ),
            (
                "[[tag]]\nname = \"a\"\ncomponent = 0\n[[tag]]\nname = \"a\"\ncomponent = 1\n",
                "used twice",
            ),
        ];
        for (text, expected) in cases {
            let message = format!("{:#}", Config::of(&Settings::of_text(text)).unwrap_err());
            assert!(message.contains(expected), "{text:?} gave: {message}");
        }
    }
}
