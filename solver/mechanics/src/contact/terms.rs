//! The weighted stencils of the contact [`potential`](super::potential), and their
//! weights w.
//!
//! B = s Σ_k w_k e_k
//!
//! Plain: each pair of a vertex and a triangle or of two edges counts one.
//!
//! Convergent: vertex v and triangle ¼ A_v; edges a and b ¼ (A_a + A_b). Where a
//! closest point lies between fewer corners, several features meet there and all
//! of them are pairs, while the distance to their union should count once. So, as
//! in the inclusion–exclusion of sets,
//!
//! − vertex v and edge e:      ¼ A_v (1 − n),  n triangles at e without v, if n > 1
//! − vertices v and w:         ¼ A_v if w is inside the surface and v makes a pair with
//!                             each triangle there, and the same with v and w exchanged
//! − edge e and vertex v:      −¼ A_e (n − 1), n edges at v that do not touch e and
//!                             are not mollified with it; for each of those that are,
//!                             −¼ A_e times the mollified pair at the distance of v
//!
//! Features whose pair is left out, as they meet through the solid of a body, are not
//! counted. Each part has the least activation of its features' ([`rest_offset`](super::rest_offset)).
//! Equal stencils are merged. Weights may be negative. In the even form the ¼ of
//! vertices and of edges are replaced by [`Form::shares`].
//!
//! Source: Li et al. 2023, "Convergent Incremental Potential Contact",
//! arXiv:2307.15908.

use std::ops::Range;

use mesh::Vec3;

use super::barrier::Form;
use super::distance::{Closest, Region, edge_edge, point_edge};
use super::mollifier::mollified;
use super::pairs::Pair;
use super::rest_offset::{Close, Offset};
use super::stencil::{Stencil, ordered_edges};
use super::surface::Surface;
use super::weights::Adjacency;

/// A stencil with its weight.
#[derive(Clone, Debug, PartialEq)]
pub struct Term {
    /// What interacts.
    pub stencil: Stencil,
    /// w; area [m²] in the convergent form, number in the plain one.
    pub weight: f64,
    shares: Range<usize>,
}

/// What one area adds to the weight of a stencil.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Share {
    stencil: Stencil,
    /// Index of the area; none counts one.
    area: Option<usize>,
    factor: f64,
}

/// The terms at one state, in the order of their stencils.
pub struct Terms {
    /// Stencils with their weights, some of which may be zero.
    pub terms: Vec<Term>,
    shares: Vec<Share>,
}

impl Terms {
    /// The terms of all pairs closer than `range` [m] at positions `x` and rest
    /// positions of the collision vertices.
    pub fn new(
        surface: &Surface,
        adjacency: &Adjacency,
        form: Form,
        active: &[Close],
        x: &[Vec3],
        rest: &[Vec3],
        range: f64,
    ) -> Self {
        let [by_vertex, by_edge] = form.shares();
        let mut collector = Collector {
            by_vertex,
            by_edge,
            surface,
            adjacency,
            x,
            rest,
            range2: range * range,
            shares: Vec::new(),
            point_edges: Vec::new(),
            edge_points: Vec::new(),
            points: Vec::new(),
        };
        match form {
            Form::Plain => active.iter().for_each(|close| {
                let stencil = collector.stencil(close);
                collector.shares.push(Share { stencil, area: None, factor: 1.0 });
            }),
            Form::Convergent | Form::Even => collector.by_area(active),
        }
        Self::merge(collector.shares, &adjacency.areas(rest))
    }

    fn merge(mut shares: Vec<Share>, areas: &[f64]) -> Self {
        shares.sort_by_key(|share| (share.stencil, share.area));
        let mut start = 0;
        let merge = |same: &[Share]| {
            let weights = same.iter().map(|s| s.factor * s.area.map_or(1.0, |a| areas[a]));
            let (sum, size) = weights.fold((0.0, 0.0), |(s, m), w| (s + w, m + w.abs()));
            let range = start..start + same.len();
            start = range.end;
            // a sum that cancels up to rounding is none
            let weight = if sum.abs() > 1e-14 * size { sum } else { 0.0 };
            Term { stencil: same[0].stencil, weight, shares: range }
        };
        let terms = shares.chunk_by(|a, b| a.stencil == b.stencil).map(merge).collect();
        Self { terms, shares }
    }

    /// Adds `by_weight` ∂w/∂A of a term to a list over all areas.
    pub fn add_by_area(&self, term: &Term, by_weight: f64, out: &mut [f64]) {
        for share in &self.shares[term.shares.clone()] {
            if let Some(area) = share.area {
                out[area] += share.factor * by_weight;
            }
        }
    }
}

/// The least activation of features that have a part in common.
fn least_offset(parts: &[Part], active: &[Close]) -> Option<Offset> {
    parts.iter().map(|part| active[part.of].offset).reduce(Offset::least).flatten()
}

struct Collector<'a> {
    /// What the area of a vertex counts with a triangle.
    by_vertex: f64,
    /// What the area of an edge counts with another.
    by_edge: f64,
    surface: &'a Surface,
    adjacency: &'a Adjacency,
    x: &'a [Vec3],
    rest: &'a [Vec3],
    range2: f64,
    shares: Vec<Share>,
    /// Vertex and edge within range, of a vertex and a triangle within range.
    point_edges: Vec<Part>,
    /// Edge and vertex within range, of two edges within range.
    edge_points: Vec<Part>,
    /// Two vertices within range, of the first and a triangle at the second.
    points: Vec<Part>,
}

/// A feature and a part of another that is within range of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Part {
    feature: usize,
    part: usize,
    /// Index of its close pair; the pairs are in a fixed order.
    of: usize,
}

impl Collector<'_> {
    fn by_area(&mut self, active: &[Close]) {
        for (of, close) in active.iter().enumerate() {
            let stencil = self.stencil(close);
            match close.pair {
                Pair::PointTriangle([p, a, b, c]) => {
                    self.add(stencil, p, self.by_vertex);
                    self.note_parts_of_triangle(of, p, [a, b, c]);
                }
                Pair::EdgeEdge([a, b, c, d]) => {
                    let edges = [[a, b], [c, d]].map(|edge| self.adjacency.edge(edge));
                    for edge in edges {
                        self.add(stencil, self.adjacency.area_of_edge(edge), self.by_edge);
                    }
                    self.note_ends(of, edges[0], [c, d]);
                    self.note_ends(of, edges[1], [a, b]);
                }
            }
        }
        let [edges, points, ends] =
            [&mut self.point_edges, &mut self.points, &mut self.edge_points].map(|list| {
                list.sort_unstable();
                std::mem::take(list)
            });
        let same = |a: &Part, b: &Part| (a.feature, a.part) == (b.feature, b.part);
        edges.chunk_by(same).for_each(|parts| self.at_edge(parts, active));
        points.chunk_by(same).for_each(|parts| self.at_points(parts, active));
        ends.chunk_by(same).for_each(|parts| self.at_end(parts, active));
    }

    fn stencil(&self, Close { pair, closest, offset }: &Close) -> Stencil {
        let stencil = match *pair {
            Pair::EdgeEdge([a, b, c, d])
                if mollified(&pair.gather(self.x), &pair.gather(self.rest)) =>
            {
                let ordered = ordered_edges([a, b], [c, d]);
                let closest = edge_edge(&ordered.map(|v| self.x[v]));
                Stencil::mollified(ordered, Region::of(2, &closest))
            }
            pair => Stencil::reduced(pair.corners(), Region::of(pair.corners_of_first(), closest)),
        };
        stencil.with_offset(*offset)
    }

    fn add(&mut self, stencil: Stencil, area: usize, factor: f64) {
        if factor != 0.0 && !self.surface.immovable(&stencil.corners) {
            self.shares.push(Share { stencil, area: Some(area), factor });
        }
    }

    fn note_parts_of_triangle(&mut self, of: usize, p: usize, [a, b, c]: [usize; 3]) {
        for edge in [[a, b], [b, c], [c, a]] {
            if self.point_edge(p, edge).1.d2 < self.range2 {
                self.point_edges.push(Part { feature: p, part: self.adjacency.edge(edge), of });
            }
        }
        for q in [a, b, c] {
            if (self.x[p] - self.x[q]).norm_squared() < self.range2 {
                self.points.push(Part { feature: p, part: q, of });
            }
        }
    }

    fn note_ends(&mut self, of: usize, edge: usize, ends: [usize; 2]) {
        for p in ends {
            if self.point_edge(p, self.adjacency.ends(edge)).1.d2 < self.range2 {
                self.edge_points.push(Part { feature: edge, part: p, of });
            }
        }
    }

    /// A vertex and an edge, once for each triangle at the edge.
    fn at_edge(&mut self, parts: &[Part], active: &[Close]) {
        if parts.len() > 1 {
            let (corners, closest) =
                self.point_edge(parts[0].feature, self.adjacency.ends(parts[0].part));
            let stencil = Stencil::reduced(corners, Region::of(1, &closest));
            let stencil = stencil.with_offset(least_offset(parts, active));
            self.add(stencil, parts[0].feature, self.by_vertex * (1.0 - parts.len() as f64));
        }
    }

    /// A vertex v and another w, once for each triangle at w.
    fn at_points(&mut self, parts: &[Part], active: &[Close]) {
        let Part { feature: v, part: w, .. } = parts[0];
        let region = Region { first: 1, active: [true, true, false, false] };
        let at_edges = self.adjacency.edges_of(w).iter().map(|&e| self.adjacency.opposite(e).len());
        // each triangle has two edges there
        if !self.adjacency.on_rim(w) && 2 * parts.len() == at_edges.sum::<usize>() {
            let stencil = Stencil::reduced([v, w, v, v], region);
            let stencil = stencil.with_offset(least_offset(parts, active));
            self.add(stencil, v, self.by_vertex);
        }
    }

    /// An edge and a vertex, once for each edge there.
    fn at_end(&mut self, parts: &[Part], active: &[Close]) {
        let Part { feature: edge, part: p, .. } = parts[0];
        let (ends, area) = (self.adjacency.ends(edge), self.adjacency.area_of_edge(edge));
        let mut kept = 0.0;
        for Close { pair, offset, .. } in parts.iter().map(|part| &active[part.of]) {
            let [a, b, c, d] = pair.corners();
            let corners = ordered_edges([a, b], [c, d]);
            let x = corners.map(|v| self.x[v]);
            if !mollified(&x, &corners.map(|v| self.rest[v])) {
                kept += 1.0;
                continue;
            }
            let point = (0..4).find(|&i| corners[i] == p).expect("an end of one edge");
            let edge = if point < 2 { [2, 3] } else { [0, 1] };
            let region = Region::of(2, &point_edge(&x, point, edge));
            let stencil = Stencil::mollified(corners, region).with_offset(*offset);
            self.add(stencil, area, -self.by_edge);
        }
        let (corners, closest) = self.point_edge(p, ends);
        let stencil = Stencil::reduced(corners, Region::of(1, &closest));
        let stencil = stencil.with_offset(least_offset(parts, active));
        self.add(stencil, area, -self.by_edge * (kept - 1.0));
    }

    /// Closest points of a vertex and an edge, with corners as of a vertex and a
    /// triangle.
    fn point_edge(&self, p: usize, [a, b]: [usize; 2]) -> ([usize; 4], Closest) {
        let corners = [p, a, b, p];
        (corners, point_edge(&corners.map(|v| self.x[v]), 0, [1, 2]))
    }
}
