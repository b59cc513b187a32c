//! Force of a thread.
//!
//! q = (∫ N^p dS / ∫ dS)^(1/p)      N along the thread, S its length at rest
//!
//! The mean for p = 1; the larger p, the nearer to the largest force. See [`mechanics::energy::Winding::mean_force`].

use mechanics::energy::{Iterate, Owner, Winding};
use program::unknown;

use super::*;

/// Powers above which forces of a hundredth of the largest are rounding.
const MOST_POWER: f64 = 100.0;

pub(super) const KIND: Kind = Kind {
    key: "winding-force",
    unit: "N",
    example: "winding = 'thread'\npower = 3.0",
    ..Kind::of::<Keys>(&[List::Probe])
};

program::table! {
    /// (∫ N^p dS / ∫ dS)^(1/p) of the force N of a thread: the mean, or nearly the largest
    #[derive(Debug)]
    struct Keys {
        /// name of the [[winding]]
        winding: String;
        /// p ≥ 1, the mean for 1; about 10 for the largest
        power: f64 = 1.0, Range::between(1.0, MOST_POWER);
    }
}

impl Specification for Keys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let place = site.threads.iter().position(|name| **name == self.winding);
        let place = place.ok_or_else(|| {
            let known = site.threads.iter().copied();
            let has = match site.threads.is_empty() {
                true => "the scene has no [[winding]]".to_owned(),
                false => format!("there are: {}", site.threads.join(", ")),
            };
            KeyPath::of("winding").told(unknown("unknown winding", &self.winding, known, ';', &has))
        })?;
        Ok(Arc::new(WindingForce { place, power: self.power }))
    }
}

/// A mean of the force of a thread.
struct WindingForce {
    /// The place of the thread among all.
    place: usize,
    power: f64,
}

impl WindingForce {
    fn on<'a>(&self, at: &Equilibrium<'a>) -> (&'a Winding, Iterate<'a>) {
        let thread = at.energies.of(Winding::owner(self.place));
        let thread = thread.expect("the scene has the thread");
        (thread, Iterate::new(at.space, at.rest, at.u, at.time))
    }
}

impl Quantity for WindingForce {
    fn value(&self, at: &Equilibrium) -> f64 {
        let (thread, at) = self.on(at);
        thread.mean_force(&at, self.power)
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        let (thread, at) = self.on(at);
        thread.add_mean_force(&at, [self.power, weight], (&mut *out.u, &mut *out.rest));
    }

    fn by_parameters(&self, at: &Equilibrium, weight: f64) -> Vec<(Owner, Vec<f64>)> {
        let (thread, at) = self.on(at);
        let by = thread.mean_force_by_parameters(&at, self.power);
        vec![(Winding::owner(self.place), by.iter().map(|by| weight * by).collect())]
    }
}
