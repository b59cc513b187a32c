//! `[[relaxation]]`: stress that a material has for a while beside that of its law.

use anyhow::{Result, ensure};
use program::{KeyPath, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SimConfig;

/// A Maxwell branch beside the laws of bodies: one term of a Prony series. The law alone is what is
/// left after a long time; stresses of result files are those of the law.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RelaxationConfig {
    /// The body or volume; all of them if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on: Option<String>,
    /// Isochoric stress that a sudden strain adds, as a part of that of the law [1].
    pub overstress: f64,
    /// Relaxation time, after which 1/e of it is left under constant strain [s].
    pub time: f64,
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
    /// Checks what can be checked of relaxation without a body.
    pub fn check_relaxation(&self) -> Result<()> {
        let key = |key: &str| KeyPath::list("relaxation").key(key);
        for RelaxationConfig { overstress, time, .. } in &self.relaxation {
            ensure!(
                *overstress > 0.0 && overstress.is_finite(),
                misfit!(
                    key("overstress"),
                    " = {overstress}: must be positive and finite; expected a part of the stress of the law, \
                     such as 0.1"
                )
            );
            ensure!(
                *time > 0.0 && time.is_finite(),
                misfit!(key("time"), " = {time} s: must be positive and finite")
            );
        }
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
