//! Threads on cubes and tubes: derivatives, lengths, and what cannot be laid.

use std::sync::Arc;

use super::*;
use crate::energy::Axis;
use crate::energy::tests::{Case, Sample};
use crate::math::linear::dot;
use crate::math::random::Random;
use crate::testing::{check_gradient, cube};

/// A cube of a degree with random displacements, and a thread across its top.
struct Wound {
    case: Arc<Case>,
    pieces: Vec<Piece>,
}

impl Wound {
    fn new(degree: usize, size: f64) -> Self {
        let mesh = cube(3, 0.2);
        let boundary = mesh::topology::boundary(&mesh).facets;
        let top = |f: &[usize; 3]| f.iter().all(|&v| mesh.vertices[v].z > 1.0 - 1e-9);
        let facets: Vec<_> = boundary.into_iter().filter(top).collect();
        let path = [[0.1, 0.2, 1.0], [0.8, 0.35, 1.1], [0.4, 0.9, 1.0]].map(Vec3::from);
        let pieces = polyline(&facets, &mesh.vertices, &path).expect("it lies on the top");
        Self { case: Arc::new(Case::new(mesh, degree, &mut Random::new(43), size)), pieces }
    }

    /// A thread of which a part is slack; the slack is wide, so that its curvature is seen by steps of the
    /// Taylor test.
    fn thread(&self, [stiffness, pretension]: [f64; 2]) -> Winding {
        let numbers = [stiffness, pretension, 0.3];
        Winding::new(&self.case.space, &self.pieces, numbers)
    }
}

const NUMBERS: [f64; 2] = [40.0, 2.0];

/// Threads on facets.
pub fn samples() -> Vec<Sample> {
    let sample = |degree| {
        let wound = Wound::new(degree, 0.03);
        Sample {
            name: format!("thread P{degree}"),
            case: Arc::clone(&wound.case),
            sizes: [3e-4, 5e-5],
            numbers: NUMBERS.to_vec(),
            term: Box::new(move |n| Box::new(wound.thread([n[0], n[1]]))),
        }
    };
    [1, 2, 3].map(sample).into()
}

/// The side faces of the cube.
fn sides(mesh: &mesh::TetMesh) -> Vec<[usize; 3]> {
    let is_side = |f: &[usize; 3]| {
        let flat = |k: usize, at: f64| f.iter().all(|&v| mesh.vertices[v][k] == at);
        (0..2).any(|k| flat(k, 0.0) || flat(k, 1.0))
    };
    mesh::topology::boundary(mesh).facets.into_iter().filter(is_side).collect()
}

/// Tests the derivatives of a helix around the cube, on its sides: by its stiffness, pretension,
/// lead and phase. The functions give the lead of its values, and the stiffness, of all values relative to `NUMBERS`.
/// Steps are so short that no piece appears or vanishes.
fn check_helix(
    degree: usize,
    values: &[f64],
    lead: impl Fn(&[f64]) -> Lead,
    stiffness: impl Fn(&[f64]) -> Along,
) {
    let (case, mesh) = (Wound::new(degree, 0.03).case, cube(3, 0.2));
    let sides = sides(&mesh);
    let axis = Axis { point: Vec3::new(0.5, 0.45, 0.0), along: Vec3::z() };
    let count = stiffness(values).values().len();
    let pieces = |values: &[f64]| {
        let phase = values[values.len() - 1];
        let course = &values[count + 1..values.len() - 1];
        let own = Helix::new(axis, lead(course), [0.1, 0.85], phase);
        helix(&sides, &mesh.vertices, &own).expect("it lies on the sides")
    };
    let facets =
        |values: &[f64]| -> Vec<_> { pieces(values).iter().map(|piece| piece.facet).collect() };
    let thread = |values: &[f64]| {
        let numbers = [values[0], values[count], 0.3];
        let thread = Winding::new(&case.space, &pieces(values), numbers);
        match stiffness(&values[..count]) {
            Along::Number(_) => thread,
            Along::Profile(profile) => thread.with_stiffness(&profile, &case.rest),
        }
    };
    let (here, at) = (facets(values), case.here());
    let weights = Random::new(33).numbers(case.u.len());
    let with = |x: &[f64]| {
        let values: Vec<f64> = x.iter().zip(values).map(|(x, value)| x * value).collect();
        assert_eq!(facets(&values), here);
        thread(&values)
    };
    let scaled = |by: Vec<f64>| -> Vec<f64> {
        assert_eq!(by.len(), values.len());
        by.iter().zip(values).map(|(by, value)| by * value).collect()
    };
    let ones = vec![1.0; values.len()];
    let by = thread(values).parameter_vjp(&at, &weights);
    check_gradient(&ones, &scaled(by), 1e-4, |x| {
        dot(&weights, &case.gradient(&with(x), &case.u, &case.rest))
    });
    let by = thread(values).mean_force_by_parameters(&at, 3.0);
    check_gradient(&ones, &scaled(by), 5e-5, |x| with(x).mean_force(&at, 3.0));
}

/// Of both hands.
#[test]
fn derivatives_by_the_course_of_a_helix_pass_the_taylor_test() {
    for degree in [1, 2, 3] {
        for hand in [1.0, -1.0] {
            check_helix(
                degree,
                &[40.0, 2.0, 0.53 * hand, 0.3],
                |course| Lead::Pitch(Along::Number(course[0])),
                |stiffness| Along::Number(stiffness[0]),
            );
        }
    }
}

/// Splines of the pitch or the angle, and of the stiffness.
#[test]
fn derivatives_by_values_along_the_axis_pass_the_taylor_test() {
    let profile = |heights: [f64; 2], values: &[f64]| {
        let axis = Axis { point: Vec3::zeros(), along: Vec3::z() };
        Along::Profile(Profile::new(axis, heights, values.to_vec()).expect("it is good"))
    };
    for degree in [1, 2] {
        for hand in [1.0, -1.0] {
            let stiffness = |values: &[f64]| profile([0.0, 0.9], values);
            let pitches = [0.41, 0.57, 0.49, 0.68, 0.6].map(|pitch| hand * pitch);
            check_helix(
                degree,
                &[&[40.0, 30.0, 55.0, 2.0][..], &pitches, &[0.3]].concat(),
                |values| Lead::Pitch(profile([0.05, 0.8], values)),
                |values| profile([0.0, 0.9], &values[..3]),
            );
            let angles = [1.42, 1.39, 1.46].map(|angle| hand * angle);
            check_helix(
                degree,
                &[&[40.0, 30.0, 2.0][..], &angles, &[0.3]].concat(),
                |values| Lead::Angle(profile([0.2, 1.0], values), 0.55),
                |values| stiffness(&values[..2]),
            );
        }
    }
}

/// With a pitch that grows linearly from 0.3 to 0.7, the thread is at the angle 2π ln(p/p₀)/p′ at every height.
#[test]
fn a_helix_of_a_changing_pitch_is_where_its_turns_are() {
    let (facets, x) = tube(96, 64, 1.0);
    let axis = Axis { point: Vec3::zeros(), along: Vec3::z() };
    let profile = Profile::new(axis, [0.5, 3.5], vec![0.3, 0.7]).expect("it is good");
    let own = Helix::new(axis, Lead::Pitch(Along::Profile(profile)), [0.5, 3.5], 0.2);
    let pieces = helix(&facets, &x, &own).expect("it lies on the tube");
    let slope = 0.4 / 3.0;
    let turns = |z: f64| ((0.3 + slope * (z - 0.5)) / 0.3).ln() / slope;
    let count: f64 = pieces.iter().map(|p| p.range[1] - p.range[0]).sum();
    assert!((count / turns(3.5) - 1.0).abs() < 1e-9, "{count}");
    assert!((own.turns() / turns(3.5) - 1.0).abs() < 1e-9);
    for piece in &pieces {
        let at = piece.place(&x, 1);
        let angle = 0.2 + std::f64::consts::TAU * turns(at.z);
        let off = (at.y.atan2(at.x) - angle).sin().abs();
        // turns are linear in a facet of 1/16: at most h²/8 of their second derivative, 0.4/3/0.09
        assert!(off < std::f64::consts::TAU * 0.0625_f64.powi(2) / 8.0 * slope / 0.09, "{off}");
    }
    assert!((pieces[pieces.len() - 1].place(&x, 1).z - 3.5).abs() < 1e-12);
    // turns that vary a lot within facets of a quarter
    let (facets, x) = tube(24, 16, 1.0);
    let profile = Profile::new(axis, [0.0, 4.0], vec![0.01, 0.01, 1.0]).expect("it is good");
    let own = Helix { lead: Lead::Pitch(Along::Profile(profile)), ..own };
    let pieces = helix(&facets, &x, &own).expect("it lies on the tube");
    let count: f64 = pieces.iter().map(|p| p.range[1] - p.range[0]).sum();
    assert!((count / own.turns() - 1.0).abs() < 1e-9, "{count}");
}

/// Pulled by λ in all directions, a thread has the force EA (λ − 1), and with pretension as much more.
#[test]
fn a_stretched_thread_has_its_force() {
    for degree in [1, 2, 3] {
        let wound = Wound::new(degree, 0.0);
        let (at, case) = (wound.case.here(), &wound);
        let places = at.space.node_positions(at.rest);
        let u: Vec<f64> = places.iter().flat_map(|x| [0.4 * x.x, 0.4 * x.y, 0.4 * x.z]).collect();
        let at = Iterate { u: &u, ..at };
        for pretension in [0.0, 3.0] {
            let found = case.thread([40.0, pretension]).summary(&at);
            let force = 16.0 + pretension;
            let means = [1.0, 7.0].map(|q| case.thread([40.0, pretension]).mean_force(&at, q));
            for force_found in found.force.into_iter().chain([found.mean_force]).chain(means) {
                assert!((force_found / force - 1.0).abs() < 1e-12, "{degree}: {found:?}");
            }
            let legs = (0.7_f64.powi(2) + 0.15_f64.powi(2)).sqrt()
                + (0.4_f64.powi(2) + 0.55_f64.powi(2)).sqrt();
            assert!((found.length / legs - 1.0).abs() < 1e-12 && found.taut == 1.0, "{found:?}");
        }
        let strands = case.thread([40.0, 0.0]).strands(&at);
        for pair in strands.windows(2) {
            assert!((pair[0].rest[1] - pair[1].rest[0]).norm() < 1e-12);
        }
        let strand = strands[1];
        assert!((strand.moved[0] - 0.4 * strand.rest[0]).norm() < 1e-12);
    }
}

/// Means of threads that are nowhere and somewhere taut: from the mean to the largest force.
#[test]
fn power_means_of_the_force_tend_to_the_largest() {
    let wound = Wound::new(2, 0.03);
    let (at, thread) = (wound.case.here(), wound.thread(NUMBERS));
    let summary = thread.summary(&at);
    assert!((thread.mean_force(&at, 1.0) / summary.mean_force - 1.0).abs() < 1e-12);
    let mut largest = 0.0_f64;
    for segment in &thread.segments {
        thread.for_each_point(&at, segment, |p| largest = largest.max(p.force()));
    }
    let means = [1.0, 2.0, 8.0, 90.0].map(|power| thread.mean_force(&at, power));
    assert!(means.is_sorted() && means[3] < largest && means[3] > 0.9 * largest, "{means:?}");
}

#[test]
fn a_slack_thread_does_nothing() {
    let wound = Wound::new(2, 0.0);
    let (at, thread) = (wound.case.here(), wound.thread([40.0, 0.0]));
    let places = at.space.node_positions(at.rest);
    let u: Vec<f64> = places.iter().flat_map(|x| [-0.1 * x.x, -0.1 * x.y, 0.0]).collect();
    let at = Iterate { u: &u, ..at };
    assert_eq!((thread.value(&at), thread.summary(&at).taut), (0.0, 0.0));
    assert!(wound.case.gradient(&thread, &u, at.rest).iter().all(|g| *g == 0.0));
    assert_eq!(thread.mean_force(&at, 2.0), 0.0);
    assert_eq!(thread.mean_force_by_parameters(&at, 2.0), [0.0; 2]);
}

/// A tube about z of radius 1 and height 4, facets of a number of cells around and along.
fn tube(around: usize, along: usize, radius: f64) -> (Vec<[usize; 3]>, Vec<Vec3>) {
    let place = |i: usize, k: usize| {
        let angle = std::f64::consts::TAU * i as f64 / around as f64;
        Vec3::new(radius * angle.cos(), radius * angle.sin(), 4.0 * k as f64 / along as f64)
    };
    let x = (0..=along).flat_map(|k| (0..around).map(move |i| place(i, k))).collect();
    let cell = |n: usize| {
        let (i, k) = (n % around, n / around);
        let id = |i: usize, k: usize| k * around + i % around;
        [[id(i, k), id(i + 1, k), id(i + 1, k + 1)], [id(i, k), id(i + 1, k + 1), id(i, k + 1)]]
    };
    ((0..around * along).flat_map(cell).collect(), x)
}

fn screw(pitch: f64, phase: f64) -> Helix {
    let axis = Axis { point: Vec3::zeros(), along: Vec3::z() };
    Helix::new(axis, Lead::Pitch(Along::Number(pitch)), [0.5, 3.5], phase)
}

fn length(pieces: &[Piece], x: &[Vec3]) -> f64 {
    pieces.iter().map(|p| (p.place(x, 1) - p.place(x, 0)).norm()).sum()
}

/// Also where it passes through vertices and along diagonals, of which every one is found twice.
#[test]
fn helices_have_their_length_and_their_hand() {
    for around in [24, 48] {
        let (facets, x) = tube(around, 16, 1.0);
        for (pitch, phase) in
            [(0.5, 0.0), (-0.5, 0.3), (4.0 / 16.0 * around as f64, 0.0), (0.1, 1.0)]
        {
            let own = screw(pitch, phase);
            let pieces = helix(&facets, &x, &own).expect("it lies on the tube");
            // the facets are a prism, which can be unrolled
            let side = (std::f64::consts::PI / around as f64).sin();
            let exact = 3.0 / pitch.abs() * (2.0 * around as f64 * side).hypot(pitch);
            let found = length(&pieces, &x);
            let turns: f64 = pieces.iter().map(|p| p.range[1] - p.range[0]).sum();
            assert!((turns - 3.0 / pitch.abs()).abs() < 1e-9, "{turns}");
            assert!((found / exact - 1.0).abs() < 1e-9, "{around} {pitch}: {found} {exact}");
            for pair in pieces.windows(2) {
                assert!((pair[0].place(&x, 1) - pair[1].place(&x, 0)).norm() < 1e-9);
            }
            let start = pieces[0].place(&x, 0);
            let (angle, step) = (start.y.atan2(start.x), pieces[0].place(&x, 1) - start);
            assert!((angle - phase).abs() < 1e-2 && (start.z - 0.5).abs() < 1e-12, "{start}");
            let turns = start.cross(&step).z.signum() * step.z.signum();
            assert_eq!(turns, pitch.signum());
        }
    }
}

#[test]
fn what_cannot_be_laid_is_said_with_its_place() {
    let (facets, x) = tube(24, 16, 1.0);
    let shorter: Vec<_> =
        facets.iter().filter(|f| f.iter().all(|&v| x[v].z < 2.6)).copied().collect();
    let Err(LayError::Leaves { at, part }) = helix(&shorter, &x, &screw(0.5, 0.0)) else {
        panic!("it leaves the tube")
    };
    assert!((at[2] - 2.5).abs() < 1e-9 && (part - 200.0 / 3.0).abs() < 1e-6, "{at:?} {part}");
    let elsewhere = Helix { heights: [5.0, 6.0], ..screw(0.5, 0.0) };
    assert_eq!(helix(&facets, &x, &elsewhere), Err(LayError::Misses));
    // a narrow band, 100 turns over 24 columns of facets that are far higher than the pitch
    let narrow = Helix { heights: [1.0, 1.0 + 1e-4], ..screw(1e-6, 0.0) };
    let found = helix(&facets, &x, &narrow).map(|pieces| pieces.len());
    assert!(found.is_ok_and(|pieces| pieces >= 2400), "{found:?}");
    // a tube within the tube
    let (mut both, mut all) = (facets.clone(), x.clone());
    let (inner, more) = tube(24, 16, 0.8);
    both.extend(inner.iter().map(|f| f.map(|v| v + x.len())));
    all.extend(more);
    let found = helix(&both, &all, &screw(0.5, 0.1));
    assert!(matches!(found, Err(LayError::Layers { .. })), "{found:?}");
    let (sheet, flat) = ([[0, 1, 2]], [Vec3::x(), -Vec3::x() + Vec3::y(), -Vec3::x() - Vec3::y()]);
    let found = helix(&sheet, &flat, &screw(0.5, 0.0));
    assert!(matches!(found, Err(LayError::AxisInside { .. })), "{found:?}");
}

/// Along a circle of points, as a hand would give them.
#[test]
fn a_polyline_follows_the_surface() {
    let (facets, x) = tube(48, 16, 1.0);
    let point = |i: i32| {
        let angle = 0.3 * f64::from(i);
        Vec3::new(1.02 * angle.cos(), 1.02 * angle.sin(), 1.03)
    };
    let path: Vec<Vec3> = (0..10).map(point).collect();
    let pieces = polyline(&facets, &x, &path).expect("it lies on the tube");
    let found = length(&pieces, &x);
    assert!((found / 2.7 - 1.0).abs() < 2e-3, "{found}");
    let gone: Vec<_> =
        facets.iter().filter(|f| f.iter().any(|&v| x[v].y > -0.5)).copied().collect();
    let path = [Vec3::new(1.0, 0.0, 1.0), Vec3::new(0.0, -1.0, 1.0)];
    let found = polyline(&gone, &x, &path);
    assert!(matches!(found, Err(LayError::Leaves { .. } | LayError::Misses)), "{found:?}");
}

/// The force in a short segment counts as a part of what it lies in.
#[test]
fn extreme_forces_are_those_of_stretches_as_long_as_segments() {
    let [low, high] = measures::extremes(&[(1.0, 2.0), (0.01, 1.0), (1.0, 3.0), (0.5, 9.0)], 0.6);
    assert!((low - 2.0).abs() < 1e-12, "{low}");
    assert!((high - 4.0 / 1.01).abs() < 1e-12, "{high}");
}

/// By its phase, a thread moves along its facets, and its ends at their heights: on edges as well, which a start may miss
/// by rounding.
#[test]
fn ends_on_edges_move_at_their_heights() {
    let (around, pitch) = (24, 0.5);
    let (facets, x) = tube(around, 7, 1.0);
    for edge in 0..around {
        let phase = std::f64::consts::TAU * edge as f64 / around as f64;
        let pieces = helix(&facets, &x, &screw(pitch, phase)).expect("it lies on the tube");
        for (piece, end) in [(&pieces[0], 0), (&pieces[pieces.len() - 1], 1)] {
            let by_phase = piece.rates.last().expect("of a helix")[end];
            let motion: Vec3 = piece.facet.iter().zip(by_phase).map(|(&v, rate)| rate * x[v]).sum();
            assert!(motion.z.abs() < 1e-9 && motion.norm() > 0.9, "{edge} {end}: {motion}");
        }
    }
}
