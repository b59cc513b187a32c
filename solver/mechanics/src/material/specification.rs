//! A law with its parameters and where they may be trusted.

use super::response::Mode;
use super::{Law, Material, Moduli};

/// A material of a scene.
#[derive(Clone)]
pub struct Specification {
    /// The law.
    pub law: &'static Law,
    /// The parameters.
    pub values: Vec<f64>,
    /// Density [kg/m³], if known.
    pub density: Option<f64>,
    /// Smallest and largest principal stretch that the parameters were fitted
    /// to and are stable in [1], if known.
    pub stretch_range: Option<[f64; 2]>,
    /// Modes that the parameters were fitted in; none where that is not known.
    pub modes: Vec<Mode>,
    /// Uniaxial stretch at which it tears [1], if known: 1 + elongation at break.
    pub stretch_at_break: Option<f64>,
    /// How much softer it may be than its law, as far as it is known.
    pub softening: Softening,
}

/// What silicone does besides: how much softer than its law it may be. The law is that of a first
/// stretch, soon after the load.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Softening {
    /// Part by which strain grows while a load is held [1]: stiffness falls to 1/(1 + creep).
    pub creep: Option<f64>,
    /// Part by which stress falls once it has been stretched before (Mullins effect) [1].
    pub mullins: Option<f64>,
}

impl Softening {
    /// The changes of all stresses that may be, as parts of them, by name: negative ones.
    pub fn changes(&self) -> impl Iterator<Item = (&'static str, f64)> {
        let creep = self.creep.map(|creep| ("creep", 1.0 / (1.0 + creep) - 1.0));
        creep.into_iter().chain(self.mullins.map(|mullins| ("mullins", -mullins)))
    }
}

impl Specification {
    /// The law, ready for use.
    pub fn build(&self) -> Box<dyn Material> {
        (self.law.build)(&self.values)
    }

    /// Smallest and largest principal stretch of its tests [1]: at constant volume a strip that was pulled to λ became
    /// as thin as λ^−½ at least.
    pub fn tested(&self) -> Option<[f64; 2]> {
        self.stretch_range.map(|[low, high]| [low.min(high.powf(-0.5)), high])
    }

    /// Moduli at rest.
    pub fn moduli(&self) -> Moduli {
        (self.law.moduli)(&self.values)
    }
}
