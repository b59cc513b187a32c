//! What threads do at a state: lengths, forces, and where they are.

use mesh::Vec3;

use super::{Segment, Winding};
use crate::element::{at, values};
use crate::energy::Iterate;

/// Measures of a winding at a state.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WindingSummary {
    /// Rest length [m].
    pub length: f64,
    /// W [J].
    pub energy: f64,
    /// Smallest and largest force along it [N], each over as much of it as its segments are long on average.
    pub force: [f64; 2],
    /// Mean force along it [N].
    pub mean_force: f64,
    /// Share of the length that is in tension.
    pub taut: f64,
}

/// A piece of the thread at a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Strand {
    /// Ends of the segment at rest [m].
    pub rest: [Vec3; 2],
    /// Their displacement [m].
    pub moved: [Vec3; 2],
    /// Mean force along it [N].
    pub force: f64,
    /// Vertices of the facet that it is in.
    pub vertices: [usize; 3],
    /// Barycentric coordinates of its ends by these [1].
    pub weights: [[f64; 3]; 2],
}

impl Winding {
    /// Measures of the thread at a state.
    pub fn summary(&self, iterate: &Iterate) -> WindingSummary {
        let mut all = WindingSummary::default();
        let mut pulled = Vec::new();
        for segment in &self.segments {
            let (mut length, mut sum) = (0.0, 0.0);
            self.for_each_point(iterate, segment, |p| {
                let (force, share) = (p.force(), p.place.weight * p.long);
                (length, sum) = (length + share, sum + share * force);
                all.length += share;
                all.energy += 0.5 * share * p.stiffness * p.square[0];
                all.taut += if force > 0.0 { share } else { 0.0 };
            });
            pulled.push((length, sum));
        }
        all.mean_force = pulled.iter().map(|(_, sum)| sum).sum::<f64>() / all.length;
        all.force = extremes(&pulled, all.length / pulled.len() as f64);
        all.taut /= all.length;
        all
    }

    /// All pieces of the thread at a state, in its order.
    pub fn strands(&self, iterate: &Iterate) -> Vec<Strand> {
        let one = |segment: &Segment| {
            let rest = [0, 1].map(|end| segment.corners(&segment.ends[end], iterate.rest));
            let moved = [0, 1].map(|end| {
                let values = values(iterate.space.degree(), &segment.ends[end]);
                segment.nodes.iter().zip(values).map(|(&n, v)| v * at(iterate.u, n)).sum()
            });
            let mut force = 0.0;
            self.for_each_point(iterate, segment, |p| force += p.place.weight * p.force());
            Strand { rest, moved, force, vertices: segment.vertices, weights: segment.ends }
        };
        self.segments.iter().map(one).collect()
    }
}

/// Smallest and largest mean force of stretches of a thread that are at least so long [m], from the length and ∫ N dS of
/// its segments [m, N m]; a shorter rest at the end is left out. The strain in a short segment, which the corner of a
/// facet cuts off, says more of the mesh than of the thread.
pub(super) fn extremes(segments: &[(f64, f64)], least: f64) -> [f64; 2] {
    let (mut low, mut high) = (f64::INFINITY, 0.0_f64);
    let (mut length, mut sum) = (0.0, 0.0);
    for (long, pulled) in segments {
        (length, sum) = (length + long, sum + pulled);
        if length >= least {
            (low, high) = (low.min(sum / length), high.max(sum / length));
            (length, sum) = (0.0, 0.0);
        }
    }
    [low, high]
}
