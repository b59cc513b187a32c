//! Numbers of materials: of volumes, and of sheets.

use crate::model::SceneLaw;
use anyhow::{Result, ensure};
use mechanics::energy::{BodyForce, Contact, Elastic, Inertia, Owner};
use mechanics::material::{Law, Specification};

use super::{Row, Setting, Swept};

pub(super) const MATERIAL: Row = Row {
    path: "material.BODY.PARAMETER",
    meaning: "a parameter of the law of a body or volume, as `solver list` names it; of a list, \
              with its place, as in material.body.mu.1",
    list: |scene| {
        let one = |(i, law): (usize, &SceneLaw)| {
            let (name, material) = (scene.law_name(law), &law.material);
            parameters(material.law, &material.values)
                .into_iter()
                .enumerate()
                .map(move |(k, (parameter, unit))| (format!("{name}.{parameter}"), unit, [i, k]))
        };
        scene.laws.iter().enumerate().flat_map(one).collect()
    },
    value: |scene, [law, k]| scene.laws[law].material.values[k],
    set: Setting::By(|scene, _, [law, k], value| {
        scene.laws[law].material.values[k] = value;
        Ok(())
    }),
    check: |scene, [law, _]| {
        let material = &scene.laws[law].material;
        Ok(material.law.check(&material.values)?)
    },
    derivative: |swept, [law, k]| {
        // a rigid body has another law than its own
        let body = &swept.scene.parts[swept.scene.laws[law].part].config.name;
        let rigid = swept.scene.is_rigid(body);
        let own = if rigid { 0.0 } else { total(swept, Elastic::owner(law), k) };
        match swept.scene.law_of_contact() {
            Some(stiffest) if stiffest == law => {
                let by_stiffness = total(swept, Contact::OWNER, 0);
                own + by_stiffness * shear_modulus_by(&swept.scene.laws[law].material, k)
            }
            _ => own,
        }
    },
    scale: None,
};

pub(super) const DENSITY: Row = Row {
    path: "density.BODY",
    meaning: "the density of a body or volume, where it is known",
    list: |scene| {
        let known = scene.laws.iter().enumerate();
        let known = known.filter(|(_, law)| law.material.density.is_some());
        known.map(|(i, law)| (scene.law_name(law), "kg/m³", [i, 0])).collect()
    },
    value: |scene, [law, _]| scene.laws[law].material.density.unwrap_or(0.0),
    set: Setting::By(|scene, _, [law, _], value| {
        scene.laws[law].material.density = Some(value);
        Ok(())
    }),
    check: |scene, place| positive("a density", (DENSITY.value)(scene, place)),
    derivative: |swept, [law, _]| {
        let of = |owner| swept.by(owner, "density");
        of(BodyForce::weight_owner(law)) + of(Inertia::owner(law))
    },
    scale: None,
};

/// Half of the difference of parameters that gives the derivative of the shear modulus, over that modulus or in the
/// parameter's unit.
const DIFFERENCE: f64 = 1e-5;

/// The derivative of the shear modulus at rest by a parameter, by a difference: moduli are linear in stresses, and
/// smooth in what has no unit.
fn shear_modulus_by(material: &Specification, k: usize) -> f64 {
    let (_, unit) = parameters(material.law, &material.values)[k];
    let by = if unit == "Pa" { DIFFERENCE * material.moduli().shear } else { DIFFERENCE };
    let moved = |by: f64| {
        let mut values = material.values.clone();
        values[k] += by;
        (material.law.moduli)(&values).shear
    };
    (moved(by) - moved(-by)) / (2.0 * by)
}

/// Names and units of all parameters of a law, one by one.
fn parameters<M: ?Sized + 'static>(law: &Law<M>, values: &[f64]) -> Vec<(String, &'static str)> {
    let mut names = Vec::new();
    for (parameter, own) in law.named(values) {
        let name = |i: usize| match parameter.list {
            true => format!("{}.{}", parameter.name, i + 1),
            false => parameter.name.to_owned(),
        };
        names.extend((0..own.len()).map(|i| (name(i), parameter.unit)));
    }
    names
}

pub(super) fn positive(what: &str, value: f64) -> Result<()> {
    ensure!(value > 0.0 && value.is_finite(), "{what} must be positive, not {value}");
    Ok(())
}

/// The derivative by the k-th number of some terms; 0 where no term has it.
pub(super) fn total(swept: &Swept, id: Owner, k: usize) -> f64 {
    swept.by.parameters.total(id).get(k).copied().unwrap_or(0.0)
}
