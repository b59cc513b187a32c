//! Steps of Newton's method that increase the energy, if later ones lower it again.
//!
//! A step that turns parts of a body which hardly changes its volume leaves changes of volume of second order, whose energy
//! may be a multiple of what the step gains. The next step takes them back. So a step may increase the energy, if those after
//! it make it as low as the first one should have, in [`LONGEST`] at most and without a short one. Where they do not, the
//! search goes back to the start, makes the first step shorter, and from then on the energy falls in every step.
//!
//! Source: the watchdog technique of Chamberlain, Powell, Lemaréchal and Pedersen 1982, "The watchdog technique for forcing
//! convergence in algorithms for constrained optimization"; Nocedal and Wright, section 15.6.

use super::evaluated::Evaluated;
use super::line_search::{ARMIJO, Accepted};

/// Most steps of an excursion.
const LONGEST: usize = 4;

/// Whether the search is out, and from where.
pub(super) struct Excursion {
    from: Option<Start>,
    /// Steps since.
    steps: usize,
    /// Whether the search has gone back once, or must not increase the energy at all.
    is_over: bool,
}

/// Where an excursion began.
pub(super) struct Start {
    pub state: Evaluated,
    /// The displacement that the step to this state began at [m].
    pub last: Option<Vec<f64>>,
    /// The first step [m].
    pub step: Vec<f64>,
    /// Energy to get to [J].
    goal: f64,
}

impl Excursion {
    /// Before the first step; where none may begin, every step decreases the energy.
    pub fn new(may_begin: bool) -> Self {
        Self { from: None, steps: 0, is_over: !may_begin }
    }

    /// Whether the next step may increase the energy.
    pub fn is_allowed(&self) -> bool {
        !self.is_over
    }

    /// Whether the energy is still to fall below that of the start.
    pub fn is_out(&self) -> bool {
        self.from.is_some()
    }

    /// Takes note of a step from the state `now`, to which a step from `last` had led; the step was predicted to decrease the
    /// energy by `by` [J]. False where the search has to go back.
    pub fn goes_on(
        &mut self,
        to: &Accepted,
        now: &Evaluated,
        last: Option<&[f64]>,
        by: f64,
    ) -> bool {
        match &self.from {
            Some(start) if to.energy <= start.goal => self.from = None,
            Some(_) => {
                self.steps += 1;
                return to.is_long && self.steps < LONGEST;
            }
            None if !to.decreases => {
                let (state, last) = (now.clone(), last.map(<[f64]>::to_vec));
                let step = to.u.iter().zip(&now.u).map(|(to, from)| to - from).collect();
                self.from = Some(Start { state, last, step, goal: now.energy - ARMIJO * by });
                self.steps = 1;
            }
            None => {}
        }
        true
    }

    /// Where to go back to; no step increases the energy from now on.
    pub fn end(&mut self) -> Option<Start> {
        self.is_over = true;
        self.from.take()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state(energy: f64) -> Evaluated {
        Evaluated { u: vec![energy], energy, gradient: vec![0.0], scale: 1.0, residual: 1.0 }
    }

    fn step(energy: f64, decreases: bool, is_long: bool) -> Accepted {
        Accepted { u: vec![energy], energy, gradient: None, decreases, is_long }
    }

    /// Energies of a search that begins at 0 J, with steps that were to take it down by 1 J.
    #[test]
    fn it_ends_below_its_start_or_goes_back_there() {
        let mut out = Excursion::new(true);
        assert!(out.goes_on(&step(5.0, false, true), &state(0.0), None, 1.0) && out.is_out());
        assert!(out.goes_on(&step(2.0, true, true), &state(5.0), None, 1.0) && out.is_out());
        assert!(out.goes_on(&step(-0.5, true, true), &state(2.0), None, 1.0));
        assert!(!out.is_out() && out.is_allowed());

        assert!(out.goes_on(&step(4.0, false, true), &state(-0.5), None, 1.0));
        assert!(!out.goes_on(&step(3.0, true, false), &state(4.0), None, 1.0));
        let start = out.end().expect("a start");
        assert_eq!((start.state.energy, start.step), (-0.5, vec![4.5]));
        assert!(!out.is_out() && !out.is_allowed());
    }

    #[test]
    fn it_takes_no_more_than_so_many_steps() {
        let mut out = Excursion::new(true);
        let goes_on = |_| out.goes_on(&step(1.0, false, true), &state(0.0), None, 1.0);
        assert_eq!((0..LONGEST).map(goes_on).filter(|on| *on).count(), LONGEST - 1);
    }
}
