//! `[[mullins]]`: stress that a first stretch takes from a material.
//!
//! | name of a cell field | is | unit |
//! |-|-|-|
//! | `mullins_factor` | mean of η in this state, 1 where nothing softens | 1 |
//! | `mullins_factor_at_rest` | mean of η at rest after it | 1 |

use anyhow::{Result, ensure};
use mechanics::energy::{Mullins, MullinsMean, MullinsSummary, Term};
use mechanics::forward::Method;
use mechanics::material::OgdenRoxburgh;
use mesh::io::vtu::Field;
use program::table::Range;
use program::{KeyPath, misfit};
use reports::Terms;

use super::material::SceneLaw;
use super::{About, Around, Ground, Known, Room, RoomNumber, Stage, State, each, isochoric, value};

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

impl Room for Vec<MullinsConfig> {
    fn about(&self) -> About {
        About {
            list: "mullins",
            stage: Stage::Body,
            paths: "mullins.N.r, .m or .beta",
            meaning: "a number of the N-th [[mullins]], counted from 1",
            example: "",
        }
    }

    fn in_words(&self) -> Vec<String> {
        let one = |MullinsConfig { on, r, m, beta }: &MullinsConfig| {
            let on = on.as_ref().map_or_else(String::new, |on| format!(" of {on}"));
            format!(
                "softening{on} after a first stretch: by {:.1} % at most, m = {m} Pa, beta = {beta}",
                100.0 / r
            )
        };
        self.iter().map(one).collect()
    }

    /// States have an order in which each follows from the last.
    fn check(&self, around: &Around) -> Result<()> {
        for MullinsConfig { m, beta, .. } in self {
            ensure!(
                *m + *beta > 0.0,
                misfit!(
                    KeyPath::list("mullins").key("m"),
                    " = 0 Pa and beta = 0: m + beta W_m divides an energy density; expected one of both above 0"
                )
            );
        }
        if self.is_empty() {
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

    fn check_laws(&self, laws: &[SceneLaw]) -> Result<()> {
        let mut softened = vec![false; laws.len()];
        for MullinsConfig { on, .. } in self {
            for i in isochoric("mullins", on.as_deref(), laws)? {
                let twice = std::mem::replace(&mut softened[i], true);
                ensure!(
                    !twice,
                    misfit!(
                        KeyPath::list("mullins").on(on.as_deref().unwrap_or_default()),
                        ": \"{}\" is softened by two tables; expected one, with on where volumes differ",
                        laws[i].name
                    )
                );
            }
        }
        Ok(())
    }

    /// The softening of a law that is not that of a rigid body.
    fn beside(&self, law: usize, ground: &Ground, first: usize) -> Result<Option<Term>> {
        let own_law = &ground.laws[law];
        let own = self.iter().find(|table| own_law.is_of(table.on.as_deref()));
        let own = own.filter(|_| !own_law.is_rigid).zip(own_law.material.build().isochoric());
        Ok(own.map(|(&MullinsConfig { r, m, beta, .. }, isochoric)| {
            let (softening, tets) = (OgdenRoxburgh { r, m, beta }, own_law.elements(ground.body));
            let mullins = Mullins::new(isochoric, softening, tets, first).named(&own_law.name);
            Term::of_both(own_law.numbers(law), Mullins::owner(law), mullins)
        }))
    }

    fn numbers(&mut self) -> Vec<RoomNumber<'_>> {
        each(self, |place, MullinsConfig { r, m, beta, .. }| {
            let numbers = vec![value("r", "1", r), value("m", "Pa", m), value("beta", "1", beta)];
            ((place + 1).to_string(), numbers)
        })
    }

    fn derivative(&self, table: usize, key: &str, known: &Known) -> f64 {
        let on = self[table].on.as_deref();
        let own = known.laws.iter().enumerate().filter(|(_, law)| law.is_of(on));
        own.map(|(place, _)| known.by(Mullins::owner(place), key)).sum()
    }

    fn report(&self, State { energies, at }: State, terms: &mut Terms) {
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
        terms.mullins = (!self.is_empty()).then(|| energies.each().map(one).collect());
    }

    fn fields(&self, State { energies, at }: State) -> Vec<Field> {
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
