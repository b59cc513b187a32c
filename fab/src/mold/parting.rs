//! Dividing the mold's material into shells along the parting surface.

use geometry::columns::{Grid, Layer, layers};
use geometry::frame::Turn;
use geometry::frustum::Frustum;
use geometry::height_field::Terrain;
use geometry::place;
use mesh::Vec3;
use mesh::check::Finding;
use mesh::solid::Solid;
use mesh::{SurfaceMesh, measure};
use nalgebra::Matrix3x4;

use crate::config::HeightFieldConfig;

/// Parting solids reach this far beyond the block, so that no faces coincide [m].
const BEYOND: f64 = 1e-3;

/// Curved partings are simplified within this distance [m].
const SIMPLIFY: f64 = 5e-6;

/// Bodies smaller than this are films of rounding and dropped: a hundredth of a drop of
/// molten plastic [m³].
pub const FILM: f64 = 1e-13;

/// A parting surface inside a block, in coordinates with z along the pull.
#[derive(Clone)]
pub struct Split {
    /// The side the pull points away from.
    pub below: Solid,
    /// Height at which keys and bolts stand [m].
    pub level: f64,
    /// What a person should know about it.
    pub findings: Vec<Finding>,
}

/// The box in which a parting surface lies.
#[derive(Clone, Debug, PartialEq)]
pub struct Site {
    /// Lowest corner of the block [m].
    pub min: Vec3,
    /// Highest corner of the block [m].
    pub max: Vec3,
    /// Width of the level rim for keys and bolts along x and y; none along an axis if it
    /// is 0 [m].
    pub rim: [f64; 2],
}

impl Split {
    /// A plane at height `z` [m].
    pub fn plane(site: &Site, z: f64) -> Self {
        let beyond = Vec3::repeat(BEYOND);
        let mut top = site.max + beyond;
        top.z = z;
        let below = Solid::cube(&(site.min - beyond), &top);
        Self { below, level: z, findings: Vec::new() }
    }

    /// A height field for the part bounded by `filled`.
    pub fn height_field(site: &Site, filled: &SurfaceMesh, settings: &HeightFieldConfig) -> Self {
        let corner = |p: &Vec3| [p.x, p.y];
        let grid = Grid::over(corner(&site.min), corner(&site.max), settings.cell);
        let columns = layers(filled, &grid);
        let findings = undercut_columns(&grid, &columns);
        // Where there is no rim, the rectangle reaches beyond all columns.
        let inset = |k: usize| if site.rim[k] > 0.0 { site.rim[k] } else { -1.0 };
        let within =
            [[0, 1].map(|k| site.min[k] + inset(k)), [0, 1].map(|k| site.max[k] - inset(k))];
        let steepest = settings.max_slope.to_radians();
        let terrain = Terrain::new(grid, &columns, within, steepest, settings.smoothing);
        let low = terrain.heights.iter().fold(site.min.z, |m, h| m.min(*h)) - BEYOND;
        let proof = "a height field over a grid is closed and faces outward";
        let fine = Solid::from_surface(&terrain.surface(low)).expect(proof);
        // Imported anew, because a simplified solid keeps its tolerance and would
        // pass it on to every shell that it cuts.
        let below = Solid::from_surface(&fine.simplify(SIMPLIFY).to_surface()).expect(proof);
        Self { below, level: terrain.level, findings }
    }

    /// The split with its solid turned.
    pub fn turned(self, turn: Turn) -> Self {
        Self { below: self.below.transform(&affine(turn)), ..self }
    }
}

/// A turn as an affine map.
pub fn affine(turn: Turn) -> Matrix3x4<f64> {
    turn.0.insert_column(3, 0.0)
}

/// A frustum with its coordinates turned.
pub fn turned(frustum: &Frustum, turn: Turn) -> Frustum {
    Frustum { base: turn.0 * frustum.base, axis: turn.0 * frustum.axis, ..frustum.clone() }
}

/// Reports the columns with more than one layer of the part: undercuts for any surface along
/// this pull.
fn undercut_columns(grid: &Grid, columns: &[Vec<Layer>]) -> Vec<Finding> {
    let covered = columns.iter().filter(|column| !column.is_empty()).count();
    let hidden = columns.iter().filter(|column| column.len() > 1).count();
    if hidden == 0 {
        return Vec::new();
    }
    let mm2 = hidden as f64 * grid.step * grid.step * 1e6;
    let percent = 100.0 * hidden as f64 / covered as f64;
    vec![Finding {
        rule: "undercut",
        message: format!(
            "{mm2:.1} mm² ({percent:.1} %) of the part's outline along the pull cover more than one layer: \
             the silicone must be peeled out there"
        ),
        count: hidden,
    }]
}

/// Both sides of a split, each in one piece.
pub struct Sides {
    /// The side the pull points to.
    pub above: Solid,
    /// The other side.
    pub below: Solid,
    /// What was moved from one to the other.
    pub findings: Vec<Finding>,
}

/// Divides `region` without the part by a split. Crumbs, pieces cut off on one
/// side, go to the other side, to which they are attached by the parting surface.
pub fn divide(region: &Solid, part: &Solid, split: &Split) -> Sides {
    // The part is subtracted last: where it lies flat on the parting surface,
    // only a difference leaves no film without thickness.
    let mut above = region.difference(&split.below).difference(part);
    let mut below = region.intersection(&split.below).difference(part);
    let mut findings = Vec::new();
    let crumbs = |solid: &Solid| {
        let others = solid.decompose().into_iter().skip(1);
        others.filter(|crumb| crumb.volume() > FILM).collect::<Vec<_>>()
    };
    for crumb in crumbs(&above) {
        findings.push(moved("below", &crumb));
        above = above.difference(&crumb);
        below = below.union(&crumb);
    }
    for crumb in crumbs(&below) {
        findings.push(moved("above", &crumb));
        below = below.difference(&crumb);
        above = above.union(&crumb);
    }
    Sides { above, below, findings }
}

fn moved(side: &str, crumb: &Solid) -> Finding {
    let (low, high) = measure::bounds(&crumb.to_surface().vertices);
    let (volume, at) = (crumb.volume() * 1e9, place(&((low + high) / 2.0), 2));
    Finding {
        rule: "crumb",
        message: format!(
            "{volume:.4} mm³ around {at} cut off by the parting went to the shell {side}"
        ),
        count: 1,
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn cube(half: f64, low: f64, high: f64) -> Solid {
        Solid::cube(&Vec3::new(-half, -half, low), &Vec3::new(half, half, high))
    }

    #[test]
    fn crumbs_go_to_the_other_side_without_a_seam() {
        // A slab with a dent in its underside, parted through the dent: its upper
        // half is cut off from the upper shell.
        let part = cube(10.0, 0.0, 10.0).difference(&cube(3.0, -1.0, 3.0));
        let region = cube(20.0, -10.0, 20.0);
        let min = Vec3::new(-20.0, -20.0, -10.0);
        let site = Site { min, max: Vec3::repeat(20.0), rim: [5.0, 0.0] };
        let split = Split::plane(&site, 1.0);
        let sides = divide(&region, &part, &split);
        assert_eq!(sides.findings.len(), 1);
        assert_eq!(sides.findings[0].rule, "crumb");
        for side in [&sides.above, &sides.below] {
            assert_eq!(side.decompose().len(), 1);
            assert!(mesh::check::check_surface(&side.to_surface()).is_empty());
        }
        let below = 40.0 * 40.0 * 11.0 - 20.0 * 20.0 + 6.0 * 6.0 * 3.0;
        assert!((sides.below.volume() - below).abs() < 1e-9);
        let whole = region.difference(&part).volume();
        assert!((sides.above.volume() + sides.below.volume() - whole).abs() < 1e-9);
    }
}
