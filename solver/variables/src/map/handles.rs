//! Free-form deformation of a surface patch: rigid motions of a few handles, blended by
//! bounded biharmonic weights (linear blend skinning).
//!
//! v' = v + Σ_j w_j(v) (T_j v − v),   T_j v = c_j + R_j (v − c_j) + t_j
//! R_j = R_z(α₃) R_y(α₂) R_x(α₁),     αₖ = θₖ / r_j
//!
//! w_j   bounded biharmonic weight of handle j, zero on the rim [1]
//! c_j   the vertex at which handle j sits [m]
//! t_j   translation [m]
//! α     angles [rad]
//! r_j   radius of the handle's support, r_j² = Σ_v w_j² |v − c_j|² / Σ_v w_j²,
//!       but at least the mean edge: a handle that moves hardly more than its own
//!       vertex must not spin with its variables [m]
//!
//! The variables of a handle are (θ₁, θ₂, θ₃, t_x, t_y, t_z), or t alone where handles do not
//! rotate, and perhaps o, by which the surface at it moves along its normals: to T_j v is added o d(v), with d the move
//! per distance out of the silicone ([`shifts`]). All are in metres: a
//! rotation variable is the path of a vertex at distance r_j, so that equal
//! changes of any variable move the surface about equally far. θ = 0 is the
//! shape as it is. The rim does not move, whatever the variables.
//!
//! Where a plane of symmetry cuts the patch, what lies in the plane is no rim: it moves along the
//! plane, as does a flat face that is to stay in its plane. For the component along the plane's normal
//! n, w_j is then another weight, which is zero in the plane, too; a handle in the plane does not move
//! across it. With several planes that are not at right angles,
//!
//! v' − v = P_v Σ_j (w_j + Σ_n (w_jn − w_j) n nᵀ) (T_j v − v)
//!
//! w_jn  the weight that is zero in all planes across n [1]
//! P_v   projection onto the planes in which v lies
//!
//! A handle may be the image of another by an isometry ([`Isometry`]): it has the variables of that one, and moves by the image of
//! its motion. A handle that is its own image, about, has only the variables whose motions are their own images, such as
//! translations along a plane of symmetry.
//!
//! Source: Gjoka et al. 2024, equation (17).

use std::collections::BTreeSet;
use std::sync::Arc;

use anyhow::{Context, Result, ensure};
use mesh::measure::mean_edge;
use mesh::offset::shifts;
use mesh::{SurfaceMesh, Vec3, topology};
use scene::config::HandleMotion;

use super::biharmonic::bounded_biharmonic;
use super::held::{Held, off};
use super::isometry::Isometry;
use super::sampling::spread_points;

type Mat3 = nalgebra::Matrix3<f64>;

/// Numbers of a motion: three rotations, three translations, an offset.
const NUMBERS: usize = 7;

/// A rigid motion about a handle's center.
struct Motion {
    /// Angles about x, y, z [rad].
    angles: [f64; 3],
    /// Translation [m].
    translation: Vec3,
    /// o [m].
    offset: f64,
    /// Q: rotation and translation are the images of these.
    frame: Mat3,
}

impl Motion {
    /// Q R_z R_y R_x Qᵀ.
    fn rotation(&self) -> Mat3 {
        let [x, y, z] = self.axes();
        self.image(z.0 * y.0 * x.0)
    }

    /// The derivatives of the rotation by α₁, α₂, α₃.
    fn rotation_slopes(&self) -> [Mat3; 3] {
        let [x, y, z] = self.axes();
        let slopes = [z.0 * y.0 * x.1, z.0 * y.1 * x.0, z.1 * y.0 * x.0];
        slopes.map(|slope| self.image(slope))
    }

    fn image(&self, rotation: Mat3) -> Mat3 {
        self.frame * rotation * self.frame.transpose()
    }

    /// Rotation about each axis with its derivative.
    fn axes(&self) -> [(Mat3, Mat3); 3] {
        let mut axes = [(Mat3::identity(), Mat3::zeros()); 3];
        for (k, (rotation, slope)) in axes.iter_mut().enumerate() {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let (sin, cos) = self.angles[k].sin_cos();
            for (matrix, on, off) in [(rotation, cos, sin), (slope, -sin, cos)] {
                matrix[(i, i)] = on;
                matrix[(j, j)] = on;
                matrix[(i, j)] = -off;
                matrix[(j, i)] = off;
            }
        }
        axes
    }
}

/// Where a handle is, and whose motion it has.
#[derive(Clone, Debug)]
struct Seat {
    /// The vertex of the patch that it is at.
    vertex: usize,
    /// c [m].
    center: Vec3,
    /// Q of the isometry by which it is an image; 1 of one that is none.
    frame: Mat3,
    /// Index of the handle with variables that it is, or is an image of.
    own: usize,
}

/// A weight for each vertex, by handle [1].
type Weights = Arc<Vec<Vec<f64>>>;

/// Handles on a surface patch.
#[derive(Clone, Debug)]
pub struct Handles {
    /// Vertex ids of the patch, ascending, rim included.
    vertices: Vec<usize>,
    /// Handles and images.
    seats: Vec<Seat>,
    /// r of each handle that is no image [m].
    radii: Vec<f64>,
    /// Which numbers of its motion are variables.
    free: Vec<[bool; NUMBERS]>,
    /// Weights by seat, in the order of `vertices`.
    weights: Weights,
    /// Normals of planes, with the weights of the motion along them.
    across: Vec<(Vec3, Weights)>,
    /// Indices in `vertices` of those that lie in planes, with orthonormal directions in which they
    /// do not move.
    in_planes: Vec<(usize, Vec<Vec3>)>,
    /// d of each vertex.
    normals: Vec<Vec3>,
    motion: HandleMotion,
}

/// A patch for handles.
struct Site<'a> {
    surface: SurfaceMesh,
    vertices: Vec<usize>,
    rim: Vec<usize>,
    held: Held<'a>,
    edge: f64,
    normals: Vec<Vec3>,
}

/// Spreads `count` handles evenly over a patch of a mesh at rest positions `rest`, and computes
/// their weights. By each isometry of the patch in itself, `own`, a handle has an image.
pub fn sample_handles(
    rest: &[Vec3],
    patch: &[[usize; 3]],
    held: Held,
    (count, motion): (usize, HandleMotion),
    own: &[Isometry],
) -> Result<Handles> {
    let site = Site::new(rest, patch, held);
    let images = |v: usize| site.images(v, own);
    let points = spread_points(&site.surface, &site.rim, count, &images)?;
    let (mut seats, mut free) = (Vec::new(), Vec::new());
    for (i, &point) in points.iter().enumerate() {
        let at = site.surface.vertices[point];
        let images = images(point);
        let alone = images.is_empty();
        let all = || own.iter().map(|g| g.image(&at));
        let center = if alone { all().sum::<Vec3>() + at } else { at };
        let center = if alone { center / (own.len() + 1) as f64 } else { center };
        seats.push(Seat { vertex: point, center, frame: Mat3::identity(), own: i });
        let image = |(vertex, g): (usize, &Isometry)| Seat {
            vertex,
            center: g.image(&at),
            frame: g.linear,
            own: i,
        };
        seats.extend(images.into_iter().zip(own).map(image));
        free.push(if alone { kept(own) } else { [true; NUMBERS] });
    }
    site.handles(seats, free, motion, None)
}

/// The numbers of a motion that is its own image by all these isometries.
fn kept(own: &[Isometry]) -> [bool; NUMBERS] {
    std::array::from_fn(|k| match k {
        0..3 => own.iter().all(|g| g.keeps(k)[1]),
        3..6 => own.iter().all(|g| g.keeps(k - 3)[0]),
        _ => true,
    })
}

impl<'a> Site<'a> {
    fn new(rest: &[Vec3], patch: &[[usize; 3]], held: Held<'a>) -> Self {
        let (surface, vertices) = topology::submesh(rest, patch);
        let rim = held.rim(&surface, &vertices);
        let edge = mean_edge(&surface.vertices, &surface.triangles);
        let normals = shifts(rest, patch).into_values().collect();
        Self { surface, vertices, rim, held, edge, normals }
    }

    /// The vertex off the rim that is nearest to a point.
    fn nearest(&self, to: &Vec3) -> Option<usize> {
        let free = (0..self.vertices.len()).filter(|v| self.rim.binary_search(v).is_err());
        let distance = |v: &usize| (self.surface.vertices[*v] - to).norm_squared();
        free.min_by(|a, b| distance(a).total_cmp(&distance(b)))
    }

    /// The images of a vertex; none of one that is within half an edge of its plane or axis of symmetry.
    fn images(&self, vertex: usize, own: &[Isometry]) -> Vec<usize> {
        let at = self.surface.vertices[vertex];
        let images = own.iter().map(|g| g.image(&at));
        if images.clone().any(|image| (image - at).norm() < self.edge) {
            return Vec::new();
        }
        images.filter_map(|image| self.nearest(&image)).collect()
    }

    /// The handles at these seats; the radii are those of their weights, if not given.
    fn handles(
        self,
        seats: Vec<Seat>,
        free: Vec<[bool; NUMBERS]>,
        motion: HandleMotion,
        radii: Option<Vec<f64>>,
    ) -> Result<Handles> {
        let points: Vec<usize> = seats.iter().map(|seat| seat.vertex).collect();
        let Self { surface, vertices, rim, held, edge, normals } = self;
        let wanted = points.len();
        ensure!(
            points.iter().collect::<BTreeSet<_>>().len() == wanted,
            "of the {wanted} handles with their images two are at the same vertex: the surface has {} vertices off its \
             rim; ask for fewer handles or take a finer mesh",
            vertices.len() - rim.len()
        );
        let weights = Arc::new(bounded_biharmonic(&surface, &rim, &points)?);
        let mut across = Vec::new();
        for normal in held.normals() {
            let in_plane: Vec<usize> =
                (0..vertices.len()).filter(|&v| held.along(vertices[v], &normal)).collect();
            if !in_plane.is_empty() {
                let mut stays = [in_plane, rim.clone()].concat();
                stays.sort_unstable();
                stays.dedup();
                across.push((normal, Arc::new(weights_across(&surface, &stays, &points)?)));
            }
        }
        let fixed = vertices.iter().map(|&v| held.directions(v).0).enumerate();
        let in_planes = fixed.filter(|(_, fixed)| !fixed.is_empty()).collect();
        let of_seat = |own: usize| {
            let i = seats.iter().position(|seat| seat.own == own).unwrap_or(0);
            radius(&surface.vertices, &seats[i].center, &weights[i]).max(edge)
        };
        let radii = radii.unwrap_or_else(|| (0..free.len()).map(of_seat).collect());
        Ok(Handles { vertices, seats, radii, free, weights, across, in_planes, normals, motion })
    }
}

/// Weights of the handles for the component across a plane, zero at the `held` vertices in it;
/// a handle that is one of them does not move across it at all.
fn weights_across(
    surface: &SurfaceMesh,
    held: &[usize],
    points: &[usize],
) -> Result<Vec<Vec<f64>>> {
    let is_held = |point: &usize| held.binary_search(point).is_ok();
    let free: Vec<usize> = points.iter().copied().filter(|p| !is_held(p)).collect();
    let mut weights = bounded_biharmonic(surface, held, &free)?.into_iter();
    let none = || vec![0.0; surface.vertices.len()];
    let one = |p: &usize| if is_held(p) { Some(none()) } else { weights.next() };
    Ok(points.iter().map(one).map(Option::unwrap_or_default).collect())
}

/// Root mean square distance to `center`, weighted with w² [m].
fn radius(vertices: &[Vec3], center: &Vec3, weights: &[f64]) -> f64 {
    let squares =
        || vertices.iter().zip(weights).map(|(v, w)| (w * w, (v - center).norm_squared()));
    let (moment, total) = squares().fold((0.0, 0.0), |(m, t), (w2, d2)| (m + w2 * d2, t + w2));
    (moment / total).sqrt()
}

impl Handles {
    /// The handles of the image of the patch by an isometry, with the same variables; `rest`, `patch` and `held` are those of
    /// the image.
    pub fn image(
        &self,
        by: &Isometry,
        rest: &[Vec3],
        patch: &[[usize; 3]],
        held: Held,
    ) -> Result<Self> {
        let site = Site::new(rest, patch, held);
        let image = |seat: &Seat| {
            let center = by.image(&seat.center);
            let vertex = site.nearest(&center)?;
            Some(Seat { vertex, center, frame: by.linear * seat.frame, own: seat.own })
        };
        let seats: Option<Vec<Seat>> = self.seats.iter().map(image).collect();
        let seats = seats.context("the image of the tag has no vertex off its rim")?;
        site.handles(seats, self.free.clone(), self.motion, Some(self.radii.clone()))
    }

    /// Number of design variables.
    pub fn variables(&self) -> usize {
        self.places().concat().into_iter().flatten().count()
    }

    /// Index among the variables of each number of the motion of each handle that is no image; none where it is 0.
    fn places(&self) -> Vec<[Option<usize>; NUMBERS]> {
        let has = match self.motion {
            HandleMotion::Rigid => 0..6,
            HandleMotion::RigidAndOffset => 0..NUMBERS,
            HandleMotion::Translation => 3..6,
        };
        let mut next = 0..;
        let mut place = |free: bool, k: usize| (free && has.contains(&k)).then(|| next.next());
        let all = self.free.iter();
        all.map(|free| std::array::from_fn(|k| place(free[k], k).flatten())).collect()
    }

    /// Vertex ids of the patch, ascending, rim included.
    pub fn vertices(&self) -> &[usize] {
        &self.vertices
    }

    /// Positions of the patch vertices for variables `theta` [m], from the rest
    /// positions `rest` of the whole mesh with which the handles were made.
    pub fn apply(&self, theta: &[f64], rest: &[Vec3]) -> Vec<Vec3> {
        let mut way = vec![Vec3::zeros(); self.vertices.len()];
        for (j, motion) in self.motions(theta).iter().enumerate() {
            let turn = motion.rotation() - Mat3::identity();
            let translation = motion.frame * motion.translation;
            for (i, &v) in self.vertices.iter().enumerate() {
                let arm = rest[v] - self.seats[j].center;
                let moved = turn * arm + translation + motion.offset * self.normals[i];
                way[i] += self.weighted(j, i, &moved);
            }
        }
        self.project(&mut way);
        self.vertices.iter().zip(way).map(|(&v, way)| rest[v] + way).collect()
    }

    /// (∂v'/∂θ)ᵀ `bar` for cotangents of the patch vertices.
    pub fn vjp(&self, theta: &[f64], rest: &[Vec3], bar: &[Vec3]) -> Vec<f64> {
        assert_eq!(bar.len(), self.vertices.len(), "one cotangent per patch vertex");
        let mut bar = bar.to_vec();
        self.project(&mut bar);
        let places = self.places();
        let mut gradient = vec![0.0; self.variables()];
        for (j, (motion, seat)) in self.motions(theta).iter().zip(&self.seats).enumerate() {
            // the derivatives by the numbers need only Σ w v̄, Σ w v̄ (v − c)ᵀ and Σ w v̄·d
            let (mut force, mut moment, mut outward) = (Vec3::zeros(), Mat3::zeros(), 0.0);
            for (i, &v) in
                self.vertices.iter().enumerate().filter(|(i, _)| bar[*i] != Vec3::zeros())
            {
                let pull = self.weighted(j, i, &bar[i]);
                force += pull;
                outward += pull.dot(&self.normals[i]);
                moment += pull * (rest[v] - seat.center).transpose();
            }
            let force = motion.frame.transpose() * force;
            let [x, y, z] =
                motion.rotation_slopes().map(|by| by.dot(&moment) / self.radii[seat.own]);
            let by_number = [x, y, z, force.x, force.y, force.z, outward];
            for (place, by) in places[seat.own].iter().zip(by_number) {
                place.iter().for_each(|&place| gradient[place] += by);
            }
        }
        gradient
    }

    /// (w + Σ_n (w_n − w) n nᵀ) d, with the weights of handle j at vertex i: symmetric in d.
    fn weighted(&self, j: usize, i: usize, d: &Vec3) -> Vec3 {
        let w = self.weights[j][i];
        let add =
            |sum: Vec3, (n, across): &(Vec3, Weights)| sum + (across[j][i] - w) * n.dot(d) * n;
        self.across.iter().fold(w * d, add)
    }

    /// Takes from vectors at the vertices what leads out of planes in which they stay.
    fn project(&self, vectors: &mut [Vec3]) {
        for (i, fixed) in &self.in_planes {
            vectors[*i] = off(fixed, &vectors[*i]);
        }
    }

    /// The motion of each handle and image.
    fn motions(&self, theta: &[f64]) -> Vec<Motion> {
        assert_eq!(theta.len(), self.variables(), "variables of all handles");
        let places = self.places();
        let motion = |seat: &Seat| {
            let number = |k: usize| places[seat.own][k].map_or(0.0, |place| theta[place]);
            Motion {
                angles: [0, 1, 2].map(|k| number(k) / self.radii[seat.own]),
                translation: Vec3::new(number(3), number(4), number(5)),
                offset: number(6),
                frame: seat.frame,
            }
        };
        self.seats.iter().map(motion).collect()
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use mechanics::testing::sphere;

    use super::*;

    #[test]
    fn one_handle_on_a_closed_surface_is_a_rigid_motion() {
        let ball = sphere(2);
        let handles = sample_handles(
            &ball.vertices,
            &ball.triangles,
            Held::default(),
            (1, HandleMotion::Rigid),
            &[],
        )
        .unwrap();
        let moved = handles.apply(&[0.3, -0.8, 0.5, 1.0, 2.0, 3.0], &ball.vertices);
        let distances = |x: &[Vec3]| -> Vec<f64> { x.iter().map(|v| (v - x[7]).norm()).collect() };
        for (a, b) in distances(&moved).iter().zip(distances(&ball.vertices)) {
            // weights are one to 1e-8
            assert!((a - b).abs() < 1e-7, "{a} {b}");
        }
    }

    /// A quarter turn about x, then y, then z: e_z → −e_y → −e_y → e_x.
    #[test]
    fn rotations_are_about_x_then_y_then_z() {
        let motion = Motion {
            angles: [std::f64::consts::FRAC_PI_2; 3],
            translation: Vec3::zeros(),
            offset: 0.0,
            frame: Mat3::identity(),
        };
        assert!((motion.rotation() * Vec3::z() - Vec3::x()).norm() < 1e-15);
    }
}
