//! Maps that keep distances, by which tags of a body are images of each other.
//!
//! g(x) = Q x + b,   Qᵀ Q = 1
//!
//! The image of a motion v ↦ T v is v ↦ g(T g⁻¹(v)). Of a rotation R about c with a translation t that is Q R Qᵀ about g(c)
//! with Q t: exact for rotations of any size. By its axis ω, a rotation becomes det(Q) Q ω.

use anyhow::{Result, ensure};
use mesh::bvh::SurfaceBvh;
use mesh::measure::mean_edge;
use mesh::{Vec3, topology};
use nalgebra::{Rotation3, Unit};
use scene::config::SymmetricConfig;

type Mat3 = nalgebra::Matrix3<f64>;

/// Largest distance of an image from where it should be, in mean edges [1]: rims of tags follow the edges of the mesh.
const APART: f64 = 1.0;
/// Rounding of a direction that stays the same [1].
const SAME: f64 = 1e-9;

/// One such map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Isometry {
    /// Q.
    pub linear: Mat3,
    /// b [m].
    shift: Vec3,
}

impl Isometry {
    /// The map from the first tag of a symmetry to that at a place in it; of one tag alone, its image of this number.
    pub fn of(symmetric: &SymmetricConfig, place: usize) -> Self {
        let axis = |axis: scene::config::Axis| Vec3::ith(axis as usize, 1.0);
        let about = |linear: Mat3, fixed: Vec3| Self { linear, shift: fixed - linear * fixed };
        if let (Some(mirror), true) = (&symmetric.mirror, place > 0) {
            let n = axis(mirror.axis);
            return about(Mat3::identity() - 2.0 * n * n.transpose(), mirror.at * n);
        }
        if let Some(turn) = &symmetric.turn {
            let angle = (place as f64 * turn.angle).to_radians();
            let turned = Rotation3::from_axis_angle(&Unit::new_unchecked(axis(turn.axis)), angle);
            return about(turned.into_inner(), turn.through.into());
        }
        let shift = symmetric.shift.map_or(Vec3::zeros(), Vec3::from);
        Self { linear: Mat3::identity(), shift: place as f64 * shift }
    }

    /// The images of a tag in itself; none of one that is no image of itself.
    pub fn own(symmetric: &SymmetricConfig) -> Vec<Self> {
        (1..=symmetric.own_images()).map(|place| Self::of(symmetric, place)).collect()
    }

    /// g(x) [m].
    pub fn image(&self, x: &Vec3) -> Vec3 {
        self.linear * x + self.shift
    }

    /// Whether a translation along an axis is its own image, and whether a rotation about it is.
    pub fn keeps(&self, axis: usize) -> [bool; 2] {
        let along = Vec3::ith(axis, 1.0);
        let image = self.linear * along;
        let about = self.linear.determinant() * image;
        [image, about].map(|image| (image - along).norm() < SAME)
    }

    /// Checks that the image of a tag is where the other tag is; of each, its name and facets.
    pub fn check_there(
        &self,
        symmetric: &SymmetricConfig,
        rest: &[Vec3],
        [first, other]: [(&str, &[[usize; 3]]); 2],
    ) -> Result<()> {
        let edge = mean_edge(rest, first.1);
        let [(mut image, _), (there, _)] = [first.1, other.1].map(|f| topology::submesh(rest, f));
        image.vertices.iter_mut().for_each(|x| *x = self.image(x));
        let surfaces = [image, there];
        let trees = [&surfaces[0], &surfaces[1]].map(SurfaceBvh::new);
        let off = |k: usize| {
            let one = |x: &Vec3| (trees[1 - k].closest(x).distance, *x);
            surfaces[k].vertices.iter().map(one).max_by(|a, b| a.0.total_cmp(&b.0))
        };
        let farthest = [off(0), off(1)].into_iter().flatten().max_by(|a, b| a.0.total_cmp(&b.0));
        let (distance, at) = farthest.unwrap_or_default();
        let what = format!(
            ": the image of \"{}\" is not where \"{}\" is: up to {:.3} mm apart, {:.1} mean edges, at ({:.2}, {:.2}, {:.2}) \
             mm; expected at most {APART:.0} mean edge",
            first.0,
            other.0,
            1e3 * distance,
            distance / edge,
            1e3 * at.x,
            1e3 * at.y,
            1e3 * at.z
        );
        ensure!(distance <= APART * edge, symmetric.refused("of", &what));
        Ok(())
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use mechanics::math::random::Random;
    use mechanics::testing::{cap, sphere};
    use mesh::SurfaceMesh;
    use scene::config::{HandleMotion, Moves};

    use super::*;
    use crate::map::held::Held;
    use crate::map::patch::Patch;

    /// Weights of quadratic programs are exact to 1e-8, and the shape moves by about 1.
    const EXACT: f64 = 1e-6;

    const MIRROR: &str = "mirror = { axis = \"x\", at = 2 }";

    fn symmetric(of: &str, how: &str) -> SymmetricConfig {
        toml::from_str(&format!("of = {of}\n{how}")).unwrap()
    }

    /// A surface with an image beside it, and the facets of both.
    fn pair(surface: &SurfaceMesh, by: &Isometry) -> (Vec<Vec3>, [Vec<[usize; 3]>; 2]) {
        let n = surface.vertices.len();
        let flips = by.linear.determinant() < 0.0;
        let order = |[a, b, c]: [usize; 3]| if flips { [a, c, b] } else { [a, b, c] };
        let image = surface.triangles.iter().map(|t| order(t.map(|v| v + n))).collect();
        let both = surface.vertices.iter().copied();
        let rest = both.chain(surface.vertices.iter().map(|x| by.image(x))).collect();
        (rest, [surface.triangles.clone(), image])
    }

    fn motions() -> [Moves; 4] {
        let handles = |motion| Moves::Handles(3, motion);
        [
            handles(HandleMotion::Rigid),
            handles(HandleMotion::Translation),
            handles(HandleMotion::RigidAndOffset),
            Moves::Offset,
        ]
    }

    #[test]
    fn the_image_moves_by_the_image_of_the_motion() {
        let turn = "turn = { axis = \"y\", through = [3, 0, 0], angle = 100 }";
        for how in [MIRROR, "shift = [3, 1, 0]", turn] {
            let by = Isometry::of(&symmetric("[\"a\", \"b\"]", how), 1);
            let (rest, [first, other]) = pair(&cap(2), &by);
            for moves in motions() {
                let held = Held::default();
                let patch = Patch::new(&rest, &first, held, moves, &[]).unwrap();
                let image = patch.image(&by, &rest, &other, held).unwrap();
                let theta = Random::new(5).numbers(patch.variables());
                assert_eq!(image.variables(), theta.len());
                let moved = patch.apply(&theta, &rest).into_iter().zip(image.apply(&theta, &rest));
                let off = moved.map(|(a, b)| (by.image(&a) - b).norm()).fold(0.0, f64::max);
                assert!(off < EXACT, "{how} {moves:?}: {off}");
            }
        }
    }

    #[test]
    fn one_tag_stays_its_own_image() {
        let ball = sphere(3);
        let x = &ball.vertices;
        let quarter = "turn = { axis = \"z\", angle = 90 }";
        for how in ["mirror = { axis = \"x\", at = 0 }", quarter] {
            let own = Isometry::own(&symmetric("\"a\"", how));
            assert_eq!(own.len(), if how == quarter { 3 } else { 1 });
            for moves in motions() {
                let held = Held::default();
                let patch = Patch::new(x, &ball.triangles, held, moves, &own);
                let patch = patch.unwrap();
                let theta = Random::new(6).numbers(patch.variables());
                let theta: Vec<f64> = theta.iter().map(|t| 0.3 * t).collect();
                let moved = patch.apply(&theta, x);
                let nearest = |at: Vec3| (0..x.len()).find(|&v| (x[v] - at).norm() < 1e-9).unwrap();
                for by in &own {
                    let off =
                        |v: usize| (by.image(&moved[v]) - moved[nearest(by.image(&x[v]))]).norm();
                    let off = (0..x.len()).map(off).fold(0.0, f64::max);
                    assert!(off < EXACT, "{how} {moves:?}: {off}");
                }
            }
        }
    }

    /// The first handle on the ball is at (−1, 0, 0), in the plane: it keeps the translations along the plane, the rotation about
    /// its normal and the offset.
    #[test]
    fn a_handle_in_the_plane_keeps_what_the_plane_allows() {
        let ball = sphere(3);
        let own = Isometry::own(&symmetric("\"a\"", "mirror = { axis = \"y\", at = 0 }"));
        let variables = |motion| {
            let moves = Moves::Handles(1, motion);
            let held = Held::default();
            let patch = Patch::new(&ball.vertices, &ball.triangles, held, moves, &own);
            patch.unwrap().variables()
        };
        assert_eq!(variables(HandleMotion::Rigid), 3);
        assert_eq!(variables(HandleMotion::Translation), 2);
        assert_eq!(variables(HandleMotion::RigidAndOffset), 4);
    }
}
