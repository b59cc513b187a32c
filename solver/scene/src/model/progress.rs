//! How far a run is: its times, and what is said on the way.

use std::ops::ControlFlow;

use mechanics::forward::{Event, Watch};
use program::Heartbeat;

use super::Scene;

impl Scene {
    /// Ends of the time steps [s]; of a static scene the full load, 1.
    pub fn times(&self) -> Vec<f64> {
        self.config.times()
    }

    /// The load at the end [s].
    pub fn end(&self) -> f64 {
        self.times().last().copied().unwrap_or(1.0)
    }

    /// A load in words, for messages.
    pub fn progress(&self, load: f64) -> String {
        progress(self.config.time.is_some(), load)
    }
}

/// A time, or of a static scene a load, in words.
fn progress(in_time: bool, load: f64) -> String {
    if in_time { format!("t = {load:.4e} s") } else { format!("{:.1} % of the load", 100.0 * load) }
}

/// Says in the log what happens on the way to an equilibrium of a static scene, or of one in time.
pub(super) fn watch(in_time: bool) -> Watch {
    let mut heartbeat = Heartbeat::start();
    Box::new(move |event| {
        match event {
            Event::Iterate { time, iteration, residual, wanted } => {
                if *iteration == 0 {
                    heartbeat = Heartbeat::start();
                }
                heartbeat.say(|| {
                    let towards = progress(in_time, *time);
                    format!(
                        "towards {towards}: iteration {iteration}, forces off balance by {residual:.1e} N, \
                         {wanted:.1e} N wanted"
                    )
                });
            }
            Event::Adjoint { step } => heartbeat.say(|| format!("adjoint of time step {step}")),
            Event::AtRoundingFloor { time, residual, wanted, floor } => log::warn!(
                "load {time:.4}: residual {residual:.1e} N instead of {wanted:.1e} N: it does not \
                 fall further and rounding alone may leave {floor:.0e} N"
            ),
            Event::KeptInMemory { error } => log::warn!(
                "{}: states could not be written ({error}); they stay in memory, beyond the budget",
                std::env::temp_dir().display()
            ),
        }
        ControlFlow::Continue(())
    })
}
