//! Bodies that lie in the solid of another body or obstacle before anything moves.
//!
//! The surface of a body is the boundary of its solid; the winding number about it is 1 in the solid,
//! and 0 outside and in its chambers. Pieces of surfaces that do not meet are wholly in a solid or wholly
//! out of it, whatever their size. Closed pieces of obstacles that face outward bound a solid, too; those
//! that face inward, as a container does, and open ones bound none, but must be in no body's solid.

use anyhow::{Result, bail};
use mechanics::contact::certificate::crossing_pairs;
use mechanics::contact::surface::Surface;
use mesh::inside::WindingNumber;
use mesh::topology::{components, directed_edges, submesh};
use mesh::{SurfaceMesh, Vec3};

use crate::term::Ground;

/// Bodies of a scene without contact must not meet or be in each other at rest.
pub(super) fn check(ground: &Ground) -> Result<()> {
    let Ground { body, space, .. } = ground;
    if body.parts.len() < 2 || ground.last.is_some() {
        return Ok(());
    }
    let parts: Vec<usize> = body.boundary().iter().map(|f| body.part_of(f[0])).collect();
    let (facets, free) = (body.boundary(), vec![false; 3 * space.node_count()]);
    let surface = Surface::new(&body.planes, space, facets, &parts, Vec::new(), 1, &free);
    let rest = surface.rest(space, &body.mesh.vertices);
    if ground.certify {
        check_crossing(&surface, &rest, ground)?;
    }
    check_nested(&surface, &rest, ground, false)
}

fn check_crossing(surface: &Surface, rest: &[Vec3], ground: &Ground) -> Result<()> {
    let triangles = &surface.features().triangles;
    let pairs = crossing_pairs(triangles, rest, |_| true).into_iter();
    let owner = |t: usize| surface.body(triangles[t][0]);
    let Some((i, j)) = pairs.into_iter().find(|&(i, j)| owner(i) != owner(j)) else {
        return Ok(());
    };
    let (names, p) = (&ground.surfaces, triangles[i].map(|v| rest[v]).iter().sum::<Vec3>());
    let p = p / 3.0;
    bail!(
        "at rest \"{}\" and \"{}\" meet near ({:.5}, {:.5}, {:.5}) m\n  bodies must be apart at the \
         start: move one by translate; or write contact = \"ignored\" if they may be in each other",
        names[owner(i)],
        names[owner(j)],
        p.x,
        p.y,
        p.z
    );
}

/// No piece of the surface of a body or obstacle may lie in the solid of another at rest. Surfaces
/// that are held in each other by fixed facets are left out: a support may stand in an obstacle.
pub(super) fn check_nested(
    surface: &Surface,
    rest: &[Vec3],
    ground: &Ground,
    has_contact: bool,
) -> Result<()> {
    let names = &ground.surfaces;
    let mut own = vec![Vec::new(); names.len()];
    for t in &surface.features().triangles {
        own[surface.body(t[0])].push(*t);
    }
    let pieces: Vec<Piece> = own.iter().flat_map(|own| pieces(surface, own)).collect();
    let is_body = |k: usize| k < ground.body.parts.len();
    for (outer, own) in own.iter().enumerate() {
        let others = pieces
            .iter()
            .filter(|piece| piece.owner != outer && (is_body(piece.owner) || is_body(outer)));
        let Some(piece) = Solid::new(own, rest).holds(others, rest) else { continue };
        let (inner, p) = (piece.owner, rest[piece.vertices[0]]);
        let what = |k: usize| if is_body(k) { "body" } else { "obstacle" };
        bail!(
            "at rest {} \"{}\" lies in the solid of {} \"{}\", at ({:.5}, {:.5}, {:.5}) m\n  bodies \
             must be apart at the start: move one by translate{}",
            what(inner),
            names[inner],
            what(outer),
            names[outer],
            p.x,
            p.y,
            p.z,
            if !is_body(outer) {
                "; an obstacle that is to hold bodies in it is open, or its facets face inward"
            } else if !has_contact {
                "; or write contact = \"ignored\" if they may be in each other"
            } else {
                ""
            }
        );
    }
    Ok(())
}

/// A connected piece of the surface of a body or obstacle.
struct Piece {
    owner: usize,
    vertices: Vec<usize>,
}

/// The pieces of a surface that can move, then those that are fixed, or an obstacle, as a whole.
fn pieces(surface: &Surface, own: &[[usize; 3]]) -> Vec<Piece> {
    let moves = |t: &[usize; 3]| !surface.immovable(t);
    let movable: Vec<[usize; 3]> = own.iter().copied().filter(moves).collect();
    let held = connected(own).into_iter().filter(|part| !part.iter().any(moves));
    let piece = |part: Vec<[usize; 3]>| {
        let mut vertices = part.into_flattened();
        vertices.sort_unstable();
        vertices.dedup();
        Piece { owner: surface.body(vertices[0]), vertices }
    };
    connected(&movable).into_iter().chain(held).map(piece).collect()
}

fn connected(triangles: &[[usize; 3]]) -> Vec<Vec<[usize; 3]>> {
    let parts = components(triangles).into_iter();
    parts.map(|part| part.into_iter().map(|t| triangles[t]).collect()).collect()
}

/// What the closed pieces of a surface bound.
struct Solid {
    surface: SurfaceMesh,
    min: Vec3,
    max: Vec3,
}

impl Solid {
    fn new(own: &[[usize; 3]], rest: &[Vec3]) -> Self {
        let closed = connected(own).into_iter().filter(|part| is_closed(part));
        let surface = submesh(rest, &closed.flatten().collect::<Vec<_>>()).0;
        let infinite = Vec3::repeat(f64::INFINITY);
        let corners = surface.vertices.iter();
        let (min, max) =
            corners.fold((infinite, -infinite), |(min, max), x| (min.inf(x), max.sup(x)));
        Self { surface, min, max }
    }

    /// The first of these pieces that is wholly inside.
    fn holds<'a>(
        &self,
        pieces: impl Iterator<Item = &'a Piece>,
        rest: &[Vec3],
    ) -> Option<&'a Piece> {
        let within = |v: &usize| (0..3).all(|k| (self.min[k]..=self.max[k]).contains(&rest[*v][k]));
        let mut near = pieces.filter(|piece| piece.vertices.iter().all(within)).peekable();
        near.peek()?;
        let solid = WindingNumber::new(&self.surface);
        near.find(|piece| piece.vertices.iter().all(|&v| solid.contains(&rest[v])))
    }
}

/// Whether triangles have no rim, and neighbours agree on which side is inside.
fn is_closed(triangles: &[[usize; 3]]) -> bool {
    let mut along: Vec<[usize; 2]> = triangles.iter().flat_map(|&t| directed_edges(t)).collect();
    let mut against: Vec<[usize; 2]> = along.iter().map(|&[a, b]| [b, a]).collect();
    along.sort_unstable();
    against.sort_unstable();
    along == against
}
