//! Symbolic factorisation by groups of unknowns.
//!
//! Unknowns that are coupled with each other and with the same others, as the displacements
//! of a node are, count as one: the graph of the nodes has a ninth of the entries.

use std::ops::Range;

use faer::Side;
use faer::perm::PermRef;
use faer::sparse::SymbolicSparseColMatRef;
use faer::sparse::linalg::cholesky::{
    CholeskySymbolicParams, SymbolicCholesky, SymbolicCholeskyRaw, SymmetricOrdering,
    factorize_symbolic_cholesky,
};
use faer::sparse::linalg::{SupernodalThreshold, SymbolicSupernodalParams};

use super::elimination;
use super::matrix::Triangle;

/// The order of elimination and the structure of the factor.
pub struct Symbolic {
    /// The unknown at each position, such that subtrees of the elimination tree are contiguous.
    pub order: Vec<usize>,
    /// Positions of the columns of each supernode, and of its rows below these, ascending.
    pub supernodes: Vec<(Range<usize>, Vec<usize>)>,
}

/// Symbolic factorisation of a lower triangle, whose unknowns are eliminated
/// group by group: up to changes that leave the fill alone, in the order given.
pub fn symbolic(pattern: &Triangle, groups: &[Range<usize>]) -> Symbolic {
    let (start, entries, ids) = quotient(pattern, groups);
    let mut members = vec![0..0; groups.len()];
    groups.iter().zip(&ids).for_each(|(group, &id)| members[id] = group.clone());
    let order = elimination::postordered(&start, &entries, &ids);
    let mean_size = pattern.size().div_ceil(groups.len().max(1)).max(1);
    let factor = factor_structure(&start, &entries, &order, mean_size);

    let mut first = vec![0];
    let mut unknowns = Vec::with_capacity(pattern.size());
    for &id in &order {
        unknowns.extend(members[id].clone());
        first.push(unknowns.len());
    }
    let supernodes = match factor.raw() {
        SymbolicCholeskyRaw::Supernodal(s) => (0..s.n_supernodes())
            .map(|k| {
                let columns = first[s.supernode_begin()[k]]..first[s.supernode_end()[k]];
                let below = s.supernode(k).pattern().iter();
                (columns, below.flat_map(|&g| first[g]..first[g + 1]).collect())
            })
            .collect(),
        // forced out by the threshold, unless there are no unknowns
        SymbolicCholeskyRaw::Simplicial(_) => Vec::new(),
    };
    Symbolic { order: unknowns, supernodes }
}

/// Groups of one unknown each, for [`super::SparseSolver::new`].
pub fn one_by_one(order: &[usize]) -> Vec<Range<usize>> {
    order.iter().map(|&unknown| unknown..unknown + 1).collect()
}

/// Supernodes up to these numbers of columns take in a child if these parts of their entries
/// are zeros at most; faer's numbers.
const RELAX: [(usize, f64); 4] = [(4, 1.0), (16, 0.8), (48, 0.1), (usize::MAX, 0.05)];

/// faer's symbolic factorisation with the group `order[i]` at position i, where groups have
/// `mean_size` unknowns.
pub fn factor_structure(
    column_start: &[usize],
    rows: &[usize],
    order: &[usize],
    mean_size: usize,
) -> SymbolicCholesky<usize> {
    let n = order.len();
    let mut position = vec![0; n];
    order.iter().enumerate().for_each(|(i, &unknown)| position[unknown] = i);
    let relax = RELAX.map(|(columns, zeros)| (columns / mean_size, zeros));
    factorize_symbolic_cholesky(
        SymbolicSparseColMatRef::new_checked(n, n, column_start, None, rows),
        Side::Lower,
        SymmetricOrdering::Custom(PermRef::new_checked(order, &position, n)),
        CholeskySymbolicParams {
            supernodal_flop_ratio_threshold: SupernodalThreshold::FORCE_SUPERNODAL,
            supernodal_params: SymbolicSupernodalParams { relax: Some(&relax) },
            ..CholeskySymbolicParams::default()
        },
    )
    .expect("memory for the symbolic factorisation")
}

/// The lower triangle of the graph of the groups, in compressed columns, and the number that
/// each group has in it.
fn quotient(pattern: &Triangle, groups: &[Range<usize>]) -> (Vec<usize>, Vec<usize>, Vec<usize>) {
    let Triangle { column_start, rows, .. } = pattern;
    let n = pattern.size();
    let mut by_first: Vec<usize> = (0..groups.len()).collect();
    by_first.sort_unstable_by_key(|&g| groups[g].start);
    let mut ids = vec![0; groups.len()];
    // the group of each unknown that is the first of one
    let mut led = vec![None; n];
    let mut next = 0;
    for (id, &g) in by_first.iter().enumerate() {
        assert_eq!(groups[g].start, next, "each unknown is in one group");
        (ids[g], led[next], next) = (id, Some(id), groups[g].end);
    }
    assert_eq!(next, n, "each unknown is in one group");

    let (mut start, mut entries) = (vec![0], Vec::new());
    let mut covered = 0;
    for &g in &by_first {
        let Range { start: first, end } = groups[g];
        let column = &rows[column_start[first]..column_start[first + 1]];
        entries.extend(column.iter().filter_map(|&row| led[row as usize]));
        // the columns of a group end with the same rows
        covered += (0..end - first).map(|k| column.len() - k).sum::<usize>();
        start.push(entries.len());
    }
    assert_eq!(covered, rows.len(), "unknowns of a group have the same neighbours");
    (start, entries, ids)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    #[should_panic(expected = "the same neighbours")]
    fn a_group_of_unlike_unknowns_is_refused() {
        let pattern = Triangle::new(vec![0, 2, 4, 5], &[0, 1, 1, 2, 2]);
        let _ = symbolic(&pattern, &[0..2, 2..3]);
    }
}
