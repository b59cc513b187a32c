//! Boundary conditions: Dirichlet conditions (supports) and loads.

use anyhow::Result;

use super::document::Key;
use super::geometry::{Geometry, Solid, tag};
use super::text::{Text, list};
use super::value::{Amount, Clock, amount, amounts};

/// Where loads act and when.
pub struct Setting<'a> {
    /// The bodies.
    pub geometry: &'a Geometry,
    /// The time steps.
    pub clock: &'a Clock,
    /// Whether tags have the name of their body in front.
    pub several: bool,
}

impl Setting<'_> {
    /// Space dimensions of the values.
    pub fn dimension(&self) -> usize {
        if self.clock.planar { 2 } else { 3 }
    }

    /// A tag as our scene calls it.
    pub fn on(&self, solid: &Solid, tag: &str) -> String {
        if self.several { format!("{}.{tag}", solid.name) } else { tag.to_owned() }
    }

    /// The tags with an id that a load names; where there are none, the load is
    /// left out.
    fn tags(&self, load: &Key) -> Result<Vec<String>> {
        let key = load.need("id", "the id of a selection")?.becomes("on");
        let ids = key.ids()?;
        let mut tags = Vec::new();
        for solid in &self.geometry.solids {
            let own = ids.iter().filter(|id| solid.ids.contains_key(id));
            tags.extend(own.map(|&id| self.on(solid, &tag(id))));
        }
        Ok(tags)
    }
}

/// Acceleration by gravity: minus the right-hand side.
pub fn gravity(conditions: &Key, at: &Setting) -> Result<Option<Vec<Amount>>> {
    let Some(key) = conditions.get("rhs") else { return Ok(None) };
    let key = key.becomes("gravity, with the opposite sign");
    let mut all = amounts(&key, None, at.clock, at.dimension())?;
    if all.iter().all(Amount::is_zero) {
        return Ok(None);
    }
    all.resize(3, Amount::Number(0.0));
    Ok(Some(all.into_iter().map(Amount::negated).collect()))
}

/// Writes all supports and loads.
pub fn write(conditions: Option<&Key>, at: &Setting, text: &mut Text) -> Result<()> {
    let items = |name: &str| -> Vec<Key> {
        conditions.and_then(|c| c.get(name)).map(|key| key.items()).unwrap_or_default()
    };
    for load in items("dirichlet_boundary") {
        fixed(&load, at, text)?;
    }
    if at.clock.planar {
        for solid in &at.geometry.solids {
            text.table("[[fixed]]").name("on", &solid.name).name("components", "z");
        }
    }
    for load in items("pressure_boundary") {
        let value = value(&load, at, "pressure, with the opposite sign")?.negated();
        for on in named(&load, at)? {
            text.table("[[chamber]]").name("on", &on).key("pressure", &value.toml());
        }
    }
    for load in items("neumann_boundary") {
        let key = load.need("value", "the force per area [Pa]")?.becomes("traction");
        let times = load.get("time_reference").map(|k| k.becomes("times of the table"));
        let traction = amounts(&key, times.as_ref(), at.clock, at.dimension())?;
        for on in named(&load, at)? {
            text.table("[[traction]]").name("on", &on).key("traction", &vector(&traction));
        }
    }
    Ok(())
}

/// The tags of a load, which is left out if there are none.
fn named(load: &Key, at: &Setting) -> Result<Vec<String>> {
    let tags = at.tags(load)?;
    if tags.is_empty() {
        load.leave("no body has a facet with this id");
    }
    Ok(tags)
}

fn value(load: &Key, at: &Setting, becomes: &str) -> Result<Amount> {
    let key = load.need("value", "a number, an expression or a list over time")?.becomes(becomes);
    let times = load.get("time_reference").map(|k| k.becomes("times of the table"));
    amount(&key, times.as_ref(), at.clock)
}

/// A vector in TOML, with zeros for what is missing.
fn vector(amounts: &[Amount]) -> String {
    let mut all = amounts.to_vec();
    all.resize(3, Amount::Number(0.0));
    list(all.iter().map(Amount::toml))
}

fn fixed(load: &Key, at: &Setting, text: &mut Text) -> Result<()> {
    let key = load.need("value", "the displacement [m]")?.becomes("displacement");
    let times = load.get("time_reference").map(|k| k.becomes("times of the table"));
    let mut displacement = amounts(&key, times.as_ref(), at.clock, at.dimension())?;
    let mut components = String::from(&"xyz"[..at.dimension()]);
    if let Some(active) = load.get("dimension") {
        let flags: Vec<bool> = active.items().iter().map(Key::flag).collect::<Result<_>>()?;
        if flags.len() != at.dimension() {
            return Err(active.wrong(&format!("expected {} values", at.dimension())));
        }
        let _ = active.becomes("components");
        let named = "xyz".chars().zip(&flags);
        components = named.filter_map(|(axis, on)| on.then_some(axis)).collect();
        for (value, on) in displacement.iter_mut().zip(flags) {
            if !on {
                *value = Amount::Number(0.0);
            }
        }
    }
    for on in named(load, at)? {
        text.table("[[fixed]]").name("on", &on);
        if components != "xyz" {
            text.name("components", &components);
        }
        if !displacement.iter().all(Amount::is_zero) {
            text.key("displacement", &vector(&displacement));
        }
    }
    Ok(())
}

/// Writes the obstacles with their displacements.
pub fn write_obstacles(conditions: Option<&Key>, at: &Setting, text: &mut Text) -> Result<()> {
    let all = conditions.and_then(|c| c.get("obstacle_displacements"));
    let all = all.map(|key| key.items()).unwrap_or_default();
    for obstacle in &at.geometry.obstacles {
        text.table("[[obstacle]]").name("name", &obstacle.name);
        text.name("surface", &format!("{}.obj", obstacle.name));
        for load in &all {
            let id = load.need("id", "the id of the obstacle")?;
            if Some(id.becomes("[[obstacle]]").id()?) != obstacle.id {
                continue;
            }
            let key = load.need("value", "the displacement [m]")?.becomes("displacement");
            let times = load.get("time_reference").map(|k| k.becomes("times of the table"));
            let displacement = amounts(&key, times.as_ref(), at.clock, 3)?;
            text.key("displacement", &vector(&displacement));
        }
    }
    Ok(())
}

/// The initial velocity of a body, if it has one [m/s].
pub fn velocity(root: &Key, solid: &Solid, dimension: usize) -> Result<Option<String>> {
    let all = root.get("initial_conditions").and_then(|c| c.get("velocity"));
    for item in all.map(|key| key.items()).unwrap_or_default() {
        let id = item.need("id", "the volume_selection of a body")?.becomes("[[body]]");
        if !id.ids()?.contains(&solid.volume) {
            continue;
        }
        let value = item.need("value", "the velocity [m/s]")?.becomes("[[body]] velocity");
        let mut numbers = value.numbers(dimension)?;
        numbers.resize(3, 0.0);
        return Ok(Some(list(numbers.into_iter().map(super::text::number))));
    }
    Ok(None)
}
