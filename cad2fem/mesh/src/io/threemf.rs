//! 3MF: shapes with unit, names and places, as slicers exchange them.
//!
//! The part of the 3MF Core Specification 1.3 (<https://github.com/3MFConsortium/spec_core>) that
//! says where triangles are: a zip archive with one XML model, in which objects are indexed
//! triangles or compositions of other objects, and items of the build say where objects stand.
//! Coordinates are written as the shortest decimals that give back the same 32-bit floats, so that a file holds the
//! same shape as its STL file, bit for bit.
//!
//! The crate threemf 0.8 would replace a third of this file, but reads an archive of any
//! unpacked size, does not check namespaces, and writes coordinates with 64-bit digits.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{Cursor, Read as _, Write as _};
use std::path::Path;

use nalgebra::Matrix3;
use roxmltree::{Document, Node, ParsingOptions};
use zip::write::SimpleFileOptions;
use zip::{ZipArchive, ZipWriter};

use super::{IoError, read_bytes, write_atomic};
use crate::{SurfaceMesh, Vec3};

/// Namespace of the core specification.
const CORE: &str = "http://schemas.microsoft.com/3dmanufacturing/core/2015/02";

/// Where the model lies in the archive.
const MODEL: &str = "3D/3dmodel.model";

/// The largest model that is read [bytes]: ten times that of 500 000 triangles.
const LARGEST: u64 = 400 << 20;

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

const TYPES: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Types xmlns="http://schemas.openxmlformats.org/package/2006/content-types">
<Default Extension="rels" ContentType="application/vnd.openxmlformats-package.relationships+xml"/>
<Default Extension="model" ContentType="application/vnd.ms-package.3dmanufacturing-3dmodel+xml"/>
</Types>
"#;

const RELATIONS: &str = r#"<?xml version="1.0" encoding="UTF-8"?>
<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships">
<Relationship Id="model" Target="/3D/3dmodel.model" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/>
</Relationships>
"#;

/// Writes shapes as one printable whole: the only shape itself, or a composition
/// with the name `title`, as `application` made it [mm]. The whole is shifted so that no coordinate is negative,
/// as the specification wants it.
pub fn write(path: &Path, application: &str, title: &str, shapes: &[Shape]) -> Result<(), IoError> {
    let bytes = pack(&model(application, title, shapes))
        .map_err(|e| IoError::content(path, format!("cannot be packed: {e}")))?;
    write_atomic(path, |out| out.write_all(&bytes))
}

fn pack(model: &str) -> zip::result::ZipResult<Vec<u8>> {
    let mut archive = ZipWriter::new(Cursor::new(Vec::new()));
    let files = [("[Content_Types].xml", TYPES), ("_rels/.rels", RELATIONS), (MODEL, model)];
    for (name, text) in files {
        archive.start_file(name, SimpleFileOptions::default())?;
        archive.write_all(text.as_bytes())?;
    }
    Ok(archive.finish()?.into_inner())
}

/// The model as XML. Writing to a string cannot fail.
fn model(application: &str, title: &str, shapes: &[Shape]) -> String {
    let title = escaped(title);
    let mut xml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <model unit=\"millimeter\" xml:lang=\"en-US\" xmlns=\"{CORE}\">\n\
         <metadata name=\"Title\">{title}</metadata>\n\
         <metadata name=\"Application\">{application}</metadata>\n<resources>\n"
    );
    for (id, shape) in (1..).zip(shapes) {
        add_object(&mut xml, id, shape);
    }
    let points = shapes.iter().flat_map(|s| s.surface.vertices.iter().map(|p| s.place.point(p)));
    let low = points.reduce(|a, b| a.inf(&b)).unwrap_or_default();
    let to_octant = Place::at(-low);
    let (whole, place) = match shapes {
        [only] => (1, to_octant.after(&only.place)),
        _ => (shapes.len() + 1, to_octant),
    };
    if whole > shapes.len() {
        let _ =
            write!(xml, "<object id=\"{whole}\" type=\"model\" name=\"{title}\">\n<components>\n");
        for (id, shape) in (1..).zip(shapes) {
            let place = transform(&shape.place);
            let _ = writeln!(xml, "<component objectid=\"{id}\" transform=\"{place}\"/>");
        }
        xml += "</components>\n</object>\n";
    }
    let place = transform(&place);
    let _ = write!(
        xml,
        "</resources>\n<build>\n<item objectid=\"{whole}\" transform=\"{place}\"/>\n</build>\n</model>\n"
    );
    xml
}

fn add_object(xml: &mut String, id: usize, shape: &Shape) {
    let name = escaped(&shape.name);
    let _ =
        write!(xml, "<object id=\"{id}\" type=\"model\" name=\"{name}\">\n<mesh>\n<vertices>\n");
    for p in &shape.surface.vertices {
        let [x, y, z] = [p.x, p.y, p.z].map(|x| x as f32);
        let _ = writeln!(xml, "<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>");
    }
    *xml += "</vertices>\n<triangles>\n";
    for [a, b, c] in &shape.surface.triangles {
        let _ = writeln!(xml, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"/>");
    }
    *xml += "</triangles>\n</mesh>\n</object>\n";
}

/// The specification maps rows, (x y z 1) M: the columns of R one after the other, then t.
fn transform(place: &Place) -> String {
    let numbers = place.turn.iter().chain(place.shift.iter()).map(|x| format!("{}", x + 0.0));
    numbers.collect::<Vec<_>>().join(" ")
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use crate::solid::Solid;

    fn shape(name: &str, low: f64, shift: f64) -> Shape {
        let third = f64::from(1.0_f32 / 3.0);
        let surface = Solid::cube(&Vec3::repeat(low), &Vec3::new(1.0, 2.0, third)).to_surface();
        let quarter = Matrix3::new(0.0, -1.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0);
        Shape {
            name: name.into(),
            surface,
            place: Place { turn: quarter, shift: Vec3::repeat(shift) },
        }
    }

    #[test]
    fn shapes_come_back_with_names_and_places() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("whole.3mf");
        let shapes = [shape("a <&> \"b\"", -1.0, 0.1), shape("c", 0.0, -7.0)];
        write(&path, "fab 0", "whole", &shapes).unwrap();
        let back = read(&path).unwrap().shapes;
        assert_eq!(back.len(), 2);
        let off = back[0].place.shift - shapes[0].place.shift;
        for (was, is) in shapes.iter().zip(&back) {
            assert_eq!((&was.name, &was.surface), (&is.name, &is.surface));
            assert_eq!(was.place.turn, is.place.turn);
            assert!((is.place.shift - was.place.shift - off).amax() < 1e-12);
        }
        let points = back.iter().flat_map(|s| s.surface.vertices.iter().map(|p| s.place.point(p)));
        let low = points.reduce(|a, b| a.inf(&b)).unwrap();
        assert!(low.amax() < 1e-12, "{low}");
        write(&path, "fab 0", "c", &shapes[1..]).unwrap();
        let back = read(&path).unwrap().shapes;
        assert_eq!((back.len(), &back[0].surface), (1, &shapes[1].surface));
    }

    #[test]
    fn small_files_of_large_models_are_refused() {
        // sixty components of sixty components, seven times; and a text of a gigabyte, packed
        let mut nested = String::new();
        for id in 1..8 {
            let component = format!("<component objectid=\"{}\"/>", id - 1);
            let all = component.repeat(60);
            nested += &format!("<object id=\"{id}\"><components>{all}</components></object>");
        }
        let empty = format!(
            "<model xmlns=\"{CORE}\"><resources><object id=\"0\"/>{nested}</resources><build>\
             <item objectid=\"7\"/></build></model>"
        );
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("bomb.3mf");
        std::fs::write(&path, pack(&empty).unwrap()).unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("more than 10000 items"));
        std::fs::write(&path, pack(&" ".repeat(LARGEST as usize + 1)).unwrap()).unwrap();
        assert!(std::fs::metadata(&path).unwrap().len() < 1 << 20);
        let message = read(&path).unwrap_err().to_string();
        assert!(message.contains("bomb.3mf") && message.contains("longer than"), "{message}");
    }

    #[test]
    fn wrong_files_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.3mf");
        let refused = |bytes: &[u8], message: &str| {
            std::fs::write(&path, bytes).unwrap();
            let error = read(&path).unwrap_err().to_string();
            assert!(error.contains(message), "{error}");
        };
        refused(b"solid", "not a zip archive");
        let good = model("fab 0", "a", &[shape("a", 0.0, 0.0)]);
        for (from, to, message) in [
            ("unit=\"millimeter\"", "unit=\"mile\"", "which 3MF does not have"),
            ("objectid=\"1\"", "objectid=\"9\"", "object 9 is missing"),
            ("v2=\"0\"", "v2=\"99\"", "names vertex 99 of 8"),
            ("x=\"1\"", "x=\"nan\"", "not finite"),
            ("transform=\"", "transform=\"1 ", "not 12 numbers"),
            (CORE, "http://example.org", "must be a 3MF <model>"),
        ] {
            refused(&pack(&good.replacen(from, to, 1)).unwrap(), message);
        }
    }
}
