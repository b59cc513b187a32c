//! Symmetric matrices of 3×3 node blocks with a fixed sparsity pattern.

use std::ops::Range;

use rayon::prelude::*;

/// The blocks (row ≥ column) that elements couple, and where each element's
/// blocks are among them.
pub struct Pattern {
    nodes_per_element: usize,
    node_count: usize,
    /// First block of each block column.
    column_start: Vec<usize>,
    /// Block row of each block, ascending within a column.
    rows: Vec<usize>,
    /// For each element its local pairs (a, b ≤ a): block index, and whether
    /// the local block must be transposed to lie in the lower triangle.
    slots: Vec<(u32, bool)>,
}

/// Number of local pairs (a, b ≤ a) of an element.
#[must_use]
pub fn pair_count(nodes: usize) -> usize {
    nodes * (nodes + 1) / 2
}

/// Index of the local pair (a, b ≤ a).
#[must_use]
pub fn pair_index(a: usize, b: usize) -> usize {
    debug_assert!(b <= a);
    a * (a + 1) / 2 + b
}

impl Pattern {
    /// The pattern of elements given as one flat list of node ids, and of further
    /// pairs of nodes.
    ///
    /// # Panics
    /// When there are 2³² blocks or more.
    #[must_use]
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
        let mut column_start = vec![0];
        let mut rows = Vec::new();
        for column in &mut columns {
            column.sort_unstable();
            column.dedup();
            rows.append(column);
            column_start.push(rows.len());
        }
        let mut pattern =
            Self { nodes_per_element, node_count, column_start, rows, slots: Vec::new() };
        for element in elements.chunks_exact(nodes_per_element) {
            for a in 0..nodes_per_element {
                for b in 0..=a {
                    let (row, column) = (element[a].max(element[b]), element[a].min(element[b]));
                    let block = u32::try_from(pattern.block(row, column)).expect("< 2^32 blocks");
                    pattern.slots.push((block, element[a] < element[b]));
                }
            }
        }
        pattern
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
    #[must_use]
    pub fn has(&self, a: usize, b: usize) -> bool {
        self.find(a.max(b), a.min(b)).is_some()
    }

    /// Number of blocks.
    #[must_use]
    pub fn block_count(&self) -> usize {
        self.rows.len()
    }

    /// Neighbours of each node, without the node itself.
    #[must_use]
    pub fn adjacency(&self) -> Vec<Vec<usize>> {
        let mut adjacency = vec![Vec::new(); self.node_count];
        for column in 0..self.node_count {
            for &row in &self.rows[self.column_start[column]..self.column_start[column + 1]] {
                if row != column {
                    adjacency[column].push(row);
                    adjacency[row].push(column);
                }
            }
        }
        adjacency
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
    #[must_use]
    pub fn zeros(pattern: &'a Pattern) -> Self {
        Self { pattern, blocks: vec![[0.0; 9]; pattern.rows.len()] }
    }

    /// Adds the lower blocks of consecutive elements, given in consecutive
    /// parts and laid out by [`pair_index`].
    pub fn add_elements(&mut self, elements: Range<usize>, parts: &[Vec<[f64; 9]>]) {
        let pairs = pair_count(self.pattern.nodes_per_element);
        let slots = &self.pattern.slots[elements.start * pairs..elements.end * pairs];
        // every task owns a range of blocks and looks through all elements
        let share = self.blocks.len().div_ceil(2 * rayon::current_num_threads()).max(1);
        self.blocks.par_chunks_mut(share).enumerate().for_each(|(i, own)| {
            for (&(slot, transpose), block) in slots.iter().zip(parts.iter().flatten()) {
                let Some(target) = (slot as usize).checked_sub(i * share) else { continue };
                let Some(target) = own.get_mut(target) else { continue };
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

    /// y_i = Σ_j |A_ij| |x_j| over all nodes.
    #[must_use]
    pub fn multiply_magnitudes(&self, x: &[f64]) -> Vec<f64> {
        let blocks = self.blocks.iter().map(|block| block.map(f64::abs)).collect();
        let x: Vec<f64> = x.iter().map(|x| x.abs()).collect();
        BlockMatrix { pattern: self.pattern, blocks }.multiply(&x)
    }

    /// y = A x over all nodes.
    #[must_use]
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

/// The lower triangle of the free degrees of freedom in compressed columns,
/// and where its values come from.
pub struct FreeTriangle {
    /// First entry of each column.
    pub column_start: Vec<usize>,
    /// Row of each entry.
    pub rows: Vec<usize>,
    /// Index into the flat block values of each entry.
    source: Vec<u32>,
    /// Degree of freedom of each free unknown.
    pub dof: Vec<usize>,
}

impl FreeTriangle {
    /// The part of a pattern on the degrees of freedom where `fixed` is false.
    #[must_use]
    pub fn new(pattern: &Pattern, fixed: &[bool]) -> Self {
        let dof: Vec<usize> = (0..fixed.len()).filter(|&d| !fixed[d]).collect();
        let mut index = vec![None; fixed.len()];
        for (i, &d) in dof.iter().enumerate() {
            index[d] = Some(i);
        }
        let mut triangle =
            Self { column_start: vec![0], rows: Vec::new(), source: Vec::new(), dof };
        for c in 0..triangle.dof.len() {
            let (column, j) = (triangle.dof[c] / 3, triangle.dof[c] % 3);
            for k in pattern.column_start[column]..pattern.column_start[column + 1] {
                let row = pattern.rows[k];
                for i in 0..3 {
                    let d = 3 * row + i;
                    if d >= triangle.dof[c]
                        && let Some(r) = index[d]
                    {
                        triangle.rows.push(r);
                        let source = u32::try_from(9 * k + 3 * i + j);
                        triangle.source.push(source.expect("< 2^32 entries"));
                    }
                }
            }
            triangle.column_start.push(triangle.rows.len());
        }
        triangle
    }

    /// The values of a matrix in the order of the entries.
    #[must_use]
    pub fn gather(&self, matrix: &BlockMatrix) -> Vec<f64> {
        let flat = matrix.blocks.as_flattened();
        let mut values = vec![0.0; self.source.len()];
        let parts = values.par_chunks_mut(1 << 14).zip(self.source.par_chunks(1 << 14));
        parts.for_each(|(values, source)| {
            values.iter_mut().zip(source).for_each(|(v, &s)| *v = flat[s as usize]);
        });
        values
    }
}
