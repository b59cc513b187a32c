//! `[[mullins]]`: stress that a first stretch takes from a material.
//!
//! | name of a cell field | is | unit |
//! |-|-|-|
//! | `mullins_factor` | mean of η in this state, 1 where nothing softens | 1 |
//! | `mullins_factor_at_rest` | mean of η at rest after it | 1 |

use anyhow::{Result, ensure};
use mechanics::energy::{Mullins, MullinsMean, MullinsSummary};
use mechanics::forward::Method;
use mechanics::material::OgdenRoxburgh;
use mesh::io::vtu::Field;
use program::table::Range;
use program::{KeyPath, misfit};
use reports::Terms;

use super::{Around, Known, State, TableNumber, TermTable, value};

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
}

impl TermTable for MullinsConfig {
    const LIST: &'static str = "mullins";
    const PATHS: &'static str = "mullins.N.r, .m or .beta";
    const MEANING: &'static str = "a number of the N-th [[mullins]], counted from 1";

    fn name(&self, place: usize) -> String {
        (place + 1).to_string()
    }

    fn in_words(&self) -> Option<String> {
        let Self { on, r, m, beta } = self;
        let on = on.as_ref().map_or_else(String::new, |on| format!(" of {on}"));
        Some(format!(
            "softening{on} after a first stretch: by {:.1} % at most, m = {m} Pa, beta = {beta}",
            100.0 / r
        ))
    }

    /// States have an order in which each follows from the last.
    fn check(all: &[Self], around: &Around) -> Result<()> {
        for MullinsConfig { m, beta, .. } in all {
            ensure!(
                *m + *beta > 0.0,
                misfit!(
                    KeyPath::list("mullins").key("m"),
                    " = 0 Pa and beta = 0: m + beta W_m divides an energy density; expected one of both above 0"
                )
            );
        }
        if all.is_empty() {
            return Ok(());
        }
        ensure!(
            around.in_time,
            misfit!(
                KeyPath::list("mullins"),
                " without [time]: the load of a scene without time steps never falls, so that nothing is softened. \
                 Expected [time], with method = \"quasistatic\" where inertia does not matter, and a load that \
                 falls and rises, such as pressure = \"20e3*sin(pi*t)^2\""
            )
        );
        ensure!(
            matches!(around.method, Method::Quasistatic | Method::ImplicitEuler),
            misfit!(
                KeyPath::table("time").key("method"),
                " = {} beside [[mullins]]: the largest energy before a step is that of the last state, not a \
                 formula of several; expected \"quasistatic\" or \"implicit-euler\"",
                serde_json::json!(around.method)
            )
        );
        Ok(())
    }

    fn numbers(&mut self) -> Vec<TableNumber<'_>> {
        let Self { r, m, beta, .. } = self;
        vec![value("r", "1", r), value("m", "Pa", m), value("beta", "1", beta)]
    }

    fn derivative(all: &[Self], place: usize, key: &str, known: &Known) -> f64 {
        let on = all[place].on.as_deref();
        let own = known.regions.iter().enumerate().filter(|(_, region)| region.is_of(on));
        own.map(|(law, _)| (known.by)(Mullins::owner(law), key)).sum()
    }

    fn report(_: &[Self], State { energies, at }: State, terms: &mut Terms) {
        let one = |own: &Mullins| {
            let MullinsSummary {
                largest_energy,
                factor,
                factor_at_rest,
                mean_factor_at_rest,
                lost,
            } = own.summary(at);
            let on = own.name.clone();
            reports::Mullins {
                on,
                largest_energy,
                factor,
                factor_at_rest,
                mean_factor_at_rest,
                lost,
            }
        };
        terms.mullins = Some(energies.each().map(one).collect());
    }

    fn fields(State { energies, at }: State) -> Vec<Field> {
        let mut softened = energies.each::<Mullins>().peekable();
        if softened.peek().is_none() {
            return Vec::new();
        }
        let virgin = MullinsMean { factor: 1.0, factor_at_rest: 1.0 };
        let mut means = vec![virgin; at.space.tets().len()];
        for mullins in softened {
            means[mullins.elements()].copy_from_slice(&mullins.means(at));
        }
        let field = |name: &str, of: fn(&MullinsMean) -> f64| Field {
            name: name.to_owned(),
            unit: "1".to_owned(),
            components: 1,
            values: means.iter().map(of).collect(),
        };
        vec![
            field("mullins_factor", |mean| mean.factor),
            field("mullins_factor_at_rest", |mean| mean.factor_at_rest),
        ]
    }
}
