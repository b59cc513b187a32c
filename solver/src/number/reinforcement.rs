//! Numbers of fibres and threads.

use mechanics::energy::ParameterId;
use scene::config::WindingConfig;

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
    meaning: "the stiffness EA or the pretension of a [[winding]]",
    list: |scene| {
        let mut entries: Vec<Entry> = Vec::new();
        for (i, winding) in scene.config.winding.iter().enumerate() {
            let keys = ["stiffness", "pretension"].into_iter().enumerate();
            entries.extend(keys.map(|(k, key)| (format!("{}.{key}", winding.name), "N", [i, k])));
        }
        entries
    },
    value: |scene, [thread, k]| {
        let winding = &scene.config.winding[thread];
        [winding.stiffness, winding.pretension][k]
    },
    set: Setting::By(|scene, _, [thread, k], value| {
        let winding = &mut scene.config.winding[thread];
        *[&mut winding.stiffness, &mut winding.pretension][k] = value;
        Ok(())
    }),
    check: |scene, _| scene.config.check_windings(),
    derivative: |swept, [thread, k]| total(swept, ParameterId::Winding(thread), k),
    scale: None,
};

/// The places of what a helix climbs by, and of its phase, among the numbers of a winding.
const CLIMB: usize = 2;
const PHASE: usize = 3;

pub(super) const COURSE: Kind = Kind {
    path: "winding.NAME.pitch, .angle or .phase",
    meaning: "the pitch or the angle of a [[winding]] around an axis, as the scene has it, and its phase",
    list: |scene| {
        let mut entries: Vec<Entry> = Vec::new();
        for (i, winding) in scene.config.winding.iter().enumerate() {
            let name = |key: &str| format!("{}.{key}", winding.name);
            entries.extend(winding.pitch.map(|_| (name("pitch"), "m", [i, CLIMB])));
            entries.extend(winding.angle.map(|_| (name("angle"), "°", [i, CLIMB])));
            entries.extend(winding.around.as_ref().map(|_| (name("phase"), "°", [i, PHASE])));
        }
        entries
    },
    value: |scene, [thread, k]| {
        let winding = &scene.config.winding[thread];
        if k == PHASE { winding.phase } else { climb(winding) }
    },
    set: Setting::By(|scene, _, [thread, k], value| {
        let winding = &mut scene.config.winding[thread];
        match (k, winding.pitch) {
            (PHASE, _) => winding.phase = value,
            (_, Some(_)) => winding.pitch = Some(value),
            (_, None) => winding.angle = Some(value),
        }
        Ok(())
    }),
    check: |scene, _| scene.config.check_windings(),
    derivative: |swept, [thread, k]| {
        let by = total(swept, ParameterId::Winding(thread), k);
        let winding = &swept.scene.config.winding[thread];
        if k == PHASE || winding.pitch.is_none() { by.to_radians() } else { by }
    },
    scale: Some(|scene, [thread, k]| match k {
        PHASE => RADIAN,
        _ => climb(&scene.config.winding[thread]),
    }),
};

/// A radian [°].
const RADIAN: f64 = 180.0 / std::f64::consts::PI;

/// The pitch [m] or the angle [°] of a helix.
fn climb(winding: &WindingConfig) -> f64 {
    winding.pitch.or(winding.angle).unwrap_or_default()
}
