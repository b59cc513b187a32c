//! Lists of neighbours (Verlet lists): candidate pairs that are kept while nothing has
//! moved far, because the broad phase costs more than to test some pairs too many.
//!
//! A list made at x⁰ with the radius r + 2 δ holds every pair closer than r as long as no
//! vertex is farther than the slack δ from its place in x⁰. The close pairs found in it
//! are those of a new search, in the same order: lists never change a result.

use std::sync::{Arc, Mutex, PoisonError};

use mesh::Vec3;

use super::pairs::Pair;
use super::potential::Potential;

/// How far vertices may move before a list is made anew, in mean edge lengths. With a
/// larger slack lists are longer and made less often.
const SLACK: f64 = 0.1;

/// Candidate pairs of which none is missing while no vertex is farther than `slack` from
/// where it was.
pub struct Neighbours {
    x: Vec<Vec3>,
    slack: f64,
    /// The pairs, in a fixed order.
    pub pairs: Vec<Pair>,
}

impl Neighbours {
    fn holds(&self, x: &[Vec3]) -> bool {
        let near = |(a, b): (&Vec3, &Vec3)| (a - b).norm_squared() <= self.slack * self.slack;
        self.x.iter().zip(x).all(near)
    }
}

/// The last list of a potential.
#[derive(Default)]
pub struct NeighbourList {
    last: Mutex<Option<Arc<Neighbours>>>,
}

impl NeighbourList {
    /// The last list, if it holds at all these positions.
    #[must_use]
    pub fn last_at(&self, positions: &[&[Vec3]]) -> Option<Arc<Neighbours>> {
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        last.as_ref().filter(|list| positions.iter().all(|x| list.holds(x))).map(Arc::clone)
    }

    /// A list that holds at positions `x` of the collision vertices [m], made anew if it
    /// must be; none where more pairs are in range than memory is meant for.
    #[must_use]
    pub fn at(&self, potential: &Potential, x: &[Vec3]) -> Option<Arc<Neighbours>> {
        if let Some(list) = self.last_at(&[x]) {
            return Some(list);
        }
        let range = potential.repulsion().range();
        let make = |slack: f64| {
            let pairs = potential.candidates(x, x, range + 2.0 * slack).ok()?;
            Some(Arc::new(Neighbours { x: x.to_vec(), slack, pairs }))
        };
        let triangles = &potential.surface().features().triangles;
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        *last = make(SLACK * mesh::measure::mean_edge(x, triangles)).or_else(|| make(0.0));
        last.clone()
    }
}
