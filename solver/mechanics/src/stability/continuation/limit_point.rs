//! The state of a path next to a limit point that lies between two others.
//!
//! Along the arc length s from the state before, dt/ds changes its sign at a limit point. Its zero is found by the false
//! position with Illinois' weights, every value by a corrector to the path: a direct method would go astray from as
//! far as the states of a path are apart. Not so next to a bifurcation: a body that is not quite symmetrical bends
//! along the branch there, the more the nearer it is.
//!
//! Source: Dahlquist and Björck 1974, "Numerical Methods", section 6.4.3; Wriggers, Wagner and Miehe 1988,
//! doi:10.1016/0045-7825(88)90024-2, who begin a direct method so.

use super::*;

/// Part of the change between the two states that is near enough for Newton's method to converge.
const NEAR: f64 = 1e-3;
/// States that are tried, at most.
const TRIED: usize = 16;

impl Continuation {
    /// The state next to the limit point between the last two. None where the first of these is the start of all,
    /// or where there is no limit point between them.
    pub fn narrowed(
        &self,
        stepper: &TimeStepper,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
    ) -> Option<LoadStep> {
        let [.., before, beyond] = &stepper.progress.last[..] else { return None };
        let step = stepper.step()?;
        let state = |at: &Reached| at.configuration(rest, Some(step));
        // the next state is sought from the one below, which a state that is found takes the place of
        let (mut below, mut above) = (state(before), state(beyond));
        let mut progress = self.before.clone()?;
        let mut search =
            FalsePosition::new(progress.direction.load, self.progress.as_ref()?.direction.load);
        let (mut nearest, mut part) = (None, 1.0);
        for _ in 0..TRIED {
            let last = below.iterate(problem);
            let mut from = ArcStep { problem, last, step, progress: &progress, end: self.path.end };
            let across = from.change(&above.iterate(problem)).length(progress.scale);
            let length = part * across * search.zero()?;
            let shortened = ArcProgress { length, ..progress.clone() };
            from.progress = &shortened;
            let Ok(found) = self.attempt(&from, stepper, workspace) else {
                part *= 0.5;
                continue;
            };
            let rate = found.progress.direction.load;
            log::debug!("limit point: dt/ds = {rate:.3e} at load {:.9}", found.step.time);
            let here = state(&found.step.clone().into_reached());
            nearest = Some(found.step);
            if search.is_near(rate) {
                break;
            }
            if search.take(rate) {
                (below, progress) = (here, found.progress);
            } else {
                above = here;
            }
            part = 1.0;
        }
        nearest
    }
}

/// dt/ds below and above a limit point.
struct FalsePosition {
    below: f64,
    above: f64,
    /// Their difference at first.
    change: f64,
    /// Whether the lower one was the last that a new one took the place of.
    below_moved: Option<bool>,
}

impl FalsePosition {
    fn new(below: f64, above: f64) -> Self {
        Self { below, above, change: (below - above).abs(), below_moved: None }
    }

    /// The fraction of the way from below to above where the line through both vanishes; none where the signs are
    /// the same.
    fn zero(&self) -> Option<f64> {
        (self.below * self.above < 0.0).then(|| self.below / (self.below - self.above))
    }

    fn is_near(&self, rate: f64) -> bool {
        rate.abs() <= NEAR * self.change
    }

    /// Puts a rate in place of that with its sign, and says whether that is the one below. The other one is halved
    /// where it stays again, so that both move.
    fn take(&mut self, rate: f64) -> bool {
        let moves_below = rate * self.below > 0.0;
        let half = if self.below_moved == Some(moves_below) { 0.5 } else { 1.0 };
        if moves_below {
            (self.below, self.above) = (rate, half * self.above);
        } else {
            (self.below, self.above) = (half * self.below, rate);
        }
        self.below_moved = Some(moves_below);
        moves_below
    }
}
