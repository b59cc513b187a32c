//! Solution with a factor, in parallel over subtrees of the elimination tree:
//! L y = b from the leaves to the roots, Lᵀ x = y from the roots to the leaves.

use rayon::prelude::*;

use super::multifrontal::Fronts;
use super::scalar::Scalar;
use super::supernode::Supernode;
use super::trapezoid;
use super::unknown::Unknown;

/// Entries of the factor that are worth a task of their own.
const TASK: usize = 1 << 18;

/// Values of the rows below a supernode: what its subtree adds to them on the way up,
/// the solution there on the way down.
type Below<X> = Vec<X>;

impl Fronts {
    /// x ← L⁻ᵀ L⁻¹ x, in the order of the factor.
    pub fn solve<T: Scalar, X: Unknown<T>>(&self, factor: &[T], x: &mut [X]) {
        self.forward_all(&self.roots, factor, x);
        let below = self.roots.iter().map(|_| Vec::new()).collect();
        self.backward_all(&self.roots, below, factor, x);
    }

    /// L y = x on disjoint subtrees, to which `factor` and `x` belong.
    fn forward_all<T: Scalar, X: Unknown<T>>(
        &self,
        roots: &[usize],
        factor: &[T],
        x: &mut [X],
    ) -> Vec<Below<X>> {
        let tasks: Vec<_> = self.parts(roots, factor, x).collect();
        tasks.into_par_iter().map(|(root, l, x)| self.forward(root, l, x)).collect()
    }

    fn forward<T: Scalar, X: Unknown<T>>(
        &self,
        root: usize,
        factor: &[T],
        x: &mut [X],
    ) -> Below<X> {
        let s = &self.supernodes[root];
        if factor.len() < TASK {
            return self.forward_in_order(root, factor, x);
        }
        let (inner, own) = factor.split_at(factor.len() - s.values.len());
        let (x_inner, x_own) = x.split_at_mut(x.len() - s.width());
        let updates = self.forward_all(&s.children, inner, x_inner);
        self.forward_front(s, own, x_own, &updates)
    }

    /// A subtree on one thread.
    fn forward_in_order<T: Scalar, X: Unknown<T>>(
        &self,
        root: usize,
        factor: &[T],
        x: &mut [X],
    ) -> Below<X> {
        let mut waiting: Vec<Below<X>> = Vec::new();
        let each: Vec<usize> = (self.supernodes[root].first..=root).collect();
        for (index, own, x) in self.parts_of(&each, factor, x) {
            let s = &self.supernodes[index];
            let children = waiting.len() - s.children.len();
            let update = self.forward_front(s, own, x, &waiting[children..]);
            waiting.truncate(children);
            waiting.push(update);
        }
        waiting.pop().expect("a subtree is not empty")
    }

    fn forward_front<T: Scalar, X: Unknown<T>>(
        &self,
        s: &Supernode,
        own: &[T],
        x: &mut [X],
        updates: &[Below<X>],
    ) -> Below<X> {
        let mut front = vec![X::zero(); s.height()];
        front[..s.width()].copy_from_slice(x);
        for (&child, update) in s.children.iter().zip(updates) {
            for (&place, &v) in self.supernodes[child].places.iter().zip(update) {
                front[place as usize] = front[place as usize].plus(T::narrow(1.0), v);
            }
        }
        trapezoid::forward(s.front(own), &mut front);
        x.copy_from_slice(&front[..s.width()]);
        front.split_off(s.width())
    }

    /// Lᵀ x = y on disjoint subtrees, given the solution below each.
    fn backward_all<T: Scalar, X: Unknown<T>>(
        &self,
        roots: &[usize],
        below: Vec<Below<X>>,
        factor: &[T],
        x: &mut [X],
    ) {
        let tasks: Vec<_> = self.parts(roots, factor, x).zip(below).collect();
        tasks.into_par_iter().for_each(|((root, l, x), below)| self.backward(root, below, l, x));
    }

    fn backward<T: Scalar, X: Unknown<T>>(
        &self,
        root: usize,
        below: Below<X>,
        factor: &[T],
        x: &mut [X],
    ) {
        let s = &self.supernodes[root];
        if factor.len() < TASK {
            return self.backward_in_order(root, below, factor, x);
        }
        let (inner, own) = factor.split_at(factor.len() - s.values.len());
        let (x_inner, x_own) = x.split_at_mut(x.len() - s.width());
        let handed_down = self.backward_front(s, own, x_own, below);
        self.backward_all(&s.children, handed_down, inner, x_inner);
    }

    fn backward_in_order<T: Scalar, X: Unknown<T>>(
        &self,
        root: usize,
        below: Below<X>,
        factor: &[T],
        x: &mut [X],
    ) {
        let mut waiting = vec![below];
        let each: Vec<usize> = (self.supernodes[root].first..=root).collect();
        let parts: Vec<_> = self.parts_of(&each, factor, x).collect();
        for (index, own, x) in parts.into_iter().rev() {
            let below = waiting.pop().expect("a parent comes before its children");
            waiting.extend(self.backward_front(&self.supernodes[index], own, x, below));
        }
    }

    /// Solves one front and returns the solution below each child.
    fn backward_front<T: Scalar, X: Unknown<T>>(
        &self,
        s: &Supernode,
        own: &[T],
        x: &mut [X],
        below: Below<X>,
    ) -> Vec<Below<X>> {
        let mut front = x.to_vec();
        front.extend(below);
        trapezoid::backward(s.front(own), &mut front);
        x.copy_from_slice(&front[..s.width()]);
        let known = |&place: &u32| front[place as usize];
        let one = |&child: &usize| self.supernodes[child].places.iter().map(known).collect();
        s.children.iter().map(one).collect()
    }

    /// The parts of disjoint subtrees.
    fn parts<'a, T, X>(
        &'a self,
        roots: &'a [usize],
        factor: &'a [T],
        x: &'a mut [X],
    ) -> impl Iterator<Item = (usize, &'a [T], &'a mut [X])> {
        let size = |root: usize| {
            let (last, first) =
                (&self.supernodes[root], &self.supernodes[self.supernodes[root].first]);
            (last.values.end - first.values.start, last.columns.end - first.columns.start)
        };
        split(roots.iter().map(move |&root| (root, size(root))), factor, x)
    }

    /// The parts of consecutive supernodes.
    fn parts_of<'a, T, X>(
        &'a self,
        each: &'a [usize],
        factor: &'a [T],
        x: &'a mut [X],
    ) -> impl Iterator<Item = (usize, &'a [T], &'a mut [X])> {
        let size = |s: &Supernode| (s.values.len(), s.width());
        split(each.iter().map(move |&s| (s, size(&self.supernodes[s]))), factor, x)
    }
}

/// Cuts parts of given lengths off a factor and a vector.
fn split<'a, T, X>(
    sizes: impl Iterator<Item = (usize, (usize, usize))>,
    mut factor: &'a [T],
    mut x: &'a mut [X],
) -> impl Iterator<Item = (usize, &'a [T], &'a mut [X])> {
    sizes.map(move |(index, (values, columns))| {
        let (own, others) = factor.split_at(values);
        let (x_own, x_others) = std::mem::take(&mut x).split_at_mut(columns);
        (factor, x) = (others, x_others);
        (index, own, x_own)
    })
}
