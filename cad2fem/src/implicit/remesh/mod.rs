//! The surface of a body with triangles of its own size and shape: isotropic remeshing (Botsch and Kobbelt
//! 2004, doi:10.1145/1057432.1057457) with edge lengths from curvature and thickness (`sizes`).
//!
//! Long edges are split, short ones contracted, others exchanged, and vertices slide along the functions of
//! their sides, where they stay: on the rim of a cut on two, in its corners on three. Each change is measured
//! at the triangles that it concerns and undone where it harms them (`net`): where an edge would become
//! sharper, a triangle flatter, or its middle farther from the function. What the lattice left smaller than
//! the edges, as fins and pits in a groove between two lobes, is smoothed away as no other change is.

mod net;
mod sizes;
#[cfg(test)]
mod tests;

use mesh::Vec3;
use mesh::topology::submesh;

use self::net::Net;
use super::sides::Sides;
use super::skin::{Part, Skin};

/// Rounds of changes: the lengths of edges are settled after five.
const ROUNDS: usize = 8;

/// Edges are split from this length on, and contracted up to the next one: either brings them nearer to their
/// size (Botsch and Kobbelt 2004) [size].
const LONG: f64 = 4.0 / 3.0;
const SHORT: f64 = 4.0 / 5.0;

/// The surface of `laid` with other triangles, the middles of which are at most about `tolerance` [m] from the
/// function of their side where that bends over more than the shortest edges. It may cross itself where walls
/// are thinner than that: the caller checks.
pub fn remeshed(laid: &Skin, tolerance: f64, sides: &Sides) -> Skin {
    let mut net = Net::new(laid, sizes::wanted(laid, tolerance, sides), tolerance, sides);
    for _ in 0..ROUNDS {
        split_long(&mut net);
        contract_short(&mut net);
        exchange(&mut net);
        slide(&mut net);
    }
    let (triangles, part) = net.triangles();
    Skin {
        surface: submesh(&net.places, &triangles).0,
        part,
        thin: laid.thin.clone(),
        chord_error: None,
    }
}

/// The largest distance of a surface, at the corners and middles of its triangles and edges, from the functions
/// of their sides, to first order, and where it is [m].
pub fn chord_error(skin: &Skin, sides: &Sides) -> (f64, Vec3) {
    let off = |(t, part): (usize, &Part)| {
        let [a, b, c] = skin.surface.corners(t);
        let points = [a, b, c, (a + b) / 2.0, (b + c) / 2.0, (c + a) / 2.0, (a + b + c) / 3.0];
        let side = sides.index(*part);
        points.map(|p| (sides.at(side, &p).abs() * sides.metres, p))
    };
    let all = skin.part.iter().enumerate().flat_map(off);
    all.fold((0.0, Vec3::zeros()), |most, one| if one.0 > most.0 { one } else { most })
}

/// Splits edges that are too long or too far from the surface, the longest of them first.
fn split_long(net: &mut Net) {
    let mut long = net.edges(|net, edge| {
        let length = net.relative_length(edge);
        length > LONG || length > 1.0 && net.is_off(edge)
    });
    long.sort_by(|&e, &f| net.length(f).total_cmp(&net.length(e)));
    long.into_iter().for_each(|edge| net.split(edge));
}

/// Contracts edges that are too short, the shortest first.
fn contract_short(net: &mut Net) {
    let mut short = net.edges(|net, edge| net.relative_length(edge) < SHORT);
    short.sort_by(|&e, &f| net.length(e).total_cmp(&net.length(f)));
    for [a, b] in short {
        if net.has_edge([a, b]) && net.relative_length([a, b]) < SHORT {
            let _ = net.contract(a, b, LONG) || net.contract(b, a, LONG);
        }
    }
}

/// Exchanges edges where that makes triangles better.
fn exchange(net: &mut Net) {
    for edge in net.edges(|_, _| true) {
        if net.has_edge(edge) {
            net.exchange(edge);
        }
    }
}

fn slide(net: &mut Net) {
    (0..net.places.len()).for_each(|v| net.slide(v));
}
