//! Wide vector instructions where the machine has them.

/// Work that gains from wide vectors. Its implementation of `run` has to be
/// marked `#[inline(always)]`, and so has what is to gain in the functions it
/// calls: only code inlined into [`widest`] is compiled for them.
pub trait Wide {
    /// What comes out.
    type Output;
    /// Does the work.
    fn run(self) -> Self::Output;
}

struct Dispatched<T>(T);

impl<T: Wide> pulp::NullaryFnOnce for Dispatched<T> {
    type Output = T::Output;

    #[inline(always)]
    fn call(self) -> T::Output {
        self.0.run()
    }
}

/// Does the work with the widest vectors of this machine. No bit of a result
/// changes: nothing is fused or reordered.
pub fn widest<T: Wide>(work: T) -> T::Output {
    pulp::Arch::new().dispatch(Dispatched(work))
}
