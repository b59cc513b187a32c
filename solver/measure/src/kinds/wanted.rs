//! A probe of the scene, or what is left to a wanted value of it.
//!
//! J = q / s                 [1]
//! J = ((q − q*(t)) / s)²    [1]
//!
//! q    value of the probe, in its unit; q* the wanted one, as it is written, from t = 0 on
//! s    scale: a difference that counts as 1

use mechanics::energy::Owner;
use mechanics::schedule::{Schedule, Written};

use super::*;
use crate::written::{ScheduleSchema, values};

pub(super) const KIND: Kind = Kind {
    key: "probe",
    unit: "1",
    may_be_maximised: true,
    example: "probe = 'q'\ntarget = '0.1*t'\nscale = 0.5",
    ..Kind::of::<Keys>(&[List::Objective])
};

program::table! {
    /// q/s, or ((q − q*)/s)², q the value of a probe of the scene
    #[derive(Debug)]
    struct Keys {
        /// its name
        probe: String;
        /// q*, in the unit of the probe: a number, an expression in t, or a table
        #[schemars(with = "Option<ScheduleSchema>")]
        target: Option<Written> = None;
        /// s, in the unit of the probe
        scale: f64 = 1.0, Range::POSITIVE;
    }
}

impl Specification for Keys {
    fn check(&self) -> Result<()> {
        if let Some(target) = &self.target {
            values("target", target)?;
            ensure!(
                !target.uses_position(),
                misfit!(KeyPath::of("target"), " = {target}: must depend on t alone")
            );
        }
        Ok(())
    }

    fn may_be_maximised(&self) -> bool {
        self.target.is_none()
    }

    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let Self { probe, target, scale } = self;
        let quantity = site.probes.get(probe).ok_or_else(|| {
            let known: Vec<&str> = site.probes.keys().map(String::as_str).collect();
            misfit!(
                KeyPath::of("probe"),
                " = \"{probe}\": no [[probe]] of the scene is called that; there are: {}",
                known.join(", ")
            )
        })?;
        let target = target.as_ref().map(|target| values("target", target)).transpose()?;
        if let Some(target) = &target {
            let checked = target.check(&site.times, &[]);
            checked.map_err(|what| misfit!(KeyPath::of("target"), ": {what}"))?;
        }
        Ok(Arc::new(Wanted { quantity: Arc::clone(quantity), target, scale: *scale }))
    }
}

/// A probe over its scale, or the square of what is left to a wanted value.
struct Wanted {
    quantity: Arc<dyn Quantity>,
    target: Option<Schedule>,
    scale: f64,
}

impl Wanted {
    /// J, with ∂J/∂q.
    fn at(&self, state: &Equilibrium) -> (f64, f64) {
        let q = self.quantity.value(state);
        let Some(target) = &self.target else { return (q / self.scale, 1.0 / self.scale) };
        let left = (q - target.as_written(Vec3::zeros(), state.time).value) / self.scale;
        (left * left, 2.0 * left / self.scale)
    }
}

impl Quantity for Wanted {
    fn value(&self, at: &Equilibrium) -> f64 {
        self.at(at).0
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        self.quantity.add_partials(at, weight * self.at(at).1, out);
    }

    fn by_parameters(&self, at: &Equilibrium, weight: f64) -> Vec<(Owner, Vec<f64>)> {
        self.quantity.by_parameters(at, weight * self.at(at).1)
    }

    fn uses_contact(&self) -> bool {
        self.quantity.uses_contact()
    }

    fn uses_reaction(&self) -> bool {
        self.quantity.uses_reaction()
    }
}
