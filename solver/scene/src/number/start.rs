//! Numbers of the state at the start.

use mechanics::symmetry::AXES;

use super::{Kind, Number, Owners, Swept};
use crate::term::{RoomNumber, each, nodes_of, value};

pub(super) const VELOCITY: Kind = Kind {
    word: "velocity",
    paths: "velocity.BODY.x, .y or .z",
    meaning: "a component of the velocity of a body at t = 0, where there is inertia",
    numbers: velocities,
    derivative: by_velocity,
};

fn velocities<'a>(_: &str, Owners { config, parts, .. }: Owners<'a>) -> Vec<RoomNumber<'a>> {
    let moving = if config.method().has_inertia() { parts } else { &mut [] };
    each(moving, |_, part| {
        let components = AXES.into_iter().zip(&mut part.config.velocity);
        let components = components.map(|(axis, v)| value(axis, "m/s", v)).collect();
        (part.config.name.clone(), components)
    })
}

/// The derivative by a component of the velocity of a body, from that by the velocities of all nodes: the sum over its
/// nodes, without what supports hold.
fn by_velocity(swept: &Swept, number: &Number) -> f64 {
    let Swept { scene, problem, by, .. } = swept;
    let Some(axis) = AXES.iter().position(|axis| *axis == number.key) else { return 0.0 };
    let nodes = nodes_of(&scene.body, number.owner(), &problem.space).into_iter();
    let dofs = nodes.map(|node| 3 * node + axis);
    dofs.filter(|&dof| !problem.dirichlet.fixed()[dof]).map(|dof| by.start.v[dof]).sum()
}
