//! 3MF: shapes with unit, names and places, as slicers take them.
//!
//! The part of the 3MF Core Specification 1.3 that printed parts need
//! (<https://github.com/3MFConsortium/spec_core>): a zip archive with one XML model,
//! in which objects are indexed triangles or compositions of other objects, and
//! items of the build say where objects stand. Coordinates are written as the
//! shortest decimals that give back the same 32-bit floats, so that a file holds the
//! same shape as its STL file, bit for bit.
//!
//! The crate threemf 0.8 writes coordinates with 64-bit digits.

use std::fmt::Write as _;
use std::io::{Cursor, Write as _};
use std::path::Path;

use mesh::io::threemf::{CORE, MODEL, read as read_model};
pub use mesh::io::threemf::{Place, Shape};
use mesh::io::{IoError, write_atomic};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

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
/// with the name `title`. The whole is shifted so that no coordinate is negative,
/// as the specification wants it.
pub fn write(path: &Path, title: &str, shapes: &[Shape]) -> Result<(), IoError> {
    let bytes = pack(&model(title, shapes))
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
fn model(title: &str, shapes: &[Shape]) -> String {
    let title = escaped(title);
    let mut xml = format!(
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
         <model unit=\"millimeter\" xml:lang=\"en-US\" xmlns=\"{CORE}\">\n\
         <metadata name=\"Title\">{title}</metadata>\n\
         <metadata name=\"Application\">fab {}</metadata>\n<resources>\n",
        env!("CARGO_PKG_VERSION")
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

/// Reads all shapes of the build of a printed part, in its order.
pub fn read(path: &Path) -> Result<Vec<Shape>, IoError> {
    let model = read_model(path)?;
    if model.unit == "millimeter" {
        return Ok(model.shapes);
    }
    Err(IoError::content(path, format!("the unit is {}, must be millimeter", model.unit)))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use mesh::Vec3;
    use mesh::io::threemf::LARGEST;
    use mesh::solid::Solid;
    use nalgebra::Matrix3;

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
        write(&path, "whole", &shapes).unwrap();
        let back = read(&path).unwrap();
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
        write(&path, "c", &shapes[1..]).unwrap();
        let back = read(&path).unwrap();
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
        let good = model("a", &[shape("a", 0.0, 0.0)]);
        for (from, to, message) in [
            ("unit=\"millimeter\"", "unit=\"inch\"", "the unit is inch"),
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
