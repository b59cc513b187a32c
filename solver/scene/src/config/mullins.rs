//! `[[mullins]]`: stress that a first stretch takes from a material.

use anyhow::{Result, ensure};
use mechanics::forward::Method;
use mechanics::material::OgdenRoxburgh;
use program::table::Range;
use program::{KeyPath, misfit};

use super::SimConfig;

program::table! {
    /// Softening of bodies by what they were stretched before, after Ogden and Roxburgh: the isochoric stress of the
    /// law times η = 1 − erf((W_m − W)/(m + beta W_m))/r. W is the isochoric energy density of the law, and W_m the
    /// largest one that the point has had at the end of a time step.
    #[derive(Clone, Debug)]
    pub struct MullinsConfig {
        /// The body or volume.
        on: Option<String> = None => "all";
        /// Stress falls by 1/r of itself at most; above 1 [1].
        r: f64, Range::above(1.0).advice(", as stress falls by 1/r of itself at most; such as 2");
        /// How slowly it falls after small stretches: an energy density; 0 or more [Pa].
        m: f64, Range::NOT_NEGATIVE.unit("Pa");
        /// How slowly it falls after large stretches; 0, as in the original law, or more, and not 0 together with m [1].
        beta: f64 = 0.0, Range::NOT_NEGATIVE;
    }
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
    /// Checks that a scene with softening has states in an order, each of which follows from the last.
    pub(super) fn check_mullins(&self) -> Result<()> {
        for MullinsConfig { m, beta, .. } in &self.mullins {
            ensure!(
                *m + *beta > 0.0,
                misfit!(
                    KeyPath::list("mullins").key("m"),
                    " = 0 Pa and beta = 0: m + beta W_m divides an energy density; expected one of both above 0"
                )
            );
        }
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
