//! Where the entries of A are added to the fronts.
//!
//! The displacements of a node follow one another in A and in the factor, and so do many of the
//! entries that they couple: these go by runs.

use super::matrix::Triangle;
use super::scalar::{Scalar, narrow};
use super::supernode::Supernode;

/// Entries of A one after the other that have places in one front.
#[derive(Clone, Copy, Default)]
pub struct Run {
    /// The first one among the values of A.
    entry: u32,
    /// Where the first one is added in the columns of the supernode.
    place: u32,
    len: u16,
    /// Whether they lie side by side in a row, not one below the other.
    across: bool,
}

impl Run {
    /// Adds the entries of A to the columns of their front.
    pub fn add<T: Scalar>(&self, a: &[f64], columns: &mut [T], height: usize) {
        let entries = &a[self.entry as usize..][..usize::from(self.len)];
        let step = if self.across { height } else { 1 };
        let places = columns[self.place as usize..].iter_mut().step_by(step);
        places.zip(entries).for_each(|(place, &a)| *place += T::narrow(a));
    }
}

/// A [`Run`] by the positions of its first entry in the factor.
#[derive(Clone, Copy, Default)]
struct Positions {
    entry: u32,
    row: u32,
    column: u32,
    len: u16,
    across: bool,
}

/// Sorts the entries of A by the supernode that they are added to, and tells each supernode which
/// runs are its own. `position[i]` is the position of the unknown i in the factor.
pub fn place_entries(
    supernodes: &mut [Supernode],
    of_column: &[usize],
    pattern: &Triangle,
    position: &[u32],
) -> Vec<Run> {
    let mut next = vec![0; supernodes.len() + 1];
    runs(pattern, position, of_column, |run| next[of_column[run.column as usize] + 1] += 1);
    for s in 0..supernodes.len() {
        next[s + 1] += next[s];
        supernodes[s].entries = next[s]..next[s + 1];
    }
    let mut sorted = vec![Positions::default(); next[supernodes.len()]];
    runs(pattern, position, of_column, |run| {
        let slot = &mut next[of_column[run.column as usize]];
        sorted[*slot] = run;
        *slot += 1;
    });
    let mut place = vec![0; position.len()];
    let mut placed = Vec::with_capacity(sorted.len());
    for s in supernodes {
        for (i, row) in s.columns.clone().chain(s.pattern.iter().copied()).enumerate() {
            place[row] = i;
        }
        for &Positions { entry, row, column, len, across } in &sorted[s.entries.clone()] {
            let column = column as usize - s.columns.start;
            let place = narrow(column * s.height() + place[row as usize]);
            placed.push(Run { entry, place, len, across });
        }
    }
    placed
}

/// Visits the entries of A by the longest runs.
fn runs(
    Triangle { column_start, rows, .. }: &Triangle,
    position: &[u32],
    of_column: &[usize],
    mut visit: impl FnMut(Positions),
) {
    for (c, &at) in position.iter().enumerate() {
        let entries = column_start[c]..column_start[c + 1];
        let Some(first) = entries.clone().next() else { continue };
        let start = |entry: usize| {
            let other = position[rows[entry] as usize];
            let across = other < at;
            Positions {
                entry: narrow(entry),
                row: other.max(at),
                column: other.min(at),
                len: 1,
                across,
            }
        };
        let mut run = start(first);
        for entry in entries.skip(1) {
            let other = position[rows[entry] as usize];
            let len = u32::from(run.len);
            let follows = if run.across {
                let own = |column: u32| of_column[column as usize];
                other == run.column + len && other < at && own(other) == own(run.column)
            } else {
                other == run.row + len
            };
            if follows && run.len < u16::MAX {
                run.len += 1;
            } else {
                visit(run);
                run = start(entry);
            }
        }
        visit(run);
    }
}
