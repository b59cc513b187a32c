//! Principal stretches of a state against those of the tests that its materials were fitted to, and against
//! the stretch at which they tear.
//!
//! The stretches λᵢ are the singular values of F = I + ∇u at the quadrature
//! points. A law is extrapolated where the largest one exceeds the largest stretch of its tests, or the smallest
//! one falls below the smallest; and, where it is strained notably, in a mode in which it was not tested. The largest is
//! compared with the uniaxial stretch at break, too: what a datasheet has, although a notch or a biaxial state
//! tears earlier.

use std::ops::Range;

use mesh::Vec3;

use crate::element::{FunctionSpace, add_at};
use crate::material::Kinematics;
use crate::material::response::Mode;
use crate::math::tensor::{Mat3, cofactor};
use crate::parallel::fill;

/// Stretch from which on it matters in which mode it is [1]: below, laws that agree in one mode agree nearly in all.
const NOTABLE: f64 = 1.2;

/// How far the material of some elements may be stretched.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Limits {
    /// What messages call it; empty where there is one alone.
    pub name: String,
    /// The elements.
    pub elements: Range<usize>,
    /// Smallest and largest principal stretch of its tests [1], if they are known.
    pub tested: Option<[f64; 2]>,
    /// Modes of its tests; none where they are not known.
    pub modes: Vec<Mode>,
    /// Uniaxial stretch at which it tears [1], if it is known.
    pub at_break: Option<f64>,
}

/// A principal stretch that no other exceeds, or falls below.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extreme {
    /// The stretch [1].
    pub stretch: f64,
    /// Rest centre of its tetrahedron [m].
    pub at: [f64; 3],
}

/// How far a state strains one material.
#[derive(Clone, Debug, PartialEq)]
pub struct Strained {
    /// What the material allows.
    pub limits: Limits,
    /// Smallest principal stretch of a quadrature point.
    pub smallest: Extreme,
    /// Largest principal stretch of a quadrature point.
    pub largest: Extreme,
    /// Rest volume [m³].
    pub volume: f64,
    /// Rest volume of the tetrahedra with a quadrature point beyond the tests, as a part of it [1].
    pub beyond: f64,
    /// Rest volume of the tetrahedra that are strained notably, each in the mode that its most strained point is
    /// nearest to, as a part of it [1]. Only modes that were not tested, where it is known which were.
    pub untested: Vec<(Mode, f64)>,
}

/// How far a state strains its materials.
#[derive(Clone, Debug, PartialEq)]
pub struct Stretches {
    /// Smallest principal stretch of a quadrature point.
    pub smallest: Extreme,
    /// Largest principal stretch of a quadrature point.
    pub largest: Extreme,
    /// Rest volume of the tetrahedra with a quadrature point beyond the tests of their material, as a part of the body [1].
    pub volume_beyond: f64,
    /// Stretch at break over the largest stretch [1], if it is known: it tears below 1.
    pub margin: Option<f64>,
    /// Least of the stretches at break [1], if one is known.
    pub at_break: Option<f64>,
    /// Of each material.
    pub materials: Vec<Strained>,
}

impl Stretches {
    /// Stretches at the displacement u.
    pub fn of(space: &FunctionSpace, rest: &[Vec3], u: &[f64], limits: Vec<Limits>) -> Self {
        let ranges = fill(space.tets().len(), 1, Strain::NONE, |range, ranges| {
            for (e, own) in range.zip(ranges) {
                *own = Strain::of(space.displacement_gradients(rest, u, e));
            }
        });
        let at_break = limits.iter().filter_map(|limits| limits.at_break).reduce(f64::min);
        let one = |limits: Limits| Strained::of(space, rest, &ranges, limits);
        let materials: Vec<Strained> = limits.into_iter().map(one).collect();
        let all = || materials.iter();
        let smallest = all().map(|own| own.smallest).fold(Extreme::NONE, Extreme::lesser);
        let largest = all().map(|own| own.largest).fold(Extreme::NONE, Extreme::greater);
        let volume: f64 = all().map(|own| own.volume).sum();
        let beyond: f64 = all().map(|own| own.beyond * own.volume).sum();
        let margin = at_break.map(|at_break| at_break / largest.stretch);
        Self { smallest, largest, volume_beyond: beyond / volume, margin, at_break, materials }
    }

    /// The warnings for the user.
    pub fn warnings(&self) -> Vec<String> {
        let extrapolated = self.materials.iter().filter_map(Strained::warning);
        let torn = self.at_break.filter(|at_break| self.largest.stretch >= *at_break);
        let torn = torn.map(|at_break| {
            format!(
                "{}: the silicone tears at {at_break:.3}: lower the load, or thicken the wall",
                self.largest.in_words("largest")
            )
        });
        extrapolated.chain(torn).collect()
    }
}

impl Extreme {
    /// At rest.
    const NONE: Self = Self { stretch: 1.0, at: [0.0; 3] };

    fn lesser(self, other: Self) -> Self {
        if other.stretch < self.stretch { other } else { self }
    }

    fn greater(self, other: Self) -> Self {
        if other.stretch > self.stretch { other } else { self }
    }

    fn in_words(&self, which: &str) -> String {
        let [x, y, z] = self.at;
        format!("{which} principal stretch {:.3} at ({x:.5}, {y:.5}, {z:.5}) m", self.stretch)
    }
}

impl Strained {
    fn of(space: &FunctionSpace, rest: &[Vec3], ranges: &[Strain], limits: Limits) -> Self {
        let [low, high] = limits.tested.unwrap_or([0.0, f64::INFINITY]);
        let (mut smallest, mut largest) = (Extreme::NONE, Extreme::NONE);
        let (mut volume, mut beyond) = (0.0, 0.0);
        let untested = Mode::ALL.into_iter().filter(|mode| !limits.modes.contains(mode));
        let mut untested: Vec<(Mode, f64)> = untested.map(|mode| (mode, 0.0)).collect();
        for e in limits.elements.clone() {
            let [a, b, c, d] = space.tets()[e].map(|v| rest[v]);
            let own = mesh::measure::tet_volume(a, b, c, d);
            let found = &ranges[e];
            let extreme = |stretch: f64| Extreme { stretch, at: ((a + b + c + d) / 4.0).into() };
            volume += own;
            if found.high > high || found.low < low {
                beyond += own;
            }
            smallest = smallest.lesser(extreme(found.low));
            largest = largest.greater(extreme(found.high));
            let notable = found.high > NOTABLE || found.low < 1.0 / NOTABLE;
            let mode = untested.iter_mut().find(|(mode, _)| notable && Some(*mode) == found.mode);
            mode.into_iter().for_each(|(_, sum)| *sum += own);
        }
        untested.retain(|(_, sum)| !limits.modes.is_empty() && *sum > 0.0);
        untested.iter_mut().for_each(|(_, sum)| *sum /= volume);
        Self { limits, smallest, largest, volume, beyond: beyond / volume, untested }
    }

    /// What is said where the state is beyond the tests.
    fn warning(&self) -> Option<String> {
        let [low, high] = self.limits.tested?;
        let mut told = Vec::new();
        if self.largest.stretch > high {
            let words = self.largest.in_words("largest");
            told.push(format!("{words}: the material was fitted up to {high:.3}"));
        }
        if self.smallest.stretch < low {
            let words = self.smallest.in_words("smallest");
            told.push(format!("{words}: the material was fitted down to {low:.3}"));
        }
        if told.is_empty() {
            return None;
        }
        let name = &self.limits.name;
        let (on, of) = match name.is_empty() {
            true => (String::new(), "the body".to_owned()),
            false => (format!("\"{name}\": "), format!("\"{name}\"")),
        };
        let mut words =
            format!("{on}{}, and {:.3} % of {of} is beyond", told.join("; "), 100.0 * self.beyond);
        if !self.untested.is_empty() {
            let tested: Vec<_> = self.limits.modes.iter().map(|mode| mode.state()).collect();
            let other = self.untested.iter();
            let other: Vec<_> = other
                .map(|(mode, part)| format!("{:.1} % {}", 100.0 * part, mode.state()))
                .collect();
            words += &format!(
                "\n  it was tested in {}, and is strained otherwise in {}",
                tested.join(", "),
                other.join(", ")
            );
        }
        Some(
            words
                + "\n  what is computed there is an extrapolation: test the silicone further, or lower the load",
        )
    }
}

/// The largest principal stretch of a state, that of [`Stretches`], and where it is.
///
/// s = max λ = |F N|,   n = F N / s,   S = n Nᵀ
/// ∂s/∂u_a = S ∇φ_a,   ∂s/∂X_k = −∇uᵀ S ∇ψ_k      at fixed nodal u
///
/// φ   basis of the displacement;   ψ   linear basis of the rest shape
///
/// It is a maximum: where two points, or two principal stretches of one point, have it together, it has a kink, and this
/// is its derivative on one side of that.
#[derive(Clone, Copy, Debug)]
pub struct LargestStretch {
    /// s [1].
    pub value: f64,
    /// Tetrahedron.
    pub element: usize,
    /// Point of its volume rule.
    pub point: usize,
}

impl LargestStretch {
    /// At the displacement u.
    pub fn of(space: &FunctionSpace, rest: &[Vec3], u: &[f64]) -> Self {
        let count = space.tets().len();
        let each = fill(count, 1, (f64::NEG_INFINITY, 0), |range, each| {
            for (element, own) in range.zip(each) {
                for (point, grad_u) in space.displacement_gradients(rest, u, element).enumerate() {
                    let [high, ..] = principal(&grad_u);
                    if high > own.0 {
                        *own = (high, point);
                    }
                }
            }
        });
        let mut found = Self { value: f64::NEG_INFINITY, element: 0, point: 0 };
        for (element, (value, point)) in each.into_iter().enumerate() {
            if value > found.value {
                found = Self { value, element, point };
            }
        }
        found
    }

    /// ∂s/∂u, three components per node, and ∂s/∂X [1/m], three per vertex.
    pub fn partials(
        &self,
        space: &FunctionSpace,
        rest: &[Vec3],
        u: &[f64],
    ) -> (Vec<f64>, Vec<f64>) {
        let Self { element, point, .. } = *self;
        let (mut by_u, mut by_rest) = (vec![0.0; u.len()], vec![0.0; 3 * rest.len()]);
        let Some(grad_u) = space.displacement_gradients(rest, u, element).nth(point) else {
            return (by_u, by_rest);
        };
        let f = Mat3::identity() + grad_u;
        let eigen = (f.transpose() * f).symmetric_eigen();
        let material = eigen.eigenvectors.column(eigen.eigenvalues.imax());
        let spatial = (f * material).normalize();
        let slope = spatial * material.transpose();
        let corners = space.tets()[element];
        let [a, b, c, d] = corners.map(|v| rest[v]);
        let edges = Mat3::from_columns(&[b - a, c - a, d - a]);
        let to_rest = cofactor(&edges) / edges.determinant();
        let n = space.nodes_per_element();
        let nodes = &space.element_nodes()[n * element..n * (element + 1)];
        for (&node, gradient) in nodes.iter().zip(&space.volume_table().gradients[point]) {
            add_at(&mut by_u, node, &(slope * (to_rest * Vec3::from(*gradient))));
        }
        let turned = grad_u.transpose() * slope;
        for (k, &vertex) in corners[1..].iter().enumerate() {
            let by = turned * to_rest.column(k);
            add_at(&mut by_rest, vertex, &-by);
            add_at(&mut by_rest, corners[0], &by);
        }
        (by_u, by_rest)
    }
}

/// Principal stretches at ∇u, the largest first.
fn principal(grad_u: &Mat3) -> [f64; 3] {
    let squares = Kinematics::new(grad_u).left_minus_1().symmetric_eigenvalues();
    let mut stretches = <[f64; 3]>::from(squares).map(|square| (1.0 + square).max(0.0).sqrt());
    stretches.sort_by(|a, b| b.total_cmp(a));
    stretches
}

/// Principal stretches of one element.
#[derive(Clone, Copy)]
struct Strain {
    low: f64,
    high: f64,
    /// That of the point with the largest ratio of both.
    mode: Option<Mode>,
}

impl Strain {
    /// At rest.
    const NONE: Self = Self { low: 1.0, high: 1.0, mode: None };

    /// By ∇u at its quadrature points.
    fn of(gradients: impl Iterator<Item = Mat3>) -> Self {
        let (mut found, mut most) = (Self::NONE, 1.0);
        for grad_u in gradients {
            let stretches @ [high, _, low] = principal(&grad_u);
            (found.low, found.high) = (found.low.min(low), found.high.max(high));
            if high / low > most {
                (most, found.mode) = (high / low, Some(Mode::nearest(stretches)));
            }
        }
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::math::linear::dot;
    use crate::math::random::Random;
    use crate::math::taylor::taylor;
    use crate::testing::{cube, flat};

    fn limits(space: &FunctionSpace, at_break: Option<f64>) -> Vec<Limits> {
        let elements = 0..space.tets().len();
        let (tested, modes) = (Some([0.6, 2.0]), vec![Mode::Uniaxial]);
        vec![Limits { name: String::new(), elements, tested, modes, at_break }]
    }

    /// The displacement of a homogeneous deformation.
    fn homogeneous(f: &Mat3) -> (FunctionSpace, Vec<Vec3>, Vec<f64>) {
        let mesh = cube(2, 0.2);
        let space = FunctionSpace::new(2, mesh.vertices.len(), mesh.tets.clone());
        let positions = space.node_positions(&mesh.vertices);
        let u = positions
            .iter()
            .flat_map(|x| {
                let u = (f - Mat3::identity()) * x;
                [u.x, u.y, u.z]
            })
            .collect();
        (space, mesh.vertices, u)
    }

    #[test]
    fn principal_stretches_are_found_whatever_the_rotation() {
        let q = nalgebra::Rotation3::from_euler_angles(0.3, -1.1, 2.0).into_inner();
        let f = q * Mat3::from_diagonal(&Vec3::new(2.5, 0.9, 0.65)) * q * q;
        let (space, rest, u) = homogeneous(&f);
        let found = Stretches::of(&space, &rest, &u, limits(&space, Some(2.2)));
        let [largest, smallest] = [&found.largest, &found.smallest].map(|of| of.stretch);
        assert!((largest - 2.5).abs() < 1e-12 && (smallest - 0.65).abs() < 1e-12);
        assert!((found.volume_beyond - 1.0).abs() < 1e-12);
        assert!((found.margin.expect("it is known") - 2.2 / 2.5).abs() < 1e-12);
        let [extrapolated, torn] = &found.warnings()[..] else { panic!("{:?}", found.warnings()) };
        assert!(extrapolated.contains("2.500") && extrapolated.contains("up to 2.000"));
        assert!(!extrapolated.contains("down to"), "{extrapolated}");
        assert!(torn.contains("tears at 2.200"), "{torn}");
    }

    /// A body that is squeezed is beyond tests of tension long before it is stretched as far as they were.
    #[test]
    fn what_is_squeezed_beyond_the_tests_is_said() {
        let (space, rest, u) = homogeneous(&Mat3::from_diagonal(&Vec3::new(1.9, 1.9, 0.277)));
        let found = Stretches::of(&space, &rest, &u, limits(&space, None));
        assert!((found.volume_beyond - 1.0).abs() < 1e-12);
        let [(mode, part)] = found.materials[0].untested[..] else { panic!("{found:?}") };
        assert!(mode == Mode::Biaxial && (part - 1.0).abs() < 1e-12);
        let [warning] = &found.warnings()[..] else { panic!("{:?}", found.warnings()) };
        for words in [
            "smallest principal stretch 0.277",
            "down to 0.600",
            "100.000 % of the body",
            "tested in tension",
            "100.0 % biaxial",
        ] {
            assert!(warning.contains(words), "{words}: {warning}");
        }
        assert!(!warning.contains("up to"), "{warning}");
    }

    #[test]
    fn within_the_range_nothing_is_said() {
        let (space, rest, u) = homogeneous(&Mat3::from_diagonal(&Vec3::new(1.5, 1.0, 0.7)));
        let found = Stretches::of(&space, &rest, &u, limits(&space, Some(8.0)));
        assert_eq!((found.warnings(), found.volume_beyond), (Vec::new(), 0.0));
        assert_eq!(found.materials[0].untested.len(), 1);
        let elements = 0..space.tets().len();
        let unknown = vec![Limits { elements, ..Limits::default() }];
        let unknown = Stretches::of(&space, &rest, &u, unknown);
        assert_eq!((unknown.warnings(), unknown.margin), (Vec::new(), None));
        assert!(unknown.materials[0].untested.is_empty());
    }

    /// Each material is compared with its own tests.
    #[test]
    fn volumes_have_their_own_tests() {
        let (space, rest, u) = homogeneous(&Mat3::from_diagonal(&Vec3::new(1.5, 1.0, 0.7)));
        let count = space.tets().len();
        let one = |name: &str, elements: Range<usize>, high: f64| Limits {
            name: name.to_owned(),
            elements,
            tested: Some([0.5, high]),
            ..Limits::default()
        };
        let both = vec![one("floor", 0..count / 4, 1.4), one("wall", count / 4..count, 3.0)];
        let found = Stretches::of(&space, &rest, &u, both);
        let [floor, wall] = &found.materials[..] else { panic!("{found:?}") };
        assert_eq!([floor.beyond, wall.beyond], [1.0, 0.0]);
        let part = floor.volume / (floor.volume + wall.volume);
        assert!((found.volume_beyond - part).abs() < 1e-12);
        let [warning] = &found.warnings()[..] else { panic!("{:?}", found.warnings()) };
        assert!(
            warning.starts_with("\"floor\": largest") && warning.contains("100.000 % of \"floor\"")
        );
    }

    /// By displacement and by rest shape, with all nodes and vertices moved.
    #[test]
    fn derivatives_of_the_largest_stretch_belong_to_it() {
        for degree in [1, 2, 3] {
            let mesh = cube(2, 0.2);
            let space = FunctionSpace::new(degree, mesh.vertices.len(), mesh.tets.clone());
            let mut random = Random::new(7);
            let u: Vec<f64> = flat(&random_vectors(&mut random, space.node_count(), 0.01));
            let found = LargestStretch::of(&space, &mesh.vertices, &u);
            let elements = 0..space.tets().len();
            let limits = vec![Limits { elements, ..Limits::default() }];
            let largest = Stretches::of(&space, &mesh.vertices, &u, limits).largest;
            assert_eq!(found.value, largest.stretch);
            let (by_u, by_rest) = found.partials(&space, &mesh.vertices, &u);
            let du = flat(&random_vectors(&mut random, space.node_count(), 1e-4));
            let dx = random_vectors(&mut random, mesh.vertices.len(), 1e-4);
            let slope = dot(&by_u, &du) + dot(&by_rest, &flat(&dx));
            let result = taylor(1.0, 6, slope, |by| {
                let u: Vec<f64> = u.iter().zip(&du).map(|(u, d)| u + by * d).collect();
                let rest: Vec<Vec3> =
                    mesh.vertices.iter().zip(&dx).map(|(x, d)| x + by * d).collect();
                Ok::<_, ()>(LargestStretch::of(&space, &rest, &u).value)
            });
            let result = result.expect("values");
            assert!((result.slope - 2.0).abs() < 0.1, "{degree} {result:?}");
        }
    }

    fn random_vectors(random: &mut Random, count: usize, size: f64) -> Vec<Vec3> {
        (0..count).map(|_| size * random.vector()).collect()
    }
}
