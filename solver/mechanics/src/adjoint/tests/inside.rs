//! What is in the chamber of a block.

use super::{CHANGE, Case, FACTOR};
use crate::energy::gas_law::SuppliedGas;
use crate::energy::{GasLaw, IdealGas, Isobaric, PrescribedVolume};

/// Each gas law, and how its volume or line is given.
#[derive(Clone, Copy, PartialEq)]
pub enum Inside {
    Pressure,
    Gas,
    Volume,
    Factor,
    Supply,
    CheckedSupply,
}

/// The gas of a case with the number that it follows over time.
pub fn gas(case: &Case, number: f64) -> Box<dyn GasLaw> {
    let ambient = 101.3e3;
    match case.inside {
        Inside::Gas => Box::new(IdealGas { fill: case.steady(number), ambient, exponent: 1.4 }),
        Inside::Pressure => Box::new(Isobaric { pressure: case.steady(number) }),
        Inside::Volume => Box::new(PrescribedVolume::Change(case.steady(CHANGE * number))),
        Inside::Factor => Box::new(PrescribedVolume::Factor(case.steady(FACTOR * number))),
        Inside::Supply | Inside::CheckedSupply => Box::new(SuppliedGas {
            supply: case.steady(number),
            checked: case.inside == Inside::CheckedSupply,
            // a flow that fills the hole in about one step
            resistance: ambient * case.dt / 1e-6,
            leak: 2e-7 / (ambient * case.dt),
            ambient,
        }),
    }
}
