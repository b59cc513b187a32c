//! Symmetric matrices of 3×3 node blocks with a fixed sparsity pattern.

use std::ops::Range;

use rayon::prelude::*;

pub use super::followers::Followers;
use super::followers::Masters;

/// The blocks (row ≥ column) that elements couple, and where each element's
/// blocks are among them.
pub struct Pattern {
    nodes_per_element: usize,
    node_count: usize,
    /// First block of each block column.
    column_start: Vec<usize>,
    /// Block row of each block, ascending within a column.
    rows: Vec<usize>,
    scatter: Scatter,
}

/// Elements whose pairs are sorted together, so that one task adds those of one part of
/// the blocks without a look at the others.
const GROUP: usize = 256;
/// Parts of the blocks, of equal length.
const PARTS: usize = 16;

/// Where the local pairs (a, b ≤ a) of elements are among the blocks: sorted by groups of
/// elements, by parts of the blocks, then by elements.
struct Scatter {
    /// First pair of each group and part.
    start: Vec<usize>,
    /// Which pair of the group: element times number of pairs, plus index.
    pair: Vec<u32>,
    /// Twice the index of its block, plus 1 where the local block must be transposed to
    /// lie in the lower triangle.
    target: Vec<u32>,
}

impl Scatter {
    /// The places of the pairs of elements by their targets, for a number of blocks.
    fn new(targets: &[u32], pairs: usize, blocks: usize) -> Self {
        let part_len = part_len(blocks);
        let part = |target: u32| (target >> 1) as usize / part_len;
        let sort = |group: &[u32]| {
            let mut lists: [Vec<u32>; PARTS] = Default::default();
            for (i, &target) in group.iter().enumerate() {
                lists[part(target)].push(u32::try_from(i).expect("< 2^32 pairs"));
            }
            lists
        };
        let sorted: Vec<_> = targets.par_chunks(GROUP * pairs).map(sort).collect();
        let mut scatter = Self { start: vec![0], pair: Vec::new(), target: Vec::new() };
        for (group, lists) in targets.chunks(GROUP * pairs).zip(sorted) {
            for list in lists {
                scatter.target.extend(list.iter().map(|&i| group[i as usize]));
                scatter.pair.extend(list);
                scatter.start.push(scatter.pair.len());
            }
        }
        scatter
    }

    /// Pairs and targets of a group in a part of the blocks.
    fn of(&self, group: usize, part: usize) -> impl Iterator<Item = (usize, u32)> {
        let range = self.start[group * PARTS + part]..self.start[group * PARTS + part + 1];
        let pairs = self.pair[range.clone()].iter().map(|&pair| pair as usize);
        pairs.zip(self.target[range].iter().copied())
    }
}

fn part_len(blocks: usize) -> usize {
    blocks.div_ceil(PARTS).max(1)
}

/// Number of local pairs (a, b ≤ a) of an element.
pub const fn pair_count(nodes: usize) -> usize {
    nodes * (nodes + 1) / 2
}

/// Index of the local pair (a, b ≤ a).
pub fn pair_index(a: usize, b: usize) -> usize {
    debug_assert!(b <= a);
    a * (a + 1) / 2 + b
}

impl Pattern {
    /// The pattern of elements given as one flat list of node ids, and of further
    /// pairs of nodes.
    pub fn new(
        node_count: usize,
        elements: &[usize],
        nodes_per_element: usize,
        couplings: &[[usize; 2]],
    ) -> Self {
        let mut columns: Vec<Vec<usize>> = vec![Vec::new(); node_count];
        for &[a, b] in couplings {
            columns[a.min(b)].push(a.max(b));
        }
        for element in elements.chunks_exact(nodes_per_element) {
            for &b in element {
                columns[b].extend(element.iter().copied().filter(|&a| a >= b));
            }
        }
        columns.par_iter_mut().for_each(|column| {
            column.sort_unstable();
            column.dedup();
        });
        let mut column_start = vec![0];
        let mut rows = Vec::with_capacity(columns.iter().map(Vec::len).sum());
        for column in &mut columns {
            rows.append(column);
            column_start.push(rows.len());
        }
        let find = |row: usize, column: usize| {
            let range = column_start[column]..column_start[column + 1];
            let offset = rows[range.clone()].binary_search(&row).expect("an element couples them");
            u32::try_from(2 * (range.start + offset)).expect("< 2^31 blocks")
        };
        let targets_of = |element: &[usize], targets: &mut [u32]| {
            let pairs = (0..nodes_per_element).flat_map(|a| (0..=a).map(move |b| (a, b)));
            for (target, (a, b)) in targets.iter_mut().zip(pairs) {
                let (row, column) = (element[a].max(element[b]), element[a].min(element[b]));
                *target = find(row, column) + u32::from(element[a] < element[b]);
            }
        };
        let pairs = pair_count(nodes_per_element);
        let mut targets = vec![0; elements.len() / nodes_per_element * pairs];
        elements
            .par_chunks_exact(nodes_per_element)
            .zip(targets.par_chunks_exact_mut(pairs))
            .with_min_len(GROUP)
            .for_each(|(element, targets)| targets_of(element, targets));
        let scatter = Scatter::new(&targets, pairs, rows.len());
        Self { nodes_per_element, node_count, column_start, rows, scatter }
    }

    /// Index of the block (row ≥ column), which must be in the pattern.
    fn block(&self, row: usize, column: usize) -> usize {
        self.find(row, column).expect("the two nodes are coupled")
    }

    fn find(&self, row: usize, column: usize) -> Option<usize> {
        let range = self.column_start[column]..self.column_start[column + 1];
        let offset = self.rows[range.clone()].binary_search(&row).ok()?;
        Some(range.start + offset)
    }

    /// Whether two nodes are coupled.
    pub fn has(&self, a: usize, b: usize) -> bool {
        self.find(a.max(b), a.min(b)).is_some()
    }

    /// Pairs of nodes (row > column) that blocks of followers couple, once these are their masters.
    pub fn images(&self, followers: &Followers) -> Vec<[usize; 2]> {
        let mut images = Vec::new();
        for (_, row, column) in self.blocks_of(followers) {
            let [rows, columns] = [row, column].map(|node| followers.masters(node));
            for (j, _) in rows.each() {
                images.extend(columns.each().map(|(k, _)| [j.max(k), j.min(k)]));
            }
        }
        images.retain(|[a, b]| a != b);
        images.sort_unstable();
        images.dedup();
        images
    }

    /// Index, row and column of the blocks that a follower has a part in.
    fn blocks_of<'a>(
        &'a self,
        followers: &'a Followers,
    ) -> impl Iterator<Item = (usize, usize, usize)> + 'a {
        let columns = 0..if followers.is_empty() { 0 } else { self.node_count };
        columns.flat_map(move |column| {
            let own = self.column_start[column]..self.column_start[column + 1];
            let blocks = own.map(move |block| (block, self.rows[block], column));
            blocks.filter(move |(_, row, _)| followers.has(*row) || followers.has(column))
        })
    }

    /// Number of blocks.
    pub fn block_count(&self) -> usize {
        self.rows.len()
    }
}

/// A symmetric matrix on a [`Pattern`]; only blocks with row ≥ column are held.
pub struct BlockMatrix<'a> {
    pattern: &'a Pattern,
    /// Row-major 3×3 blocks.
    blocks: Vec<[f64; 9]>,
}

impl<'a> BlockMatrix<'a> {
    /// The zero matrix.
    pub fn zeros(pattern: &'a Pattern) -> Self {
        Self::zeros_in(pattern, Vec::new())
    }

    /// The zero matrix in the memory of an earlier one, from [`Self::into_memory`].
    pub fn zeros_in(pattern: &'a Pattern, mut memory: Vec<[f64; 9]>) -> Self {
        let zeros = rayon::iter::repeat_n([0.0; 9], pattern.rows.len());
        zeros.with_min_len(1 << 14).collect_into_vec(&mut memory);
        Self { pattern, blocks: memory }
    }

    /// The memory, for the next matrix.
    pub fn into_memory(self) -> Vec<[f64; 9]> {
        self.blocks
    }

    /// Adds the lower blocks of consecutive elements, given in consecutive
    /// parts and laid out by [`pair_index`].
    pub fn add_elements(&mut self, elements: Range<usize>, parts: &[&[[f64; 9]]]) {
        self.add_pairs(elements, parts, |target, block, transpose| {
            if transpose {
                for i in 0..3 {
                    for j in 0..3 {
                        target[3 * i + j] += block[3 * j + i];
                    }
                }
            } else {
                for (t, b) in target.iter_mut().zip(block) {
                    *t += b;
                }
            }
        });
    }

    /// Adds blocks as [`Self::add_elements`] does, which are multiples of the identity and are
    /// given by their factors.
    pub fn add_multiples_of_identity(&mut self, elements: Range<usize>, parts: &[&[f64]]) {
        self.add_pairs(elements, parts, |target, factor, _| {
            for i in [0, 4, 8] {
                target[i] += factor;
            }
        });
    }

    /// Calls `add` with the block of each pair of consecutive elements, with what is given
    /// for the pair, and with whether that is to be transposed; of each block in the order
    /// of the elements. The parts but the last are of equal length.
    fn add_pairs<B: Sync>(
        &mut self,
        elements: Range<usize>,
        parts: &[&[B]],
        add: impl Fn(&mut [f64; 9], &B, bool) + Sync,
    ) {
        let pairs = pair_count(self.pattern.nodes_per_element);
        let Some(part_pairs) = parts.first().map(|part| part.len()) else { return };
        let (scatter, share) = (&self.pattern.scatter, part_len(self.blocks.len()));
        let wanted = elements.start * pairs..elements.end * pairs;
        self.blocks.par_chunks_mut(share).enumerate().for_each(|(own, blocks)| {
            for group in elements.start / GROUP..elements.end.div_ceil(GROUP) {
                let first = group * GROUP * pairs;
                for (pair, target) in scatter.of(group, own) {
                    if !wanted.contains(&(first + pair)) {
                        continue;
                    }
                    let at = first + pair - wanted.start;
                    let given = &parts[at / part_pairs][at % part_pairs];
                    let block = &mut blocks[(target >> 1) as usize - own * share];
                    add(block, given, target & 1 == 1);
                }
            }
        });
    }

    /// Adds the block of the node pair (`row`, `column`); pairs in the upper
    /// triangle are taken to be the transposes of their mirror images and left
    /// out.
    pub fn add_lower(&mut self, row: usize, column: usize, block: &crate::math::tensor::Mat3) {
        if row < column {
            return;
        }
        let target = &mut self.blocks[self.pattern.block(row, column)];
        for i in 0..3 {
            for j in 0..3 {
                target[3 * i + j] += block[(i, j)];
            }
        }
    }

    /// Adds the blocks of all pairs of some nodes, row by row, as [`Self::add_lower`] does.
    pub fn add_dense(&mut self, nodes: &[usize], blocks: &[crate::math::tensor::Mat3]) {
        for (&row, blocks) in nodes.iter().zip(blocks.chunks_exact(nodes.len())) {
            for (&column, block) in nodes.iter().zip(blocks) {
                self.add_lower(row, column, block);
            }
        }
    }

    /// Tᵀ A T on the nodes that follow none: the blocks of followers are added to those of their masters,
    /// which the pattern must have, and are not used any more.
    pub fn fold(&mut self, followers: &Followers) {
        for (block, row, column) in self.pattern.blocks_of(followers) {
            let values = self.blocks[block];
            let [rows, columns] = [row, column].map(|node| followers.masters(node));
            self.add_images(&values, &rows, &columns);
            if row != column {
                self.add_images(&transposed(&values), &columns, &rows);
            }
        }
    }

    /// Adds a block times the weights of its masters where that lies in the lower triangle.
    fn add_images(&mut self, values: &[f64; 9], rows: &Masters, columns: &Masters) {
        for (j, b_j) in rows.each() {
            for (k, b_k) in columns.each().filter(|(k, _)| *k <= j) {
                let target = &mut self.blocks[self.pattern.block(j, k)];
                target.iter_mut().zip(values).for_each(|(t, v)| *t += b_j * b_k * v);
            }
        }
    }

    /// y_i = Σ_j |A_ij| |x_j| over all nodes.
    pub fn multiply_magnitudes(&self, x: &[f64]) -> Vec<f64> {
        let blocks = self.blocks.iter().map(|block| block.map(f64::abs)).collect();
        let x: Vec<f64> = x.iter().map(|x| x.abs()).collect();
        BlockMatrix { pattern: self.pattern, blocks }.multiply(&x)
    }

    /// y = A x over all nodes.
    pub fn multiply(&self, x: &[f64]) -> Vec<f64> {
        let mut y = vec![0.0; x.len()];
        for column in 0..self.pattern.node_count {
            for k in self.pattern.column_start[column]..self.pattern.column_start[column + 1] {
                let (row, block) = (self.pattern.rows[k], &self.blocks[k]);
                for i in 0..3 {
                    for j in 0..3 {
                        y[3 * row + i] += block[3 * i + j] * x[3 * column + j];
                        if row != column {
                            y[3 * column + j] += block[3 * i + j] * x[3 * row + i];
                        }
                    }
                }
            }
        }
        y
    }
}

fn transposed(block: &[f64; 9]) -> [f64; 9] {
    std::array::from_fn(|i| block[3 * (i % 3) + i / 3])
}

/// Where the values of the lower triangle of the free degrees of freedom come from.
pub struct FreeTriangle {
    /// Index into the flat block values of each entry.
    source: Vec<u32>,
    /// Degree of freedom of each free unknown.
    pub dof: Vec<usize>,
}

impl FreeTriangle {
    /// The part of a pattern on the degrees of freedom where `fixed` is false, with the
    /// first entry of each of its columns and the row of each entry.
    pub fn new(pattern: &Pattern, fixed: &[bool]) -> (Self, Vec<usize>, Vec<usize>) {
        let dof: Vec<usize> = (0..fixed.len()).filter(|&d| !fixed[d]).collect();
        let mut index = vec![None; fixed.len()];
        for (i, &d) in dof.iter().enumerate() {
            index[d] = Some(i);
        }
        let most = 9 * pattern.block_count();
        let (mut rows, mut sources) = (Vec::with_capacity(most), Vec::with_capacity(most));
        let mut column_start = vec![0];
        for &own in &dof {
            let (column, j) = (own / 3, own % 3);
            for k in pattern.column_start[column]..pattern.column_start[column + 1] {
                let row = pattern.rows[k];
                for i in 0..3 {
                    let d = 3 * row + i;
                    if d >= own
                        && let Some(r) = index[d]
                    {
                        rows.push(r);
                        let source = u32::try_from(9 * k + 3 * i + j);
                        sources.push(source.expect("< 2^32 entries"));
                    }
                }
            }
            column_start.push(rows.len());
        }
        (Self { source: sources, dof }, column_start, rows)
    }

    /// The values of a matrix in the order of the entries, written to a vector of any
    /// length.
    pub fn gather(&self, matrix: &BlockMatrix, values: &mut Vec<f64>) {
        let flat = matrix.blocks.as_flattened();
        let gathered = self.source.par_iter().with_min_len(1 << 14).map(|&s| flat[s as usize]);
        gathered.collect_into_vec(values);
    }
}
