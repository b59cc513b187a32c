//! Lists of neighbours (Verlet lists): candidate pairs that are kept while nothing has
//! moved far, because the broad phase costs more than to test some pairs too many.
//!
//! A list made at x⁰ with the radius r + 2 δ holds every pair closer than r as long as no
//! vertex is farther than the slack δ from its place in x⁰. The close pairs found in it
//! are those of a new search, in the same order: lists never change a result. A list is
//! for one rest shape, which decides what runs through [solid](super::solid).

use std::sync::{Arc, Mutex, PoisonError};

use mesh::Vec3;

use super::pairs::Pair;
use super::potential::{Partners, Potential};
use super::solid::Solid;

/// How far vertices may move before a list is made anew, in mean edge lengths. With a
/// larger slack lists are longer and made less often.
const SLACK: f64 = 0.1;

/// Candidate pairs of which none is missing while no vertex is farther than `slack` from
/// where it was.
pub struct Neighbours {
    x: Vec<Vec3>,
    slack: f64,
    /// The pairs that may repel each other, in a fixed order.
    pub pairs: Vec<Pair>,
    /// Those through the solid of a body.
    pub through_solid: Vec<Pair>,
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
    last: Mutex<Last>,
}

/// The last list, if there is any, and the solid of the last rest shape.
#[derive(Default)]
struct Last {
    rest: Vec<Vec3>,
    solid: Option<Arc<Solid>>,
    list: Option<Arc<Neighbours>>,
}

impl Last {
    /// Forgets what is of another rest shape.
    fn be_of(&mut self, rest: &[Vec3]) {
        if self.rest != rest {
            *self = Self { rest: rest.to_vec(), ..Self::default() };
        }
    }
}

impl NeighbourList {
    /// The last list, if it holds for this rest shape at all these positions.
    #[must_use]
    pub fn last_at(&self, rest: &[Vec3], positions: &[&[Vec3]]) -> Option<Arc<Neighbours>> {
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let list = last.list.as_ref().filter(|_| last.rest == rest);
        list.filter(|list| positions.iter().all(|x| list.holds(x))).map(Arc::clone)
    }

    /// A list that holds at positions `x` and rest positions of the collision vertices [m],
    /// made anew if it must be; none where more pairs are in range than memory is meant for.
    #[must_use]
    pub fn at(&self, potential: &Potential, x: &[Vec3], rest: &[Vec3]) -> Option<Arc<Neighbours>> {
        if let Some(list) = self.last_at(rest, &[x]) {
            return Some(list);
        }
        let range = potential.repulsion().range();
        let make = |slack: f64| {
            let pairs = potential.candidates(x, x, range + 2.0 * slack).ok()?;
            let [pairs, through_solid] = self.partition(potential, rest, pairs);
            Some(Arc::new(Neighbours { x: x.to_vec(), slack, pairs, through_solid }))
        };
        let triangles = &potential.surface().features().triangles;
        let list = make(SLACK * mesh::measure::mean_edge(x, triangles)).or_else(|| make(0.0));
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        last.be_of(rest);
        last.list.clone_from(&list);
        list
    }

    /// Pairs that may repel each other, and those through the solid of a body at rest, both in
    /// their order.
    #[must_use]
    pub fn partition(
        &self,
        potential: &Potential,
        rest: &[Vec3],
        pairs: Vec<Pair>,
    ) -> [Vec<Pair>; 2] {
        if potential.partners() != Partners::ThroughAir {
            return [pairs, Vec::new()];
        }
        self.solid(potential, rest).partition(pairs)
    }

    fn solid(&self, potential: &Potential, rest: &[Vec3]) -> Arc<Solid> {
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        last.be_of(rest);
        let make = || Solid::new(potential.surface(), rest, potential.repulsion().range());
        Arc::clone(last.solid.get_or_insert_with(|| Arc::new(make())))
    }
}
