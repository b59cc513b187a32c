//! Cubic cells as quadratic ones, for programs that know no others.

use std::collections::BTreeMap;

use super::{CellType, Field, Grid};

/// A cubic polynomial in the middle of an edge from its values at the ends and
/// at the thirds.
const MIDDLE: [f64; 4] = [-1.0 / 16.0, 9.0 / 16.0, 9.0 / 16.0, -1.0 / 16.0];

impl Grid {
    /// The quadratic grid with the same corners, and the middles of the edges
    /// where the cubic one has them; any other grid as it is. Nodes inside edges
    /// and faces remain as points without a cell.
    pub fn at_most_quadratic(&self) -> Self {
        if self.cell_type != CellType::Tet20 {
            return self.clone();
        }
        let mut lowered = Self { cell_type: CellType::Tet10, cells: Vec::new(), ..self.clone() };
        let mut middles: BTreeMap<[usize; 2], usize> = BTreeMap::new();
        for cell in self.cells.chunks_exact(CellType::Tet20.nodes()) {
            lowered.cells.extend(&cell[..4]);
            for (i, &[a, b]) in CellType::Tet20.edges().iter().enumerate() {
                let along = [cell[a], cell[4 + 2 * i], cell[5 + 2 * i], cell[b]];
                let key = [cell[a].min(cell[b]), cell[a].max(cell[b])];
                let middle = *middles.entry(key).or_insert_with(|| lowered.add_middle(along));
                lowered.cells.push(middle);
            }
        }
        lowered
    }

    /// Adds a point between four points of an edge, with its fields.
    fn add_middle(&mut self, along: [usize; 4]) -> usize {
        let mean = along.iter().zip(MIDDLE).map(|(&p, w)| w * self.points[p]).sum();
        self.points.push(mean);
        for Field { components, values, .. } in &mut self.point_fields {
            for c in 0..*components {
                let at = |&p: &usize| values[p * *components + c];
                values.push(along.iter().map(at).zip(MIDDLE).map(|(v, w)| w * v).sum());
            }
        }
        self.points.len() - 1
    }
}
