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

impl ArcFollower {
    /// The state next to the limit point between the last two. None where the first of these is the start of all,
    /// or where there is no limit point between them.
    #[must_use]
    pub fn narrowed(
        &self,
        stepper: &TimeStepper,
        problem: &Problem,
        workspace: &mut Workspace,
        rest: &[Vec3],
    ) -> Option<LoadStep> {
        let progress = self.before.as_ref()?;
        let [.., before, beyond] = &stepper.progress.last[..] else { return None };
        let step = stepper.step()?;
        let state = |at: &Reached| Configuration {
            rest,
            time: at.time,
            step: Some(step),
            u: at.u.clone(),
            multipliers: at.multipliers.clone(),
        };
        let (before, beyond) = (state(before), state(beyond));
        let last = before.iterate(problem);
        let from = From { problem, last, step, progress, end: self.path.end };
        let across = from.change(&beyond.iterate(problem)).length(progress.scale);
        let (low, high) = (progress.direction.load, self.progress.as_ref()?.direction.load);
        let mut bracket = Bracket { low: (0.0, low), high: (across, high), low_moved: None };
        let mut nearest = None;
        for _ in 0..TRIED {
            let Some(length) = bracket.next() else { break };
            let progress = ArcProgress { length, ..progress.clone() };
            let from = From { progress: &progress, ..from };
            let Ok(found) = self.attempt(&from, stepper, workspace) else { break };
            let rate = found.progress.direction.load;
            log::debug!("limit point: dt/ds = {rate:.3e} at load {:.9}", found.step.time);
            nearest = Some(found.step);
            if rate.abs() <= NEAR * (high - low).abs() {
                break;
            }
            bracket.take((length, rate));
        }
        nearest
    }
}

/// Two arguments of a function with values of different signs.
struct Bracket {
    low: (f64, f64),
    high: (f64, f64),
    /// Whether the lower one was the last that a new one took the place of.
    low_moved: Option<bool>,
}

impl Bracket {
    /// Where the line through both vanishes; none where the signs are the same.
    fn next(&self) -> Option<f64> {
        let ((a, low), (b, high)) = (self.low, self.high);
        (low * high < 0.0).then(|| (a * high - b * low) / (high - low))
    }

    /// Puts a value between them in place of that with its sign. The value of an end that stays again is halved, so
    /// that both move.
    fn take(&mut self, new: (f64, f64)) {
        let moves_low = new.1 * self.low.1 > 0.0;
        let again = self.low_moved == Some(moves_low);
        let (goes, stays) = if moves_low {
            (&mut self.low, &mut self.high)
        } else {
            (&mut self.high, &mut self.low)
        };
        *goes = new;
        stays.1 *= if again { 0.5 } else { 1.0 };
        self.low_moved = Some(moves_low);
    }
}
