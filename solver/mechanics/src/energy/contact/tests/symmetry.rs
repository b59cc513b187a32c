//! Contact of a part with its mirror image.

use super::*;
use crate::testing::{half, whole};

fn scene(degree: usize, form: Form) -> Scene {
    let (part, plane) = half();
    let in_plane = |x: &[Vec3; 3]| x.iter().all(|v| v.x == 0.0);
    let barrier = barrier(form, 0.15);
    let mut scene =
        Scene::cut_by(&[plane], degree, &[part], Vec::new(), barrier, |x| !in_plane(&x));
    scene.u = Random::new(3).numbers(scene.u.len()).iter().map(|v| 0.004 * v).collect();
    for (n, x) in scene.space.node_positions(&scene.rest).iter().enumerate() {
        if x.x == 0.0 {
            scene.u[3 * n] = 0.0;
        }
    }
    scene
}

#[test]
fn a_part_has_its_share_of_the_energy_and_the_forces() {
    for form in [Form::Convergent, Form::Even, Form::Plain] {
        let part = scene(1, form);
        let mesh = whole(&half().0);
        let own = part.rest.len();
        let mut all = Scene::new(1, &[mesh], Vec::new(), barrier(form, 0.15), |_| true);
        all.u[..3 * own].copy_from_slice(&part.u);
        let with_image = (0..own).filter(|&v| part.rest[v].x != 0.0);
        for (image, v) in (own..).zip(with_image) {
            let u = at(&part.u, v);
            all.u[3 * image..3 * image + 3].copy_from_slice(&[-u.x, u.y, u.z]);
        }
        let (energy, expected) = (part.contact.value(&part.here()), all.contact.value(&all.here()));
        assert!((2.0 * energy / expected - 1.0).abs() < 1e-12, "{form:?} {energy} {expected}");
        let gradient = part.gradient(&part.contact, &part.u, &part.rest);
        let expected = all.gradient(&all.contact, &all.u, &all.rest);
        let largest = expected.iter().fold(0.0_f64, |m, g| m.max(g.abs()));
        let mut across = 0.0_f64;
        for v in 0..own {
            let (own, mut whole) = (at(&gradient, v), at(&expected, v));
            if part.rest[v].x == 0.0 {
                // the image has the other half
                whole *= 0.5;
            } else {
                across = across.max(own.x.abs());
            }
            assert!((own - whole).yz().norm() < 1e-11 * largest, "{form:?} {v} {own} {whole}");
            let free = part.rest[v].x != 0.0;
            assert!(!free || (own.x - whole.x).abs() < 1e-11 * largest, "{form:?} {v}");
        }
        assert!(across > 1e-3 * largest, "nothing touches its image");
    }
}

#[test]
fn derivatives_belong_to_the_energy_of_a_part() {
    for (degree, form) in [(1, Form::Convergent), (2, Form::Convergent), (1, Form::Plain)] {
        let scene = scene(degree, form);
        scene.check(&scene.contact, 0.1);
    }
}
