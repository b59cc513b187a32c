//! Boundary conditions: Dirichlet conditions (supports) and loads.

use anyhow::Result;
use toml::{Table, Value};

use super::document::Key;
use super::geometry::{Geometry, Solid, tag};
use super::tables::{push, table};
use super::value::{Clock, amount, amounts, is_zero, negated};

/// Where loads act and when.
pub struct Setting<'a> {
    /// The bodies.
    pub geometry: &'a Geometry,
    /// The time steps.
    pub clock: &'a Clock,
}

impl Setting<'_> {
    /// Space dimensions of the values.
    pub fn dimension(&self) -> usize {
        if self.clock.planar { 2 } else { 3 }
    }
}

/// Acceleration by gravity: minus the right-hand side.
pub fn gravity(conditions: Option<&Key>, at: &Setting) -> Result<Option<Value>> {
    let Some(key) = conditions.and_then(|c| c.get("rhs")) else { return Ok(None) };
    let all = amounts(&key, None, at.clock, at.dimension())?;
    let none = all.iter().all(is_zero);
    Ok((!none).then(|| vector(all.into_iter().map(negated))))
}

/// Adds all supports and loads.
pub fn add(conditions: Option<&Key>, at: &Setting, scene: &mut Table) -> Result<()> {
    let items = |name: &str| conditions.map(|c| c.items_of(name)).unwrap_or_default();
    for load in items("dirichlet_boundary") {
        fixed(&load, at, scene)?;
    }
    if at.clock.planar {
        for solid in &at.geometry.solids {
            let of_plane = [("on", solid.name.clone().into()), ("components", "z".into())];
            push(scene, "fixed", table(of_plane));
        }
    }
    for load in items("pressure_boundary") {
        let key = load.need("value", "a number, an expression or a list over time")?;
        let value = amount(&key, load.get("time_reference").as_ref(), at.clock)?;
        let pressure = negated(value);
        for on in named(&load, at)? {
            let chamber = [("on", on.into()), ("pressure", pressure.clone())];
            push(scene, "chamber", table(chamber));
        }
    }
    for load in items("neumann_boundary") {
        let traction = values(&load, "the force per area [Pa]", at, at.dimension())?;
        for on in named(&load, at)? {
            let load = [("on", on.into()), ("traction", vector(traction.clone()))];
            push(scene, "traction", table(load));
        }
    }
    Ok(())
}

/// The tags with an id that a load names; it is left out if there are none.
fn named(load: &Key, at: &Setting) -> Result<Vec<String>> {
    let ids = load.need("id", "the id of a selection")?.ids()?;
    let mut tags = Vec::new();
    for solid in &at.geometry.solids {
        let own = ids.iter().filter(|id| solid.ids.contains_key(id));
        tags.extend(own.map(|&id| at.geometry.on(solid, &tag(id))));
    }
    if tags.is_empty() {
        load.leave("no body has a facet with this id");
    }
    Ok(tags)
}

/// The components of a load.
fn values(load: &Key, what: &str, at: &Setting, dimension: usize) -> Result<Vec<Value>> {
    let key = load.need("value", what)?;
    amounts(&key, load.get("time_reference").as_ref(), at.clock, dimension)
}

/// A vector, with zeros for what is missing.
fn vector(amounts: impl IntoIterator<Item = Value>) -> Value {
    let zeros = std::iter::repeat(Value::Float(0.0));
    Value::Array(amounts.into_iter().chain(zeros).take(3).collect())
}

fn fixed(load: &Key, at: &Setting, scene: &mut Table) -> Result<()> {
    let mut displacement = values(load, "the displacement [m]", at, at.dimension())?;
    let mut components = String::from(&"xyz"[..at.dimension()]);
    if let Some(active) = load.get("dimension") {
        let flags: Vec<bool> = active.items().iter().map(Key::flag).collect::<Result<_>>()?;
        if flags.len() != at.dimension() {
            return Err(active.wrong(&format!("expected {} values", at.dimension())));
        }
        let named = "xyz".chars().zip(&flags);
        components = named.filter_map(|(axis, on)| on.then_some(axis)).collect();
        let free = displacement.iter_mut().zip(flags).filter(|(_, on)| !on);
        free.for_each(|(value, _)| *value = 0.0.into());
    }
    for on in named(load, at)? {
        let mut support = table([("on", on.into())]);
        if components != "xyz" {
            support.insert("components".to_owned(), components.clone().into());
        }
        if !displacement.iter().all(is_zero) {
            support.insert("displacement".to_owned(), vector(displacement.clone()));
        }
        push(scene, "fixed", support);
    }
    Ok(())
}

/// Adds the obstacles with their displacements.
pub fn add_obstacles(conditions: Option<&Key>, at: &Setting, scene: &mut Table) -> Result<()> {
    let all = conditions.map(|c| c.items_of("obstacle_displacements")).unwrap_or_default();
    for obstacle in &at.geometry.obstacles {
        let surface = format!("{}.obj", obstacle.name);
        let mut moved =
            table([("name", obstacle.name.clone().into()), ("surface", surface.into())]);
        for load in &all {
            if Some(load.need("id", "the id of the obstacle")?.id()?) == obstacle.id {
                let displacement = values(load, "the displacement [m]", at, 3)?;
                moved.insert("displacement".to_owned(), vector(displacement));
            }
        }
        push(scene, "obstacle", moved);
    }
    Ok(())
}

/// The initial velocity of a body, if it has one [m/s].
pub fn velocity(root: &Key, solid: &Solid, dimension: usize) -> Result<Option<Vec<f64>>> {
    let all = root.get("initial_conditions").map(|c| c.items_of("velocity"));
    for item in all.unwrap_or_default() {
        let ids = item.need("id", "the volume_selection of a body")?.ids()?;
        if !ids.contains(&solid.volume) {
            continue;
        }
        let mut numbers = item.need("value", "the velocity [m/s]")?.numbers(dimension)?;
        numbers.resize(3, 0.0);
        return Ok(Some(numbers));
    }
    Ok(None)
}
