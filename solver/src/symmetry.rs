//! Planes of symmetry: a body may be the half, quarter or eighth of a symmetric one.
//!
//! The facets of a cut lie in a plane x_k = c across an axis k, the body on one side of
//! it. Its mirror image x_k ↦ 2c − x_k makes the whole. In the plane u_k = 0, and no other
//! force acts: what the image does to the body is the reaction of this support.
//!
//! Planes are across different axes, so that they are orthogonal and reflections commute.

use std::collections::BTreeSet;

use anyhow::{Result, bail, ensure};
use mesh::measure::mean_edge;
use mesh::{TetMesh, Vec3, facet_key};

/// Names of the axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];
/// Distance from its plane at which a vertex of a cut, or of a flat face, still counts as in it, in
/// mean edges of the cut or face [1]. Vertices of a cut are moved into the plane.
pub const FLAT: f64 = 1e-3;

/// A plane of symmetry of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Tags of the cut.
    pub tags: Vec<String>,
    /// Index of the axis across which it lies.
    pub axis: usize,
    /// Its coordinate on that axis [m].
    pub level: f64,
    /// 1 where the body is above the level, −1 below.
    pub side: f64,
    /// How far a vertex may be off the plane that counts as in it [m].
    pub tolerance: f64,
    /// Facets of the cut.
    facets: BTreeSet<[usize; 3]>,
    /// Vertices of the cut, ascending.
    vertices: Vec<usize>,
}

impl Plane {
    /// The plane of the facets of a cut through a mesh.
    ///
    /// # Errors
    /// With numbers when the facets are not in one plane across an axis, the body is on
    /// both sides, or facets in the plane are missing in the cut.
    pub fn find(
        mesh: &TetMesh,
        boundary: &[[usize; 3]],
        tags: &[String],
        cut: &[[usize; 3]],
    ) -> Result<Self> {
        let x = &mesh.vertices;
        let facets: BTreeSet<[usize; 3]> = cut.iter().map(|&f| facet_key(f)).collect();
        let vertices: BTreeSet<usize> = cut.iter().flatten().copied().collect();
        let vertices: Vec<usize> = vertices.into_iter().collect();
        let tolerance = FLAT * mean_edge(x, cut);
        let (axis, level) = across(x, cut, &vertices, tolerance)?;
        let mut plane =
            Self { tags: tags.to_vec(), axis, level, side: 1.0, tolerance, facets, vertices };
        plane.side = plane.find_side(mesh)?;
        plane.check_complete(x, boundary)?;
        Ok(plane)
    }

    /// Whether a vertex is of the cut.
    #[must_use]
    pub fn contains(&self, vertex: usize) -> bool {
        self.vertices.binary_search(&vertex).is_ok()
    }

    /// Whether a facet is of the cut.
    #[must_use]
    pub fn has_facet(&self, facet: [usize; 3]) -> bool {
        self.facets.contains(&facet_key(facet))
    }

    /// Vertices of the cut, ascending.
    #[must_use]
    pub fn vertices(&self) -> &[usize] {
        &self.vertices
    }

    /// How far a point is from the plane, on the body's side [m].
    #[must_use]
    pub fn height(&self, x: &Vec3) -> f64 {
        self.side * (x[self.axis] - self.level)
    }

    /// The mirror image of a point [m].
    #[must_use]
    pub fn mirror(&self, mut x: Vec3) -> Vec3 {
        x[self.axis] = 2.0 * self.level - x[self.axis];
        x
    }

    /// What messages call it.
    #[must_use]
    pub fn title(&self) -> String {
        title(&self.tags)
    }

    /// The plane as an equation.
    #[must_use]
    pub fn equation(&self) -> String {
        format!("{} = {:.6} m", AXES[self.axis], self.level)
    }

    /// The side of the plane that the mesh is on.
    fn find_side(&self, mesh: &TetMesh) -> Result<f64> {
        let used = mesh.tets.iter().flatten();
        let heights = used.map(|&v| mesh.vertices[v][self.axis] - self.level);
        let (low, high) = heights.fold((0.0_f64, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
        ensure!(
            low >= -self.tolerance || high <= self.tolerance,
            "the body is on both sides of the plane {}: from {:.3e} m below it to {high:.3e} m above; \
             expected a body that is cut there",
            self.equation(),
            -low
        );
        Ok(if high >= -low { 1.0 } else { -1.0 })
    }

    /// All facets in the plane must be of the cut.
    fn check_complete(&self, x: &[Vec3], boundary: &[[usize; 3]]) -> Result<()> {
        let flat = |f: &&[usize; 3]| f.iter().all(|&v| self.height(&x[v]).abs() <= self.tolerance);
        let others = boundary.iter().filter(flat).filter(|f| !self.has_facet(**f));
        let others: Vec<&[usize; 3]> = others.collect();
        let Some(first) = others.first() else { return Ok(()) };
        let p = first.iter().map(|&v| x[v]).sum::<Vec3>() / 3.0;
        bail!(
            "{} other facets lie in its plane {}, the first at ({:.5}, {:.5}, {:.5}) m; expected all \
             facets there in the cut: give them its tag, or name theirs, too, as in on = [\"{}\", \
             \"other\"]",
            others.len(),
            self.equation(),
            p.x,
            p.y,
            p.z,
            self.tags[0]
        )
    }
}

/// What messages call the cut of some tags.
#[must_use]
pub fn title(tags: &[String]) -> String {
    format!("[[symmetry]] on \"{}\"", tags.join("\", \""))
}

/// The axis that facets in a plane are across, and the coordinate of the plane: the median
/// of their vertices', which is exact where most of them are.
fn across(
    x: &[Vec3],
    cut: &[[usize; 3]],
    vertices: &[usize],
    tolerance: f64,
) -> Result<(usize, f64)> {
    let area = |f: &[usize; 3]| (x[f[1]] - x[f[0]]).cross(&(x[f[2]] - x[f[0]]));
    let normal = cut.iter().map(area).sum::<Vec3>().normalize();
    let axis = normal.iamax();
    let mut levels: Vec<f64> = vertices.iter().map(|&v| x[v][axis]).collect();
    levels.sort_by(f64::total_cmp);
    let level = levels[levels.len() / 2];
    let off = (level - levels[0]).max(levels[levels.len() - 1] - level);
    if off <= tolerance {
        return Ok((axis, level));
    }
    let centre = vertices.iter().map(|&v| x[v]).sum::<Vec3>() / vertices.len() as f64;
    let bent = vertices.iter().map(|&v| (x[v] - centre).dot(&normal).abs()).fold(0.0, f64::max);
    ensure!(
        bent > tolerance,
        "its facets lie in a plane with the normal ({:.4}, {:.4}, {:.4}), {:.2}° off the axis {}; \
         expected a plane across x, y or z: turn the mesh",
        normal.x,
        normal.y,
        normal.z,
        normal[axis].abs().min(1.0).acos().to_degrees(),
        AXES[axis]
    );
    bail!(
        "its facets are not in one plane: a vertex is {off:.3e} m off {} = {level:.6} m; expected \
         {tolerance:.1e} m at most, a thousandth of the mean edge",
        AXES[axis]
    )
}

/// Planes must be across different axes.
///
/// # Errors
/// With both planes when they are parallel.
pub fn check_orthogonal(planes: &[Plane]) -> Result<()> {
    for (i, plane) in planes.iter().enumerate() {
        let Some(other) = planes[..i].iter().find(|other| other.axis == plane.axis) else {
            continue;
        };
        bail!(
            "{}: its plane {} is parallel to {} of \"{}\"; expected orthogonal planes: name tags in one \
             plane in one table, and support a second parallel plane by [[fixed]]",
            plane.title(),
            plane.equation(),
            other.equation(),
            other.tags.join("\", \"")
        );
    }
    Ok(())
}

/// Sets to zero the components across planes of vectors at the vertices in them.
pub fn project(planes: &[Plane], vectors: &mut [Vec3]) {
    for plane in planes {
        plane.vertices.iter().for_each(|&v| vectors[v][plane.axis] = 0.0);
    }
}
