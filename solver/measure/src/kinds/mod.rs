//! All quantities: one a file, with its keys and its row; one line per row in [`KINDS`].

mod angle;
mod bending;
mod clearance;
mod contact_force;
mod contact_proxy;
mod curvature;
mod displacement;
mod distance;
mod gap;
mod motion;
mod point;
mod reaction;
mod smoothness;
mod strain_limit;
mod stress;
mod stretch;
mod target;
#[cfg(test)]
mod tests;
mod twist;
mod volume;
mod wall_thickness;
mod wanted;
mod winding_force;

use std::sync::Arc;

use anyhow::{Result, ensure};
use mesh::Vec3;
use program::table::Range;
use program::{KeyPath, Misfit, misfit, unknown};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

// what nearly every kind is made with, which has it by `super::*`
use crate::quantity::{
    Axis, Equilibrium, Kind, List, Means, Measure, Partials, Patch, Quantity, Site, Specification,
    of_means, solid_integral,
};

/// All kinds, in the order in which they are listed.
pub const KINDS: &[Kind] = &[
    displacement::ALONG,
    displacement::MAGNITUDE,
    point::KIND,
    bending::KIND,
    twist::KIND,
    angle::KIND,
    distance::KIND,
    gap::KIND,
    curvature::KIND,
    volume::CHAMBER,
    stretch::KIND,
    contact_force::ALONG,
    reaction::KIND,
    winding_force::KIND,
    target::KIND,
    motion::DISPLACEMENT,
    motion::POSITION,
    contact_force::KIND,
    contact_proxy::KIND,
    wall_thickness::KIND,
    smoothness::KIND,
    clearance::KIND,
    volume::KIND,
    stress::KIND,
    strain_limit::KIND,
    wanted::KIND,
];

/// The kinds that a list may have.
pub fn of(list: List) -> impl Iterator<Item = &'static Kind> + Clone {
    KINDS.iter().filter(move |kind| kind.lists.contains(&list))
}

/// The kind of a list that is called so.
pub fn find(list: List, key: &str) -> Result<&'static Kind, Misfit> {
    of(list).find(|kind| kind.key == key).ok_or_else(|| {
        let names: Vec<String> = of(list).map(|kind| format!("`{}`", kind.key)).collect();
        let (names, option) = (names.join(", "), list.option());
        let listed = format!("expected one of {names}\n  `solver list {option}` explains them");
        let (before, known) = (format!("unknown kind `{key}`"), of(list).map(|kind| kind.key));
        KeyPath::of("kind").told(unknown(&before, key, known, ',', &listed))
    })
}
