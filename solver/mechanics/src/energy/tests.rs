//! Every term against differences, over one registry of samples: forces, Hessian, and derivatives of the forces by the rest
//! shape and by the numbers that the term is made with.

use std::sync::Arc;

use mesh::{TetMesh, Vec3};
use nalgebra::{DMatrix, DVector};

use super::*;
use crate::material::{Material, MooneyRivlin, OgdenRoxburgh};
use crate::math::linear::dot;
use crate::math::random::Random;
use crate::math::sparse::Pattern;
use crate::schedule::{Field, Schedule};
use crate::testing::{check_gradient, cube, flat, points};

/// A body at a state.
pub struct Case {
    pub space: FunctionSpace,
    pub rest: Vec<Vec3>,
    pub u: Vec<f64>,
    pub step: Option<TimeStep>,
}

impl Case {
    /// A body of a degree with random displacements.
    pub fn new(mesh: TetMesh, degree: usize, random: &mut Random, size: f64) -> Self {
        let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets);
        let u = random.numbers(3 * space.node_count()).iter().map(|x| size * x).collect();
        Self { space, rest: mesh.vertices, u, step: None }
    }

    pub fn at<'a>(&'a self, u: &'a [f64], rest: &'a [Vec3]) -> Iterate<'a> {
        Iterate { step: self.step.as_ref(), ..Iterate::new(&self.space, rest, u, 1.0) }
    }

    pub fn here(&self) -> Iterate<'_> {
        self.at(&self.u, &self.rest)
    }

    pub fn gradient(&self, energy: &dyn Energy, u: &[f64], rest: &[Vec3]) -> Vec<f64> {
        let mut gradient = vec![0.0; u.len()];
        energy.add_gradient(&self.at(u, rest), &mut gradient);
        gradient
    }

    /// The Hessian at an iterate times vectors.
    pub fn products<'a>(
        &self,
        at: &Iterate,
        energy: &dyn Energy,
        kind: Hessian,
        by: impl Iterator<Item = &'a [f64]>,
    ) -> Vec<Vec<f64>> {
        let n = self.space.nodes_per_element();
        let (nodes, couplings) = (self.space.element_nodes(), energy.couplings(at, 1.0));
        let pattern = Pattern::new(self.space.node_count(), nodes, n, &couplings);
        let mut hessian = BlockMatrix::zeros(&pattern);
        energy.add_hessian(at, kind, &mut hessian);
        let dense = energy.rank_one(at);
        let product = |by: &[f64]| {
            let mut product = hessian.multiply(by);
            if let Some(RankOne { scale, vector }) = &dense {
                let along = scale * dot(vector, by);
                product.iter_mut().zip(vector).for_each(|(p, v)| *p += along * v);
            }
            product
        };
        by.map(product).collect()
    }

    pub fn times_hessian(&self, energy: &dyn Energy, kind: Hessian, by: &[f64]) -> Vec<f64> {
        self.products(&self.here(), energy, kind, [by].into_iter()).remove(0)
    }

    pub fn weights(&self) -> Vec<f64> {
        Random::new(33).numbers(self.u.len())
    }

    /// The smallest eigenvalue of the Hessian, as a part of the largest.
    pub fn smallest(&self, energy: &dyn Energy, kind: Hessian) -> f64 {
        self.smallest_of(energy, kind, &(0..self.u.len()).collect::<Vec<_>>())
    }

    /// The smallest eigenvalue of the rows and columns `free` of the Hessian, as a part of the largest.
    pub fn smallest_of(&self, energy: &dyn Energy, kind: Hessian, free: &[usize]) -> f64 {
        let unit = DMatrix::<f64>::identity(self.u.len(), self.u.len());
        let units = unit.as_slice().chunks_exact(self.u.len());
        let columns =
            self.products(&self.here(), energy, kind, units).into_iter().map(DVector::from_vec);
        let dense = DMatrix::from_columns(&columns.collect::<Vec<_>>());
        let eigenvalues = dense.select_rows(free).select_columns(free).symmetric_eigenvalues();
        eigenvalues.min() / eigenvalues.amax()
    }
}

/// A term at a state.
pub struct Sample {
    pub name: String,
    pub case: Arc<Case>,
    /// First steps of the tests of the energy and of the forces [m].
    pub sizes: [f64; 2],
    /// The numbers that the term is made with, in the order of the derivatives by them.
    pub numbers: Vec<f64>,
    /// The term by such numbers.
    pub term: ByNumbers,
}

/// A term by its numbers.
type ByNumbers = Box<dyn Fn(&[f64]) -> Box<dyn Energy>>;

/// A term on a space by its numbers.
type Build = Box<dyn Fn(&FunctionSpace, &[f64]) -> Box<dyn Energy>>;

/// One sample or more of every term; contact and friction have bodies of their own.
fn samples() -> Vec<Sample> {
    let mut all = elastic::tests::samples();
    all.extend(fibres::tests::samples());
    all.extend(membrane::tests::samples());
    all.extend(winding::tests::samples());
    all.extend(rigid::tests::samples());
    all.extend(loads());
    all.extend(remembering());
    all
}

/// Overstress, and softening of points that were stretched further before, and that were not.
fn remembering() -> Vec<Sample> {
    let mut random = Random::new(45);
    let mut sample = |name: &str, numbers: &[f64], past: fn(f64) -> f64, term: Build| {
        let mut case = Case::new(cube(2, 0.2), 2, &mut random, 0.03);
        let own = term(&case.space, numbers);
        let count = own.internal_variables().expect("it remembers").count(&case.space);
        let internal = random.numbers(count).into_iter().map(past).collect();
        case.step = Some(TimeStep { internal_h: 0.02, internal, ..TimeStep::default() });
        let case = Arc::new(case);
        let (name, numbers, sizes) = (name.to_owned(), numbers.to_vec(), [3e-4; 2]);
        let space = Arc::clone(&case);
        let term = Box::new(move |numbers: &[f64]| term(&space.space, numbers));
        Sample { name, case, sizes, numbers, term }
    };
    let law = |n: &[f64]| MooneyRivlin { c1: n[0], c2: n[1], c3: n[2], d1: n[3] };
    let viscous: Build = Box::new(move |space, n| {
        let branches = n[4..].chunks(2).map(|b| Branch { overstress: b[0], time: b[1] });
        let law = law(n).isochoric().expect("in invariants");
        Box::new(Viscous::new(law, branches.collect(), 0..space.tets().len(), 0))
    });
    let mullins = || -> Build {
        Box::new(move |space, n| {
            let softening = OgdenRoxburgh { r: n[4], m: n[5], beta: n[6] };
            let law = law(n).isochoric().expect("in invariants");
            Box::new(Mullins::new(law, softening, 0..space.tets().len(), 0))
        })
    };
    let softening = [55e3, 5e3, 1.7e3, 1e6, 1.5, 5.0, 0.3];
    vec![
        sample("viscous", &[55e3, 5e3, 1.7e3, 1e6, 0.6, 0.03, 0.3, 0.4], |x| 1e3 * x, viscous),
        sample("softened", &softening, |x| 5e4 * (2.0 + x), mullins()),
        sample("stretched further", &softening, |_| 1e-3, mullins()),
    ]
}

/// A load on a space and its boundary by its numbers.
type Load = fn(&FunctionSpace, &[[usize; 3]], &[f64]) -> Box<dyn Energy>;

fn field(values: &[f64]) -> Field {
    Field([0, 1, 2].map(|axis| Schedule::held(values[axis])))
}

/// Gas around a body.
fn around(space: &FunctionSpace, facets: &[[usize; 3]], gas: Box<dyn GasLaw>) -> Box<dyn Energy> {
    let outside: Vec<[usize; 3]> = facets.iter().map(|&[a, b, c]| [a, c, b]).collect();
    Box::new(Chamber::new(Wall::new(space, &outside), gas))
}

/// Each with its numbers.
const LOADS: [(&str, &[f64], Load); 5] = [
    ("weight", &[3.0, 1.0, -2.0, 0.5], |space, _, n| {
        Box::new(BodyForce::weight(field(&n[1..]), n[0], 0..space.tets().len()))
    }),
    ("traction", &[1.0, -2.0, 0.5], |space, facets, n| {
        Box::new(Traction::new(space, facets, field(n)))
    }),
    ("inertia", &[3.0], |space, _, n| Box::new(Inertia::new(space, n[0], 0..space.tets().len()))),
    ("ideal gas", &[3e4], |space, facets, n| {
        let (fill, ambient, exponent) = (Schedule::held(n[0]), 101.3e3, 1.4);
        around(space, facets, Box::new(IdealGas { fill, ambient, exponent }))
    }),
    ("pressure", &[3e4], |space, facets, n| {
        around(space, facets, Box::new(Isobaric { pressure: Schedule::held(n[0]) }))
    }),
];

/// Loads, gas around the body, and inertia, on a cube.
fn loads() -> Vec<Sample> {
    let mut case = Case::new(cube(2, 0.2), 2, &mut Random::new(41), 0.03);
    let at = case.weights();
    case.step = Some(TimeStep {
        free_flight: Some(FreeFlight { at, square: 0.04 }),
        ..TimeStep::default()
    });
    let case = Arc::new(case);
    let facets = mesh::topology::boundary(&cube(2, 0.2)).facets;
    let sample = |(name, numbers, load): (&str, &[f64], Load)| {
        let (own, facets) = (Arc::clone(&case), facets.clone());
        Sample {
            name: name.to_owned(),
            case: Arc::clone(&case),
            sizes: [1e-2; 2],
            numbers: numbers.to_vec(),
            term: Box::new(move |numbers| load(&own.space, &facets, numbers)),
        }
    };
    LOADS.map(sample).into()
}

/// Taylor test of a derivative, or that the function is linear.
fn check(name: &str, x: &[f64], by: &[f64], size: f64, value: impl Fn(&[f64]) -> f64) {
    let q = Random::new(7).numbers(x.len());
    let moved: Vec<f64> = x.iter().zip(&q).map(|(x, q)| x + size * q).collect();
    let along = size * dot(by, &q);
    let scale = along.abs().max(1e-4 * value(x).abs());
    if (value(&moved) - value(x) - along).abs() <= 1e-9 * scale {
        return;
    }
    eprintln!("{name}");
    check_gradient(x, by, size, value);
}

/// Forces, Hessian, and derivatives of the forces by the rest shape and by the numbers, against differences.
pub fn check_derivatives(Sample { name, case, sizes, numbers, term }: &Sample) {
    let (own, weights) = (term(numbers), case.weights());
    let pull = |u: &[f64], x: &[Vec3]| dot(&weights, &case.gradient(&*own, u, x));
    let by = case.gradient(&*own, &case.u, &case.rest);
    check(name, &case.u, &by, sizes[0], |u| own.value(&case.at(u, &case.rest)));
    let by = case.times_hessian(&*own, Hessian::Exact, &weights);
    check(name, &case.u, &by, sizes[1], |u| pull(u, &case.rest));
    let mut by = vec![0.0; 3 * case.rest.len()];
    own.add_mixed_vjp(&case.here(), &weights, &mut by);
    check(name, &flat(&case.rest), &by, sizes[1], |x| pull(&case.u, &points(x)));
    if numbers.is_empty() {
        return;
    }
    let (by, slots) = (own.parameter_vjp(&case.here(), &weights), own.slots());
    assert!(by.len() == numbers.len() && slots.len() <= by.len(), "{name}: {slots:?}");
    for (i, by) in by.iter().enumerate() {
        let unit = if numbers[i] == 0.0 { 1.0 } else { numbers[i] };
        let value = |part: f64| {
            let mut changed = numbers.clone();
            changed[i] += part * unit;
            dot(&weights, &case.gradient(&*term(&changed), &case.u, &case.rest))
        };
        let (slope, by) = ((value(1e-5) - value(-1e-5)) / 2e-5, by * unit);
        let scale = by.abs() + value(0.0).abs();
        assert!((slope - by).abs() <= 1e-7 * scale, "{name} {i}: {slope} {by}");
    }
}

#[test]
fn every_term_has_its_derivatives() {
    samples().iter().for_each(check_derivatives);
}

/// Of terms that remember: the forces by Z°, and Z by all that it depends on.
#[test]
fn internal_variables_have_their_derivatives() {
    let mut seen = 0;
    for Sample { name, case, sizes, numbers, term } in samples() {
        let (own, weights, at) = (term(&numbers), case.weights(), case.here());
        let (Some(variables), Some(step)) = (own.internal_variables(), at.step) else { continue };
        let past = &step.internal;
        let size = 1e-3 * past.iter().fold(0.0_f64, |m, z| m.max(z.abs()));
        let with_past = |z: &[f64]| TimeStep { internal: z.to_vec(), ..step.clone() };
        let mut by = PastCotangent::zeros(case.u.len());
        own.add_past_vjp(&at, &weights, &mut by);
        check(&name, past, &by.internal, size, |z| {
            let mut forces = vec![0.0; case.u.len()];
            own.add_gradient(&Iterate { step: Some(&with_past(z)), ..at }, &mut forces);
            dot(&weights, &forces)
        });
        let bars = Random::new(8).numbers(past.len());
        let (mut by_u, mut by_rest) = (vec![0.0; case.u.len()], vec![0.0; 3 * case.rest.len()]);
        let by = variables.add_vjp(&at, &bars, &mut by_u, &mut by_rest);
        let values = |at: &Iterate| dot(&bars, &variables.values(at));
        check(&name, &case.u, &by_u, sizes[1], |u| values(&Iterate { u, ..at }));
        check(&name, &flat(&case.rest), &by_rest, sizes[1], |x| {
            values(&Iterate { rest: &points(x), ..at })
        });
        check(&name, past, &by.past, size, |z| {
            values(&Iterate { step: Some(&with_past(z)), ..at })
        });
        let scaled: Vec<f64> = by.parameters.iter().zip(&numbers).map(|(b, n)| b * n).collect();
        check(&name, &vec![1.0; numbers.len()], &scaled, 1e-3, |x| {
            let numbers: Vec<f64> = x.iter().zip(&numbers).map(|(x, n)| x * n).collect();
            dot(&bars, &term(&numbers).internal_variables().expect("as before").values(&at))
        });
        seen += 1;
    }
    assert_eq!(seen, 3);
}
