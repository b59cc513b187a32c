//! What is apart at rest, and what is not: walls, slots, folds.

use super::*;
use crate::contact::candidates::close_within;
use crate::contact::friction::LaggedContactCotangent;
use crate::contact::solid::Solid;
use crate::testing::{block, prisms, sphere};

/// Cells between grid lines, six tetrahedra each, where `solid` holds.
fn grid(lines: [&[f64]; 3], solid: impl Fn([usize; 3]) -> bool) -> TetMesh {
    let cells @ [nx, ny, _] = lines.map(|line| line.len() - 1);
    let mut mesh = block(cells);
    for x in &mut mesh.vertices {
        *x = Vec3::from_fn(|k, _| lines[k][(x[k] * cells[k] as f64).round() as usize]);
    }
    let of_cells = mesh.tets.chunks_exact(6).enumerate();
    let kept = of_cells.filter(|(cell, _)| solid([cell % nx, cell / nx % ny, cell / (nx * ny)]));
    let tets: Vec<[usize; 4]> = kept.flat_map(|(_, tets)| tets).copied().collect();
    mesh.with_tets(&tets)
}

fn even(cells: usize, edge: f64) -> Vec<f64> {
    (0..=cells).map(|i| i as f64 * edge).collect()
}

/// Moves what is inside of the box around a mesh, and leaves its outside.
fn move_inside(mut mesh: TetMesh, to: impl Fn(Vec3) -> Vec3) -> TetMesh {
    let (low, high) = mesh
        .vertices
        .iter()
        .fold((mesh.vertices[0], mesh.vertices[0]), |(low, high): (Vec3, Vec3), v| {
            (low.inf(v), high.sup(v))
        });
    let inside = |v: &Vec3| (0..3).all(|k| v[k] > low[k] && v[k] < high[k]);
    mesh.vertices.iter_mut().filter(|v| inside(v)).for_each(|v| *v = to(*v));
    mesh
}

/// Lines at both ends of walls, and between them such that all together are so long.
fn behind_walls(cells: usize, wall: f64, length: f64) -> Vec<f64> {
    let step = (length - 2.0 * wall) / cells as f64;
    let inner = (0..=cells).map(|i| wall + i as f64 * step);
    [0.0].into_iter().chain(inner).chain([length]).collect()
}

/// A closed box around a chamber of `cells`³ cells, whose wall is this thick.
fn hollow_box(cells: usize, wall: f64) -> TetMesh {
    let n = cells + 2;
    let lines = behind_walls(cells, wall, 1.8 * cells as f64 + 2.0 * wall.max(1.8));
    grid([&lines; 3], |c| !c.iter().all(|&i| i > 0 && i + 1 < n))
}

/// A box with two chambers, between which there is a thin wall.
fn two_chambers(wall: f64) -> TetMesh {
    let (side, short) = (even(3, 1.3), even(4, 1.3));
    let other = side.iter().map(|x| 3.9 + wall + x);
    let long: Vec<f64> = side.iter().copied().chain(other).collect();
    let in_chamber = |c: [usize; 3]| {
        [1, 2, 4, 5].contains(&c[0]) && (1..3).contains(&c[1]) && (1..3).contains(&c[2])
    };
    grid([&long, &short, &short], |c| !in_chamber(c))
}

/// A box with a chamber whose ceiling comes close to the skin in its middle.
fn near_the_skin(wall: f64) -> TetMesh {
    let lines = even(6, 1.3);
    let mesh = grid([&lines; 3], |c| !c.iter().all(|&i| i > 0 && i < 5));
    let top = 5.0 * 1.3;
    move_inside(mesh, |v| {
        let bump = [v.x, v.y].map(|c| (std::f64::consts::PI * (c / 1.3 - 1.0) / 4.0).sin());
        let lift = if v.z > top - 0.1 { (1.3 - wall.min(2.0)) * bump[0] * bump[1] } else { 0.0 };
        v + Vec3::z() * lift
    })
}

/// A block with a slot from above, that is so wide at its floor and its mouth.
fn slotted(cells: usize, [floor, mouth]: [f64; 2]) -> TetMesh {
    let (lines, high) = (even(3, 2.0), even(cells + 1, 6.0 / cells as f64));
    let mut mesh =
        grid([&lines, &even(cells, 6.0 / cells as f64), &high], |c| c[0] != 1 || c[2] == 0);
    let (bottom, top) = (high[1], high[cells + 1]);
    for v in &mut mesh.vertices {
        let share = ((v.z - bottom) / (top - bottom)).max(0.0);
        if (v.x - 3.0).abs() < 1.5 {
            v.x = 3.0 + 0.5 * (floor + share * (mouth - floor)) * (v.x - 3.0).signum();
        }
    }
    mesh
}

/// A wall that is folded to zigzags of this pitch.
fn folded(wall: f64, pitch: f64) -> TetMesh {
    let mut mesh = grid([&even(6, 1.0), &even(2, 3.0), &even(1, wall)], |_| true);
    for v in &mut mesh.vertices {
        let fold = if (v.x.round() as usize).is_multiple_of(2) { 0.0 } else { 3.0 };
        *v = Vec3::new(0.5 * pitch * v.x, v.y, v.z + fold);
    }
    mesh
}

/// A spherical shell of prisms.
fn shell(levels: usize, inner: f64, outer: f64) -> TetMesh {
    prisms(&sphere(levels), [inner, outer])
}

impl Scene {
    /// This scene with contact between all pairs.
    fn with_all_pairs(mut self, barrier: Barrier) -> Self {
        self.contact = Contact::new(Arc::clone(self.contact.surface()), Partners::All, barrier);
        self
    }

    /// Displacements that take nodes from their rest places to others.
    fn moved(mut self, to: impl Fn(Vec3) -> Vec3) -> Self {
        let nodes = self.space.node_positions(&self.rest);
        self.u = flat(&nodes.iter().map(|x| to(*x) - x).collect::<Vec<_>>());
        self
    }

    /// Terms of pairs that are close at rest and repel each other.
    fn offset_terms(&self) -> usize {
        let contacts = self.contact.contacts(&self.here());
        let acts = |t: &&Term| t.stencil.offset.is_some() && contacts.local(t).value() > 0.0;
        contacts.terms().iter().filter(acts).count()
    }
}

fn alone(degree: usize, mesh: TetMesh, barrier: Barrier) -> Scene {
    let volume = |t: &[usize; 4]| {
        let [a, b, c, d] = t.map(|v| mesh.vertices[v]);
        mesh::measure::tet_volume(a, b, c, d)
    };
    assert!(mesh.tets.iter().all(|t| volume(t) > 0.0));
    Scene::new(degree, &[mesh], Vec::new(), barrier, |_| true)
}

/// All bodies of the campaign for walls that are so thick, in activations.
fn campaign(wall: f64) -> Vec<(&'static str, usize, TetMesh)> {
    let turn = nalgebra::Rotation3::from_euler_angles(0.3, -0.5, 0.7);
    let mut oblique = hollow_box(2, wall);
    oblique.vertices.iter_mut().for_each(|v| *v = turn * *v);
    let mut bodies = vec![
        ("box", 1, hollow_box(1, wall)),
        ("box", 2, hollow_box(3, wall)),
        ("oblique box", 1, oblique),
        ("two chambers", 1, two_chambers(wall)),
        ("two chambers", 2, two_chambers(wall)),
        ("near the skin", 1, near_the_skin(wall)),
        ("near the skin", 2, near_the_skin(wall)),
        ("slot", 1, slotted(2, [wall, wall])),
        ("slot", 2, slotted(3, [wall, wall])),
        ("groove", 1, slotted(3, [0.2, wall])),
        ("fold", 1, folded(1.5, 2.0 * wall)),
        ("folded wall", 1, folded(wall, 4.0)),
    ];
    for levels in [1, 2] {
        bodies.push(("shell", 1, shell(levels, 10.0, 10.0 + wall)));
    }
    bodies.push(("shell", 3, shell(1, 10.0, 10.0 + wall)));
    bodies
}

/// Bodies without load: neither energy nor force, whatever the wall. All pairs push.
#[test]
fn nothing_acts_at_rest_through_walls_and_across_slots() {
    let mut pushed = 0;
    let forms = [Form::Convergent, Form::Even, Form::Plain];
    for (k, wall) in [0.2, 0.999, 1.1].into_iter().enumerate() {
        for (name, degree, mesh) in campaign(wall) {
            let barrier = barrier(forms[(k + degree) % 3], 1.0);
            let scene = alone(degree, mesh, barrier);
            let what = format!("{name}, degree {degree}, wall {wall}, {:?}", barrier.form);
            assert_eq!(scene.contact.value(&scene.here()), 0.0, "{what}");
            let forces = scene.contact.forces(&scene.here());
            assert!(forces.iter().all(|f| *f == Vec3::zeros()), "{what}");
            assert_eq!(scene.contact.gaps(&scene.here()).pairs, 0, "{what}");
            if degree == 1 {
                let all = scene.with_all_pairs(barrier);
                pushed += usize::from(all.contact.value(&all.here()) > 0.0);
            }
        }
    }
    assert!(pushed > 20, "{pushed} bodies pushed with all pairs");
}

/// Both skins of a thin wall are no contact; that of the chamber is with itself.
#[test]
fn pairs_of_both_skins_are_through_the_solid_and_pairs_of_a_chamber_are_not() {
    for wall in [0.2, 0.6, 0.9] {
        let scene = alone(1, hollow_box(3, wall), barrier(Form::Convergent, 1.0));
        let surface = scene.contact.surface();
        let rest = surface.rest(&scene.space, &scene.rest);
        let solid = Solid::new(surface, &rest, 1.0);
        let outside = |v: usize| rest[v].iter().any(|c| !(1e-9..9.0 - 1e-9).contains(c));
        let mut seen = [0; 2];
        for pair in close_within(surface.features(), &rest, 2.0) {
            let distance = pair.closest(&pair.gather(&rest)).d2.sqrt();
            let [first, .., second] = pair.corners().map(outside);
            let apart = distance < 1.0 && first != second;
            if apart || (!first && !second && distance >= 1.0) {
                assert_eq!(solid.is_between(&pair), apart, "wall {wall}: {pair:?}");
                seen[usize::from(apart)] += 1;
            }
        }
        assert!(seen.iter().all(|&n| n > 10), "{seen:?}");
    }
}

#[test]
fn half_of_a_body_is_as_free_at_rest_as_the_whole() {
    for wall in [0.2, 0.7, 1.5] {
        let whole = hollow_box(4, wall);
        let middle = 3.0 * 1.8;
        let tets =
            whole.tets.iter().filter(|t| t.iter().all(|&v| whole.vertices[v].x < middle + 1e-9));
        let part = whole.with_tets(&tets.copied().collect::<Vec<_>>());
        let in_plane = |x: &[Vec3; 3]| x.iter().all(|v| (v.x - middle).abs() < 1e-9);
        let facets = mesh::topology::boundary(&part).facets;
        let cut: Vec<_> =
            facets.iter().filter(|f| in_plane(&f.map(|v| part.vertices[v]))).copied().collect();
        let plane = Plane::find(&part, &facets, &["cut".to_owned()], &cut).expect("a plane");
        let barrier = barrier(Form::Even, 1.0);
        let scene = Scene::cut_by(&[plane], 1, &[part], Vec::new(), barrier, |x| !in_plane(&x));
        assert_eq!(scene.contact.value(&scene.here()), 0.0, "{wall}");
        let all = scene.with_all_pairs(barrier);
        assert!(wall > 1.0 || all.contact.value(&all.here()) > 0.0, "{wall}");
    }
}

/// A shell of thickness 2.5 that is blown up to three times its radius is 0.3 thick.
#[test]
fn a_wall_that_is_stretched_to_less_than_the_activation_feels_nothing() {
    let (inner, outer) = (10.0_f64, 12.5);
    let blown_up = |x: Vec3| {
        let r = x.norm();
        x * ((r.powi(3) - inner.powi(3) + (3.0 * inner).powi(3)).cbrt() / r)
    };
    let barrier = barrier(Form::Convergent, 1.0);
    let scene = alone(1, shell(2, inner, outer), barrier).moved(blown_up);
    assert_eq!(scene.contact.value(&scene.here()), 0.0);
    let all = scene.with_all_pairs(barrier);
    assert!(all.contact.value(&all.here()) > 0.0);
    assert!(all.contact.gaps(&all.here()).smallest < 0.4);
}

#[test]
fn the_ends_of_a_bar_that_is_bent_to_a_ring_meet() {
    let length = 40.0;
    let mesh = grid([&even(20, length / 20.0), &even(1, 2.0), &even(1, 2.0)], |_| true);
    let ring = |gap: f64| {
        let radius = (length + gap) / std::f64::consts::TAU;
        let bent = move |x: Vec3| {
            let (angle, r) = (x.x / radius, radius + x.z - 1.0);
            Vec3::new(r * angle.sin(), x.y, -r * angle.cos())
        };
        let scene = alone(1, mesh.clone(), barrier(Form::Convergent, 0.5)).moved(bent);
        scene.contact.value(&scene.here())
    };
    // wider at the outer side
    assert_eq!(ring(0.7), 0.0);
    assert!(ring(0.3) > ring(0.4) && ring(0.4) > 0.0);
}

/// The far sides of two plates that are one body meet when the plates change places.
#[test]
fn only_what_has_solid_all_the_way_between_is_left_out() {
    let high = [0.0, 0.5, 1.0, 1.5];
    let plates = grid([&even(3, 1.5), &even(3, 1.5), &high], |c| c[2] != 1);
    let scene = |lift: f64| {
        let lifted = move |x: Vec3| if x.z < 0.75 { x + Vec3::z() * lift } else { x };
        let scene = alone(1, plates.clone(), barrier(Form::Convergent, 0.6)).moved(lifted);
        (scene.contact.value(&scene.here()), scene.contact.gaps(&scene.here()).smallest)
    };
    assert_eq!(scene(0.0).0, 0.0);
    // the lower one is above the upper one
    let (energy, gap) = scene(1.8);
    assert!(energy > 0.0 && (gap - 0.5).abs() < 1e-9, "{energy} {gap}");
    assert_eq!(scene(2.2).0, 0.0);
}

#[test]
fn sides_of_a_narrow_slot_repel_each_other_below_their_distance_at_rest() {
    for form in [Form::Convergent, Form::Even, Form::Plain] {
        let energy = |share: f64| {
            let narrower = move |x: Vec3| Vec3::new(3.0 + share * (x.x - 3.0), x.y, x.z);
            let mesh = slotted(3, [0.6, 0.6]);
            let scene = alone(1, mesh, barrier(form, 1.0)).moved(narrower);
            scene.contact.value(&scene.here())
        };
        assert_eq!([1.0, 1.1, 1.5].map(energy), [0.0; 3]);
        assert!(energy(0.5) > energy(0.8) && energy(0.8) > energy(0.9) && energy(0.9) > 0.0);
    }
}

/// A wall that is thinner than the minimum distance neither forbids a state nor ends a step.
#[test]
fn thin_walls_need_no_thickness_of_contact() {
    let barrier = Barrier { thickness: 0.5, ..barrier(Form::Convergent, 0.5) };
    let scene = alone(1, hollow_box(3, 0.3), barrier);
    let rest = scene.contact.surface().rest(&scene.space, &scene.rest);
    let close = scene.contact.close_at_rest(&rest).expect("few pairs");
    let violated = close.iter().find(|pair| pair.is_violated(&barrier.repulsion()));
    assert!(violated.is_none(), "{:?}", violated.map(|v| (v, v.pair.gather(&rest))));
    assert_eq!(scene.contact.value(&scene.here()), 0.0);
    for share in [1e-3, 0.5] {
        let to = flat(&scene.rest.iter().map(|x| x * share).collect::<Vec<_>>());
        assert_eq!(scene.contact.max_step(&scene.here(), &scene.at(&to, &scene.rest)), 1.0);
    }
    let all = scene.with_all_pairs(barrier);
    assert!(all.contact.value(&all.here()).is_infinite());
}

/// A slot that is narrower than the activation at its floor and wider at its mouth, and is
/// bent until its sides repel each other; by a body beside it, too.
fn closing(degree: usize, form: Form, scale: f64, thickness: f64) -> Scene {
    let mut mesh = slotted(if degree < 3 { 2 } else { 1 }, [0.8, 1.6]);
    let mut other = grid([&[6.4, 9.0], &even(1, 5.0), &even(1, 5.0)], |_| true);
    let mut random = Random::new(7);
    for v in mesh.vertices.iter_mut().chain(&mut other.vertices) {
        *v = (*v + 0.05 * random.vector()) * scale;
    }
    let barrier = Barrier { thickness: thickness * scale, ..barrier(form, scale) };
    let mut scene = Scene::new(degree, &[mesh, other], Vec::new(), barrier, |_| true).moved(|x| {
        let off = x.x - 3.0 * scale;
        let towards = if off.abs() < scale { 0.35 * off } else { 0.0 };
        Vec3::new(x.x - towards, x.y, x.z)
    });
    let noise = random.numbers(scene.u.len());
    scene.u.iter_mut().zip(noise).for_each(|(u, n)| *u += 0.02 * scale * n);
    scene
}

#[test]
fn derivatives_follow_rest_distances() {
    for (degree, form, scale, thickness) in [
        (1, Form::Convergent, 1.0, 0.0),
        (1, Form::Even, 1e-3, 0.1),
        (2, Form::Convergent, 1e-3, 0.1),
        (1, Form::Plain, 1.0, 0.1),
        (3, Form::Convergent, 1e3, 0.0),
    ] {
        let scene = closing(degree, form, scale, thickness);
        let (offset, all) = (scene.offset_terms(), census(&scene)[2]);
        assert!(offset > 10 && offset < all, "{offset} of {all}");
        // shorter steps, within which no pair comes into range
        scene.check(&scene.contact, 0.3 * scale);
    }
}

/// Normal forces that friction is made of follow the rest shape.
#[test]
fn lagged_contacts_follow_rest_distances() {
    for (form, thickness) in [(Form::Convergent, 0.1), (Form::Even, 0.0)] {
        let scene = closing(1, form, 1.0, thickness);
        let count = scene.contact.lagged_contacts(&scene.here()).len();
        let mut random = Random::new(2);
        let by_force = random.numbers(count);
        let cotangents: Vec<_> = by_force
            .iter()
            .map(|&force| LaggedContactCotangent { force, ..Default::default() })
            .collect();
        let (mut by_u, mut by_rest) = (vec![0.0; scene.u.len()], vec![0.0; 3 * scene.rest.len()]);
        let at = scene.here();
        scene.contact.add_lagged_contacts_vjp(&at, &cotangents, &mut by_u, &mut by_rest);
        let value = |rest: &[f64]| {
            let lagged = scene.contact.lagged_contacts(&scene.at(&scene.u, &points(rest)));
            assert_eq!(lagged.len(), count);
            lagged.iter().zip(&by_force).map(|(contact, by)| by * contact.force).sum()
        };
        check_gradient(&flat(&scene.rest), &by_rest, 1e-5, value);
    }
}

/// What a shape is asked for does not depend on what another was asked before.
#[test]
fn results_are_those_of_the_rest_shape_that_is_asked_for() {
    let scene = closing(1, Form::Convergent, 1.0, 0.0);
    let wider: Vec<Vec3> = scene.rest.iter().map(|x| x * 1.2).collect();
    let bits = |scene: &Scene, rest: &[Vec3]| {
        let at = scene.at(&scene.u, rest);
        let gradient = scene.gradient(&scene.contact, &scene.u, rest);
        let value = scene.contact.value(&at);
        gradient.into_iter().chain([value]).map(f64::to_bits).collect::<Vec<_>>()
    };
    let fresh = bits(&closing(1, Form::Convergent, 1.0, 0.0), &wider);
    let first = bits(&scene, &scene.rest);
    assert!(first != fresh);
    assert_eq!(bits(&scene, &wider), fresh);
    assert_eq!(bits(&scene, &scene.rest), first);
}
