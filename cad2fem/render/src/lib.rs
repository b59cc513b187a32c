//! Shaded pictures in software, without a display.
//!
//! Steps of a picture: a file becomes a [`shape::Shape`] (triangles with
//! shading normals, and cells where it is solid), is cut by a plane
//! ([`cut`]), seen by a [`camera::Camera`], reduced to visible fragments
//! ([`raster`]), lit by a sky and a key light with real shadows ([`light`]),
//! and set on a [`sheet`] with title, captions, scale ([`annotate`]) and labels ([`label`]).
//!
//! Colours are linear RGB until a pixel is finished.

pub mod annotate;
pub mod camera;
pub mod color;
pub mod cut;
pub mod font;
pub mod image;
pub mod label;
pub mod light;
pub mod panel;
pub mod quadratic;
pub mod raster;
pub mod shape;
pub mod sheet;
pub mod view;
pub mod zbuffer;

use color::Rgb;
use mesh::Vec3;

/// A triangle to draw.
#[derive(Clone, Copy, Debug)]
pub struct Facet {
    /// Corners, counter-clockwise from outside.
    pub points: [Vec3; 3],
    /// Unit shading normal at each corner.
    pub normals: [Vec3; 3],
    /// Field value at each corner; NaN where the facet has its own colour.
    pub values: [f64; 3],
    /// Colour where there is no field value.
    pub color: Rgb,
    /// Bit i: the side from corner i to i + 1 is an edge of the mesh.
    pub edges: u8,
    /// Bit i: that side is a sharp or open edge of the shape.
    pub features: u8,
    /// Whether this is part of a cut through a solid.
    pub section: bool,
}

impl Facet {
    /// Turns its back to the front.
    pub fn turn(&mut self) {
        self.points.swap(1, 2);
        self.values.swap(1, 2);
        self.normals.swap(1, 2);
        self.normals.iter_mut().for_each(|n| *n = -*n);
        // the first and the last side are exchanged
        for sides in [&mut self.edges, &mut self.features] {
            *sides = (*sides & 0b010) | ((*sides >> 2) & 1) | ((*sides & 1) << 2);
        }
    }
}

/// Facets drawn as one object.
#[derive(Clone, Debug, Default)]
pub struct Piece {
    /// What to draw.
    pub facets: Vec<Facet>,
    /// Whether the facets enclose a volume.
    pub closed: bool,
    /// Set if the facets are a closed surface that was cut: wherever its
    /// inside would be seen, the cut face is drawn in this colour.
    pub cap: Option<Cap>,
}

/// The face that a plane leaves on a closed surface.
#[derive(Clone, Copy, Debug)]
pub struct Cap {
    /// The plane that cut it.
    pub plane: cut::Plane,
    /// Colour of the face.
    pub color: Rgb,
}

/// Axis-aligned bounds of all facets, if there are any.
pub fn bounds(pieces: &[Piece]) -> Option<(Vec3, Vec3)> {
    let points = pieces.iter().flat_map(|p| &p.facets).flat_map(|f| f.points);
    points.map(|p| (p, p)).reduce(|(min, max), (p, _)| (min.inf(&p), max.sup(&p)))
}
