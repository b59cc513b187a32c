//! Force of a support on the body.
//!
//! q = a · Σ r_n      over the nodes of a fixed tag, along the axes that it fixes   [N]
//!
//! r = ∂E/∂u on fixed degrees of freedom. A node on the rim of several fixed tags counts
//! for the first of them.

use super::*;

pub(super) const KIND: Kind = Kind {
    key: "reaction",
    unit: "N",
    example: "on = 'bottom'\naxis = [0, 0, 1]",
    ..Kind::of::<Keys>(&[List::Probe])
};

program::table! {
    /// force of a support on the body along an axis, a · Σ r
    #[derive(Debug)]
    struct Keys {
        /// tag of a [[fixed]]
        on: String;
        /// a, of any length but 0
        axis: Axis;
    }
}

impl Specification for Keys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        // a tag that does not exist is another error than one that is not fixed
        site.body.facets(&self.on)?;
        let dofs = site.supports.get(&self.on).ok_or_else(|| {
            let fixed: Vec<&str> = site.supports.keys().map(String::as_str).collect();
            misfit!(
                KeyPath::of("on"),
                " = \"{}\": no [[fixed]] has this tag; fixed are: {}",
                self.on,
                fixed.join(", ")
            )
        })?;
        Ok(Arc::new(Reaction { dofs: dofs.clone(), axis: self.axis.unit() }))
    }
}

/// Sum of the forces on fixed degrees of freedom along an axis.
struct Reaction {
    dofs: Vec<usize>,
    axis: Vec3,
}

impl Quantity for Reaction {
    fn value(&self, at: &Equilibrium) -> f64 {
        self.dofs.iter().map(|&dof| self.axis[dof % 3] * at.reaction[dof]).sum()
    }

    fn uses_reaction(&self) -> bool {
        true
    }

    fn add_partials(&self, _: &Equilibrium, weight: f64, out: &mut Partials) {
        self.dofs.iter().for_each(|&dof| out.reaction[dof] += weight * self.axis[dof % 3]);
    }
}
