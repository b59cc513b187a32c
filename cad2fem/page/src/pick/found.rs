//! What a body proposes by itself: closed chambers, flat sides to hold or to mirror at, and planes
//! in which it is its own mirror image.

use std::collections::BTreeSet;

use mesh::Vec3;
use mesh::bvh::SurfaceBvh;
use mesh::measure::{bounds, diagonal, enclosed_volume};
use mesh::topology::{components, submesh};
use serde_json::{Value, json};

use super::MM;
use super::body::{Body, Face};

/// Lengths that differ by less are the same [diagonal].
const SAME: f64 = 1e-4;

/// How far a mirror image may be from the body, which both are made of triangles [diagonal].
const MIRRORED: f64 = 2e-3;

/// A flat side that is smaller is no proposal [area of the body].
const LARGE: f64 = 0.01;

/// Vertices by which a mirror image is compared.
const PROBES: usize = 2000;

/// All proposals.
#[must_use]
pub fn of(body: &Body) -> Value {
    json!({
        "chambers": chambers(body),
        "sides": sides(body),
        "mirrors": (0..3).filter_map(|axis| mirror(body, axis)).collect::<Vec<_>>(),
    })
}

/// Triangles that bound the body.
fn skin(body: &Body) -> usize {
    let outer = body.faces.iter().filter(|face| !face.inside);
    outer.map(|face| face.triangles.end).max().unwrap_or(0)
}

/// Closed surfaces that face inward, with all their faces, the largest first.
fn chambers(body: &Body) -> Vec<Value> {
    let triangles = &body.surface.triangles[..skin(body)];
    let mut found = Vec::new();
    let mut inner = vec![false; triangles.len()];
    for shell in components(triangles) {
        let own: Vec<_> = shell.iter().map(|&t| triangles[t]).collect();
        let volume = enclosed_volume(&submesh(&body.surface.vertices, &own).0);
        if volume < 0.0 {
            shell.iter().for_each(|&t| inner[t] = true);
            found.push((-volume, shell));
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let face_of = |t: usize| body.faces.iter().position(|face| face.triangles.contains(&t));
    let chamber = |(volume, shell): (f64, Vec<usize>)| {
        let faces: BTreeSet<usize> = shell.iter().filter_map(|&t| face_of(t)).collect();
        // a region that is also outside is no wall
        let whole = |&f: &usize| {
            let Face { triangles, file, .. } = &body.faces[f];
            file.is_some() && triangles.clone().all(|t| inner[t])
        };
        let volume = MM.powi(3) * volume;
        faces.iter().all(whole).then(|| json!({ "volume": volume, "faces": faces }))
    };
    found.into_iter().filter_map(chamber).collect()
}

/// Flat faces at the ends of the body along the axes, the largest first.
fn sides(body: &Body) -> Vec<Value> {
    let (low, high) = bounds(&body.surface.vertices);
    let same = SAME * diagonal(&body.surface.vertices);
    let total: f64 = body.faces.iter().map(|face| face.area).sum();
    let mut found = Vec::new();
    for axis in 0..3 {
        for (sign, at) in [(-1.0, low[axis]), (1.0, high[axis])] {
            let there = |face: &Face| {
                let facing = face.normal.is_some_and(|n| sign * n[axis] > 0.9999);
                facing
                    && face.file.is_some()
                    && !face.inside
                    && (face.middle[axis] - at).abs() < same
            };
            let faces: Vec<usize> =
                (0..body.faces.len()).filter(|&f| there(&body.faces[f])).collect();
            let area: f64 = faces.iter().map(|&f| body.faces[f].area).sum();
            if area > LARGE * total {
                let at = if at.abs() < same { 0.0 } else { MM * at };
                found.push((area, json!({ "axis": axis, "sign": sign, "at": at, "faces": faces })));
            }
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.into_iter().map(|(_, side)| side).collect()
}

/// The plane across an axis through the middle, if the body is its mirror image in it, with the
/// image of each face; null of a face whose image is not one.
fn mirror(body: &Body, axis: usize) -> Option<Value> {
    let vertices = &body.surface.vertices;
    let (low, high) = bounds(vertices);
    let at = 0.5 * (low[axis] + high[axis]);
    let image = |p: &Vec3| {
        let mut q = *p;
        q[axis] = 2.0 * at - q[axis];
        q
    };
    let close = MIRRORED * diagonal(vertices);
    let bvh = SurfaceBvh::new(&body.surface);
    let step = vertices.len().div_ceil(PROBES);
    let on_body = |p: &Vec3| bvh.closest(&image(p)).distance < close;
    if !vertices.iter().step_by(step).all(on_body) {
        return None;
    }
    let partner = |face: &Face| {
        let target = image(&face.middle);
        let alike = |other: &Face| {
            let area = (other.area / face.area - 1.0).abs() < 0.02;
            let distance = (other.middle - target).norm();
            (area && other.inside == face.inside && distance < close).then_some(distance)
        };
        let alike = body.faces.iter().enumerate().filter_map(|(i, f)| Some((alike(f)?, i)));
        alike.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, i)| i)
    };
    let partners: Vec<Option<usize>> = body.faces.iter().map(partner).collect();
    let at = if at.abs() < 1e-9 { 0.0 } else { MM * at };
    Some(json!({ "axis": axis, "at": at, "partners": partners }))
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::body::tests::hollow;
    use super::*;

    #[test]
    fn a_hollow_box_has_a_chamber_sides_and_mirrors() {
        let folder = hollow();
        let found = of(&Body::read(folder.path()).unwrap());
        assert_eq!(found["chambers"].as_array().unwrap().len(), 1);
        let chamber = &found["chambers"][0];
        assert!((chamber["volume"].as_f64().unwrap() - 800.0).abs() < 1e-3, "{chamber}");
        assert_eq!(chamber["faces"], json!([6, 7, 8, 9, 10, 11]));
        let sides = found["sides"].as_array().unwrap();
        assert_eq!(sides.len(), 6);
        assert!(sides.iter().all(|side| side["faces"].as_array().unwrap().len() == 1));
        assert_eq!(sides[0]["axis"], 2, "the largest");
        // the air is nearer to one end: no mirror across x
        let mirrors = found["mirrors"].as_array().unwrap();
        let axes: Vec<_> = mirrors.iter().map(|m| m["axis"].as_u64().unwrap()).collect();
        assert_eq!(axes, [1, 2]);
        let partners = mirrors[0]["partners"].as_array().unwrap();
        let own = partners.iter().enumerate().filter(|(i, p)| **p == json!(i)).count();
        assert_eq!(own, 8, "all but those that face ±y");
    }
}
