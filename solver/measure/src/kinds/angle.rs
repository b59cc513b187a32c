//! Angle between two tags.
//!
//! q = angle between N₁ and N₂, from 0 to 180°      N = ∫ n da of the deformed tag   [deg]
//!
//! N is the mean normal, out of the body, times the area. A closed surface has none. q has no
//! derivative at 0 and 180°.

use super::*;
use crate::quantity::Normal;

pub(super) const KIND: Kind = Kind {
    key: "angle",
    unit: "deg",
    example: "on = 'top'\nto = 'left'",
    ..Kind::of::<Keys>(&[List::Probe])
};

program::table! {
    /// angle between the mean normals of two tags, from 0 to 180
    #[derive(Debug)]
    struct Keys {
        /// tag
        on: String;
        /// the other tag
        to: String;
    }
}

impl Specification for Keys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let sides = [Normal::new(&self.on, site)?, Normal::new(&self.to, site)?];
        Ok(Arc::new(Angle { sides }))
    }
}

/// The angle between two walls.
struct Angle {
    sides: [Normal; 2],
}

impl Angle {
    /// Adds `weight` ∂q/∂x at the nodes.
    fn add_by_nodes(&self, state: &Equilibrium, weight: f64, out: &mut [f64]) {
        let x = state.nodes(Measure::Deformed);
        let [a, b] = self.sides.each_ref().map(|side| side.at(state.space, &x));
        let Some(across) = a.cross(&b).try_normalize(0.0) else { return };
        let by = [a.cross(&across) / a.norm_squared(), across.cross(&b) / b.norm_squared()];
        for (side, by) in self.sides.iter().zip(by) {
            side.add_by_nodes(state.space, &x, &(weight.to_degrees() * by), out);
        }
    }
}

impl Quantity for Angle {
    fn value(&self, state: &Equilibrium) -> f64 {
        let x = state.nodes(Measure::Deformed);
        let [a, b] = self.sides.each_ref().map(|side| side.at(state.space, &x));
        a.cross(&b).norm().atan2(a.dot(&b)).to_degrees()
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        out.add_by_nodes(at, Measure::Deformed, |nodal| self.add_by_nodes(at, weight, nodal));
    }
}
