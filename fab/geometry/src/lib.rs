//! Geometry that knows neither settings nor files: the mold's frame, solids as columns, caps of
//! planar holes, local maxima of height, planes clear of vertices, sections and their girth,
//! overhangs, undercuts, partings by a height field, frusta.

pub mod cap;
pub mod columns;
pub mod frame;
pub mod frustum;
pub mod gap;
pub mod girth;
pub mod height_field;
pub mod maxima;
pub mod overhang;
pub mod undercut;

use mesh::Vec3;

/// From where to where points reach along a direction [m].
pub fn extent<'a>(points: impl IntoIterator<Item = &'a Vec3>, along: &Vec3) -> [f64; 2] {
    points
        .into_iter()
        .map(|p| p.dot(along))
        .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], x| [a.min(x), b.max(x)])
}

/// A point [m] in words, in millimetres with some decimals.
pub fn place(p: &Vec3, decimals: usize) -> String {
    let [x, y, z] = (p * MM).into();
    format!("({x:.decimals$}, {y:.decimals$}, {z:.decimals$}) mm")
}

/// A point or direction, as files have it.
pub type Triple = [f64; 3];

/// Millimetres per metre.
pub const MM: f64 = 1e3;
