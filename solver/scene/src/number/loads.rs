//! Numbers of loads and of the state at the start.

use crate::config::{ChamberConfig, SimConfig, TractionConfig};
use crate::model::{Scene, ScenePart, nodes_of};
use anyhow::ensure;
use mechanics::body::Body;
use mechanics::energy::{BodyForce, ChamberId, Friction, RigidLoad, Traction};
use mechanics::forward::Problem;
use mechanics::schedule::Written;
use mesh::Vec3;

use super::laws::total;
use super::{Indices, Row, Setting, any, nothing_added};

const AXES: [&str; 3] = mechanics::symmetry::AXES;

pub(super) const CHAMBER: Row = Row {
    path: "chamber.TAG.KEY",
    meaning: "what is added to the pressure, fill, volume_change, volume_factor or injected volume of a chamber",
    list: |scene| {
        let chambers = scene.config.chamber.iter().enumerate();
        let number = |(i, chamber): (usize, &ChamberConfig)| {
            let ChamberConfig { name, gas, .. } = chamber;
            (format!("{name}.{}", gas.key()), gas.unit(), [i, 0])
        };
        chambers.map(number).collect()
    },
    value: nothing_added,
    set: Setting::AddedTo(chamber),
    check: any,
    derivative: |swept, [chamber, _]| {
        let name = &swept.scene.config.chamber[chamber].name;
        let own = swept.problem.energies.chambers().filter(|(_, named)| named.name == *name);
        let steps = 0..swept.by.parameters.steps();
        let by = |id: ChamberId| steps.clone().map(move |n| swept.by.parameters.sum(n, id.owner()));
        own.map(|(id, _)| by(id).sum::<f64>()).sum()
    },
    scale: Some(|scene, [chamber, _]| largest(scene, &scene.config.chamber[chamber].gas.value)),
};

pub(super) const FRICTION: Row = Row {
    path: "contact.friction",
    meaning: "the coefficient of friction, where there is some",
    list: |scene| {
        let has_some = scene.config.contact().is_some_and(|contact| contact.friction > 0.0);
        has_some.then(|| ("friction".to_owned(), "1", [0, 0])).into_iter().collect()
    },
    value: |scene, _| scene.config.contact().map_or(0.0, |contact| contact.friction),
    set: Setting::By(|scene, _, _, value| {
        scene.config.contact_mut().into_iter().for_each(|contact| contact.friction = value);
        Ok(())
    }),
    check: |scene, place| {
        let value = (FRICTION.value)(scene, place);
        ensure!(value > 0.0 && value.is_finite(), "friction = {value}: must be positive");
        Ok(())
    },
    derivative: |swept, _| total(swept, Friction::OWNER, 0),
    scale: None,
};

pub(super) const GRAVITY: Row = Row {
    path: "gravity.x, .y or .z",
    meaning: "what is added to a component of gravity",
    list: |scene| {
        let heavy = scene.config.rigid.iter().any(|part| part.mass > 0.0);
        let falls = (heavy || (0..scene.laws.len()).any(|law| scene.weighs(law)))
            && !scene.config.gravity.is_zero();
        let axes = AXES.iter().enumerate().filter(|_| falls);
        axes.map(|(k, axis)| ((*axis).to_owned(), "m/s²", [0, k])).collect()
    },
    value: nothing_added,
    set: Setting::AddedTo(gravity),
    check: any,
    derivative: |swept, [_, axis]| {
        let laws = 0..swept.scene.laws.len();
        let parts = 0..swept.scene.config.rigid.len();
        let of_laws =
            laws.map(|law| swept.by(BodyForce::weight_owner(law), &component("gravity", axis)));
        let of_parts =
            parts.map(|part| swept.by(RigidLoad::owner(part), &component("gravity", axis)));
        of_laws.chain(of_parts).sum()
    },
    scale: Some(|scene, _| {
        scene.config.gravity.0.iter().map(|g| largest(scene, g)).fold(0.0, f64::max)
    }),
};

pub(super) const TRACTION: Row = Row {
    path: "traction.TAG.x, .y or .z",
    meaning: "what is added to a component of the traction on a tag that has one",
    list: |scene| {
        let all = &scene.config.traction;
        let alone =
            |load: &TractionConfig| all.iter().filter(|other| other.on == load.on).count() == 1;
        let loads = all.iter().enumerate().filter(|(_, load)| alone(load));
        let one = |(i, load): (usize, &TractionConfig)| {
            let on = load.on.clone();
            AXES.iter().enumerate().map(move |(k, axis)| (format!("{on}.{axis}"), "Pa", [i, k]))
        };
        loads.flat_map(one).collect()
    },
    value: nothing_added,
    set: Setting::AddedTo(traction),
    check: any,
    derivative: |swept, [load, axis]| swept.by(Traction::owner(load), &component("traction", axis)),
    scale: Some(|scene, [load, _]| {
        let components = &scene.config.traction[load].traction.0;
        components.iter().map(|t| largest(scene, t)).fold(0.0, f64::max)
    }),
};

pub(super) const VELOCITY: Row = Row {
    path: "velocity.BODY.x, .y or .z",
    meaning: "a component of the velocity of a body at t = 0, where there is inertia",
    list: |scene| {
        let moves = scene.config.method().has_inertia();
        let parts = scene.parts.iter().enumerate().filter(|_| moves);
        let one = |(i, part): (usize, &ScenePart)| {
            let name = part.config.name.clone();
            AXES.map(|axis| format!("{name}.{axis}"))
                .into_iter()
                .enumerate()
                .map(move |(k, path)| (path, "m/s", [i, k]))
        };
        parts.flat_map(one).collect()
    },
    value: |scene, [part, axis]| scene.parts[part].config.velocity[axis],
    set: Setting::By(|scene, _, [part, axis], value| {
        scene.parts[part].config.velocity[axis] = value;
        Ok(())
    }),
    check: any,
    derivative: |swept, [part, axis]| {
        velocity_vjp(swept.problem, &swept.scene.body, part, &swept.by.start.v)[axis]
    },
    scale: Some(|_, _| 1.0),
};

/// What a component of a vector is called among the numbers of a term.
fn component(key: &str, axis: usize) -> String {
    format!("{key}.{}", AXES[axis])
}

fn chamber(config: &mut SimConfig, [chamber, _]: Indices) -> &mut Written {
    &mut config.chamber[chamber].gas.value
}

fn gravity(config: &mut SimConfig, [_, axis]: Indices) -> &mut Written {
    &mut config.gravity.0[axis]
}

fn traction(config: &mut SimConfig, [load, axis]: Indices) -> &mut Written {
    &mut config.traction[load].traction.0[axis]
}

/// The largest of a number over time, without sign, at the ends of time steps.
pub(super) fn largest(scene: &Scene, written: &Written) -> f64 {
    let schedule = scene.config.schedule(written);
    scene.times().iter().map(|&t| schedule.at(t).abs()).fold(0.0, f64::max)
}

/// The derivative by the velocity of a body at t = 0, from that by the velocities of all nodes:
/// the sum over its nodes, without what supports hold.
pub fn velocity_vjp(problem: &Problem, body: &Body, part: usize, by_nodes: &[f64]) -> [f64; 3] {
    let mut sum = Vec3::zeros();
    for node in nodes_of(body, part, &problem.space) {
        for k in (0..3).filter(|k| !problem.dirichlet.fixed()[3 * node + k]) {
            sum[k] += by_nodes[3 * node + k];
        }
    }
    sum.into()
}
