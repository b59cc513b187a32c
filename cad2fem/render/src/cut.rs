//! Cutting shapes by a plane.
//!
//! The part beyond the plane goes. Tetrahedra show their exact section with
//! the field interpolated on it; closed surfaces get their face while drawing
//! (see [`super::Cap`]); open surfaces show their inside.

use mesh::Vec3;

use super::color::section;
use super::quadratic::{SmallTet, split_tet};
use super::shape::{Cells, Shape};
use super::{Cap, Facet, Piece};

/// The points with n · x ≤ offset stay.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Plane {
    /// Unit normal, towards the part that goes.
    pub normal: Vec3,
    /// Distance from the origin along the normal.
    pub offset: f64,
}

impl Plane {
    /// Distance beyond the plane, negative for what stays.
    pub fn beyond(&self, p: &Vec3) -> f64 {
        self.normal.dot(p) - self.offset
    }
}

/// What is left of a shape, with the face of the cut.
pub fn cut(shape: &Shape, plane: Option<Plane>) -> Piece {
    let Some(plane) = plane else {
        return Piece { facets: shape.facets.clone(), closed: shape.closed, cap: None };
    };
    let mut facets: Vec<Facet> = shape.facets.iter().flat_map(|f| clip(f, &plane)).collect();
    if let Some(cells) = &shape.cells {
        facets.extend(sections(cells, &plane));
    }
    let solid = shape.cells.is_some();
    let like = shape.facets.first().filter(|_| shape.closed && !solid);
    let cap = like.map(|f| Cap { plane, color: section(f.color) });
    Piece { facets, closed: shape.closed && solid, cap }
}

/// A corner of a clipped polygon; `edge` and `feature` describe the side that
/// starts here.
#[derive(Clone, Copy)]
struct Corner {
    point: Vec3,
    normal: Vec3,
    value: f64,
    edge: bool,
    feature: bool,
}

/// The part of a facet that stays, as up to two facets.
fn clip(facet: &Facet, plane: &Plane) -> Vec<Facet> {
    let beyond = facet.points.map(|p| plane.beyond(&p));
    if beyond.iter().all(|&d| d <= 0.0) {
        return vec![*facet];
    }
    let mut polygon = Vec::with_capacity(4);
    for i in 0..3 {
        let j = (i + 1) % 3;
        let corner = Corner {
            point: facet.points[i],
            normal: facet.normals[i],
            value: facet.values[i],
            edge: facet.edges >> i & 1 == 1,
            feature: facet.features >> i & 1 == 1,
        };
        if beyond[i] <= 0.0 {
            polygon.push(corner);
        }
        if (beyond[i] <= 0.0) != (beyond[j] <= 0.0) {
            let t = beyond[i] / (beyond[i] - beyond[j]);
            let leaving = beyond[i] <= 0.0;
            polygon.push(Corner {
                point: facet.points[i].lerp(&facet.points[j], t),
                normal: facet.normals[i].lerp(&facet.normals[j], t).normalize(),
                value: (1.0 - t) * facet.values[i] + t * facet.values[j],
                edge: !leaving && corner.edge,
                feature: leaving || corner.feature,
            });
        }
    }
    fan(&polygon, facet)
}

/// A convex polygon as triangles; sides inside it are no edges.
fn fan(polygon: &[Corner], like: &Facet) -> Vec<Facet> {
    let last = polygon.len().saturating_sub(1);
    (1..last)
        .map(|i| {
            let corners = [polygon[0], polygon[i], polygon[i + 1]];
            let border = [i == 1, true, i + 1 == last];
            let bits = |on: fn(&Corner) -> bool| {
                // The side that closes the fan starts at the last corner.
                (0..3).filter(|&k| border[k] && on(&corners[k])).map(|k| 1 << k).sum()
            };
            Facet {
                points: corners.map(|c| c.point),
                normals: corners.map(|c| c.normal),
                values: corners.map(|c| c.value),
                color: like.color,
                edges: bits(|c| c.edge),
                features: bits(|c| c.feature),
                section: like.section,
            }
        })
        .collect()
}

/// Sections of all tetrahedra that the plane meets.
fn sections(cells: &Cells, plane: &Plane) -> Vec<Facet> {
    let mut facets = Vec::new();
    let all = cells.nodes.iter().zip(&cells.values).zip(&cells.colors);
    for ((nodes, values), color) in all {
        let points: Vec<Vec3> = nodes.iter().map(|&v| cells.points[v]).collect();
        if !may_meet(&points, plane) {
            continue;
        }
        let tets = if points.len() == 4 {
            vec![SmallTet {
                points: [0, 1, 2, 3].map(|i| points[i]),
                values: [0, 1, 2, 3].map(|i| values[i]),
                faces: 0b1111,
            }]
        } else {
            split_tet(&points, values)
        };
        facets.extend(tets.iter().flat_map(|tet| slice(tet, plane, section(*color))));
    }
    facets
}

/// A curved edge bulges by at most the distance of its middle node from its
/// chord, which is less than the spread of the nodes.
fn may_meet(points: &[Vec3], plane: &Plane) -> bool {
    let beyond = points.iter().map(|p| plane.beyond(p));
    let (min, max) =
        beyond.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), d| (a.min(d), b.max(d)));
    let slack = if points.len() > 4 { 0.25 * (max - min) } else { 0.0 };
    min - slack <= 0.0 && max + slack > 0.0
}

/// The section of a straight tetrahedron: nothing, a triangle or a quadrilateral.
fn slice(tet: &SmallTet, plane: &Plane, color: super::color::Rgb) -> Vec<Facet> {
    let beyond = tet.points.map(|p| plane.beyond(&p));
    let (stay, go): (Vec<usize>, Vec<usize>) = (0..4).partition(|&i| beyond[i] <= 0.0);
    // Crossed edges in the order of their points around the section.
    let edges: Vec<[usize; 2]> = match (&stay[..], &go[..]) {
        (&[a], go) => go.iter().map(|&b| [a, b]).collect(),
        (stay, &[b]) => stay.iter().map(|&a| [a, b]).collect(),
        (&[a, b], &[c, d]) => vec![[a, c], [a, d], [b, d], [b, c]],
        _ => return vec![],
    };
    let mut polygon: Vec<Corner> = Vec::with_capacity(4);
    for (i, &[a, b]) in edges.iter().enumerate() {
        let t = beyond[a] / (beyond[a] - beyond[b]);
        let [c, d] = edges[(i + 1) % edges.len()];
        // The side to the next point lies on the face without the fourth corner.
        let opposite = (0..4).find(|k| ![a, b, c, d].contains(k));
        polygon.push(Corner {
            point: tet.points[a].lerp(&tet.points[b], t),
            normal: plane.normal,
            value: (1.0 - t) * tet.values[a] + t * tet.values[b],
            edge: opposite.is_some_and(|k| tet.faces >> k & 1 == 1),
            feature: false,
        });
    }
    let like = Facet {
        points: [Vec3::zeros(); 3],
        normals: [plane.normal; 3],
        values: [f64::NAN; 3],
        color,
        edges: 0,
        features: 0,
        section: true,
    };
    let mut facets = fan(&polygon, &like);
    facets.iter_mut().for_each(|f| face(f, &plane.normal));
    facets
}

/// Turns a facet so that it faces `normal`.
fn face(facet: &mut Facet, normal: &Vec3) {
    let [a, b, c] = facet.points;
    if (b - a).cross(&(c - a)).dot(normal) < 0.0 {
        facet.turn();
        facet.normals = [*normal; 3];
    }
}

#[cfg(test)]
mod tests {
    use super::super::color::material;
    use super::*;

    fn area(facets: &[Facet]) -> f64 {
        let [a, b, c] = [0, 1, 2].map(|i| move |f: &Facet| f.points[i]);
        facets.iter().map(|f| mesh::measure::triangle_area(a(f), b(f), c(f))).sum()
    }

    fn tet() -> Cells {
        Cells {
            points: vec![Vec3::zeros(), Vec3::x(), Vec3::y(), Vec3::z()],
            nodes: vec![vec![0, 1, 2, 3]],
            values: vec![vec![0.0, 1.0, 0.0, 0.0]],
            colors: vec![material()],
        }
    }

    fn plane(normal: Vec3, offset: f64) -> Plane {
        Plane { normal: normal.normalize(), offset: offset / normal.norm() }
    }

    #[test]
    fn sections_have_the_exact_area_and_face_the_cut() {
        // x = h cuts a triangle of legs 1 − h; x + y = h a rectangle of sides h√2 and 1 − h
        let h = 0.3;
        let cases = [
            (plane(Vec3::x(), h), 0.5 * (1.0 - h) * (1.0 - h), 3),
            (plane(-Vec3::x(), -h), 0.5 * (1.0 - h) * (1.0 - h), 3),
            (plane(Vec3::new(1.0, 1.0, 0.0), h), h * 2.0_f64.sqrt() * (1.0 - h), 4),
        ];
        for (plane, expected, sides) in cases {
            let facets = sections(&tet(), &plane);
            assert!((area(&facets) - expected).abs() < 1e-15, "{} {expected}", area(&facets));
            assert_eq!(facets.iter().map(|f| f.edges.count_ones()).sum::<u32>(), sides);
            for f in &facets {
                let [a, b, c] = f.points;
                assert!((b - a).cross(&(c - a)).dot(&plane.normal) > 0.0);
                // the field is x, linear on the section
                assert!(f.points.iter().zip(f.values).all(|(p, v)| (p.x - v).abs() < 1e-15));
            }
        }
    }

    #[test]
    fn clipping_keeps_the_near_part_and_marks_the_cut() {
        let facet = Facet {
            points: [Vec3::zeros(), Vec3::x(), Vec3::y()],
            normals: [Vec3::z(); 3],
            values: [0.0, 1.0, 0.0],
            color: material(),
            edges: 0b111,
            features: 0,
            section: false,
        };
        let kept = clip(&facet, &plane(Vec3::x(), 0.5));
        assert!((area(&kept) - 0.375).abs() < 1e-15);
        assert_eq!(kept.iter().map(|f| f.edges.count_ones()).sum::<u32>(), 3);
        assert_eq!(kept.iter().map(|f| f.features.count_ones()).sum::<u32>(), 1);
        assert_eq!(clip(&facet, &plane(Vec3::x(), 2.0)).len(), 1);
        assert!(clip(&facet, &plane(Vec3::x(), -1.0)).is_empty());
    }
}
