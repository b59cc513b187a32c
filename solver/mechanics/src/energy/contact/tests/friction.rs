//! Friction of lagged contacts.

use super::*;
use crate::energy::Friction;

fn sliding_blocks(form: Form, scale: f64) -> (Scene, Friction) {
    let mut scene = blocks(1, form, scale, 0.0);
    let history = scene.u.clone();
    let lagged_contacts = scene.contact.lagged_contacts(&scene.here());
    let mut random = Random::new(9);
    // speeds from below to above the full one
    scene.u.iter_mut().for_each(|u| *u += 4e-3 * scale * random.uniform());
    scene.step = Some(TimeStep { h: 0.01, history, lagged_contacts, ..TimeStep::default() });
    let friction = Friction::new(Arc::clone(scene.contact.surface()), 0.7, 0.4 * scale);
    (scene, friction)
}

#[test]
fn friction_has_its_derivatives_and_no_resultant() {
    for (form, scale) in [(Form::Convergent, 1.0), (Form::Plain, 1e-3), (Form::Convergent, 1e3)] {
        let (scene, friction) = sliding_blocks(form, scale);
        scene.check(&friction, scale);
        let forces = friction.forces(&scene.here());
        let size: f64 = forces.iter().map(Vec3::norm).sum();
        assert!(size > 0.0 && forces.iter().sum::<Vec3>().norm() < 1e-13 * size);
        let mut random = Random::new(8);
        for _ in 0..20 {
            let q = random.numbers(scene.u.len());
            assert!(dot(&q, &scene.times_hessian(&friction, Hessian::Projected, &q)) >= 0.0);
        }
    }
}

/// A flat skin slides on a floor as a whole: |T| = μ N f₀′(y).
#[test]
fn sliding_as_a_whole_has_the_force_of_coulomb() {
    // the floor itself moves along y
    let mut scene = on_floor(3, Some(Box::new(|_, t| Vec3::new(0.0, 0.003, 0.0) * t)));
    let normal = scene.contact.body_forces(&scene.here())[0].force;
    let lagged_contacts = scene.contact.lagged_contacts(&scene.here());
    let counted: f64 = lagged_contacts.iter().map(|s| s.force).sum();
    assert!((counted / normal.z - 1.0).abs() < 1e-12 && normal.xy().norm() < 1e-12 * normal.z);
    let friction = Friction::new(Arc::clone(scene.contact.surface()), 0.5, 1e-3);
    let h = 0.1;
    let history = scene.u.clone();
    for (relative, share) in [(0.25e-3, 0.4375), (1e-3, 1.0), (5e-3, 1.0), (1e-9, 2e-6)] {
        let by = Vec3::new(relative, 0.003, 0.0) * h;
        scene.u = (0..scene.space.node_count()).flat_map(|_| <[f64; 3]>::from(by)).collect();
        let (history, lagged_contacts) = (history.clone(), lagged_contacts.clone());
        scene.step = Some(TimeStep { h, history, lagged_contacts, ..TimeStep::default() });
        let force = friction.body_forces(&scene.here())[0].force;
        let expected = Vec3::new(-0.5 * normal.z * share, 0.0, 0.0);
        assert!((force - expected).norm() < 1e-6 * expected.norm(), "{force} {expected}");
    }
}
