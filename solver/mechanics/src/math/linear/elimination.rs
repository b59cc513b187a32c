//! The elimination tree of a sparse symmetric matrix, in postorder.
//!
//! Sources: Liu 1990, "The role of elimination trees in sparse factorization",
//! doi:10.1137/0611010; Davis, "Direct Methods for Sparse Linear Systems", ch. 4.

use super::scalar::narrow;

/// Stands for "no column".
const NONE: usize = usize::MAX;

/// An order of elimination with the same fill as `order`, in which the columns
/// of every subtree of the elimination tree follow one another, so that
/// disjoint subtrees own disjoint ranges of the factor. The pattern is a lower
/// triangle in compressed columns; `order[i]` is the unknown at position i.
pub fn postordered(column_start: &[usize], rows: &[usize], order: &[usize]) -> Vec<usize> {
    let parent = parents(&earlier_neighbours(column_start, rows, order));
    postorder(&parent).into_iter().map(|position| order[position]).collect()
}

/// For each position the neighbours that are eliminated before it, as
/// compressed rows.
fn earlier_neighbours(
    column_start: &[usize],
    rows: &[usize],
    order: &[usize],
) -> (Vec<usize>, Vec<u32>) {
    let n = order.len();
    let mut position = vec![0; n];
    for (i, &unknown) in order.iter().enumerate() {
        position[unknown] = i;
    }
    let pairs = || {
        (0..n).flat_map(|c| {
            let entries = &rows[column_start[c]..column_start[c + 1]];
            let at = position[c];
            let position = &position;
            entries.iter().map(move |&r| (position[r].max(at), position[r].min(at)))
        })
    };
    let mut start = vec![0; n + 1];
    for (later, earlier) in pairs() {
        start[later + 1] += usize::from(later != earlier);
    }
    for i in 0..n {
        start[i + 1] += start[i];
    }
    let mut next = start.clone();
    let mut neighbours = vec![0; start[n]];
    for (later, earlier) in pairs() {
        if later != earlier {
            neighbours[next[later]] = narrow(earlier);
            next[later] += 1;
        }
    }
    (start, neighbours)
}

/// Parent of each column in the elimination tree: the first later column that
/// its elimination reaches.
fn parents((start, neighbours): &(Vec<usize>, Vec<u32>)) -> Vec<usize> {
    let n = start.len() - 1;
    let mut parent = vec![NONE; n];
    // a shortcut to the root found so far
    let mut ancestor = vec![NONE; n];
    for column in 0..n {
        for &neighbour in &neighbours[start[column]..start[column + 1]] {
            let mut at = neighbour as usize;
            while ancestor[at] != NONE && ancestor[at] != column {
                at = std::mem::replace(&mut ancestor[at], column);
            }
            if ancestor[at] == NONE {
                ancestor[at] = column;
                parent[at] = column;
            }
        }
    }
    parent
}

/// Positions in an order in which children come right before their parents.
fn postorder(parent: &[usize]) -> Vec<usize> {
    let n = parent.len();
    // lists of children, each in ascending order
    let (mut first, mut sibling) = (vec![NONE; n], vec![NONE; n]);
    for column in (0..n).rev().filter(|&c| parent[c] != NONE) {
        sibling[column] = first[parent[column]];
        first[parent[column]] = column;
    }
    let mut order = Vec::with_capacity(n);
    let mut path = Vec::new();
    for root in (0..n).filter(|&c| parent[c] == NONE) {
        path.push(root);
        while let Some(&column) = path.last() {
            if first[column] == NONE {
                order.push(column);
                path.pop();
            } else {
                path.push(std::mem::replace(&mut first[column], NONE));
            }
            // a column that was finished hands over to its sibling
            if order.last() == Some(&column) && sibling[column] != NONE {
                path.push(sibling[column]);
            }
        }
    }
    order
}
