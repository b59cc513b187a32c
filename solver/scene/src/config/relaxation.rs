//! `[[relaxation]]`: stress that a material has for a while beside that of its law.

use anyhow::{Result, ensure};
use program::table::Range;
use program::{KeyPath, misfit};

use super::SimConfig;

program::table! {
    /// A Maxwell branch beside the laws of bodies: one term of a Prony series. The law alone is what is
    /// left after a long time; stresses of result files are those of the law.
    #[derive(Clone, Debug)]
    pub struct RelaxationConfig {
        /// The body or volume.
        on: Option<String> = None => "all";
        /// Isochoric stress that a sudden strain adds, as a part of that of the law [1].
        overstress: f64, Range::POSITIVE.advice("; expected a part of the stress of the law, such as 0.1");
        /// Relaxation time, after which 1/e of it is left under constant strain [s].
        time: f64, Range::POSITIVE.unit("s");
    }
}

impl RelaxationConfig {
    /// What reports and messages call it.
    pub fn in_words(&self) -> String {
        let Self { on, overstress, time } = self;
        let on = on.as_ref().map_or_else(String::new, |on| format!(" of {on}"));
        format!(
            "relaxation{on}: {:.1} % more isochoric stress at once, for {time} s",
            100.0 * overstress
        )
    }
}

impl SimConfig {
    pub(super) fn check_relaxation(&self) -> Result<()> {
        ensure!(
            self.relaxation.is_empty() || self.time.is_some(),
            misfit!(
                KeyPath::list("relaxation"),
                " without [time]: a scene without time steps has no rate; its state is that after a long \
                 time, of the law alone. Expected [time], with method = \"quasistatic\" where inertia does \
                 not matter"
            )
        );
        Ok(())
    }
}
