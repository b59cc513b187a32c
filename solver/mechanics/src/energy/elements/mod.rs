//! Energies that are sums over consecutive elements: evaluated several elements side by side, and merged.

mod batch;

use std::ops::Range;

use mesh::Vec3;
use pulp::{Simd, WithSimd};

use super::{Elastic, Energy, Fibres, Hessian, Iterate, Nature, Slot};
use crate::element::{FunctionSpace, add_at};
use crate::math::lanes::{Lanes, MOST, widest};
use crate::math::pool::Pool;
use crate::math::sparse::{BlockMatrix, pair_count};
use crate::parallel::{fill, map_merge, map_merge_waves};

pub(super) use batch::{Batch, CORNERS, CUBIC, Forces, Nodal, QUADRATIC, points};

#[cfg(test)]
pub(super) mod tests;

/// An energy that is a sum over consecutive elements. What takes a batch is compiled for the vectors of the machine:
/// its implementation has to be marked `#[inline(always)]`, and so have the functions that it calls.
pub(super) trait ElementEnergy: Send + Sync {
    /// What messages call it.
    const NAME: &'static str;
    /// [`Energy::is_reinforcement`].
    const REINFORCES: bool = false;

    /// Memory that is used again from batch to batch.
    type Memory<S: Simd, const N: usize>: Default;

    /// The elements.
    fn range(&self, space: &FunctionSpace) -> Range<usize>;

    /// Energies of the elements [J].
    fn energies<S: Simd, const N: usize>(&self, batch: &Batch<S, N>) -> [f64; MOST];

    /// ∂E/∂u_a of the elements [N].
    fn forces<S: Simd, const N: usize>(&self, batch: &Batch<S, N>) -> Nodal<S, N>;

    /// Writes the lower blocks ∂²E/∂u_a∂u_b of the elements [N/m].
    fn write_blocks<S: Simd, const N: usize>(
        &self,
        batch: &Batch<S, N>,
        kind: Hessian,
        memory: &mut Self::Memory<S, N>,
        out: &mut Blocks,
    );

    /// λᵀ ∂²E/∂u∂X of an element, at its corners.
    fn mixed_vjp(&self, at: &Iterate, lambda: &[f64], element: usize) -> [Vec3; 4];

    /// Number of its parameters.
    fn parameter_count(&self) -> usize;

    /// Its parameters, where they are not those of a law.
    fn slots(&self) -> Vec<Slot> {
        Vec::new()
    }

    /// λᵀ ∂²E/∂u∂p of some elements, by the parameters; or several of these, one after the other, to be added.
    fn parameters_vjp(&self, at: &Iterate, lambda: &[f64], elements: Range<usize>) -> Vec<f64>;
}

/// The lower blocks of the Hessians of some elements, in the order of
/// [`pair_index`](crate::math::sparse::pair_index).
pub(super) struct Blocks<'a> {
    blocks: &'a mut [[f64; 9]],
    /// Blocks of an element.
    pairs: usize,
}

impl Blocks<'_> {
    /// Writes one block of each element; entry (i, j) at 3 i + j.
    #[inline(always)]
    pub(super) fn write<S: Simd>(&mut self, pair: usize, block: &[Lanes<S>; 9]) {
        for (entry, value) in block.iter().enumerate() {
            let values = value.to_array();
            for (element, value) in self.blocks.chunks_exact_mut(self.pairs).zip(values) {
                element[pair][entry] = value;
            }
        }
    }
}

/// Where something is evaluated: an energy in consecutive elements.
pub(super) struct Part<'a, E> {
    pub(super) energy: &'a E,
    pub(super) iterate: &'a Iterate<'a>,
    pub(super) elements: Range<usize>,
}

impl<'a, E> Part<'a, E> {
    /// Elements counted from the first one that the energy has.
    fn new(energy: &'a E, iterate: &'a Iterate<'a>, own: &Range<usize>, r: &Range<usize>) -> Self {
        Self { energy, iterate, elements: shifted(r, own.start) }
    }
}

/// The energy of some elements [J].
pub(super) struct Value<'a, E, const N: usize>(pub(super) Part<'a, E>);

impl<E: ElementEnergy, const N: usize> WithSimd for Value<'_, E, N> {
    type Output = f64;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> f64 {
        let Self(Part { energy, iterate, elements }) = self;
        let mut sum = 0.0;
        for elements in pieces(elements, Lanes::<S>::COUNT) {
            let count = elements.len();
            let values = energy.energies(&Batch::<S, N>::new(simd, iterate, elements));
            // element by element, so that the sum is the same for any number of lanes
            values.iter().take(count).for_each(|value| sum += value);
        }
        if sum.is_finite() { sum } else { f64::INFINITY }
    }
}

/// Writes the gradients of elements, N values each.
pub(super) struct Gradients<'a, E, const N: usize> {
    pub(super) of: Part<'a, E>,
    pub(super) out: &'a mut [Vec3],
}

impl<E: ElementEnergy, const N: usize> WithSimd for Gradients<'_, E, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Part { energy, iterate, elements } = self.of;
        let out = self.out.chunks_mut(N * Lanes::<S>::COUNT);
        for (elements, out) in pieces(elements, Lanes::<S>::COUNT).zip(out) {
            let forces = energy.forces(&Batch::<S, N>::new(simd, iterate, elements));
            for (a, force) in forces.iter().enumerate() {
                for i in 0..3 {
                    let values = force[i].to_array();
                    for (element, value) in out.chunks_exact_mut(N).zip(values) {
                        element[a][i] = value;
                    }
                }
            }
        }
    }
}

/// Writes the lower blocks of the Hessians of elements.
pub(super) struct Hessians<'a, E, const N: usize> {
    pub(super) of: Part<'a, E>,
    pub(super) kind: Hessian,
    pub(super) blocks: &'a mut [[f64; 9]],
}

impl<E: ElementEnergy, const N: usize> WithSimd for Hessians<'_, E, N> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Part { energy, iterate, elements } = self.of;
        let pairs = pair_count(N);
        let mut memory = E::Memory::<S, N>::default();
        let blocks = self.blocks.chunks_mut(pairs * Lanes::<S>::COUNT);
        for (elements, blocks) in pieces(elements, Lanes::<S>::COUNT).zip(blocks) {
            let batch = Batch::<S, N>::new(simd, iterate, elements);
            energy.write_blocks(&batch, self.kind, &mut memory, &mut Blocks { blocks, pairs });
        }
    }
}

/// Cuts a range into pieces of at most `each`.
fn pieces(range: Range<usize>, each: usize) -> impl Iterator<Item = Range<usize>> {
    range.clone().step_by(each).map(move |first| first..(first + each).min(range.end))
}

fn shifted(range: &Range<usize>, by: usize) -> Range<usize> {
    range.start + by..range.end + by
}

fn total<E: ElementEnergy, const N: usize>(energy: &E, iterate: &Iterate) -> f64 {
    let own = energy.range(iterate.space);
    let mut sum = 0.0;
    map_merge(
        own.len(),
        |r| widest(Value::<E, N>(Part::new(energy, iterate, &own, &r))),
        |_, part| sum += part,
    );
    sum
}

fn merge_gradients<E: ElementEnergy, const N: usize>(
    energy: &E,
    iterate: &Iterate,
    out: &mut [f64],
) {
    let own = energy.range(iterate.space);
    let forces = fill(own.len(), N, Vec3::zeros(), |r, out| {
        widest(Gradients::<E, N> { of: Part::new(energy, iterate, &own, &r), out });
    });
    iterate.space.incidence().add(N * own.start..N * own.end, &forces, out);
}

fn merge_hessians<E: ElementEnergy, const N: usize>(
    energy: &E,
    iterate: &Iterate,
    kind: Hessian,
    out: &mut BlockMatrix,
) {
    let own = energy.range(iterate.space);
    let memory = Pool::default();
    map_merge_waves(
        own.len(),
        |r| {
            let mut blocks = memory.overwritable(pair_count(N) * r.len(), [0.0; 9]);
            let (of, out) = (Part::new(energy, iterate, &own, &r), &mut blocks);
            widest(Hessians::<E, N> { of, kind, blocks: out });
            blocks
        },
        |r, parts| {
            let blocks: Vec<&[[f64; 9]]> = parts.iter().map(|part| &part[..]).collect();
            out.add_elements(shifted(&r, own.start), &blocks);
            parts.into_iter().for_each(|part| memory.give(part));
        },
    );
}

fn merge_mixed<E: ElementEnergy>(energy: &E, iterate: &Iterate, lambda: &[f64], out: &mut [f64]) {
    let own = energy.range(iterate.space);
    map_merge(
        own.len(),
        |r| -> Vec<[Vec3; 4]> {
            let one = |e| energy.mixed_vjp(iterate, lambda, e);
            shifted(&r, own.start).map(one).collect()
        },
        |r, parts| {
            for (e, part) in shifted(&r, own.start).zip(parts) {
                for (v, p) in iterate.space.tets()[e].iter().zip(part) {
                    add_at(out, *v, &p);
                }
            }
        },
    );
}

fn merge_parameters<E: ElementEnergy>(energy: &E, iterate: &Iterate, lambda: &[f64]) -> Vec<f64> {
    let (own, count) = (energy.range(iterate.space), energy.parameter_count());
    let mut sum = vec![0.0; count];
    map_merge(
        own.len(),
        |r| energy.parameters_vjp(iterate, lambda, shifted(&r, own.start)),
        |_, parts| {
            for part in parts.chunks_exact(count.max(1)) {
                sum.iter_mut().zip(part).for_each(|(s, p)| *s += p);
            }
        },
    );
    sum
}

/// Calls a function of an energy with the number of nodes per element as a constant, so that
/// its loops have fixed lengths.
macro_rules! with_nodes {
    ($space:expr, $function:ident::<$energy:ty>($($argument:expr),*)) => {
        match $space.nodes_per_element() {
            4 => $function::<$energy, 4>($($argument),*),
            10 => $function::<$energy, 10>($($argument),*),
            _ => $function::<$energy, 20>($($argument),*),
        }
    };
}

/// Makes a type an energy by what it is on elements. As text, not as a generic implementation: that would be compiled
/// where terms are put together, with the settings of a crate that computes nothing.
macro_rules! energy_of_elements {
    ($energy:ty) => {
        impl Energy for $energy {
            fn kind(&self) -> (&'static str, Nature) {
                (<$energy as ElementEnergy>::NAME, Nature::Elastic)
            }

            fn is_reinforcement(&self) -> bool {
                <$energy as ElementEnergy>::REINFORCES
            }

            fn value(&self, iterate: &Iterate) -> f64 {
                with_nodes!(iterate.space, total::<$energy>(self, iterate))
            }

            fn add_gradient(&self, iterate: &Iterate, out: &mut [f64]) {
                with_nodes!(iterate.space, merge_gradients::<$energy>(self, iterate, out));
            }

            fn add_hessian(&self, iterate: &Iterate, kind: Hessian, out: &mut BlockMatrix) {
                with_nodes!(iterate.space, merge_hessians::<$energy>(self, iterate, kind, out));
            }

            fn add_mixed_vjp(&self, iterate: &Iterate, lambda: &[f64], out: &mut [f64]) {
                merge_mixed(self, iterate, lambda, out);
            }

            fn slots(&self) -> Vec<Slot> {
                ElementEnergy::slots(self)
            }

            fn parameter_vjp(&self, iterate: &Iterate, lambda: &[f64]) -> Vec<f64> {
                merge_parameters(self, iterate, lambda)
            }
        }
    };
}

energy_of_elements!(Elastic);
energy_of_elements!(Fibres);
