//! Numbers of fibres and threads.

use mechanics::energy::ParameterId;

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
