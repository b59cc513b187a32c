//! Lists of neighbours (Verlet lists): candidate pairs that are kept while nothing has
//! moved far, because the broad phase costs more than to test some pairs too many.
//!
//! A list made at x⁰ with the radius r + 2 δ holds every pair closer than r as long as no
//! vertex is farther than the slack δ from its place in x⁰. The close pairs found in it
//! are those of a new search, in the same order: lists never change a result. A list is
//! for one rest shape, which decides what runs through [solid](super::solid).
//!
//! The pairs that come within the radius of a list while vertices move along straight lines serve
//! collision detection. Those of them that are within it anywhere on the way are the list there, so
//! that a step of Newton's method needs one broad phase and not two.

use std::sync::{Arc, Mutex, PoisonError};

use mesh::Vec3;
use rayon::prelude::*;

use super::pairs::Pair;
use super::potential::{Partners, Potential};
use super::solid::Solid;

/// How far vertices may move before a list is made anew, in mean edge lengths. With a
/// larger slack lists are longer and made less often.
const SLACK: f64 = 0.1;
/// Lists that are kept, the last one first: derivatives go back and forth between the ends of a time step.
const LISTS: usize = 3;
/// Pairs of lists that are kept beside the last one, at most: 80 MB.
const KEPT_PAIRS: usize = 2_000_000;
/// Part of the slack by which positions may be beside a way that they are taken to be on.
const BESIDE: f64 = 1e-3;

/// Candidate pairs of which none is missing while no vertex is farther than the slack from
/// where it was.
pub struct Neighbours {
    x: Vec<Vec3>,
    /// δ [m]. A list on the way of a motion has less of it, by the part `BESIDE`.
    pub slack: f64,
    /// The pairs that may repel each other, in a fixed order.
    pub pairs: Vec<Pair>,
    /// Those through the solid of a body.
    pub through_solid: Vec<Pair>,
}

impl Neighbours {
    fn count(&self) -> usize {
        self.pairs.len() + self.through_solid.len()
    }

    fn holds(&self, x: &[Vec3]) -> bool {
        let near = |(a, b): (&Vec3, &Vec3)| (a - b).norm_squared() <= self.slack * self.slack;
        self.x.iter().zip(x).all(near)
    }
}

/// Candidate pairs of a motion along straight lines, of which none is missing that comes within the radius of a list.
pub struct Swept {
    from: Vec<Vec3>,
    to: Vec<Vec3>,
    slack: f64,
    /// The pairs that may repel each other, in a fixed order.
    pub pairs: Vec<Pair>,
    /// Those through the solid of a body.
    pub through_solid: Vec<Pair>,
}

impl Swept {
    /// Whether positions are on the way, up to [`BESIDE`].
    fn passes(&self, x: &[Vec3]) -> bool {
        let all = || self.from.iter().zip(&self.to).zip(x);
        let length2: f64 = all().map(|((a, b), _)| (b - a).norm_squared()).sum();
        let along: f64 = all().map(|((a, b), x)| (b - a).dot(&(x - a))).sum();
        let t = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
        let beside2 = (BESIDE * self.slack).powi(2);
        all().all(|((a, b), x)| (x - a - t * (b - a)).norm_squared() <= beside2)
    }

    /// The list at positions on the way, for pairs within a range.
    fn list(&self, x: &[Vec3], range: f64) -> Neighbours {
        let reach2 = (range + 2.0 * self.slack).powi(2);
        let near = |pair: &&Pair| pair.closest(&pair.gather(x)).d2 <= reach2;
        let [pairs, through_solid] = [&self.pairs, &self.through_solid]
            .map(|pairs| pairs.par_iter().filter(near).copied().collect());
        Neighbours { x: x.to_vec(), slack: (1.0 - BESIDE) * self.slack, pairs, through_solid }
    }
}

/// The last lists of a potential.
#[derive(Default)]
pub struct NeighbourList {
    last: Mutex<Last>,
}

/// The last lists and the last motion, if there are any, and the solid of the last rest shape.
#[derive(Default)]
struct Last {
    rest: Vec<Vec3>,
    solid: Option<Arc<Solid>>,
    lists: Vec<Arc<Neighbours>>,
    swept: Option<Arc<Swept>>,
    /// All rest shapes that are asked for hardly differ from this one.
    held: bool,
}

impl Last {
    fn is_of(&self, rest: &[Vec3]) -> bool {
        self.held || self.rest == rest
    }

    /// Forgets what is of another rest shape.
    fn be_of(&mut self, rest: &[Vec3]) {
        if !self.is_of(rest) {
            *self = Self { rest: rest.to_vec(), ..Self::default() };
        }
    }

    /// Puts a list before the others, of which some are kept.
    fn keep(&mut self, list: &Arc<Neighbours>) {
        self.lists.insert(0, Arc::clone(list));
        self.lists.truncate(LISTS);
        let others = |lists: &[Arc<Neighbours>]| -> usize {
            lists[1..].iter().map(|list| list.count()).sum()
        };
        while others(&self.lists) > KEPT_PAIRS {
            self.lists.pop();
        }
    }
}

/// While it lives, what is known of the last rest shape is taken for all others.
pub struct Held<'a>(&'a NeighbourList);

impl Drop for Held<'_> {
    fn drop(&mut self) {
        self.0.set_held(false);
    }
}

impl NeighbourList {
    /// Takes rest shapes that hardly differ from the last one for it, as a derivative by the rest shape does: no pair
    /// begins or ceases to be through the solid there.
    pub fn hold(&self) -> Held<'_> {
        self.set_held(true);
        Held(self)
    }

    fn set_held(&self, held: bool) {
        self.last.lock().unwrap_or_else(PoisonError::into_inner).held = held;
    }

    /// One of the last lists, if it holds for this rest shape at all these positions.
    pub fn last_at(&self, rest: &[Vec3], positions: &[&[Vec3]]) -> Option<Arc<Neighbours>> {
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        let mut lists = last.lists.iter().filter(|_| last.is_of(rest));
        lists.find(|list| positions.iter().all(|x| list.holds(x))).map(Arc::clone)
    }

    /// A list that holds at positions `x` and rest positions of the collision vertices [m],
    /// made anew if it must be; none where more pairs are in range than memory is meant for.
    pub fn at(&self, potential: &Potential, x: &[Vec3], rest: &[Vec3]) -> Option<Arc<Neighbours>> {
        if let Some(list) = self.last_at(rest, &[x]) {
            return Some(list);
        }
        let range = potential.repulsion().range();
        let make = |slack: f64| {
            let pairs = potential.candidates(x, x, range + 2.0 * slack).ok()?;
            let [pairs, through_solid] = self.partition(potential, rest, pairs);
            Some(Neighbours { x: x.to_vec(), slack, pairs, through_solid })
        };
        let swept = self.last_swept(rest).filter(|swept| swept.passes(x));
        let list = swept.map(|swept| swept.list(x, range));
        let list = list.or_else(|| make(slack(potential, x))).or_else(|| make(0.0)).map(Arc::new);
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        last.be_of(rest);
        if let Some(list) = &list {
            last.keep(list);
        }
        list
    }

    /// What collision vertices meet that move from `x0` to `x1` [m]; none where more pairs come within the radius of a
    /// list than memory is meant for.
    pub fn sweep(
        &self,
        potential: &Potential,
        [x0, x1]: [&[Vec3]; 2],
        rest: &[Vec3],
    ) -> Option<Arc<Swept>> {
        let slack = slack(potential, x0);
        let radius = potential.repulsion().range() + 2.0 * slack;
        let pairs = potential.candidates(x0, x1, radius).ok()?;
        let [pairs, through_solid] = self.partition(potential, rest, pairs);
        let (from, to) = (x0.to_vec(), x1.to_vec());
        let swept = Arc::new(Swept { from, to, slack, pairs, through_solid });
        let mut last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        last.be_of(rest);
        last.swept = Some(Arc::clone(&swept));
        Some(swept)
    }

    fn last_swept(&self, rest: &[Vec3]) -> Option<Arc<Swept>> {
        let last = self.last.lock().unwrap_or_else(PoisonError::into_inner);
        last.swept.as_ref().filter(|_| last.is_of(rest)).map(Arc::clone)
    }

    /// Pairs that may repel each other, and those through the solid of a body at rest, both in
    /// their order.
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

/// The slack of a list at positions [m]. It takes the edges that the surface keeps: a search for them in each call took
/// 3 % of a run of the gripper.
fn slack(potential: &Potential, x: &[Vec3]) -> f64 {
    let edges = &potential.surface().features().edges;
    let length: f64 = edges.iter().map(|[a, b]| (x[*b] - x[*a]).norm()).sum();
    SLACK * length / edges.len().max(1) as f64
}
