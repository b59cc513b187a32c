//! `tags.toml`: an ordered list of selections.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use anyhow::{Context as _, Result, anyhow, bail, ensure};
use program::schema::{Format, add_keys, one_of};
use program::table;
use program::table::{Range, Table};
use program::{Change, KeyPath, Keys, Misfit, Picked, Settings, read_key, unknown};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::select::{Entry, SELECTORS};

/// Keys of a `[[tag]]` besides the selectors.
const TAG_KEYS: [&str; 5] = ["name", "pressure", "rim", "plug", "inside"];

/// Keys of a `[[volume]]` besides the selectors.
const VOLUME_KEYS: [&str; 1] = ["name"];

const KEYS: Keys = Keys { paths: &["patch", "surface", "volume"], named: &[], meaning: None };

/// A tag file.
#[derive(Debug)]
pub struct Config {
    /// Selection distance ε, if the file gives one.
    pub epsilon: Option<Epsilon>,
    /// File of the whole model surface, which competes with the patches.
    pub surface: Option<PathBuf>,
    /// Selections; the first that holds a facet wins.
    pub tags: Vec<Tag>,
    /// Selections of tetrahedra, which have none in common.
    pub volumes: Vec<Volume>,
    /// The faces of the model when they were picked, by the names of their files.
    pub faces: BTreeMap<String, Picked>,
}

/// One `[[volume]]`.
#[derive(Debug)]
pub struct Volume {
    /// Name, unique in the file.
    pub name: String,
    /// Key of the selector, a row of [`SELECTORS`].
    pub selector: &'static str,
    /// Value of that key.
    pub value: toml::Value,
}

/// Selection distance ε, which must exceed the envelope of the mesher.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Epsilon {
    /// A length [m].
    Absolute(f64),
    /// A part of the diagonal of the bounding box of the mesh.
    Relative(f64),
}

impl Epsilon {
    /// The distance for a mesh with this diagonal [m].
    pub fn length(self, diagonal: f64) -> f64 {
        match self {
            Self::Absolute(length) => length,
            Self::Relative(part) => part * diagonal,
        }
    }

    fn of(file: &File) -> Result<Option<Self>> {
        match (file.epsilon, file.relative_epsilon) {
            (Some(_), Some(_)) => bail!("both `epsilon` and `relative_epsilon`: give one of them"),
            (Some(length), None) => Ok(Some(Self::Absolute(length))),
            (None, Some(part)) => Ok(Some(Self::Relative(part))),
            (None, None) => Ok(None),
        }
    }
}

/// One `[[tag]]`.
#[derive(Debug)]
pub struct Tag {
    /// Name, unique in the file.
    pub name: String,
    /// Key of the selector, a row of [`SELECTORS`].
    pub selector: &'static str,
    /// Value of that key.
    pub value: toml::Value,
    /// Whether this is the wall of a pressurised cavity.
    pub pressure: bool,
    /// Names of the fixed tags and planes of symmetry that hold the rim of an open pressure wall.
    pub rim: Vec<String>,
    /// Whether plugs close an open pressure wall, whose rim may then lie anywhere.
    pub plug: bool,
    /// Whether it is a surface inside the body.
    pub inside: bool,
}

table! {
    /// A tag file as it is written.
    pub struct File {
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
        /// Parts of the surface; the first that holds a facet wins.
        #[schemars(schema_with = "tags")]
        tag: Vec<toml::Table> = Vec::new();
        /// Parts of the body, which have no tetrahedra in common.
        #[schemars(schema_with = "volumes")]
        volume: Vec<toml::Table> = Vec::new();
    }
}

/// The schema of a tag file.
pub const FORMAT: Format = Format::of::<File>("tags", "tags.toml");

fn tags(generator: &mut SchemaGenerator) -> Schema {
    let flag = |meaning: &str| json!({ "type": "boolean", "description": meaning });
    let mut rim = Rim::json_schema(generator).to_value();
    rim["description"] =
        "Fixed tags or planes of symmetry that hold the rim of a pressure wall that \
                          is open."
            .into();
    let more = [
        ("pressure", flag("Whether it is the wall of a chamber."), false),
        ("rim", rim, false),
        (
            "plug",
            flag(
                "Whether plugs close a pressure wall that is open, so that nothing need hold its rim.",
            ),
            false,
        ),
        ("inside", flag("Whether the patch is a surface inside the body."), false),
    ];
    selections(generator, &more)
}

fn volumes(generator: &mut SchemaGenerator) -> Schema {
    selections(generator, &[])
}

/// A list of tables with a name, one selector and `more` keys.
fn selections(generator: &mut SchemaGenerator, more: &[(&str, Value, bool)]) -> Schema {
    let name =
        json!({ "type": "string", "minLength": 1, "description": "Its name, unique in the file." });
    let one = |selector: &Entry| {
        let mut schema =
            schemars::json_schema!({ "type": "object", "additionalProperties": false });
        schema.insert("title".into(), format!("`{}`", selector.key).into());
        let mut value = (selector.schema)(generator).to_value();
        value["description"] = selector.meaning.into();
        add_keys(&mut schema, &[("name", name.clone(), true), (selector.key, value, true)]);
        add_keys(&mut schema, more);
        schema
    };
    let items = one_of(SELECTORS.iter().map(one));
    schemars::json_schema!({ "type": "array", "items": items })
}

impl Config {
    /// Reads and checks a tag file, with changes from outside.
    pub fn read(path: &Path, changes: &[Change]) -> Result<Self> {
        Settings::read(path, changes, KEYS)?.checked(Self::of)
    }

    fn of(settings: &Settings) -> Result<Self> {
        let file: File = settings.parse()?;
        file.check_ranges(&KeyPath::default())?;
        ensure!(!file.tag.is_empty(), "no [[tag]]: at least one selection is needed");
        let epsilon = Epsilon::of(&file)?;
        let tags: Vec<Tag> = file
            .tag
            .into_iter()
            .enumerate()
            .map(|(i, table)| Tag::parse(table).with_context(|| KeyPath::list("tag").number(i + 1)))
            .collect::<Result<_>>()?;
        check_names(&tags)?;
        let volumes: Vec<Volume> = file
            .volume
            .into_iter()
            .enumerate()
            .map(|(i, table)| {
                Volume::parse(table).with_context(|| KeyPath::list("volume").number(i + 1))
            })
            .collect::<Result<_>>()?;
        for (i, volume) in volumes.iter().enumerate() {
            let twice = volumes[..i].iter().any(|other| other.name == volume.name);
            let what = format!("the name `{}` of a [[volume]] is used twice", volume.name);
            ensure!(!twice, KeyPath::list("volume").number(i + 1).key("name").told(what));
        }
        Ok(Self { epsilon, surface: file.surface, tags, volumes, faces: file.faces })
    }
}

impl Tag {
    fn parse(mut table: toml::Table) -> Result<Self> {
        let (selector, name) = selector_and_name(&mut table, &TAG_KEYS)?;
        let pressure = take(&mut table, "pressure")?.unwrap_or(false);
        let rim = take::<Rim>(&mut table, "rim")?.map_or_else(Vec::new, Rim::all);
        let refused = |key: &str, what: &str| KeyPath::of(key).told(what);
        ensure!(rim.is_empty() || pressure, refused("rim", "`rim` needs `pressure = true`"));
        let plug = take(&mut table, "plug")?.unwrap_or(false);
        ensure!(
            !plug || (pressure && rim.is_empty()),
            refused("plug", "`plug = true` is for a wall with `pressure = true` and without `rim`")
        );
        let inside = take(&mut table, "inside")?.unwrap_or(false);
        ensure!(
            !inside || (selector == "patch" && !pressure),
            refused("inside", "`inside = true` is for a `patch`, without `pressure`")
        );
        let value = table.remove(selector).ok_or_else(|| anyhow!("`{selector}` is missing"))?;
        Ok(Self { name, selector, value, pressure, rim, plug, inside })
    }
}

impl Tag {
    /// The names of its patches, as the file has them.
    pub fn patches(&self) -> impl Iterator<Item = &str> {
        let value = Some(&self.value).filter(|_| self.selector == "patch");
        let several = value.and_then(toml::Value::as_array).map_or(&[][..], Vec::as_slice);
        value.into_iter().chain(several).filter_map(toml::Value::as_str)
    }
}

impl Volume {
    fn parse(mut table: toml::Table) -> Result<Self> {
        let (selector, name) = selector_and_name(&mut table, &VOLUME_KEYS)?;
        let value = table.remove(selector).ok_or_else(|| anyhow!("`{selector}` is missing"))?;
        Ok(Self { name, selector, value })
    }
}

/// The one selector of a table that has no keys but these and those of selectors, and its name.
fn selector_and_name(table: &mut toml::Table, others: &[&str]) -> Result<(&'static str, String)> {
    let selectors = SELECTORS.iter().map(|s| s.key);
    let keys: Vec<&str> = others.iter().copied().chain(selectors).collect();
    if let Some(key) = table.keys().find(|k| !keys.contains(&k.as_str())) {
        let (before, list) = (format!("unknown key `{key}`"), keys.join(", "));
        let list = format!("expected one of {list}");
        bail!(KeyPath::word(key).told(unknown(&before, key, keys.iter().copied(), ',', &list)));
    }
    let mut given = SELECTORS.iter().filter(|s| table.contains_key(s.key)).map(|s| s.key);
    let (selector, second) = (given.next(), given.next());
    if let (Some(a), Some(b)) = (selector, second) {
        let what = format!("both `{a}` and `{b}`: there is exactly one selector");
        bail!(KeyPath::word(b).told(what));
    }
    let forms = || SELECTORS.iter().map(|s| format!("\n  {} = {}", s.key, s.meaning));
    let selector =
        selector.ok_or_else(|| anyhow!("no selector; one of:{}", forms().collect::<String>()))?;
    let name = take::<String>(table, "name")?
        .filter(|name| !name.is_empty())
        .ok_or_else(|| anyhow!("`name` is missing"))?;
    Ok((selector, name))
}

/// `rim` as it is written.
#[derive(Deserialize, JsonSchema)]
#[serde(untagged, expecting = "expected the name of a tag, or a list of names")]
enum Rim {
    One(String),
    Several(Vec<String>),
}

impl Rim {
    fn all(self) -> Vec<String> {
        match self {
            Self::One(name) => vec![name],
            Self::Several(names) => names,
        }
    }
}

/// Removes and converts the value of a key.
fn take<T: DeserializeOwned>(table: &mut toml::Table, key: &str) -> Result<Option<T>, Misfit> {
    let found = read_key(table, key).map_err(|what| what.titled(format!("`{key}`")));
    table.remove(key);
    found
}

fn check_names(tags: &[Tag]) -> Result<()> {
    let names: Vec<&str> = tags.iter().map(|t| t.name.as_str()).collect();
    for (i, tag) in tags.iter().enumerate() {
        let at = || KeyPath::list("tag").number(i + 1);
        ensure!(
            !names[..i].contains(&names[i]),
            at().key("name").told(format!("the name `{}` is used twice", names[i]))
        );
        for rim in &tag.rim {
            ensure!(
                names.contains(&rim.as_str()) && *rim != tag.name,
                at().key("rim").told(format!(
                    "[[tag]] `{}`: rim = \"{rim}\" is not another tag; tags: {}",
                    tag.name,
                    names.join(", ")
                ))
            );
        }
    }
    Ok(())
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    #[test]
    fn reads_selectors_in_order() {
        let config = Config::of(&Settings::of_text(
            "epsilon = 2e-4\n\
             [[tag]]\nname = \"seat\"\npatch = \"seat.stl\"\n\
             [[tag]]\nname = \"cavity\"\ncomponent = 1\npressure = true\nrim = \"seat\"\n",
        ))
        .unwrap();
        assert_eq!(config.epsilon, Some(Epsilon::Absolute(2e-4)));
        let read: Vec<_> = config.tags.iter().map(|t| (t.name.as_str(), t.selector)).collect();
        assert_eq!(read, [("seat", "patch"), ("cavity", "component")]);
        assert_eq!(config.tags[1].rim, ["seat"]);
    }

    #[test]
    fn a_rim_may_lie_on_several_tags() {
        let tags =
            "[[tag]]\nname = \"seat\"\ncomponent = 0\n[[tag]]\nname = \"cut\"\ncomponent = 2\n";
        let wall = "[[tag]]\nname = \"cavity\"\ncomponent = 1\npressure = true\n";
        let read = |rim: &str| Config::of(&Settings::of_text(&format!("{tags}{wall}{rim}\n")));
        let config = read("rim = [\"seat\", \"cut\"]").unwrap();
        assert_eq!(config.tags[2].rim, ["seat", "cut"]);
        let error = read("rim = [\"seat\", \"top\"]").unwrap_err();
        assert!(format!("{error:#}").contains("rim = \"top\" is not another tag"), "{error:#}");
    }

    #[test]
    fn names_what_is_wrong() {
        let cases = [
            ("", "at least one selection"),
            ("sigma = 1\n", "unknown field `sigma`"),
            ("epsilon = -1.0\n[[tag]]\nname = \"a\"\ncomponent = 0\n", "must be positive"),
            ("epsilon = 1\nrelative_epsilon = 1\n[[tag]]\n", "give one of them"),
            (
                "[[tag]]\nname = \"a\"\nptach = \"a.stl\"\n",
                "expected one of name, pressure, rim, plug, inside, patch",
            ),
            ("[[tag]]\nname = \"a\"\n", "no selector; one of"),
            ("[[tag]]\nname = \"a\"\ncomponent = 0\npatch = \"a\"\n", "exactly one selector"),
            ("[[tag]]\ncomponent = 0\n", "`name` is missing"),
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
