//! What a body proposes by itself: closed chambers, chambers that open in a flat face, flat sides to
//! hold or to mirror at.

use std::collections::BTreeSet;

use mesh::Vec3;
use mesh::measure::{bounds, diagonal, enclosed_volume};
use mesh::topology::components;
use serde_json::{Value, json};

use super::MM;
use super::body::{Body, Face};

/// Lengths that differ by less are the same [diagonal].
const SAME: f64 = 1e-4;

/// A flat side that is smaller is no proposal [area of the body].
const LARGE: f64 = 0.01;

/// A pocket that is smaller is no chamber [bounding box].
const ROOMY: f64 = 2e-3;

/// All proposals.
pub fn of(body: &Body) -> Value {
    json!({
        "chambers": chambers(body),
        "pockets": pockets(body),
        "sides": sides(body),
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
        let volume = enclosed_volume(&body.surface.part(&shell));
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

/// Faces that are joined with the rest of the body through one flat face alone, and hollow: the walls
/// of chambers that open in it. The largest first.
fn pockets(body: &Body) -> Vec<Value> {
    let (low, high) = bounds(&body.surface.vertices);
    let least = ROOMY * (high - low).product();
    let mut found: Vec<(f64, usize, BTreeSet<usize>)> = Vec::new();
    for (lid, normal) in body.faces.iter().map(|face| face.normal).enumerate() {
        let (Some(normal), false) = (normal, body.faces[lid].inside) else { continue };
        for faces in apart(body, lid) {
            let volume = -volume_over(body, &faces, &body.faces[lid].middle);
            let hollow = volume > least && faces.iter().all(|&f| body.faces[f].file.is_some());
            if hollow && lies_below(body, &faces, &body.faces[lid].middle, &normal) {
                found.push((volume, lid, faces));
            }
        }
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    // what lies within another pocket is a part of its wall
    let outermost = (0..found.len())
        .filter(|&i| found[..i].iter().all(|larger| !found[i].2.is_subset(&larger.2)));
    let value = |i: usize| {
        let (volume, lid, faces) = &found[i];
        json!({ "volume": MM.powi(3) * volume, "lid": lid, "faces": faces })
    };
    outermost.map(value).collect()
}

/// The parts that the faces around a face form when the face is taken out, without the one with the largest box, the
/// outside: of what has folds, the chamber's wall may have more area.
fn apart(body: &Body, lid: usize) -> Vec<BTreeSet<usize>> {
    let around: Vec<usize> = body.beside(lid).collect();
    let mut parts: Vec<BTreeSet<usize>> = Vec::new();
    for start in around {
        if parts.iter().any(|part| part.contains(&start)) {
            continue;
        }
        let (mut part, mut front) = (BTreeSet::from([start]), vec![start]);
        while let Some(face) = front.pop() {
            let next = body.beside(face).filter(|&next| next != lid);
            front.extend(next.filter(|&next| part.insert(next)));
        }
        parts.push(part);
    }
    let size = |part: &BTreeSet<usize>| {
        let triangles = part.iter().flat_map(|&f| body.faces[f].triangles.clone());
        diagonal(&triangles.flat_map(|t| body.surface.corners(t)).collect::<Vec<Vec3>>())
    };
    parts.sort_by(|a, b| size(b).total_cmp(&size(a)));
    parts.into_iter().skip(1).collect()
}

/// What faces enclose with a flat lid through a point [m³].
fn volume_over(body: &Body, faces: &BTreeSet<usize>, point: &Vec3) -> f64 {
    let part = |t: usize| {
        let [a, b, c] = body.surface.corners(t).map(|p| p - point);
        a.dot(&b.cross(&c)) / 6.0
    };
    faces.iter().flat_map(|&f| body.faces[f].triangles.clone()).map(part).sum()
}

/// Whether faces lie behind a plane, where the body is.
fn lies_below(body: &Body, faces: &BTreeSet<usize>, point: &Vec3, normal: &Vec3) -> bool {
    let same = SAME * diagonal(&body.surface.vertices);
    let below = |t: usize| body.surface.corners(t).iter().all(|p| normal.dot(&(p - point)) < same);
    faces.iter().flat_map(|&f| body.faces[f].triangles.clone()).all(below)
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

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::super::body::tests::{body_with_air, hollow};
    use super::*;

    #[test]
    fn a_chamber_that_opens_in_a_flat_face_is_found() {
        // the air reaches the outside at x = 0
        let folder = body_with_air(-5.0);
        let mut body = Body::read(folder.path()).unwrap();
        let found = of(&body);
        assert_eq!(found["chambers"], json!([]));
        let pockets = found["pockets"].as_array().unwrap();
        assert_eq!(pockets.len(), 1, "{pockets:?}");
        // 25 mm long, five walls
        assert!((pockets[0]["volume"].as_f64().unwrap() - 1000.0).abs() < 1e-3, "{pockets:?}");
        assert_eq!(pockets[0]["faces"].as_array().unwrap().len(), 5);
        let lid = &body.faces[pockets[0]["lid"].as_u64().unwrap() as usize];
        assert_eq!(lid.normal, Some(-Vec3::x()));
        // folds give walls of a chamber more area than the outside has
        for face in pockets[0]["faces"].as_array().unwrap() {
            body.faces[face.as_u64().unwrap() as usize].area *= 10.0;
        }
        assert_eq!(of(&body)["pockets"], found["pockets"]);
    }

    #[test]
    fn a_hollow_box_has_a_chamber_and_sides() {
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
    }
}
