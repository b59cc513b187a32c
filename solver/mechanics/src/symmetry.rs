//! Planes of symmetry: a body may be the half, quarter or eighth of a symmetric one.
//!
//! The facets of a cut lie in a plane x_k = c across an axis k, the body on one side of
//! it. Its mirror image x_k ↦ 2c − x_k makes the whole. In the plane u_k = 0, and no other
//! force acts: what the image does to the body is the reaction of this support.
//!
//! Planes are across different axes, so that they are orthogonal and reflections commute.

use std::collections::BTreeSet;

use mesh::measure::mean_edge;
use mesh::{TetMesh, Vec3, facet_key};

/// Names of the axes.
pub const AXES: [&str; 3] = ["x", "y", "z"];
/// Distance from its plane at which a vertex of a cut, or of a flat face, still counts as in it, in
/// mean edges of the cut or face [1]. Vertices of a cut are moved into the plane.
pub const OFF_PLANE: f64 = 1e-3;

/// Facets that are no cut of a body in a plane of symmetry.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum NoPlane {
    /// They lie in a plane that is across no axis.
    #[error(
        "its facets lie in a plane with the normal ({:.4}, {:.4}, {:.4}), {:.2}° off the axis {}; \
         expected a plane across x, y or z: turn the mesh",
        normal.x, normal.y, normal.z, normal[*axis].abs().min(1.0).acos().to_degrees(), AXES[*axis]
    )]
    Oblique {
        /// Unit normal.
        normal: Vec3,
        /// Index of the nearest axis.
        axis: usize,
    },
    /// They lie in no plane.
    #[error(
        "its facets are not in one plane: a vertex is {off:.3e} m off {} = {level:.6} m; expected \
         {tolerance:.1e} m at most, a thousandth of the mean edge",
        AXES[*axis]
    )]
    Bent {
        /// Largest distance of a vertex from the plane [m].
        off: f64,
        /// Index of the axis across the plane.
        axis: usize,
        /// Coordinate of the plane on the axis [m].
        level: f64,
        /// Largest distance that counts as none [m].
        tolerance: f64,
    },
    /// The body is not cut there.
    #[error(
        "the body is on both sides of the plane {plane}: from {below:.3e} m below it to {above:.3e} m \
         above; expected a body that is cut there"
    )]
    BothSides {
        /// The plane as an equation.
        plane: String,
        /// How far the body reaches below it [m].
        below: f64,
        /// How far it reaches above it [m].
        above: f64,
    },
    /// Facets in the plane are missing in the cut.
    #[error(
        "{count} other facets lie in its plane {plane}, the first at ({:.5}, {:.5}, {:.5}) m; expected \
         all facets there in the cut: give them its tag, or name theirs, too, as in on = [\"{tag}\", \
         \"other\"]",
        first.x, first.y, first.z
    )]
    Incomplete {
        /// How many.
        count: usize,
        /// The plane as an equation.
        plane: String,
        /// Centroid of the first of them [m].
        first: Vec3,
        /// The first tag of the cut.
        tag: String,
    },
}

/// Two planes of symmetry across one axis.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{}: its plane {} is parallel to {} of \"{}\"; expected orthogonal planes: name tags in one \
     plane in one table, and support a second parallel plane by [[fixed]]",
    planes[1].title(), planes[1].equation(), planes[0].equation(), planes[0].tags.join("\", \"")
)]
pub struct Parallel {
    /// Both, in their order.
    pub planes: Box<[Plane; 2]>,
}

/// A plane of symmetry of a body.
#[derive(Clone, Debug, PartialEq)]
pub struct Plane {
    /// Tags of the cut.
    pub tags: Vec<String>,
    /// Index of the axis across which it lies.
    pub axis: usize,
    /// The coordinate on that axis [m].
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
    pub fn find(
        mesh: &TetMesh,
        boundary: &[[usize; 3]],
        tags: &[String],
        cut: &[[usize; 3]],
    ) -> Result<Self, NoPlane> {
        let x = &mesh.vertices;
        let facets: BTreeSet<[usize; 3]> = cut.iter().map(|&f| facet_key(f)).collect();
        let vertices: BTreeSet<usize> = cut.iter().flatten().copied().collect();
        let vertices: Vec<usize> = vertices.into_iter().collect();
        let tolerance = OFF_PLANE * mean_edge(x, cut);
        let (axis, level) = across(x, cut, &vertices, tolerance)?;
        let mut plane =
            Self { tags: tags.to_vec(), axis, level, side: 1.0, tolerance, facets, vertices };
        plane.side = plane.find_side(mesh)?;
        plane.check_complete(x, boundary)?;
        Ok(plane)
    }

    /// Whether a vertex is of the cut.
    pub fn contains(&self, vertex: usize) -> bool {
        self.vertices.binary_search(&vertex).is_ok()
    }

    /// Whether a facet is of the cut.
    pub fn has_facet(&self, facet: [usize; 3]) -> bool {
        self.facets.contains(&facet_key(facet))
    }

    /// Vertices of the cut, ascending.
    pub fn vertices(&self) -> &[usize] {
        &self.vertices
    }

    /// How far a point is from the plane, on the body's side [m].
    pub fn height(&self, x: &Vec3) -> f64 {
        self.side * (x[self.axis] - self.level)
    }

    /// The mirror image of a point [m].
    pub fn mirror(&self, mut x: Vec3) -> Vec3 {
        x[self.axis] = 2.0 * self.level - x[self.axis];
        x
    }

    /// What messages call it.
    pub fn title(&self) -> String {
        title(&self.tags)
    }

    /// The plane as an equation.
    pub fn equation(&self) -> String {
        format!("{} = {:.6} m", AXES[self.axis], self.level)
    }

    /// The side of the plane that the mesh is on.
    fn find_side(&self, mesh: &TetMesh) -> Result<f64, NoPlane> {
        let used = mesh.tets.iter().flatten();
        let heights = used.map(|&v| mesh.vertices[v][self.axis] - self.level);
        let (low, high) = heights.fold((0.0_f64, 0.0_f64), |(l, h), x| (l.min(x), h.max(x)));
        if low < -self.tolerance && high > self.tolerance {
            let plane = self.equation();
            return Err(NoPlane::BothSides { plane, below: -low, above: high });
        }
        Ok(if high >= -low { 1.0 } else { -1.0 })
    }

    /// All facets in the plane must be of the cut.
    fn check_complete(&self, x: &[Vec3], boundary: &[[usize; 3]]) -> Result<(), NoPlane> {
        let flat = |f: &&[usize; 3]| f.iter().all(|&v| self.height(&x[v]).abs() <= self.tolerance);
        let others = boundary.iter().filter(flat).filter(|f| !self.has_facet(**f));
        let others: Vec<&[usize; 3]> = others.collect();
        let Some(first) = others.first() else { return Ok(()) };
        Err(NoPlane::Incomplete {
            count: others.len(),
            plane: self.equation(),
            first: first.iter().map(|&v| x[v]).sum::<Vec3>() / 3.0,
            tag: self.tags[0].clone(),
        })
    }
}

/// What messages call the cut of some tags.
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
) -> Result<(usize, f64), NoPlane> {
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
    Err(if bent > tolerance {
        NoPlane::Bent { off, axis, level, tolerance }
    } else {
        NoPlane::Oblique { normal, axis }
    })
}

/// Planes must be across different axes.
pub fn check_orthogonal(planes: &[Plane]) -> Result<(), Parallel> {
    for (i, plane) in planes.iter().enumerate() {
        if let Some(other) = planes[..i].iter().find(|other| other.axis == plane.axis) {
            return Err(Parallel { planes: Box::new([other.clone(), plane.clone()]) });
        }
    }
    Ok(())
}

/// Sets to zero the components across planes of vectors at the vertices in them.
pub fn project(planes: &[Plane], vectors: &mut [Vec3]) {
    for plane in planes {
        plane.vertices.iter().for_each(|&v| vectors[v][plane.axis] = 0.0);
    }
}
