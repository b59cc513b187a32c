//! Fill-reducing ordering of the node graph by METIS nested dissection.
//!
//! Source: Karypis and Kumar 1998, "A fast and high quality multilevel scheme
//! for partitioning irregular graphs", doi:10.1137/S1064827595287997.

use std::sync::{Mutex, PoisonError};

/// METIS draws its random numbers from the `rand` of the C library, which all threads share and which each call
/// seeds: of two calls at a time, neither order could be had again.
static ONE_AT_A_TIME: Mutex<()> = Mutex::new(());

/// Nested-dissection order of an undirected graph in adjacency form without
/// self-loops: `order[i]` is the vertex eliminated at position `i`. It depends on the graph alone.
///
/// # Panics
/// When METIS reports an error, which it does only for a malformed graph or
/// when memory runs out.
pub fn nested_dissection(adjacency: &[Vec<usize>]) -> Vec<usize> {
    let n = adjacency.len();
    if n < 2 {
        return (0..n).collect();
    }
    let index = |i: usize| i32::try_from(i).expect("METIS takes up to 2^31 - 1 graph edges");
    let mut offsets = vec![0_i32];
    let mut neighbours = Vec::new();
    for row in adjacency {
        neighbours.extend(row.iter().map(|&j| index(j)));
        offsets.push(index(neighbours.len()));
    }
    let (mut order, mut position) = (vec![0_i32; n], vec![0_i32; n]);
    let mut count = index(n);
    let alone = ONE_AT_A_TIME.lock().unwrap_or_else(PoisonError::into_inner);
    // SAFETY: all pointers are to live buffers of the lengths METIS documents:
    // n + 1 offsets, offsets[n] neighbours, n entries for both results; null
    // asks for unit weights and default options.
    #[allow(unsafe_code)]
    let status = unsafe {
        metis_sys::METIS_NodeND(
            &raw mut count,
            offsets.as_mut_ptr(),
            neighbours.as_mut_ptr(),
            std::ptr::null_mut(),
            std::ptr::null_mut(),
            order.as_mut_ptr(),
            position.as_mut_ptr(),
        )
    };
    drop(alone);
    assert!(status == metis_sys::rstatus_et_METIS_OK, "METIS failed with status {status}");
    order
        .into_iter()
        .map(|i| usize::try_from(i).expect("METIS indices are from 0 to n - 1"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid has many separators that are as good as each other.
    #[test]
    fn orders_made_at_the_same_time_are_the_same() {
        let side = 12;
        let at = |x: usize, y: usize, z: usize| x + side * (y + side * z);
        let mut grid = vec![Vec::new(); side.pow(3)];
        let mut join = |a: usize, b: usize| {
            grid[a].push(b);
            grid[b].push(a);
        };
        for (z, y, x) in
            (0..side).flat_map(|z| (0..side).flat_map(move |y| (1..side).map(move |x| (z, y, x))))
        {
            join(at(x - 1, y, z), at(x, y, z));
            join(at(y, x - 1, z), at(y, x, z));
            join(at(y, z, x - 1), at(y, z, x));
        }
        let alone = nested_dissection(&grid);
        let orders = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..4)
                .map(|_| scope.spawn(|| (0..5).map(|_| nested_dissection(&grid)).collect()))
                .collect();
            threads
                .into_iter()
                .flat_map(|t| -> Vec<_> { t.join().expect("no panic") })
                .collect::<Vec<_>>()
        });
        assert!(orders.iter().all(|order| *order == alone));
    }
}
