//! What is written beside the STL files says the same as they do.

use std::path::Path;

use mesh::io::threemf::{self, Shape};
use mesh::{SurfaceMesh, Vec3};
use serde_json::Value;

use super::Line;
use super::closed_mold::Files;
use crate::files::output::{ASSEMBLY, threemf_file};
use crate::files::report::{MoldReport, Part};
use crate::files::sheet::{self, Sheet};
use crate::files::slicer;

/// All checks of copies.
pub fn checks(files: &Files, folder: &Path) -> Vec<Line> {
    let parts = &files.report.parts;
    let mut lines: Vec<Line> = parts
        .iter()
        .zip(&files.parts)
        .map(|(part, surface)| alone(folder, part, surface))
        .collect();
    lines.extend(parts.iter().filter_map(|part| sliced(folder, &files.report, part)));
    lines.push(together(folder, parts, &files.parts));
    lines.push(sheet(files, folder));
    lines
}

/// The 3MF file of a part holds its triangles, bit for bit.
fn alone(folder: &Path, part: &Part, surface: &SurfaceMesh) -> Line {
    let file = threemf_file(part);
    let found = shapes(&folder.join(&file));
    let result = found.and_then(|shapes| match &shapes[..] {
        [shape] => same(shape, part, surface),
        _ => Err(format!("{} shapes", shapes.len())),
    });
    line(&file, result, "the triangles of the STL file, in millimetres")
}

/// The shapes of a file of printed parts.
fn shapes(path: &Path) -> Result<Vec<Shape>, String> {
    let model = threemf::read(path).map_err(|e| e.to_string())?;
    match model.unit {
        "millimeter" => Ok(model.shapes),
        unit => Err(format!("the unit is {unit}, must be millimeter")),
    }
}

/// The settings for the slicer are those of the part and the printer.
fn sliced(folder: &Path, report: &MoldReport, part: &Part) -> Option<Line> {
    let settings = slicer::settings(report, part)?;
    let file = slicer::file(part);
    let found = mesh::io::read_text(&folder.join(&file)).map_err(|e| e.to_string());
    let result = found.and_then(|text| match text == settings {
        true => Ok(text.lines().count()),
        false => Err("other settings".into()),
    });
    Some(line(&file, result, "the settings that follow from mold.json"))
}

/// The assembly holds all parts where they are in the closed mold.
fn together(folder: &Path, parts: &[Part], surfaces: &[SurfaceMesh]) -> Line {
    let found = shapes(&folder.join(ASSEMBLY));
    let result = found.and_then(|shapes| {
        if shapes.len() != parts.len() {
            return Err(format!("{} shapes", shapes.len()));
        }
        let shift = shapes[0].place.shift;
        for ((shape, part), surface) in shapes.iter().zip(parts).zip(surfaces) {
            same(shape, part, surface)?;
            let turned = (shape.place.turn - Files::turn(part)).amax();
            let moved = (shape.place.shift - shift).amax();
            // Numbers of transforms are exact, sums of shifts are rounded.
            if turned > 0.0 || moved > 1e-9 {
                return Err(format!("{} is turned by {turned} or moved by {moved} mm", part.name));
            }
        }
        Ok(shapes.len())
    });
    line(ASSEMBLY, result, "all parts, each where it is in the closed mold")
}

/// Triangles that are the same, whatever the numbers of their vertices.
fn same(shape: &Shape, part: &Part, surface: &SurfaceMesh) -> Result<usize, String> {
    let count = shape.surface.triangles.len();
    if shape.name != part.name {
        return Err(format!("its name is {:?}", shape.name));
    }
    if count != surface.triangles.len() {
        return Err(format!("{count} triangles, the STL file has {}", surface.triangles.len()));
    }
    let turn = Files::turn(part);
    let ours = |t: usize| from_the_least(surface.corners(t));
    let other = |t: usize| from_the_least(shape.surface.corners(t).map(|p| turn * p)) != ours(t);
    match (0..count).filter(|&t| other(t)).count() {
        0 => Ok(count),
        n => Err(format!("{n} of {count} triangles differ")),
    }
}

/// A triangle from its least corner on: STL files may begin with another one.
fn from_the_least(corners: [Vec3; 3]) -> [Vec3; 3] {
    // Adding zero turns -0 into +0.
    let mut corners = corners.map(|p| p.add_scalar(0.0));
    let least = (0..3).min_by(|&i, &j| {
        let order = corners[i].iter().zip(&corners[j]).map(|(a, b)| a.total_cmp(b));
        order.fold(std::cmp::Ordering::Equal, std::cmp::Ordering::then)
    });
    corners.rotate_left(least.unwrap_or_default());
    corners
}

/// What the sheet says is that of the report.
fn sheet(files: &Files, folder: &Path) -> Line {
    let read = mesh::io::read_text(&folder.join(sheet::FILE)).map_err(|e| e.to_string());
    let result = read.and_then(|text| {
        let found: Value = serde_json::from_str(&text).map_err(|e| e.to_string())?;
        let sheet = Sheet::new(&files.report)?;
        let text = serde_json::to_string(&sheet).map_err(|e| e.to_string())?;
        let expected: Value = serde_json::from_str(&text).map_err(|e| e.to_string())?;
        let keys = expected.as_object().into_iter().flatten();
        let off: Vec<&str> =
            keys.filter(|(k, v)| !alike(found.get(k), v)).map(|(k, _)| k.as_str()).collect();
        match off.is_empty() {
            false => Err(format!("other {}", off.join(", "))),
            true => Ok(sheet.steps.len()),
        }
    });
    line(sheet::FILE, result, "the volumes and masses of mold.json")
}

/// Whether two values say the same: decimals are read back to the last digits.
fn alike(found: Option<&Value>, expected: &Value) -> bool {
    match (found, expected) {
        (Some(Value::Number(a)), Value::Number(b)) => {
            let (a, b) = (a.as_f64().unwrap_or(f64::NAN), b.as_f64().unwrap_or(f64::NAN));
            (a - b).abs() <= 1e-12 * b.abs()
        }
        (Some(Value::Array(a)), Value::Array(b)) => {
            a.len() == b.len() && a.iter().zip(b).all(|(a, b)| alike(Some(a), b))
        }
        (Some(Value::Object(a)), Value::Object(b)) => {
            a.len() == b.len() && b.iter().all(|(key, b)| alike(a.get(key), b))
        }
        (found, expected) => found == Some(expected),
    }
}

fn line(name: &str, result: Result<usize, String>, needed: &str) -> Line {
    match result {
        Ok(count) => Line::new(name, true, format!("{count} the same"), needed),
        Err(message) => Line::new(name, false, message, needed),
    }
}
