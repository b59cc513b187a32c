//! Numbers of fibres and threads.

use crate::config::{Along, FibreConfig, WindingConfig};
use mechanics::energy::{Fibres, Winding};

use super::laws::total;
use super::{Entry, Kind, Setting};

pub(super) const FIBRE: Kind = Kind {
    path: "fibre.NAME.k1, .k2, .dispersion or .angle",
    meaning: "a number of the law of a [[fibre]], or its angle to an axis; of values along an axis, with the place in \
              their list, as in fibre.weave.k1.2",
    list: |scene| {
        let one = |(i, fibre): (usize, &FibreConfig)| {
            let own = named(fibre).into_iter().enumerate();
            let name = fibre.name.clone();
            own.map(move |(k, (key, unit))| (format!("{name}.{key}"), unit, [i, k]))
        };
        scene.config.fibre.iter().enumerate().flat_map(one).collect()
    },
    value: |scene, [family, k]| {
        let FibreConfig { k1, k2, dispersion, angle, .. } = &scene.config.fibre[family];
        let angles = angle.as_ref().map_or(&[][..], Along::values);
        [k1.values(), &[*k2, *dispersion], angles].concat()[k]
    },
    set: Setting::By(|scene, _, [family, k], value| {
        let FibreConfig { k1, k2, dispersion, angle, .. } = &mut scene.config.fibre[family];
        let angles = angle.as_mut().map_or(&mut [][..], Along::values_mut);
        let law = k1.values_mut().iter_mut().chain([k2, dispersion]);
        // the places are those of the list
        law.chain(angles).skip(k).take(1).for_each(|number| *number = value);
        Ok(())
    }),
    check: |scene, _| scene.config.check(),
    derivative: |swept, [family, k]| {
        let by = total(swept, Fibres::owner(family), k);
        let law = swept.scene.config.fibre[family].k1.values().len() + 2;
        if k >= law { by.to_radians() } else { by }
    },
    scale: None,
};

/// The numbers of a family in the order of those of its energy: their keys, and units.
fn named(fibre: &FibreConfig) -> Vec<(String, &'static str)> {
    let mut all = along("k1", &fibre.k1, "Pa");
    all.extend(["k2", "dispersion"].map(|key| (key.to_owned(), "1")));
    all.extend(fibre.angle.iter().flat_map(|angle| along("angle", angle, "°")));
    all
}

/// The key of a number; or of values along an axis with their places.
fn along(key: &str, number: &Along, unit: &'static str) -> Vec<(String, &'static str)> {
    match number {
        Along::Number(_) => vec![(key.to_owned(), unit)],
        Along::Profile(profile) => {
            (1..=profile.values.len()).map(|place| (format!("{key}.{place}"), unit)).collect()
        }
    }
}

pub(super) const WINDING: Kind = Kind {
    path: "winding.NAME.stiffness or .pretension",
    meaning: "the stiffness EA or the pretension of a [[winding]]; of a table along the axis, with its place, as in winding.NAME.stiffness.2",
    list: |scene| {
        let mut entries: Vec<Entry> = Vec::new();
        for (i, winding) in scene.config.winding.iter().enumerate() {
            let name = |key: &str| format!("{}.{key}", winding.name);
            let stiffness = along("stiffness", &winding.stiffness, "N").into_iter().enumerate();
            entries.extend(stiffness.map(|(k, (key, unit))| (name(&key), unit, [i, k])));
            entries.push((name("pretension"), "N", [i, pretension(winding)]));
        }
        entries
    },
    value: |scene, [thread, k]| {
        let winding = &scene.config.winding[thread];
        winding.stiffness.values().get(k).copied().unwrap_or(winding.pretension)
    },
    set: Setting::By(|scene, _, [thread, k], value| {
        let winding = &mut scene.config.winding[thread];
        match winding.stiffness.values_mut().get_mut(k) {
            Some(stiffness) => *stiffness = value,
            None => winding.pretension = value,
        }
        Ok(())
    }),
    check: |scene, _| scene.config.check(),
    derivative: |swept, [thread, k]| total(swept, Winding::owner(thread), k),
    scale: None,
};

pub(super) const COURSE: Kind = Kind {
    path: "winding.NAME.pitch, .angle or .phase",
    meaning: "the pitch or the angle of a [[winding]] around an axis, as the scene has it, with its place in a table, and its phase",
    list: |scene| {
        let mut entries: Vec<Entry> = Vec::new();
        for (i, winding) in scene.config.winding.iter().enumerate() {
            let Some((key, number, unit)) = course(winding) else { continue };
            let name = |key: &str| format!("{}.{key}", winding.name);
            let (all, first) = (along(key, number, unit), pretension(winding) + 1);
            let all = all.into_iter().enumerate();
            entries.extend(all.map(|(k, (key, unit))| (name(&key), unit, [i, first + k])));
            entries.push((name("phase"), "°", [i, phase(winding)]));
        }
        entries
    },
    value: |scene, [thread, k]| {
        let winding = &scene.config.winding[thread];
        climb(winding, k).unwrap_or(winding.phase)
    },
    set: Setting::By(|scene, _, [thread, k], value| {
        let winding = &mut scene.config.winding[thread];
        let first = pretension(winding) + 1;
        let along = winding.pitch.as_mut().or(winding.angle.as_mut());
        match along.and_then(|along| along.values_mut().get_mut(k - first)) {
            Some(climb) => *climb = value,
            None => winding.phase = value,
        }
        Ok(())
    }),
    check: |scene, _| scene.config.check(),
    derivative: |swept, [thread, k]| {
        let by = total(swept, Winding::owner(thread), k);
        let winding = &swept.scene.config.winding[thread];
        if k == phase(winding) || winding.pitch.is_none() { by.to_radians() } else { by }
    },
    scale: Some(|scene, [thread, k]| climb(&scene.config.winding[thread], k).unwrap_or(RADIAN)),
};

/// A radian [°].
const RADIAN: f64 = 180.0 / std::f64::consts::PI;

/// The key that says how a helix climbs, with its value and unit; none of a line through points.
fn course(winding: &WindingConfig) -> Option<(&'static str, &Along, &'static str)> {
    let pitch = winding.pitch.as_ref().map(|pitch| ("pitch", pitch, "m"));
    pitch.or_else(|| winding.angle.as_ref().map(|angle| ("angle", angle, "°")))
}

/// The place of the pretension among the numbers of a winding, behind its stiffness and before its course.
fn pretension(winding: &WindingConfig) -> usize {
    winding.stiffness.values().len()
}

/// The place of the phase, the last.
fn phase(winding: &WindingConfig) -> usize {
    pretension(winding) + 1 + course(winding).map_or(0, |(_, along, _)| along.values().len())
}

/// A pitch [m] or an angle [°] of a helix by its place; none at that of the phase.
fn climb(winding: &WindingConfig, k: usize) -> Option<f64> {
    let (_, along, _) = course(winding)?;
    along.values().get(k - pretension(winding) - 1).copied()
}
