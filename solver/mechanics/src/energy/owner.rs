//! Whose numbers the terms of the energy are made with, and derivatives by these.

use crate::symmetry::AXES;

/// Whose numbers some are: a table of a scene by its kind, and its place among the tables of that kind.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Owner {
    kind: &'static str,
    place: usize,
}

impl Owner {
    /// The owner of a kind at a place.
    pub const fn new(kind: &'static str, place: usize) -> Self {
        Self { kind, place }
    }

    /// Its place among those of its kind.
    pub fn place(&self) -> usize {
        self.place
    }
}

/// A number that a term is made with, as it is called where it is written and read.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Slot {
    /// What it is, such as `thickness`; of the values of a [`Profile`](super::Profile) with its place, as `k1.2`.
    pub key: String,
    /// SI unit.
    pub unit: &'static str,
}

impl Slot {
    /// A number.
    pub fn new(key: &str, unit: &'static str) -> Self {
        Self { key: key.to_owned(), unit }
    }

    /// The three components of a vector.
    pub fn components(key: &str, unit: &'static str) -> [Self; 3] {
        AXES.map(|axis| Self { key: format!("{key}.{axis}"), unit })
    }

    /// A number; or the values of one that changes along an axis.
    pub fn along(key: &str, unit: &'static str, values: Option<usize>) -> Vec<Self> {
        let Some(values) = values else { return vec![Self::new(key, unit)] };
        (1..=values).map(|place| Self { key: format!("{key}.{place}"), unit }).collect()
    }
}

/// λᵀ ∂²E/∂u∂p for the numbers p that the terms are made with, in each time step.
#[derive(Clone, Debug, Default)]
pub struct ParameterGradients {
    /// Gradients of each time step, of each term that has parameters.
    steps: Vec<Vec<(Owner, Vec<f64>)>>,
}

impl ParameterGradients {
    /// None yet, for some time steps.
    pub fn new(steps: usize) -> Self {
        Self { steps: vec![Vec::new(); steps] }
    }

    /// Number of time steps.
    pub fn steps(&self) -> usize {
        self.steps.len()
    }

    /// Adds those of a term in a time step, counted from 0.
    pub fn add(&mut self, step: usize, owner: Owner, by: Vec<f64>) {
        self.steps[step].push((owner, by));
    }

    /// Gradients of each term in a time step, counted from 0.
    pub fn of_step(&self, step: usize) -> Vec<(Owner, Vec<f64>)> {
        self.steps[step].clone()
    }

    /// By all numbers of an owner in a time step, counted from 0, as by what a chamber is prescribed by.
    pub fn sum(&self, step: usize, owner: Owner) -> f64 {
        let own = self.steps[step].iter().filter(|(of, _)| *of == owner);
        own.flat_map(|(_, by)| by).sum()
    }

    /// Sum over all time steps, term by term, and over the terms that share the
    /// numbers; nothing where no term has them.
    pub fn total(&self, owner: Owner) -> Vec<f64> {
        let of_step = |step: &Vec<(Owner, Vec<f64>)>| -> Vec<Vec<f64>> {
            step.iter().filter(|(of, _)| *of == owner).map(|(_, by)| by.clone()).collect()
        };
        let mut steps = self.steps.iter().map(of_step);
        let Some(mut terms) = steps.next() else { return Vec::new() };
        for step in steps {
            terms.iter_mut().zip(&step).for_each(|(sum, by)| add(sum, by));
        }
        let mut terms = terms.into_iter();
        let Some(mut total) = terms.next() else { return Vec::new() };
        terms.for_each(|by| add(&mut total, &by));
        total
    }
}

fn add(sum: &mut [f64], by: &[f64]) {
    sum.iter_mut().zip(by).for_each(|(s, b)| *s += b);
}
