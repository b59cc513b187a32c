//! 3MF, read only: shapes with unit, names and places, as slicers exchange them.
//!
//! The part of the 3MF Core Specification 1.3 (<https://github.com/3MFConsortium/spec_core>) that
//! says where triangles are: a zip archive with one XML model, in which objects are indexed
//! triangles or compositions of other objects, and items of the build say where objects stand.
//!
//! The crate threemf 0.8 would replace a third of this file, but reads an archive of any
//! unpacked size and does not check namespaces.

use std::collections::BTreeMap;
use std::io::{Cursor, Read as _};
use std::path::Path;

use nalgebra::Matrix3;
use roxmltree::{Document, Node, ParsingOptions};
use zip::ZipArchive;

use super::{IoError, read_bytes};
use crate::{SurfaceMesh, Vec3};

/// Namespace of the core specification.
pub const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";

/// Where the model lies in the archive.
pub const MODEL: &str = "3D/3dmodel.model";

/// The largest model that is read [bytes]: ten times that of 500 000 triangles.
pub const LARGEST: u64 = 400 << 20;

/// Elements and texts of the XML that are read; a triangle of a part has five with its vertices.
const MOST_NODES: u32 = 30_000_000;

/// Items and components that are followed; a mold has less than a hundred.
const MOST_COMPONENTS: usize = 10_000;

/// Compositions of compositions that are followed.
const DEEPEST: usize = 8;

/// Units of the specification by their names [m].
const UNITS: &[(&str, f64)] = &[
    ("micron", 1e-6),
    ("millimeter", 1e-3),
    ("centimeter", 1e-2),
    ("inch", 25.4e-3),
    ("foot", 0.3048),
    ("meter", 1.0),
];

/// What a file holds.
#[derive(Clone, Debug, PartialEq)]
pub struct Model {
    /// Name of the unit.
    pub unit: &'static str,
    /// Metres per unit [m].
    pub metres: f64,
    /// The shapes of the build, in its order.
    pub shapes: Vec<Shape>,
}

/// x ↦ R x + t.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Place {
    /// The linear part R [1].
    pub turn: Matrix3<f64>,
    /// The image t of the origin.
    pub shift: Vec3,
}

impl Place {
    /// A shift only.
    pub fn at(shift: Vec3) -> Self {
        Self { turn: Matrix3::identity(), shift }
    }

    /// The image of a point.
    pub fn point(&self, p: &Vec3) -> Vec3 {
        self.turn * p + self.shift
    }

    /// First `first`, then this.
    pub fn after(&self, first: &Self) -> Self {
        Self { turn: self.turn * first.turn, shift: self.point(&first.shift) }
    }
}

/// A named surface and where it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    /// The name.
    pub name: String,
    /// The surface, in coordinates that 32-bit floats hold exactly.
    pub surface: SurfaceMesh,
    /// From the surface to the whole.
    pub place: Place,
}

impl Shape {
    /// The surface where it stands.
    pub fn placed(&self) -> SurfaceMesh {
        let mut surface = self.surface.clone();
        surface.vertices.iter_mut().for_each(|p| *p = self.place.point(p));
        if self.place.turn.determinant() < 0.0 {
            surface.triangles.iter_mut().for_each(|t| t.swap(1, 2));
        }
        surface
    }
}

/// Reads all shapes of the build, in its order.
pub fn read(path: &Path) -> Result<Model, IoError> {
    let text = unpack(&read_bytes(path)?).map_err(|message| IoError::content(path, message))?;
    parse(&text).map_err(|message| IoError::content(path, message))
}

fn unpack(bytes: &[u8]) -> Result<String, String> {
    let mut archive =
        ZipArchive::new(Cursor::new(bytes)).map_err(|e| format!("not a zip archive: {e}"))?;
    let entry = archive.by_name(MODEL).map_err(|e| format!("{MODEL}: {e}"))?;
    let mut text = String::new();
    let length =
        entry.take(LARGEST).read_to_string(&mut text).map_err(|e| format!("{MODEL}: {e}"))?;
    if length as u64 == LARGEST {
        return Err(format!("{MODEL}: longer than {LARGEST} bytes"));
    }
    Ok(text)
}

fn parse(text: &str) -> Result<Model, String> {
    let options = ParsingOptions { nodes_limit: MOST_NODES, ..ParsingOptions::default() };
    let document = Document::parse_with_options(text, options).map_err(|e| e.to_string())?;
    let model = document.root_element();
    if !model.has_tag_name((CORE, "model")) {
        return Err(format!("the root is <{}>, must be a 3MF <model>", model.tag_name().name()));
    }
    let unit = model.attribute("unit").unwrap_or("millimeter");
    let &(unit, metres) = UNITS
        .iter()
        .find(|known| known.0 == unit)
        .ok_or_else(|| format!("the unit is {unit:?}, which 3MF does not have"))?;
    let objects = model.descendants().filter(|n| n.has_tag_name((CORE, "object")));
    let objects = objects.filter_map(|n| Some((n.attribute("id")?, n))).collect();
    let mut build = Build { objects, shapes: Vec::new(), followed: 0 };
    for item in model.descendants().filter(|n| n.has_tag_name((CORE, "item"))) {
        build.follow(item, &Place::at(Vec3::zeros()), DEEPEST)?;
    }
    Ok(Model { unit, metres, shapes: build.shapes })
}

/// What has been collected of a model.
struct Build<'a> {
    objects: BTreeMap<&'a str, Node<'a, 'a>>,
    shapes: Vec<Shape>,
    /// Items and components.
    followed: usize,
}

impl Build<'_> {
    /// Collects the shapes of the object that an item or component names.
    fn follow(&mut self, from: Node, place: &Place, depth: usize) -> Result<(), String> {
        self.followed += 1;
        if self.followed > MOST_COMPONENTS {
            return Err(format!("more than {MOST_COMPONENTS} items and components"));
        }
        let id = from.attribute("objectid").ok_or("an item or component without objectid")?;
        let object = *self.objects.get(id).ok_or_else(|| format!("object {id} is missing"))?;
        let place = place.after(&parse_transform(from.attribute("transform"))?);
        if let Some(mesh) = object.children().find(|n| n.has_tag_name((CORE, "mesh"))) {
            let name = object.attribute("name").unwrap_or_default().to_owned();
            let surface = parse_mesh(mesh).map_err(|message| format!("object {id}: {message}"))?;
            self.shapes.push(Shape { name, surface, place });
        }
        if depth == 0 {
            return Err(format!("object {id}: more than {DEEPEST} compositions within each other"));
        }
        for component in object.descendants().filter(|n| n.has_tag_name((CORE, "component"))) {
            self.follow(component, &place, depth - 1)?;
        }
        Ok(())
    }
}

fn parse_transform(text: Option<&str>) -> Result<Place, String> {
    let Some(text) = text else { return Ok(Place::at(Vec3::zeros())) };
    let numbers: Vec<f64> = text.split_whitespace().flat_map(str::parse).collect();
    if numbers.len() != 12 || numbers.iter().any(|x| !x.is_finite()) {
        return Err(format!("transform {text:?} is not 12 numbers"));
    }
    Ok(Place {
        turn: Matrix3::from_column_slice(&numbers[..9]),
        shift: Vec3::from_column_slice(&numbers[9..]),
    })
}

fn parse_mesh(mesh: Node) -> Result<SurfaceMesh, String> {
    fn attributes<T: std::str::FromStr>(node: Node, names: [&str; 3]) -> Result<[T; 3], String> {
        let read = |name| node.attribute(name).and_then(|text| text.trim().parse().ok());
        let [Some(a), Some(b), Some(c)] = names.map(read) else {
            return Err(format!("<{}> without numbers {names:?}", node.tag_name().name()));
        };
        Ok([a, b, c])
    }
    let mut surface = SurfaceMesh::default();
    for node in mesh.descendants() {
        if node.has_tag_name((CORE, "vertex")) {
            let p: [f32; 3] = attributes(node, ["x", "y", "z"])?;
            surface.vertices.push(Vec3::from(p.map(f64::from)));
        } else if node.has_tag_name((CORE, "triangle")) {
            surface.triangles.push(attributes(node, ["v1", "v2", "v3"])?);
        }
    }
    let count = surface.vertices.len();
    if surface.vertices.iter().flatten().any(|x| !x.is_finite()) {
        return Err("a coordinate is not finite".into());
    }
    match surface.triangles.iter().flatten().find(|&&v| v >= count) {
        Some(v) => Err(format!("a triangle names vertex {v} of {count}")),
        None => Ok(surface),
    }
}
