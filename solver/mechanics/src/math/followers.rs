//! Nodes whose displacement is a sum of those of others: u_i = Σ_j b_ij u_j.

/// Nodes that follow others, their masters, which follow none.
#[derive(Clone, Debug, Default)]
pub struct Followers {
    /// Each follower with its masters and their weights b.
    each: Vec<(usize, Vec<(usize, f64)>)>,
    /// Place of each node among them; empty where none follows.
    place: Vec<Option<u32>>,
}

impl Followers {
    /// Some of a number of nodes, each with its masters and their weights.
    pub fn new(nodes: usize, each: Vec<(usize, Vec<(usize, f64)>)>) -> Self {
        let mut place = if each.is_empty() { Vec::new() } else { vec![None; nodes] };
        for (i, (node, _)) in each.iter().enumerate() {
            place[*node] = Some(u32::try_from(i).expect("< 2^32 nodes"));
        }
        Self { each, place }
    }

    /// Whether no node follows another.
    pub fn is_empty(&self) -> bool {
        self.each.is_empty()
    }

    /// Whether a node follows others.
    pub fn has(&self, node: usize) -> bool {
        self.place.get(node).is_some_and(Option::is_some)
    }

    /// The masters of a node with their weights; of one that follows none, itself.
    pub(super) fn masters(&self, node: usize) -> Masters<'_> {
        match self.place.get(node).copied().flatten() {
            Some(place) => Masters::Others(&self.each[place as usize].1),
            None => Masters::Itself(node),
        }
    }

    /// Tᵀ: adds what acts on followers to their masters, three components per node.
    pub fn add_to_masters(&self, full: &mut [f64]) {
        for (node, masters) in &self.each {
            let own = [0, 1, 2].map(|k| full[3 * node + k]);
            for (master, weight) in masters {
                (0..3).for_each(|k| full[3 * master + k] += weight * own[k]);
            }
        }
    }

    /// T: moves followers with their masters, three components per node.
    pub fn follow(&self, full: &mut [f64]) {
        for (node, masters) in &self.each {
            for k in 0..3 {
                let sum = masters.iter().map(|(master, weight)| weight * full[3 * master + k]);
                full[3 * node + k] = sum.sum();
            }
        }
    }
}

/// Masters with their weights.
pub(super) enum Masters<'a> {
    /// A node that follows none.
    Itself(usize),
    /// Those of a follower.
    Others(&'a [(usize, f64)]),
}

impl Masters<'_> {
    /// Each with its weight.
    pub fn each(&self) -> impl Iterator<Item = (usize, f64)> + Clone + '_ {
        let (own, others): (Option<usize>, &[(usize, f64)]) = match self {
            Self::Itself(node) => (Some(*node), &[]),
            Self::Others(masters) => (None, masters),
        };
        own.map(|node| (node, 1.0)).into_iter().chain(others.iter().copied())
    }
}
