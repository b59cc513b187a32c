//! Which elements meet at a node: sums over elements in parallel over the nodes.

use std::ops::Range;

use mesh::Vec3;
use rayon::prelude::*;

use super::at;

/// Nodes that one task sums up.
const NODES: usize = 1024;

/// Where each node stands in the list of the elements' nodes.
#[derive(Debug, Default)]
pub struct Incidence {
    /// First place of each node among `places`, and their number.
    start: Vec<u32>,
    /// Places in the list of the elements' nodes, ascending for each node.
    places: Vec<u32>,
}

impl Incidence {
    /// Incidence for the nodes of all elements, one after the other.
    pub fn new(node_count: usize, element_nodes: &[usize]) -> Self {
        let narrow = |i: usize| u32::try_from(i).expect("less than 2^32 nodes of elements");
        let mut start = vec![0; node_count + 1];
        element_nodes.iter().for_each(|&node| start[node + 1] += 1);
        for node in 0..node_count {
            start[node + 1] += start[node];
        }
        let mut next = start.clone();
        let mut places = vec![0; element_nodes.len()];
        for (place, &node) in element_nodes.iter().enumerate() {
            places[next[node] as usize] = narrow(place);
            next[node] += 1;
        }
        Self { start, places }
    }

    /// Adds what is given for consecutive places to the components of their nodes; to each
    /// in the order of the elements.
    pub fn add(&self, places: Range<usize>, given: &[Vec3], out: &mut [f64]) {
        out.par_chunks_mut(3 * NODES).enumerate().for_each(|(part, out)| {
            for (i, out) in out.chunks_exact_mut(3).enumerate() {
                let node = part * NODES + i;
                let own = self.start[node] as usize..self.start[node + 1] as usize;
                let own = self.places[own].iter().map(|&place| place as usize);
                let mut sum = at(out, 0);
                for place in own.filter(|place| places.contains(place)) {
                    sum += given[place - places.start];
                }
                out.copy_from_slice(sum.as_slice());
            }
        });
    }
}
