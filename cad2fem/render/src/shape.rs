//! What a file holds, ready to be cut and painted.

use std::collections::BTreeMap;

use mesh::topology::{DisjointSets, directed_edges, edge_facets};
use mesh::{Vec3, measure};

use super::Facet;
use super::color::Rgb;

/// Cosine of the angle between facets above which an edge is drawn sharp (40°).
const CREASE: f64 = 0.77;
/// Length of the shortest chain of sharp edges that is drawn, relative to the diagonal.
const CHAIN: f64 = 0.06;
/// Height over longest side below which a triangle is a sliver.
const SLIVER: f64 = 0.1;

/// A triangle of a surface that shares its points with others.
#[derive(Clone, Copy, Debug)]
pub struct Triangle {
    /// Indices of its points, counter-clockwise from outside.
    pub points: [usize; 3],
    /// Field value at each corner; NaN where the triangle has its own colour.
    pub values: [f64; 3],
    /// Colour where there is no field value.
    pub color: Rgb,
    /// Bit i: the side from corner i to i + 1 is an edge of the mesh.
    pub edges: u8,
}

/// The solid behind a surface: tetrahedra with 4 or 10 nodes in VTK order.
#[derive(Clone, Debug, Default)]
pub struct Cells {
    /// Node positions.
    pub points: Vec<Vec3>,
    /// Nodes of each tetrahedron.
    pub nodes: Vec<Vec<usize>>,
    /// Field value at each node of each tetrahedron; NaN for none.
    pub values: Vec<Vec<f64>>,
    /// Colour of each tetrahedron where there is no field value.
    pub colors: Vec<Rgb>,
}

/// A surface and, if it bounds a mesh, the solid inside.
#[derive(Clone, Debug)]
pub struct Shape {
    /// The surface.
    pub facets: Vec<Facet>,
    /// What a cut shows; none for a mere surface.
    pub cells: Option<Cells>,
    /// Whether a surface without cells is closed, so that a cut through it has a face.
    pub closed: bool,
}

impl Shape {
    /// Moves the shape.
    pub fn translate(&mut self, by: &Vec3) {
        for p in self.facets.iter_mut().flat_map(|f| &mut f.points) {
            *p += by;
        }
        for p in self.cells.iter_mut().flat_map(|c| &mut c.points) {
            *p += by;
        }
    }
}

/// Triangles with shading normals: the mean of the normals around a point,
/// weighted by angle, over those neighbours that do not lie across a crease.
pub fn shade(points: &[Vec3], triangles: &[Triangle]) -> Vec<Facet> {
    let corners: Vec<[usize; 3]> = triangles.iter().map(|t| t.points).collect();
    let edges = edge_facets(&corners);
    let normals = facet_normals(points, triangles, &edges);
    let around = incidence(points.len(), triangles);
    let features = features(points, &corners, &normals, &edges);
    let smooth = |t: usize, corner: usize| {
        let v = triangles[t].points[corner];
        let mut sum = Vec3::zeros();
        for &n in around[v].iter().filter(|&&n| normals[t].dot(&normals[n]) > CREASE) {
            sum += angle(points, &triangles[n], v) * normals[n];
        }
        sum.try_normalize(1e-12).unwrap_or(normals[t])
    };
    triangles
        .iter()
        .enumerate()
        .map(|(t, triangle)| Facet {
            points: triangle.points.map(|v| points[v]),
            normals: [0, 1, 2].map(|corner| smooth(t, corner)),
            values: triangle.values,
            color: triangle.color,
            edges: triangle.edges,
            features: features[t],
            section: false,
        })
        .collect()
}

/// Edges, ends in ascending order, and the triangles at each.
type Edges = BTreeMap<[usize; 2], Vec<usize>>;

/// Unit normals. That of a sliver says little: where two triangles beside it
/// agree with each other but not with it, it takes their mean.
fn facet_normals(points: &[Vec3], triangles: &[Triangle], edges: &Edges) -> Vec<Vec3> {
    let own: Vec<Vec3> = triangles.iter().map(|t| normal(points, t)).collect();
    let mut beside: Vec<Vec<Vec3>> = vec![Vec::new(); triangles.len()];
    for on in edges.values() {
        if let [a, b] = on[..] {
            beside[a].push(own[b]);
            beside[b].push(own[a]);
        }
    }
    let agree = |a: &Vec3, b: &Vec3| a.dot(b) > CREASE;
    let outvoted = |t: usize| {
        let pairs = [(0, 1), (1, 2), (2, 0)];
        let pairs = pairs.iter().filter_map(|&(i, j)| beside[t].get(i).zip(beside[t].get(j)));
        let mut against =
            pairs.filter(|(a, b)| agree(a, b) && !agree(a, &own[t]) && !agree(b, &own[t]));
        against.next().map(|(a, b)| (a + b).normalize())
    };
    (0..triangles.len())
        .map(|t| {
            Some(t)
                .filter(|&t| is_sliver(points, &triangles[t]))
                .and_then(outvoted)
                .unwrap_or(own[t])
        })
        .collect()
}

fn normal(points: &[Vec3], triangle: &Triangle) -> Vec3 {
    let [a, b, c] = triangle.points.map(|v| points[v]);
    (b - a).cross(&(c - a)).try_normalize(0.0).unwrap_or_else(Vec3::z)
}

fn is_sliver(points: &[Vec3], triangle: &Triangle) -> bool {
    let [a, b, c] = triangle.points.map(|v| points[v]);
    let longest = [b - a, c - b, a - c].map(|e| e.norm_squared()).into_iter().fold(0.0, f64::max);
    (b - a).cross(&(c - a)).norm() < SLIVER * longest
}

fn incidence(count: usize, triangles: &[Triangle]) -> Vec<Vec<usize>> {
    let mut around = vec![Vec::new(); count];
    for (t, triangle) in triangles.iter().enumerate() {
        for v in triangle.points {
            around[v].push(t);
        }
    }
    around
}

/// Angle of a triangle at point `v` [rad].
fn angle(points: &[Vec3], triangle: &Triangle, v: usize) -> f64 {
    let i = triangle.points.iter().position(|&p| p == v).unwrap_or(0);
    let [a, b, c] = [0, 1, 2].map(|k| points[triangle.points[(i + k) % 3]]);
    (b - a).angle(&(c - a))
}

/// Per triangle, the sides that are creases or open and belong to a chain of
/// some length: single sharp edges are flaws of a mesh, not of a shape.
fn features(points: &[Vec3], triangles: &[[usize; 3]], normals: &[Vec3], edges: &Edges) -> Vec<u8> {
    let sharp = |on: &[usize]| match on[..] {
        [a, b] => normals[a].dot(&normals[b]) < CREASE,
        _ => true,
    };
    let sharp: Vec<(&[usize; 2], &Vec<usize>)> = edges.iter().filter(|(_, on)| sharp(on)).collect();
    let ends: Vec<[usize; 2]> = sharp.iter().map(|(edge, _)| **edge).collect();
    let long = CHAIN * measure::diagonal(points);
    let mut features = vec![0; triangles.len()];
    for ((edge, on), length) in sharp.iter().zip(chain_lengths(points, &ends)) {
        for &t in on.iter().filter(|_| length >= long) {
            let is_side = |[a, b]: [usize; 2]| **edge == [a.min(b), a.max(b)];
            let sides = directed_edges(triangles[t]).into_iter().enumerate();
            sides.filter(|(_, side)| is_side(*side)).for_each(|(i, _)| features[t] |= 1 << i);
        }
    }
    features
}

/// For every edge, the total length of the edges that are connected with it.
fn chain_lengths(points: &[Vec3], edges: &[[usize; 2]]) -> Vec<f64> {
    let mut chains = DisjointSets::new(points.len());
    edges.iter().for_each(|&[a, b]| chains.join(a, b));
    let mut lengths = vec![0.0; points.len()];
    for &[a, b] in edges {
        lengths[chains.representative(a)] += (points[b] - points[a]).norm();
    }
    edges.iter().map(|&[a, _]| lengths[chains.representative(a)]).collect()
}
