//! The wall of a chamber, and the volume behind it.
//!
//! V(x) = C(x) − ⅓ ∫_Γ (x − o) · (g₁ × g₂) dξ      g_α = ∂x/∂ξ_α
//! ∂V/∂x_a = −∫ φ_a (g₁ × g₂) dξ
//! ∂²V/∂x_a∂x_b = −S_ab,  S_ab = ∫ φ_a (−∂₁φ_b [g₂]ₓ + ∂₂φ_b [g₁]ₓ) dξ
//!
//! Facets are oriented out of the solid, so that g₁ × g₂ points into the
//! chamber. An open wall is closed by caps, one for each loop of its [`Rim`]: the
//! cone from the mean c of the loop's vertices, of volume
//! C = ⅙ ∮ ((x − o) × dx) · (c − o). Its rim must not move, or only within a plane in which
//! the cap then lies: in both cases the cap does no work. Or a plug holds the gas there ([`plug`]). S is symmetric when Γ is closed
//! or its rim is held like that: what is not symmetric is ∮ (δ₁x × δ₂x) · dx along the rim.
//!
//! A wall that planes of symmetry cut is closed by a piece of each plane. The origin o lies
//! in all of them, so that these pieces add nothing to V: (x − o) · n = 0 there. They do no
//! work, as the rim slides in the planes, so no force and no stiffness belongs to them. V is
//! the volume of the part, without its mirror images. Without planes o = 0.
//!
//! Source: Rumpel and Schweizerhof 2003, doi:10.1002/nme.561; Niewiarowski,
//! Adriaenssens and Pauletti 2020, doi:10.1016/j.cma.2020.113059.

mod plug;

use mesh::Vec3;

use super::Iterate;
use super::rim::{Rim, rims};
use crate::element::{FunctionSpace, add_at, at};
use crate::math::sparse::{BlockMatrix, pair_count, pair_index};
use crate::math::tensor::{Mat3, cross_matrix};
use crate::parallel::map_each;
use crate::symmetry::Plane;

/// Nodes of a facet, at most.
const MOST_NODES: usize = 10;

/// Facets of the solid around a chamber, as node ids.
#[derive(Clone, Debug)]
pub struct Wall {
    facets: Vec<Vec<usize>>,
    /// What caps close.
    rims: Vec<Rim>,
    /// Whether the gas pushes on the caps, too.
    plugged: bool,
    /// o [m].
    origin: Vec3,
}

/// Values of a facet at one quadrature point; the weight includes the ½ of the
/// reference triangle's area.
struct Point<'a> {
    weight: f64,
    values: &'a [f64],
    gradients: &'a [[f64; 3]],
    g1: Vec3,
    g2: Vec3,
}

impl Point<'_> {
    /// The matrix of ∂(g₁ × g₂)/∂x_b.
    fn normal_by(&self, b: usize) -> Mat3 {
        let [d1, d2, _] = self.gradients[b];
        d2 * cross_matrix(&self.g1) - d1 * cross_matrix(&self.g2)
    }
}

impl Wall {
    /// A wall of boundary facets (vertex ids, oriented out of the solid).
    pub fn new(space: &FunctionSpace, facets: &[[usize; 3]]) -> Self {
        Self::cut_by(&[], space, facets)
    }

    /// A wall of a body that is cut by planes of symmetry.
    pub fn cut_by(planes: &[Plane], space: &FunctionSpace, facets: &[[usize; 3]]) -> Self {
        let mut origin = Vec3::zeros();
        planes.iter().for_each(|plane| origin[plane.axis] = plane.level);
        let facets_of_nodes = facets.iter().map(|&f| space.facet_nodes(f)).collect();
        Self { facets: facets_of_nodes, rims: rims(facets, planes), plugged: false, origin }
    }

    /// Whether the wall, with its mirror images, encloses the chamber without caps.
    pub fn is_closed(&self) -> bool {
        self.rims.is_empty()
    }

    /// What caps close.
    pub fn rims(&self) -> &[Rim] {
        &self.rims
    }

    /// Calls `f` with each facet's nodes, their positions and each point.
    fn for_each_point(
        &self,
        space: &FunctionSpace,
        x: impl Fn(usize) -> Vec3,
        mut f: impl FnMut(&[usize], &[Vec3], &Point),
    ) {
        for nodes in &self.facets {
            points(space, nodes, &x, |x, point| f(nodes, x, point));
        }
    }

    /// Calls `f` with each rim, the nodes of each edge of it, their positions and the apex of the cap, from the origin.
    fn for_each_rim_edge(
        &self,
        space: &FunctionSpace,
        x: impl Fn(usize) -> Vec3 + Copy,
        mut f: impl FnMut(&Rim, &[usize], &[Vec3], Vec3),
    ) {
        for rim in &self.rims {
            let apex = rim.apex(x) - self.origin;
            for [a, b] in rim.edges() {
                let inside = space.edge_nodes([a, b]);
                let edge: Vec<usize> = [a].into_iter().chain(inside).chain([b]).collect();
                let nodes: Vec<Vec3> = edge.iter().map(|&n| x(n) - self.origin).collect();
                f(rim, &edge, &nodes, apex);
            }
        }
    }

    /// A point of a facet from the origin, by the positions of its nodes.
    fn position(&self, x: &[Vec3], p: &Point) -> Vec3 {
        x.iter().zip(p.values).map(|(x, v)| x * *v).sum::<Vec3>() - self.origin
    }

    /// Volume behind the wall, its caps and planes of symmetry at node positions `x` [m³].
    pub fn volume(&self, space: &FunctionSpace, x: impl Fn(usize) -> Vec3 + Sync) -> f64 {
        let behind = |nodes: &Vec<usize>| {
            let mut volume = 0.0;
            points(space, nodes, &x, |x, p| {
                let position = self.position(x, p);
                volume -= p.weight / 3.0 * position.dot(&p.g1.cross(&p.g2));
            });
            volume
        };
        let mut volume = 0.0;
        map_each(&self.facets, behind, |_, part| volume += part);
        self.for_each_rim_edge(space, &x, |_, _, nodes, c| volume += swept(nodes).dot(&c) / 6.0);
        volume
    }

    /// Adds `scale` ∂V/∂x at the nodes, of the wall alone if it has no plugs [m²]: minus the
    /// force of a unit pressure.
    pub fn add_wall_gradient(
        &self,
        space: &FunctionSpace,
        x: impl Fn(usize) -> Vec3 + Sync,
        scale: f64,
        out: &mut [f64],
    ) {
        if self.plugged {
            return self.add_gradient(space, x, scale, out);
        }
        let of_facet = |nodes: &Vec<usize>| {
            let mut forces = [Vec3::zeros(); MOST_NODES];
            points(space, nodes, &x, |_, p| {
                let normal = -scale * p.weight * p.g1.cross(&p.g2);
                forces.iter_mut().zip(p.values).for_each(|(f, v)| *f += normal * *v);
            });
            forces
        };
        map_each(&self.facets, of_facet, |nodes, forces| {
            nodes.iter().zip(forces).for_each(|(&node, f)| add_at(out, node, &f));
        });
    }

    /// Adds `scale` ∂V/∂x at the nodes, of wall and caps [m²].
    ///
    /// Rims may move as they like, so the whole derivative of x · (g₁ × g₂) counts:
    /// inside a wall, and in all of a closed one, its three parts are the same.
    pub fn add_gradient(
        &self,
        space: &FunctionSpace,
        x: impl Fn(usize) -> Vec3,
        scale: f64,
        out: &mut [f64],
    ) {
        self.for_each_point(space, &x, |nodes, x, p| {
            let position = self.position(x, p);
            let (by1, by2) = (p.g2.cross(&position), position.cross(&p.g1));
            let (normal, weight) = (p.g1.cross(&p.g2), -scale * p.weight / 3.0);
            for (b, node) in nodes.iter().enumerate() {
                let [d1, d2, _] = p.gradients[b];
                let by = p.values[b] * normal + d1 * by1 + d2 * by2;
                add_at(out, *node, &(weight * by));
            }
        });
        let sixth = scale / 6.0;
        self.for_each_rim_edge(space, &x, |rim, edge, nodes, c| {
            for (i, j, k) in swept_terms(nodes.len()) {
                add_at(out, edge[i], &(sixth * k * nodes[j].cross(&c)));
                add_at(out, edge[j], &(sixth * k * c.cross(&nodes[i])));
            }
            let by_apex = rim.apex_vjp(sixth, swept(nodes));
            by_apex.for_each(|(v, by)| add_at(out, v, &by));
        });
    }

    /// Adds `scale` ∂V/∂X of wall and caps, three components per vertex, where
    /// nodes at `x` move with the rest vertices [m²].
    pub fn add_volume_gradient(
        &self,
        space: &FunctionSpace,
        x: impl Fn(usize) -> Vec3,
        scale: f64,
        out: &mut [f64],
    ) {
        let mut nodal = vec![0.0; 3 * space.node_count()];
        self.add_gradient(space, x, scale, &mut nodal);
        space.add_to_vertices(&nodal, out);
    }

    /// Adds `scale` S to the lower triangle; of a wall with plugs S = −∂²V/∂x∂x of wall and caps.
    pub fn add_stiffness(
        &self,
        space: &FunctionSpace,
        x: impl Fn(usize) -> Vec3 + Sync,
        scale: f64,
        out: &mut BlockMatrix,
    ) {
        if self.plugged {
            return self.add_plugged_stiffness(space, &x, scale, out);
        }
        let of_facet = |nodes: &Vec<usize>| {
            // of the pairs of nodes (a, b ≤ a)
            let mut blocks = vec![Mat3::zeros(); pair_count(nodes.len())];
            points(space, nodes, &x, |_, p| {
                let mut by = [Mat3::zeros(); MOST_NODES];
                by.iter_mut()
                    .take(nodes.len())
                    .enumerate()
                    .for_each(|(b, by)| *by = p.normal_by(b));
                for a in 0..nodes.len() {
                    for b in 0..=a {
                        // S is symmetric once assembled, so its symmetric part is it
                        let both = p.values[a] * by[b] + p.values[b] * by[a].transpose();
                        blocks[pair_index(a, b)] += 0.5 * scale * p.weight * both;
                    }
                }
            });
            blocks
        };
        map_each(&self.facets, of_facet, |nodes, blocks| {
            for (a, &row) in nodes.iter().enumerate() {
                for (b, &column) in nodes[..=a].iter().enumerate() {
                    let block = &blocks[pair_index(a, b)];
                    if row >= column {
                        out.add_lower(row, column, block);
                    } else {
                        out.add_lower(column, row, &block.transpose());
                    }
                }
            }
        });
    }

    /// Adds `scale` λᵀ S at the nodes.
    pub fn add_stiffness_vjp(
        &self,
        space: &FunctionSpace,
        x: impl Fn(usize) -> Vec3,
        lambda: &[f64],
        scale: f64,
        out: &mut [f64],
    ) {
        if self.plugged {
            return self.add_plugged_stiffness_vjp(space, &x, lambda, scale, out);
        }
        self.for_each_point(space, &x, |nodes, _, p| {
            let l: Vec3 = nodes.iter().zip(p.values).map(|(n, v)| at(lambda, *n) * *v).sum();
            for (b, node) in nodes.iter().enumerate() {
                add_at(out, *node, &(scale * p.weight * (p.normal_by(b).transpose() * l)));
            }
        });
    }
}

/// Calls `f` with the positions of a facet's nodes and each of its points.
fn points(
    space: &FunctionSpace,
    nodes: &[usize],
    x: impl Fn(usize) -> Vec3,
    mut f: impl FnMut(&[Vec3], &Point),
) {
    let table = space.facet_table();
    let mut positions = [Vec3::zeros(); MOST_NODES];
    nodes.iter().zip(&mut positions).for_each(|(&n, position)| *position = x(n));
    let x = &positions[..nodes.len()];
    for (q, weight) in table.weights.iter().enumerate() {
        let gradients = &table.gradients[q];
        let tangent = |k: usize| x.iter().zip(gradients).map(|(x, g)| x * g[k]).sum::<Vec3>();
        let point = Point {
            weight: 0.5 * weight,
            values: &table.values[q],
            gradients,
            g1: tangent(0),
            g2: tangent(1),
        };
        f(x, &point);
    }
}

/// ∫ x × dx along an edge with equidistant nodes: Σ_{i<j} K_ij x_i × x_j.
fn swept(nodes: &[Vec3]) -> Vec3 {
    swept_terms(nodes.len()).map(|(i, j, k)| k * nodes[i].cross(&nodes[j])).sum()
}

/// i < j and K_ij = ∫ φ_i φ_j′ − φ_j φ_i′ on an edge with a number of nodes.
fn swept_terms(count: usize) -> impl Iterator<Item = (usize, usize, f64)> {
    let weights: &[f64] = match count {
        2 => &[1.0],
        3 => &[4.0 / 3.0, -1.0 / 3.0, 4.0 / 3.0],
        _ => &[57.0 / 40.0, -0.6, 7.0 / 40.0, 81.0 / 40.0, -0.6, 57.0 / 40.0],
    };
    let pairs = (0..count).flat_map(move |i| (i + 1..count).map(move |j| (i, j)));
    pairs.zip(weights).map(|((i, j), k)| (i, j, *k))
}

/// Node positions x = ΠX + u.
pub fn positions<'a>(iterate: &Iterate<'a>) -> impl Fn(usize) -> Vec3 + Copy + use<'a> {
    let Iterate { space, rest, u, .. } = *iterate;
    move |node| space.node_position(rest, node) + at(u, node)
}

/// Node positions ΠX at rest.
pub fn rest_positions<'a>(iterate: &Iterate<'a>) -> impl Fn(usize) -> Vec3 + Copy + use<'a> {
    let Iterate { space, rest, .. } = *iterate;
    move |node| space.node_position(rest, node)
}
