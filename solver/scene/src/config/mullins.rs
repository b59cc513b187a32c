//! `[[mullins]]`: stress that a first stretch takes from a material.

use anyhow::{Result, ensure};
use mechanics::forward::Method;
use mechanics::material::OgdenRoxburgh;
use program::{KeyPath, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SimConfig;

/// Softening of bodies by what they were stretched before, after Ogden and Roxburgh: the isochoric stress of the
/// law times η = 1 − erf((W_m − W)/(m + beta W_m))/r. W is the isochoric energy density of the law, and W_m the
/// largest one that the point has had at the end of a time step.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MullinsConfig {
    /// The body or volume; all of them if not given.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub on: Option<String>,
    /// Stress falls by 1/r of itself at most; above 1 [1].
    pub r: f64,
    /// How slowly it falls after small stretches: an energy density; 0 or more [Pa].
    pub m: f64,
    /// How slowly it falls after large stretches; 0, as in the original law, or more, and not 0 together with m [1].
    #[serde(default)]
    pub beta: f64,
}

impl MullinsConfig {
    /// The law of softening.
    pub fn law(&self) -> OgdenRoxburgh {
        OgdenRoxburgh { r: self.r, m: self.m, beta: self.beta }
    }

    /// What reports and messages call it.
    pub fn in_words(&self) -> String {
        let Self { on, r, m, beta } = self;
        let on = on.as_ref().map_or_else(String::new, |on| format!(" of {on}"));
        format!(
            "softening{on} after a first stretch: by {:.1} % at most, m = {m} Pa, beta = {beta}",
            100.0 / r
        )
    }
}

impl SimConfig {
    /// Checks what can be checked of softening without a body.
    pub fn check_mullins(&self) -> Result<()> {
        let key = |key: &str| KeyPath::list("mullins").key(key);
        for MullinsConfig { r, m, beta, .. } in &self.mullins {
            ensure!(
                *r > 1.0 && r.is_finite(),
                misfit!(
                    key("r"),
                    " = {r}: must be above 1 and finite, as stress falls by 1/r of itself at most; expected a \
                     number such as 2"
                )
            );
            ensure!(
                *m >= 0.0 && m.is_finite(),
                misfit!(key("m"), " = {m} Pa: must be 0 or more and finite")
            );
            ensure!(
                *beta >= 0.0 && beta.is_finite(),
                misfit!(key("beta"), " = {beta}: must be 0 or more and finite")
            );
            ensure!(
                *m + *beta > 0.0,
                misfit!(
                    key("m"),
                    " = 0 Pa and beta = 0: m + beta W_m divides an energy density; expected one of both above 0"
                )
            );
        }
        self.check_history_of_mullins()
    }

    /// Checks that a scene with softening has states in an order, each of which follows from the last.
    fn check_history_of_mullins(&self) -> Result<()> {
        if self.mullins.is_empty() {
            return Ok(());
        }
        ensure!(
            self.time.is_some(),
            misfit!(
                KeyPath::list("mullins"),
                " without [time]: the load of a scene without time steps never falls, so that nothing is softened. \
                 Expected [time], with method = \"quasistatic\" where inertia does not matter, and a load that \
                 falls and rises, such as pressure = \"20e3*sin(pi*t)^2\""
            )
        );
        let method = self.method();
        ensure!(
            matches!(method, Method::Quasistatic | Method::ImplicitEuler),
            misfit!(
                KeyPath::table("time").key("method"),
                " = {} beside [[mullins]]: the largest energy before a step is that of the last state, not a \
                 formula of several; expected \"quasistatic\" or \"implicit-euler\"",
                serde_json::json!(method)
            )
        );
        Ok(())
    }
}
