//! Numbers of materials.

use mechanics::energy::{BodyForce, Contact, Elastic, Inertia, Slot};
use mechanics::material::Specification;

use super::{Kind, Owners};
use crate::term::material::SceneLaw;
use crate::term::{Place, RoomNumber, each, value};

pub(super) const MATERIAL: Kind = Kind {
    word: "material",
    paths: "material.BODY.PARAMETER",
    meaning: "a parameter of the law of a body or volume, as `solver list` names it; of a list, \
              with its place, as in material.body.mu.1",
    numbers: parameters,
    derivative: |swept, number| {
        let (place, law) = (number.owner(), &swept.scene.laws[number.owner()]);
        let slots = slots(&law.material);
        let Some(k) = slots.iter().position(|slot| slot.key == number.key) else { return 0.0 };
        // a rigid body has another law than its own
        let own = if law.is_rigid { 0.0 } else { swept.known.total(Elastic::owner(place), k) };
        match swept.scene.law_of_contact() {
            Some(stiffest) if stiffest == place => {
                let by_stiffness = swept.known.total(Contact::OWNER, 0);
                own + by_stiffness * shear_modulus_by(&law.material, (k, slots[k].unit))
            }
            _ => own,
        }
    },
};

pub(super) const DENSITY: Kind = Kind {
    word: "density",
    paths: "density.BODY",
    meaning: "the density of a body or volume, where it is known",
    numbers: densities,
    derivative: |swept, number| {
        let of = |owner| swept.known.by(owner, "density");
        of(BodyForce::weight_owner(number.owner())) + of(Inertia::owner(number.owner()))
    },
};

fn parameters<'a>(_: &str, Owners { laws, .. }: Owners<'a>) -> Vec<RoomNumber<'a>> {
    each(laws, |_, SceneLaw { name, material, .. }| {
        let slots = slots(material).into_iter().zip(&mut material.values);
        (name.clone(), slots.map(|(slot, value)| (slot, Place::Value(value))).collect())
    })
}

fn densities<'a>(_: &str, Owners { laws, .. }: Owners<'a>) -> Vec<RoomNumber<'a>> {
    each(laws, |_, SceneLaw { name, material, .. }| {
        let density = material.density.iter_mut();
        (name.clone(), density.map(|density| value("", "kg/m³", density)).collect())
    })
}

/// Half of the difference of parameters that gives the derivative of the shear modulus, over that modulus or in the
/// parameter's unit.
const DIFFERENCE: f64 = 1e-5;

/// The derivative of the shear modulus at rest by a parameter with a unit, by a difference: moduli are linear in stresses,
/// and smooth in what has no unit.
fn shear_modulus_by(material: &Specification, (k, unit): (usize, &str)) -> f64 {
    let by = if unit == "Pa" { DIFFERENCE * material.moduli().shear } else { DIFFERENCE };
    let moved = |by: f64| {
        let mut values = material.values.clone();
        values[k] += by;
        (material.law.moduli)(&values).shear
    };
    (moved(by) - moved(-by)) / (2.0 * by)
}

/// Names and units of all parameters of a law, one by one.
fn slots(material: &Specification) -> Vec<Slot> {
    let named = material.law.named(&material.values).into_iter();
    let slots = named.flat_map(|(parameter, own)| {
        let count = parameter.list.then_some(own.len());
        Slot::along(parameter.name, parameter.unit, count)
    });
    slots.collect()
}
