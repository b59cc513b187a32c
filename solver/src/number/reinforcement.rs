//! Numbers of fibres and threads.

use mechanics::energy::ParameterId;
use scene::config::{Along, WindingConfig};

use super::laws::total;
use super::{Entry, Kind, Setting};

/// The place of the angle among the numbers of a family.
const ANGLE: usize = 3;

pub(super) const FIBRE: Kind = Kind {
    path: "fibre.NAME.k1, .k2, .dispersion or .angle",
    meaning: "a number of the law of a [[fibre]], or its angle to an axis",
    list: |scene| {
        let mut entries: Vec<Entry> = Vec::new();
        for (i, fibre) in scene.config.fibre.iter().enumerate() {
            let name = |key: &str| format!("{}.{key}", fibre.name);
            let law = [("k1", "Pa"), ("k2", "1"), ("dispersion", "1")].into_iter().enumerate();
            entries.extend(law.map(|(k, (key, unit))| (name(key), unit, [i, k])));
            entries.extend(fibre.angle.map(|_| (name("angle"), "°", [i, ANGLE])));
        }
        entries
    },
    value: |scene, [family, k]| {
        let fibre = &scene.config.fibre[family];
        [fibre.k1, fibre.k2, fibre.dispersion, fibre.angle.unwrap_or(0.0)][k]
    },
    set: Setting::By(|scene, _, [family, k], value| {
        let fibre = &mut scene.config.fibre[family];
        match k {
            ANGLE => fibre.angle = Some(value),
            _ => *[&mut fibre.k1, &mut fibre.k2, &mut fibre.dispersion][k] = value,
        }
        Ok(())
    }),
    check: |scene, _| scene.config.check_fibres(),
    derivative: |swept, [family, k]| {
        let by = total(swept, ParameterId::Fibre(family), k);
        if k == ANGLE { by.to_radians() } else { by }
    },
    scale: None,
};

pub(super) const WINDING: Kind = Kind {
    path: "winding.NAME.stiffness or .pretension",
    meaning: "the stiffness EA or the pretension of a [[winding]]; of a table along the axis, with its place, as in winding.NAME.stiffness.2",
    list: |scene| {
        let mut entries: Vec<Entry> = Vec::new();
        for (i, winding) in scene.config.winding.iter().enumerate() {
            let name = |key: &str| format!("{}.{key}", winding.name);
            let stiffness = names(&name("stiffness"), &winding.stiffness).into_iter().enumerate();
            entries.extend(stiffness.map(|(k, name)| (name, "N", [i, k])));
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
    check: |scene, _| scene.config.check_windings(),
    derivative: |swept, [thread, k]| total(swept, ParameterId::Winding(thread), k),
    scale: None,
};

pub(super) const COURSE: Kind = Kind {
    path: "winding.NAME.pitch, .angle or .phase",
    meaning: "the pitch or the angle of a [[winding]] around an axis, as the scene has it, with its place in a table, and its phase",
    list: |scene| {
        let mut entries: Vec<Entry> = Vec::new();
        for (i, winding) in scene.config.winding.iter().enumerate() {
            let Some((key, along, unit)) = course(winding) else { continue };
            let all = names(&format!("{}.{key}", winding.name), along).into_iter().enumerate();
            let first = pretension(winding) + 1;
            entries.extend(all.map(|(k, name)| (name, unit, [i, first + k])));
            entries.push((format!("{}.phase", winding.name), "°", [i, phase(winding)]));
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
    check: |scene, _| scene.config.check_windings(),
    derivative: |swept, [thread, k]| {
        let by = total(swept, ParameterId::Winding(thread), k);
        let winding = &swept.scene.config.winding[thread];
        if k == phase(winding) || winding.pitch.is_none() { by.to_radians() } else { by }
    },
    scale: Some(|scene, [thread, k]| climb(&scene.config.winding[thread], k).unwrap_or(RADIAN)),
};

/// A radian [°].
const RADIAN: f64 = 180.0 / std::f64::consts::PI;

/// The names of a number, or of the values of a table, counted from 1.
fn names(path: &str, along: &Along) -> Vec<String> {
    match along {
        Along::Number(_) => vec![path.to_owned()],
        Along::Profile(profile) => {
            (1..=profile.values.len()).map(|i| format!("{path}.{i}")).collect()
        }
    }
}

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
