//! Undercuts of two shells that separate along a direction, and their depth.
//!
//! The body is cut into columns along the pull. Above the parting surface, empty space with
//! the body over it is *trapped*: it is filled by a shell that is demolded upward, and the
//! body blocks this shell. Below the parting surface it is the same with down and up
//! exchanged. The depth of a trapped place is its distance, across the pull, from the nearest
//! open place of the same empty space: the body must give way by it. The width w is the chord,
//! in that direction, through the part of the body that blocks the shell. If the shell reaches
//! below the other end of the chord, too, the body is squeezed from both sides. Squeezed by d
//! and d' it is compressed by (d + d')/w, the ratio that decides whether it can be peeled out.

use std::collections::BinaryHeap;

use mesh::bvh::SurfaceBvh;
use mesh::measure::bounds;
use mesh::{SurfaceMesh, Vec3};
use nalgebra::Matrix3;

use crate::columns::{Grid, Layer, layers, middle_of_longest};
use crate::frame::{Frame, moved};

/// Columns along the longest side of the body.
const COLUMNS: f64 = 120.0;

/// Films between a flat face and the parting it lies on are not trapped [m].
const THINNEST: f64 = 1e-5;

/// Trapped places whose width is measured, at most, for the ratio.
const SAMPLES: usize = 400;

/// A body as seen along a direction.
pub struct View {
    /// From the body to the view, whose z is the direction [1].
    rotation: Matrix3<f64>,
    surface: SurfaceMesh,
    grid: Grid,
    columns: Vec<Vec<Layer>>,
}

/// Where two shells part, in a view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PartingHeight {
    /// At a height along the direction, from the body's origin [m].
    Plane(f64),
    /// In the middle of the longest filled interval of each column, as a height field does.
    Middle,
}

/// The undercuts of two shells.
#[derive(Clone, Debug, PartialEq)]
pub struct Undercut {
    /// Depth at each triangle of the body, 0 where it is free [m].
    pub facets: Vec<f64>,
    /// Part of the area in undercuts deeper than the view resolves [1].
    pub share: f64,
    /// Largest depth [m].
    pub depth: f64,
    trapped: Vec<Trapped>,
}

/// Where the body must give way most, for its width.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worst {
    /// Depths on both sides over width [1].
    pub ratio: f64,
    /// How far the body must give way [m].
    pub depth: f64,
    /// How far it must give way at the other end of its width at the same time [m].
    pub opposite: f64,
    /// How wide it is in that direction [m].
    pub width: f64,
    /// In the middle of what must give way, in the body's coordinates [m].
    pub at: Vec3,
}

/// Empty space in a column, between the parting and a layer over it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Trapped {
    node: usize,
    low: f64,
    high: f64,
    /// The layer that blocks the shell.
    over: Layer,
    /// Where the same space is open [m].
    rim: Option<[f64; 2]>,
    depth: f64,
    /// Whether the shell that is demolded upward fills it.
    upper: bool,
}

impl View {
    /// The body seen along `pull`.
    pub fn along(body: &SurfaceMesh, pull: &Vec3) -> Self {
        let (frame, _) = Frame::new(*pull, *pull).expect("a direction is along itself");
        let rotation = frame.rotation;
        let surface = moved(body, |p| rotation * p);
        let (low, high) = bounds(&surface.vertices);
        let step = (high.x - low.x).max(high.y - low.y) / COLUMNS;
        let grid = Grid::over([low.x, low.y], [high.x, high.y], step);
        let columns = layers(&surface, &grid);
        Self { rotation, surface, grid, columns }
    }

    /// Lowest and highest point along the direction [m].
    pub fn extent(&self) -> [f64; 2] {
        let (low, high) = bounds(&self.surface.vertices);
        [low.z, high.z]
    }

    /// Area covered by the body as seen [m²].
    pub fn outline(&self) -> f64 {
        let covered = self.columns.iter().filter(|column| !column.is_empty()).count();
        covered as f64 * self.grid.step.powi(2)
    }

    /// The undercuts of the two shells of a parting surface.
    pub fn undercut(&self, parting: PartingHeight) -> Undercut {
        let upper = self.side(parting, &self.columns, 1.0);
        let mirrored: Vec<Vec<Layer>> = self
            .columns
            .iter()
            .map(|column| column.iter().rev().map(|&[low, high]| [-high, -low]).collect())
            .collect();
        let mut lower = self.side(parting, &mirrored, -1.0);
        for place in &mut lower.1 {
            (place.low, place.high) = (-place.high, -place.low);
            place.over = [-place.over[1], -place.over[0]];
            place.upper = false;
        }
        let facets: Vec<f64> = upper.0.iter().zip(&lower.0).map(|(a, b)| a.max(*b)).collect();
        let area = |t: usize| self.surface.area(t);
        let all: f64 = (0..facets.len()).map(area).sum();
        let hidden: f64 = (0..facets.len()).filter(|&t| facets[t] > self.grid.step).map(area).sum();
        let trapped = [upper.1, lower.1].concat();
        let depth = trapped.iter().map(|place| place.depth).fold(0.0, f64::max);
        // An empty sum is −0.
        Undercut { facets, share: hidden / all + 0.0, depth, trapped }
    }

    /// Depths of the triangles and trapped places of the shell that is demolded upward;
    /// heights are multiplied by `sign`.
    fn side(
        &self,
        parting: PartingHeight,
        columns: &[Vec<Layer>],
        sign: f64,
    ) -> (Vec<f64>, Vec<Trapped>) {
        let floor = |column: &[Layer]| match parting {
            PartingHeight::Plane(z) => sign * z,
            PartingHeight::Middle => middle_of_longest(column).unwrap_or(f64::NEG_INFINITY),
        };
        let mut first = Vec::with_capacity(columns.len());
        // By layers: what is trapped below each.
        let mut below: Vec<Option<usize>> = Vec::new();
        let mut trapped = Vec::new();
        for (node, column) in columns.iter().enumerate() {
            first.push(below.len());
            let floor = floor(column);
            let mut low = f64::NEG_INFINITY;
            for &over in column {
                let place = Trapped {
                    node,
                    low: low.max(floor),
                    high: over[0],
                    over,
                    rim: None,
                    depth: 0.0,
                    upper: true,
                };
                let is_trapped = place.high - place.low > THINNEST;
                below.push(is_trapped.then_some(trapped.len()));
                trapped.extend(is_trapped.then_some(place));
                low = over[1];
            }
        }
        let open_from = |node: usize| match columns[node].last() {
            Some(top) => top[1].max(floor(&columns[node])),
            None => f64::NEG_INFINITY,
        };
        let places_of = |node: usize| {
            let slots = first[node]..first[node] + columns[node].len();
            below[slots].iter().flatten().copied()
        };
        self.measure_depths(&mut trapped, open_from, places_of);
        let facets = (0..self.surface.triangles.len()).map(|t| {
            let centre = self.surface.centroid(t);
            let node = self.grid.nearest([centre.x, centre.y]);
            let column = &columns[node];
            let z = sign * centre.z;
            let [a, b, c] = self.surface.corners(t);
            let faces_up = sign * (b - a).cross(&(c - a)).z > 0.0;
            let end = usize::from(faces_up);
            let off = |k: &usize| (column[*k][end] - z).abs();
            let nearest = (0..column.len()).min_by(|a, b| off(a).total_cmp(&off(b)));
            // What is over a layer is below the next.
            let over = nearest.map(|k| k + end).filter(|&k| k < column.len());
            let place = over.and_then(|k| below[first[node] + k]);
            place.map_or(0.0, |place| trapped[place].depth)
        });
        (facets.collect(), trapped)
    }

    /// The distance of every trapped place from the nearest open one that the same
    /// space leads to, by Dijkstra's algorithm over columns with the rim carried along.
    /// All empty space leads out of a body; places that do not are narrower than the view
    /// resolves, and count as free.
    fn measure_depths<I: Iterator<Item = usize>>(
        &self,
        trapped: &mut [Trapped],
        open_from: impl Fn(usize) -> f64,
        places_of: impl Fn(usize) -> I,
    ) {
        let far = |node: usize, rim: [f64; 2]| {
            let p = self.grid.point(node);
            ((p[0] - rim[0]).hypot(p[1] - rim[1]) - 0.5 * self.grid.step).max(0.0)
        };
        // Bits of floats that are not negative sort as the floats do.
        let mut queue = BinaryHeap::new();
        for (i, place) in trapped.iter().enumerate() {
            for n in self.grid.neighbours(place.node).filter(|&n| open_from(n) < place.high) {
                let depth = far(place.node, self.grid.point(n));
                queue.push((std::cmp::Reverse(depth.to_bits()), i, n));
            }
        }
        while let Some((std::cmp::Reverse(depth), i, open)) = queue.pop() {
            if trapped[i].rim.is_some() {
                continue;
            }
            let rim = self.grid.point(open);
            trapped[i].rim = Some(rim);
            trapped[i].depth = f64::from_bits(depth);
            let place = trapped[i];
            for n in self.grid.neighbours(place.node) {
                for j in places_of(n) {
                    let other = &trapped[j];
                    let meet = other.low.max(place.low) < other.high.min(place.high);
                    if other.rim.is_none() && meet {
                        queue.push((std::cmp::Reverse(far(n, rim).to_bits()), j, open));
                    }
                }
            }
        }
    }

    /// Where an undercut squeezes the body most for its width.
    pub fn worst(&self, undercut: &Undercut) -> Option<Worst> {
        self.places(undercut).into_iter().max_by(|a, b| a.ratio.total_cmp(&b.ratio))
    }

    /// Greatest depth over width of an undercut below a rigid body. What is trapped there gives
    /// way outward, on each side by itself, so that sides do not add up.
    pub fn steepest(&self, undercut: &Undercut) -> f64 {
        let ratio = |place: Worst| place.depth / place.width.max(self.grid.step);
        self.places(undercut).into_iter().map(ratio).fold(0.0, f64::max)
    }

    /// Places of an undercut, deep enough to be resolved, and what must give way there.
    fn places(&self, undercut: &Undercut) -> Vec<Worst> {
        let deep: Vec<&Trapped> =
            undercut.trapped.iter().filter(|place| place.depth > self.grid.step).collect();
        if deep.is_empty() {
            return Vec::new();
        }
        let bvh = SurfaceBvh::new(&self.surface);
        let mut above = vec![Vec::new(); self.grid.len()];
        undercut.trapped.iter().for_each(|place| above[place.node].push(*place));
        let samples = deep.iter().step_by(deep.len().div_ceil(SAMPLES));
        let measured = samples.filter_map(|place| {
            let from = self.blocking(place)?;
            let inward = place.inward(&self.grid)?;
            let reach = |d: Vec3| bvh.ray(&from, &d).first().map_or(0.0, |hit| hit.0);
            let ahead = reach(inward);
            let width = ahead + reach(-inward);
            let at = self.rotation.transpose() * from;
            let depth = place.depth;
            let opposite = self.opposite(place, &from, inward * ahead, &above);
            let ratio = (depth + opposite) / width.max(self.grid.step);
            Some(Worst { ratio, depth, opposite, width, at })
        });
        measured.collect()
    }

    /// The middle of the part of the body over `place`, where that is thickest between there and
    /// the nearest open place: near its edge it may have no thickness.
    fn blocking(&self, place: &Trapped) -> Option<Vec3> {
        let ([x, y], rim) = (self.grid.point(place.node), place.rim?);
        let steps = ((x - rim[0]).hypot(y - rim[1]) / self.grid.step).ceil();
        let along = (0..=steps as usize).map(|k| {
            let t = k as f64 / steps.max(1.0);
            let node = self.grid.nearest([x + (rim[0] - x) * t, y + (rim[1] - y) * t]);
            let meets = |l: &&Layer| l[0] < place.over[1] && place.over[0] < l[1];
            self.columns[node].iter().filter(meets).map(move |layer| (node, *layer))
        });
        let thickness = |layer: &Layer| layer[1] - layer[0];
        let thickest = along.flatten().max_by(|a, b| thickness(&a.1).total_cmp(&thickness(&b.1)));
        let (node, layer) = thickest.unwrap_or((place.node, place.over));
        let [x, y] = self.grid.point(node);
        Some(Vec3::new(x, y, (layer[0] + layer[1]) / 2.0))
    }

    /// How far the shell that fills `place` reaches below the body from the other side, along
    /// the vector `way` from there through the body: the greatest depth against that direction.
    fn opposite(&self, place: &Trapped, from: &Vec3, way: Vec3, above: &[Vec<Trapped>]) -> f64 {
        let steps = (way.norm() / self.grid.step) as usize;
        let mut deepest: f64 = 0.0;
        for k in 1..=steps {
            let p = from + way * (k as f64 / steps as f64);
            let node = self.grid.nearest([p.x, p.y]);
            let here = above[node].iter().filter(|other| {
                other.upper == place.upper && other.over[0] <= p.z && p.z <= other.over[1]
            });
            for other in here {
                let Some(inward) = other.inward(&self.grid) else { continue };
                deepest = deepest.max(-inward.dot(&way.normalize()) * other.depth);
            }
        }
        deepest
    }
}

impl Trapped {
    /// The direction from where the space is open to the place.
    fn inward(&self, grid: &Grid) -> Option<Vec3> {
        let ([x, y], rim) = (grid.point(self.node), self.rim?);
        Some(Vec3::new(x - rim[0], y - rim[1], 0.0).normalize())
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;
    use mesh::solid::Solid;

    fn cylinder(radius: f64, low: f64, high: f64) -> Solid {
        let base = Vec3::new(0.0, 0.0, low);
        Solid::cylinder(&base, &(Vec3::z() * (high - low)), radius, radius, 96)
    }

    /// Two discs of radius 10 on a stem of radius 4.
    fn spool() -> SurfaceMesh {
        let discs = cylinder(10.0, 0.0, 5.0).union(&cylinder(10.0, 15.0, 20.0));
        discs.union(&cylinder(4.0, 4.0, 16.0)).to_surface()
    }

    #[test]
    fn a_convex_body_hides_nothing() {
        let ball = Solid::sphere(&Vec3::zeros(), 1.0, 64).to_surface();
        for pull in [Vec3::z(), Vec3::new(1.0, 2.0, 3.0)] {
            let view = View::along(&ball, &pull);
            for parting in [PartingHeight::Middle, PartingHeight::Plane(0.0)] {
                let undercut = view.undercut(parting);
                assert!(undercut.share < 1e-2, "{}", undercut.share);
                assert!(undercut.depth < view.grid.step);
                assert_eq!(view.worst(&undercut), None);
            }
        }
    }

    #[test]
    fn a_plane_off_the_middle_of_a_ball_hides_the_belt_between() {
        // Between the plane at h and the equator, the ball is in the way: a belt of
        // area 2πrh, so a share of h/2r, without the part at the equator that is less
        // deep than the view resolves; the mold reaches below it by r − √(r² − h²).
        let ball = Solid::sphere(&Vec3::zeros(), 1.0, 256).to_surface();
        let view = View::along(&ball, &Vec3::z());
        let undercut = view.undercut(PartingHeight::Plane(-0.8));
        let shallow = (1.0 - (1.0 - 2.0 * view.grid.step).powi(2)).sqrt();
        assert!((0.4 - shallow / 2.0..0.4).contains(&undercut.share), "{}", undercut.share);
        assert!((undercut.depth - 0.4).abs() < view.grid.step, "{}", undercut.depth);
        let worst = view.worst(&undercut).unwrap();
        assert!((worst.width - 2.0).abs() < 0.3, "{worst:?}");
    }

    #[test]
    fn a_spool_hides_what_is_between_its_discs_only_along_its_axis() {
        let spool = spool();
        let along = View::along(&spool, &Vec3::z());
        let undercut = along.undercut(PartingHeight::Plane(10.0));
        // Both faces between the discs: 2π(10² − 4²), and the stem 2π·4·10 of radius 4,
        // whose columns are full.
        assert!((undercut.depth - 6.0).abs() < 2.0 * along.grid.step, "{}", undercut.depth);
        let worst = along.worst(&undercut).unwrap();
        // By 6 on both sides of a disc 20 wide.
        assert!((worst.ratio - 12.0 / 20.0).abs() < 0.06, "{worst:?}");
        assert!((worst.opposite - 6.0).abs() < 2.0 * along.grid.step, "{worst:?}");
        // Each side by itself.
        assert!((along.steepest(&undercut) - 6.0 / 20.0).abs() < 0.03, "{worst:?}");
        assert!((worst.at.z - 17.5).abs() < 1e-9 || (worst.at.z - 2.5).abs() < 1e-9);
        let across = View::along(&spool, &Vec3::x());
        assert!(across.undercut(PartingHeight::Plane(0.0)).share < 1e-2);
        assert!(across.undercut(PartingHeight::Middle).share < 1e-2);
    }

    #[test]
    fn what_hangs_over_on_one_side_is_squeezed_from_there_only() {
        // A stem of 4 under a plate that reaches 6 beyond it on one side.
        let stem = Solid::cube(&Vec3::new(-2.0, -2.0, 0.0), &Vec3::new(2.0, 2.0, 10.0));
        let plate = Solid::cube(&Vec3::new(-8.0, -2.0, 9.0), &Vec3::new(2.0, 2.0, 12.0));
        let view = View::along(&stem.union(&plate).to_surface(), &Vec3::z());
        let undercut = view.undercut(PartingHeight::Plane(1.0));
        let worst = view.worst(&undercut).unwrap();
        // The open side is nearer across the plate: 2 from either side, squeezed from both.
        assert!((worst.depth - 2.0).abs() < 2.0 * view.grid.step, "{worst:?}");
        assert!((worst.width - 4.0).abs() < 1e-9, "{worst:?}");
        // Of a bracket along a wall, only the front is open.
        let wall = Solid::cube(&Vec3::new(-2.0, -20.0, 0.0), &Vec3::new(2.0, 20.0, 10.0));
        let plate = Solid::cube(&Vec3::new(-8.0, -20.0, 9.0), &Vec3::new(2.0, 20.0, 12.0));
        let view = View::along(&wall.union(&plate).to_surface(), &Vec3::z());
        let undercut = view.undercut(PartingHeight::Plane(1.0));
        let worst = view.worst(&undercut).unwrap();
        assert!((worst.depth - 6.0).abs() < 2.0 * view.grid.step, "{worst:?}");
        assert_eq!(worst.opposite, 0.0, "{worst:?}");
        assert!((worst.ratio - 0.6).abs() < 0.06, "{worst:?}");
    }
}
