//! A solid as columns along z (a dexel model): the heights between which each column is filled.

use mesh::{SurfaceMesh, Vec3};

/// A square grid of nodes in the plane.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Node (0, 0) [m].
    pub origin: [f64; 2],
    /// Spacing [m].
    pub step: f64,
    /// Nodes along x and y.
    pub count: [usize; 2],
}

impl Grid {
    /// The grid over a rectangle and one step beyond it on every side.
    pub fn over(low: [f64; 2], high: [f64; 2], step: f64) -> Self {
        // Shifted by an irrational part of a step, so that columns do not pass
        // through the vertices and edges of shapes drawn in round numbers.
        let shift = [std::f64::consts::FRAC_1_SQRT_2, std::f64::consts::FRAC_1_PI];
        let origin = [0, 1].map(|k| low[k] - step * (1.0 + shift[k]));
        let count = [0, 1].map(|k| ((high[k] + step - origin[k]) / step).ceil() as usize + 1);
        Self { origin, step, count }
    }

    /// Number of nodes.
    pub fn len(&self) -> usize {
        self.count[0] * self.count[1]
    }

    /// Whether there are no nodes.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Index of a node.
    pub fn index(&self, i: usize, j: usize) -> usize {
        j * self.count[0] + i
    }

    /// Column and row of a node.
    pub fn cell(&self, node: usize) -> [usize; 2] {
        [node % self.count[0], node / self.count[0]]
    }

    /// The node nearest to a point.
    pub fn nearest(&self, p: [f64; 2]) -> usize {
        let step = |k: usize| {
            let s = ((p[k] - self.origin[k]) / self.step).round();
            (s.max(0.0) as usize).min(self.count[k] - 1)
        };
        self.index(step(0), step(1))
    }

    /// Position of a node [m].
    pub fn point(&self, node: usize) -> [f64; 2] {
        let [i, j] = self.cell(node);
        [self.origin[0] + i as f64 * self.step, self.origin[1] + j as f64 * self.step]
    }

    /// The up to four nodes next to a node.
    pub fn neighbours(&self, node: usize) -> impl Iterator<Item = usize> + use<> {
        let [i, j] = self.cell(node);
        let [nx, ny] = self.count;
        let west = (i > 0).then(|| node - 1);
        let east = (i + 1 < nx).then_some(node + 1);
        let south = (j > 0).then(|| node - nx);
        let north = (j + 1 < ny).then_some(node + nx);
        [west, east, south, north].into_iter().flatten()
    }

    /// Indices of the nodes within [low, high] along axis `k`.
    fn range(&self, k: usize, low: f64, high: f64) -> std::ops::Range<usize> {
        let first = ((low - self.origin[k]) / self.step).ceil().max(0.0) as usize;
        let end = ((high - self.origin[k]) / self.step).floor() + 1.0;
        first..(end.max(0.0) as usize).min(self.count[k])
    }
}

/// A filled interval of a column: its lowest and its highest point [m].
pub type Layer = [f64; 2];

/// The filled intervals of every column of `grid`, the lowest first.
///
/// `surface` is closed and faces outward.
pub fn layers(surface: &SurfaceMesh, grid: &Grid) -> Vec<Vec<Layer>> {
    let mut crossings = vec![Vec::new(); grid.len()];
    for t in 0..surface.triangles.len() {
        let corners = surface.corners(t);
        let range = |k: usize| {
            let values = corners.map(|c| c[k]);
            let low = values.into_iter().fold(f64::INFINITY, f64::min);
            let high = values.into_iter().fold(f64::NEG_INFINITY, f64::max);
            grid.range(k, low, high)
        };
        for j in range(1) {
            for i in range(0) {
                let node = grid.index(i, j);
                crossings[node].extend(crossing(&corners, grid.point(node)));
            }
        }
    }
    crossings.into_iter().map(filled).collect()
}

/// The intervals between a crossing into the solid and the next out of it.
fn filled(mut crossings: Vec<(f64, bool)>) -> Vec<Layer> {
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    let through = crossings.windows(2).filter(|pair| !pair[0].1 && pair[1].1);
    through.map(|pair| [pair[0].0, pair[1].0]).collect()
}

/// The middle of the longest filled interval of a column, none where the solid is missed [m].
pub fn middle_of_longest(column: &[Layer]) -> Option<f64> {
    let longest = column.iter().max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])));
    longest.map(|layer| (layer[0] + layer[1]) / 2.0)
}

/// Height at which the vertical through a point of the plane crosses a triangle, and
/// whether that faces up.
fn crossing(corners: &[Vec3; 3], p: [f64; 2]) -> Option<(f64, bool)> {
    let side =
        |a: &Vec3, b: &Vec3, [x, y]: [f64; 2]| (b.x - a.x) * (y - a.y) - (b.y - a.y) * (x - a.x);
    // Rounded alike in both triangles of an edge, so that no column slips through between them.
    let beside = |a: &Vec3, b: &Vec3| match (a.x, a.y) <= (b.x, b.y) {
        true => side(a, b, p),
        false => -side(b, a, p),
    };
    let [a, b, c] = corners;
    let sides = [(b, c), (c, a), (a, b)];
    // Upright triangles are not crossed.
    let area = side(a, b, [c.x, c.y]);
    let inside = area != 0.0 && sides.iter().all(|(from, to)| beside(from, to) * area >= 0.0);
    let weights = sides.map(|(from, to)| side(from, to, p));
    let height = weights[0] * a.z + weights[1] * b.z + weights[2] * c.z;
    inside.then_some((height / weights.iter().sum::<f64>(), area > 0.0))
}

#[cfg(test)]
mod tests {
    use super::*;
    use mesh::solid::Solid;

    #[test]
    fn columns_of_two_stacked_boxes() {
        let low = Solid::cube(&Vec3::zeros(), &Vec3::new(2.0, 1.0, 1.2));
        let high = Solid::cube(&Vec3::new(1.0, 0.0, 2.0), &Vec3::new(3.0, 1.0, 3.0));
        let surface = low.union(&high).to_surface();
        let grid = Grid::over([0.0, 0.0], [3.0, 1.0], 0.1);
        for (node, column) in layers(&surface, &grid).iter().enumerate() {
            let [x, y] = grid.point(node);
            let (expected, middle): (&[Layer], _) = match x {
                _ if !(0.0..1.0).contains(&y) || !(0.0..3.0).contains(&x) => (&[], None),
                _ if x < 1.0 => (&[[0.0, 1.2]], Some(0.6)),
                _ if x < 2.0 => (&[[0.0, 1.2], [2.0, 3.0]], Some(0.6)),
                _ => (&[[2.0, 3.0]], Some(2.5)),
            };
            assert_eq!(column.len(), expected.len(), "at ({x}, {y})");
            let off = column.iter().flatten().zip(expected.iter().flatten());
            assert!(off.map(|(a, b)| (a - b).abs()).all(|off| off < 1e-12), "at ({x}, {y})");
            let off = middle_of_longest(column).zip(middle).map(|(a, b)| (a - b).abs());
            assert_eq!(off.map(|off| off < 1e-12), middle.map(|_| true), "at ({x}, {y})");
        }
    }
}
