//! The model file: primitives, cuts, regions and variants.
//!
//! Lengths are in the file's `unit` until [`crate::surface`] converts
//! the finished surface to metres.

use std::path::Path;

use anyhow::{Context, Result, bail, ensure};
use mesh::Vec3;
use program::schema::partial;
use program::units::Unit;
use program::{Change, KeyPath, Keys, Names, Settings, misfit, read_table};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use serde_json::json;
use toml::{Table, Value};

pub use super::shape::Bounds;
use super::shape::Shape;
use super::value::{require_file_name, require_finite};

/// Most cells of the sampling lattice, 2 samples each.
const MAX_CELLS: f64 = 3e7;

/// An implicit model.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Model {
    /// Unit of every length in the file.
    pub unit: Unit,
    /// Edge length of the triangles that are laid on the surface [unit].
    pub grid: f64,
    /// How far simplification may move the surface [unit].
    #[serde(default)]
    pub simplify: f64,
    /// The body, cavities filled; built in the order of the file.
    pub solid: Vec<Primitive>,
    /// What is taken out of the body; built in the order of the file.
    #[serde(default)]
    pub cavity: Vec<Primitive>,
    /// Planar faces.
    #[serde(default)]
    pub cut: Vec<Cut>,
    /// Named parts of the surface; a triangle belongs to the first that takes it.
    pub region: Vec<Region>,
    /// The same body with some primitives changed, each a surface of its own.
    #[serde(default)]
    #[schemars(schema_with = "variants")]
    variant: Vec<Table>,
}

/// Any part of the keys of primitives, by their names.
fn variants(generator: &mut SchemaGenerator) -> Schema {
    let primitive = Primitive::json_schema(generator);
    let changes = json!({
        "type": "object",
        "additionalProperties": partial(&primitive, generator.definitions()),
    });
    schemars::json_schema!({ "type": "array", "items": {
        "type": "object",
        "properties": {
            "name": { "type": "string", "description": "Name of the surface that is written." },
            "solid": changes,
            "cavity": changes,
        },
        "required": ["name"],
        "additionalProperties": false,
    } })
}

/// One step in building a body.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Primitive {
    /// Name, by which regions and variants refer to it.
    pub name: String,
    /// Geometry.
    pub shape: Shape,
    /// What it does to the body built so far.
    #[serde(default)]
    pub op: Op,
    /// Width k of the smooth transition [unit].
    #[serde(default)]
    pub blend: f64,
    /// Whether its mirror image in y = 0 follows right after it.
    #[serde(default)]
    pub mirror: bool,
    /// Whether it is an ornament that a simulation does without.
    #[serde(default)]
    pub fine: bool,
}

/// What a primitive does to the body built so far.
#[derive(Clone, Copy, Debug, Default, Deserialize, JsonSchema, PartialEq)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Op {
    /// Added.
    #[default]
    Union,
    /// Taken away.
    Difference,
    /// Only what is in both stays.
    Intersection,
    /// The surface is raised where it lies inside the primitive.
    Emboss {
        /// Height, negative to engrave [unit].
        height: f64,
        /// Width over which the height fades at the primitive's surface [unit].
        width: f64,
    },
}

/// A plane that cuts the body after meshing, so that the face is exactly planar.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cut {
    /// Name, by which regions refer to the face.
    pub name: String,
    /// Outward normal n of the face, not normalised.
    pub normal: [f64; 3],
    /// The body keeps n·p ≤ offset with n normalised [unit].
    pub offset: f64,
}

/// A named part of the surface. A triangle is taken if all given conditions hold.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Region {
    /// Name of the patch file.
    pub name: String,
    /// On the face of this cut.
    pub cut: Option<String>,
    /// On the wall of the cavity, or of these primitives of it.
    #[serde(default)]
    pub cavity: Cavity,
    /// On the outside, nearest to one of these primitives of the solid.
    pub primitives: Option<Vec<String>>,
    /// With the centroid in this box.
    pub within: Option<Cuboid>,
    /// Everything that is left.
    #[serde(default)]
    pub rest: bool,
}

/// Walls of cavities that a region takes.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(
    untagged,
    expecting = "expected true, or the name of a primitive of the cavity, or a list of names"
)]
pub enum Cavity {
    /// All, or nothing is said of them.
    All(bool),
    /// Where one of these primitives is the nearest.
    Of(Names),
}

impl Default for Cavity {
    fn default() -> Self {
        Self::All(false)
    }
}

impl Cavity {
    /// Whether a region has this condition.
    pub fn is_given(&self) -> bool {
        !matches!(self, Self::All(false))
    }

    /// The primitives that are named.
    pub fn names(&self) -> &[String] {
        match self {
            Self::All(_) => &[],
            Self::Of(names) => names.all(),
        }
    }
}

/// An axis-aligned box.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cuboid {
    /// Lower corner [unit].
    pub min: [f64; 3],
    /// Upper corner [unit].
    pub max: [f64; 3],
}

/// A model file with its variants.
#[derive(Clone, Debug)]
pub struct ModelFile {
    /// The model itself.
    pub model: Model,
    /// Variants: the name and the model with the overridden values.
    pub variants: Vec<(String, Model)>,
}

impl ModelFile {
    /// Reads and checks a model file, with changes from outside.
    pub fn read(path: &Path, changes: &[Change]) -> Result<Self> {
        Settings::read(path, changes, Keys::default())?.checked(Self::of)
    }

    /// Reads and checks the text of a model file.
    pub fn parse(text: &str) -> Result<Self> {
        Settings::of_text(text).checked(Self::of)
    }

    fn of(file: &Settings) -> Result<Self> {
        let model: Model = file.parse()?;
        let mut table: Table = file.parse()?;
        table.remove("variant");
        require_finite("", KeyPath::default(), &Value::Table(table.clone()))?;
        model.check()?;
        let mut variants: Vec<(String, Model)> = Vec::new();
        for changes in &model.variant {
            let (name, changes) = named(changes.clone())?;
            let title = || KeyPath::of("variant").named(&name);
            ensure!(variants.iter().all(|(n, _)| *n != name), misfit!(title(), " occurs twice"));
            let variant = vary(&table, changes).with_context(title)?;
            variants.push((name, variant));
        }
        Ok(Self { model, variants })
    }
}

/// The name of a variant and its changes.
fn named(mut changes: Table) -> Result<(String, Table)> {
    let Some(Value::String(name)) = changes.remove("name") else {
        bail!("a [[variant]] needs a name")
    };
    require_file_name(&name)?;
    Ok((name, changes))
}

/// The model with the primitives of `changes` overridden.
fn vary(base: &Table, changes: Table) -> Result<Model> {
    let mut table = base.clone();
    for (list, primitives) in changes {
        let (Value::Table(primitives), "solid" | "cavity") = (primitives, list.as_str()) else {
            bail!(KeyPath::word(&list).told(format!(
                "unknown key {list:?}; a variant changes primitives: [variant.solid.NAME]"
            )));
        };
        for (name, change) in primitives {
            let target = table
                .get_mut(&list)
                .and_then(Value::as_array_mut)
                .and_then(|a| a.iter_mut().find(|p| p.get("name") == Some(&name.clone().into())))
                .ok_or_else(|| {
                    KeyPath::word(&name).told(format!("there is no {list} primitive {name:?}"))
                })?;
            merge(target, change);
        }
    }
    require_finite("", KeyPath::default(), &Value::Table(table.clone()))?;
    let model: Model = read_table(&table)?;
    model.check()?;
    Ok(model)
}

/// Replaces values of `target` by those of `change`, table by table.
fn merge(target: &mut Value, change: Value) {
    match (target, change) {
        (Value::Table(target), Value::Table(change)) => {
            for (key, value) in change {
                match target.get_mut(&key) {
                    Some(old) => merge(old, value),
                    None => drop(target.insert(key, value)),
                }
            }
        }
        (target, change) => *target = change,
    }
}

impl Model {
    fn check(&self) -> Result<()> {
        let (grid, simplify) = (self.grid, self.simplify);
        ensure!(grid > 0.0, misfit!(KeyPath::of("grid"), " must be positive, found {grid}"));
        ensure!(
            simplify >= 0.0,
            misfit!(KeyPath::of("simplify"), " must not be negative, found {simplify}")
        );
        check_primitives("solid", &self.solid)?;
        check_primitives("cavity", &self.cavity)?;
        ensure!(!self.solid.is_empty(), "a model needs at least one [[solid]] primitive");
        for cut in &self.cut {
            ensure!(
                Vec3::from(cut.normal).norm() > 0.0,
                misfit!(KeyPath::of("cut").named(&cut.name), ": the normal is zero")
            );
        }
        self.require_cells(self.grid)?;
        self.region.iter().try_for_each(|region| {
            self.check_region(region).with_context(|| KeyPath::of("region").named(&region.name))
        })
    }

    /// Refuses a grid that would take very long.
    pub(super) fn require_cells(&self, grid: f64) -> Result<()> {
        let (min, max) = self.bounds();
        let cells = (max - min).product() / grid.powi(3);
        ensure!(
            cells <= MAX_CELLS,
            KeyPath::of("grid").told(format!(
                "grid {grid} makes {cells:.1e} cells in the box of the body; more than {MAX_CELLS:.0e} \
                 take minutes and gigabytes: choose a coarser grid"
            ))
        );
        Ok(())
    }

    fn check_region(&self, region: &Region) -> Result<()> {
        require_file_name(&region.name)?;
        if let Some(cut) = &region.cut {
            let known = names(self.cut.iter().map(|c| &c.name));
            let what = || KeyPath::of("cut").told(format!("no cut {cut:?}; cuts: {known}"));
            ensure!(self.cut.iter().any(|c| c.name == *cut), what());
        }
        for name in region.primitives.iter().flatten() {
            let what = || {
                let known = names(self.solid.iter().map(|p| &p.name));
                KeyPath::word(name).told(format!(
                    "{name:?} is in [[cavity]], and its walls are cavity = {name:?}; primitives: {known}"
                ))
            };
            ensure!(self.cavity.iter().all(|p| p.name != *name), what());
            require_body("solid", &self.solid, name)?;
        }
        for name in region.cavity.names() {
            require_body("cavity", &self.cavity, name)?;
        }
        let selective = region.cut.is_some()
            || region.cavity.is_given()
            || region.primitives.is_some()
            || region.within.is_some();
        ensure!(
            selective != region.rest,
            "needs conditions (cut, cavity, primitives, within) or `rest = true`, not both"
        );
        Ok(())
    }

    /// Region names in the order of the file, each once.
    pub fn region_names(&self) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for region in &self.region {
            if !names.contains(&region.name) {
                names.push(region.name.clone());
            }
        }
        names
    }

    /// A box around the body, with room for blends and for a grid cell [unit].
    pub fn bounds(&self) -> Bounds {
        let bodies = self.solid.iter().filter(|p| p.is_body());
        let boxes = bodies.flat_map(|p| {
            let images = [Some(&p.shape).cloned(), p.mirror.then(|| p.shape.mirrored())];
            // A smooth union adds at most a quarter of its blend width.
            let room = p.blend / 4.0 + 2.0 * self.grid;
            images
                .into_iter()
                .flatten()
                .filter_map(|s| s.bounds())
                .map(move |(min, max)| (min.add_scalar(-room), max.add_scalar(room)))
        });
        let empty = (Vec3::repeat(f64::INFINITY), Vec3::repeat(f64::NEG_INFINITY));
        boxes.fold(empty, |a, b| (a.0.inf(&b.0), a.1.sup(&b.1)))
    }
}

impl Primitive {
    /// Whether it adds volume, so that the surface may be nearest to it.
    pub fn is_body(&self) -> bool {
        self.op == Op::Union && !matches!(self.shape, Shape::Crease { .. })
    }
}

fn check_primitives(list: &str, primitives: &[Primitive]) -> Result<()> {
    for (i, primitive) in primitives.iter().enumerate() {
        let name = &primitive.name;
        let refused = |what: String| {
            let title = format!("{list} primitive {name:?}");
            KeyPath::of(list).number(i + 1).told(what).titled(title)
        };
        let twice = primitives[..i].iter().any(|p| p.name == *name);
        ensure!(!twice, refused("the name occurs twice".into()));
        let blend = primitive.blend;
        ensure!(blend >= 0.0, refused(format!("blend {blend} is negative")));
        primitive.shape.check().map_err(refused)?;
        let first = "the first primitive must be a body";
        ensure!(i > 0 || primitive.is_body(), refused(first.into()));
        let crease = matches!(primitive.shape, Shape::Crease { .. });
        let plain = primitive.op == Op::Union && primitive.blend == 0.0;
        ensure!(!crease || plain, refused("a crease takes neither op nor blend".into()));
        if let Op::Emboss { width, .. } = primitive.op {
            let what = || format!("width must be positive, found {width}");
            ensure!(width > 0.0, refused(what()));
        }
    }
    Ok(())
}

/// Refuses a name that no body of a list has.
fn require_body(list: &str, primitives: &[Primitive], name: &str) -> Result<()> {
    let what = || {
        let known = names(primitives.iter().map(|p| &p.name));
        KeyPath::word(name).told(format!("no body {name:?} in [[{list}]]; primitives: {known}"))
    };
    ensure!(primitives.iter().any(|p| p.name == name && p.is_body()), what());
    Ok(())
}

fn names<'a>(items: impl Iterator<Item = &'a String>) -> String {
    let items: Vec<&str> = items.map(String::as_str).collect();
    if items.is_empty() { "none".into() } else { items.join(", ") }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    const BALL: &str = "unit = 'mm'\ngrid = 1\n[[solid]]\nname = 'ball'\n\
        shape.sphere = { center = [0, 0, 0], radius = 5 }\n[[region]]\nname = 'all'\nrest = true\n";

    fn error(text: &str) -> String {
        format!("{:#}", ModelFile::parse(text).unwrap_err())
    }

    #[test]
    fn mistakes_are_named() {
        let variant = |rest: &str| format!("{BALL}[[variant]]\nname = 'v'\n{rest}\n");
        for (text, expected) in [
            (BALL.replace("radius", "radios"), "radios"),
            (BALL.replace("radius = 5", "radius = nan"), "solid.shape.sphere.radius is NaN"),
            (BALL.replace("radius = 5", "radius = -5"), "radius must be positive, found [-5.0]"),
            (BALL.replace("grid = 1", "grid = 0.001"), "coarser grid"),
            (BALL.replace("rest = true", ""), "needs conditions"),
            (BALL.replace("rest = true", "cut = 'floor'"), "no cut \"floor\"; cuts: none"),
            (BALL.replace("'all'", "'../all'"), "names a file"),
            (variant("[variant.solid.bull]\nblend = 1"), "no solid primitive \"bull\""),
            (variant("[variant.solid.ball]\nblnd = 1"), "blnd"),
            (variant("[variant.cut.floor]\noffset = 1"), "unknown key \"cut\""),
        ] {
            let message = error(&text);
            assert!(message.contains(expected), "{expected:?} not in {message:?}");
        }
    }
}
