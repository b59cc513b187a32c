//! How long a run will take, foreseen from what it took so far: how many iterations a body takes is not known before.

use std::ops::ControlFlow;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use mechanics::forward::{Event, GROWTH, Workspace};
use program::about;

/// Newton iterations from rest to a load. Six bodies took 6 to 10.
const ITERATIONS: f64 = 8.0;
/// Time of a later load step, in times of one of the first two, as five bodies took it.
const LATER: f64 = 0.7;
/// Share of a run after which its time is foreseen for the report.
const ENOUGH: f64 = 0.1;
/// Share that is none.
const ROUNDING: f64 = 1e-9;
/// What is worth a word [s].
const LONG: f64 = 2.0;

/// What is foreseen of a run that goes on.
pub struct Outlook {
    since: Instant,
    in_time: bool,
    /// Shares of the run where it began and where it came to, and the largest that a step takes.
    shares: [f64; 3],
    /// Steps made, and the time after the first of them [s].
    steps: usize,
    first: f64,
    /// Time of the whole [s], as it was foreseen first.
    foreseen: Arc<Mutex<Option<f64>>>,
}

impl Outlook {
    /// Of a run that begins at the share `begin` of its load, or of its time steps. A step takes the share `largest` at most.
    /// Where one step is left, the run is foreseen after its first iteration.
    pub fn new(in_time: bool, begin: f64, largest: f64, workspace: &mut Workspace) -> Self {
        let (since, foreseen) = (Instant::now(), Arc::new(Mutex::new(None)));
        if begin + largest >= 1.0 {
            let known = Arc::clone(&foreseen);
            let mut inner = workspace.watch.take();
            workspace.watch = Some(Box::new(move |event| {
                if let Event::Iterate { iteration: 1, .. } = event {
                    let left = (ITERATIONS - 1.0) * since.elapsed().as_secs_f64();
                    let mut known = known.lock().unwrap_or_else(PoisonError::into_inner);
                    if known.is_none() && left > LONG {
                        log::info!(
                            "about {} left, if it takes as many iterations as most",
                            about(left)
                        );
                    }
                    known.get_or_insert(since.elapsed().as_secs_f64() + left);
                }
                match &mut inner {
                    Some(inner) => inner(event),
                    None => ControlFlow::Continue(()),
                }
            }));
        }
        Self { since, in_time, shares: [begin, begin, largest], steps: 0, first: 0.0, foreseen }
    }

    /// Takes note of a share of the run that a step has reached: what is left, in words, if that is worth a word.
    pub fn reached(&mut self, share: f64) -> Option<String> {
        let spent = self.since.elapsed().as_secs_f64();
        let [begin, last, largest] = self.shares;
        (self.shares[1], self.steps) = (share, self.steps + 1);
        // the first step begins with less than others
        let each = match self.steps {
            1 => {
                self.first = spent;
                spent
            }
            steps => (spent - self.first) / (steps - 1) as f64,
        };
        let later = if self.in_time || self.steps > 2 { 1.0 } else { LATER };
        let left = later * each * steps_left(share, share - last, largest);
        if share - begin >= ENOUGH * (1.0 - begin) {
            let mut foreseen = self.foreseen.lock().unwrap_or_else(PoisonError::into_inner);
            foreseen.get_or_insert(spent + left);
        }
        (left > LONG).then(|| format!("about {} left", about(left)))
    }

    /// Time of the whole that was foreseen after its first tenth, or after the first iteration of a single step [s].
    pub fn foreseen(&self) -> Option<f64> {
        *self.foreseen.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Steps from a share to the end, of which each grows by [`GROWTH`] up to the largest.
fn steps_left(mut share: f64, step: f64, largest: f64) -> f64 {
    let mut step = step.max(ROUNDING);
    let mut steps = 0.0;
    while share < 1.0 - ROUNDING {
        step = (GROWTH * step).min(largest);
        let taken = step.min(1.0 - share);
        // many equal ones at once
        let equal = if step >= largest { ((1.0 - share) / largest).floor().max(1.0) } else { 1.0 };
        share += equal * taken;
        steps += equal;
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_grow_to_the_largest() {
        assert_eq!(steps_left(0.25, 0.25, 0.25), 3.0);
        assert_eq!(steps_left(1.0, 0.25, 0.25), 0.0);
        // 0.15, 0.225, 0.3 and the rest
        assert_eq!(steps_left(0.1, 0.1, 0.3), 4.0);
        assert_eq!(steps_left(0.999, 1e-3, 1e-3), 1.0);
    }
}
