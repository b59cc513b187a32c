//! Geometry that knows neither bodies nor molds: the mold's frame, solids as columns, caps of
//! planar holes, local maxima of height, sections and their girth, overhangs, frusta.

pub mod cap;
pub mod columns;
pub mod frame;
pub mod frustum;
pub mod girth;
pub mod maxima;
pub mod overhang;

/// A point or direction, as files have it.
pub type Triple = [f64; 3];

/// Millimetres per metre.
pub const MM: f64 = 1e3;
