//! Minimum thickness of the wall between two parts of the rest surface.
//!
//! quadratic   J = Σ_k m_k (d_k² − d̂²)²                            for d_k < d̂
//! log         J = Σ_k m_k b(d_k² − d₀², d̂² + 2 d₀ d̂),  +∞ for d_k ≤ d₀,
//!                                                     acts for d_k < d₀ + d̂
//!
//! d_k   distance of pair k: a vertex of one side and a triangle of the other,
//!       or an edge of each [m]
//! m_k   parallel-edge mollifier, one for vertex–triangle pairs [1]
//! d̂     activation distance [m];   d₀ minimum distance [m]
//! b     log barrier of [`barrier`](crate::contact::barrier) [m⁴]
//!
//! J is in m⁴. Both forms are in *squared* distances and every pair counts once,
//! as in the published scenes, so that their weights (10⁶ … 10⁷ m⁻⁴) carry over;
//! near d̂ the quadratic form is 4 d̂² (d − d̂)². J grows with the number of
//! facets of a thin region.
//!
//! The two sides must not touch: next to a common rim every pair would be
//! "thin", whatever the shape. An open cavity is therefore compared with the
//! outer skin only, and the seat that holds its rim belongs to neither side.
//!
//! Source: Gjoka et al. 2024, equations (14) and (15), on the rest shape.

use mesh::bvh::SurfaceBvh;
use mesh::{Vec3, topology};

use super::{Equilibrium, Objective};
use crate::contact::barrier::{log_barrier, quadratic};
use crate::contact::pairs::{Features, Pair, pairs_between};
use crate::contact::potential;

/// The function of distance, with lengths in [m].
#[derive(Clone, Copy, Debug)]
enum Form {
    Quadratic { activation: f64 },
    Log { minimum: f64, activation: f64 },
}

impl Form {
    /// Distance from which on the term is zero [m].
    fn range(&self) -> f64 {
        match self {
            Self::Quadratic { activation } => *activation,
            Self::Log { minimum, activation } => minimum + activation,
        }
    }

    /// β and ∂β/∂d² at a squared distance.
    fn density(&self, d2: f64) -> (f64, f64) {
        match *self {
            Self::Quadratic { activation } => quadratic(d2, activation * activation),
            Self::Log { minimum, activation } => {
                let range = activation * (activation + 2.0 * minimum);
                let [b, slope, _] = log_barrier(d2 - minimum * minimum, range);
                (b, slope)
            }
        }
    }
}

/// The two sides of a wall have vertices in common.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error(
    "the two sides of the wall share {count} vertices, the first is {first}: no thickness is \
     defined there; leave the surface that joins them (the seat) out of both sides"
)]
pub struct SidesTouch {
    /// Number of shared vertices.
    pub count: usize,
    /// The smallest shared vertex id.
    pub first: usize,
}

/// Penalty on thin walls.
pub struct WallThickness {
    name: String,
    form: Form,
    inner: Features,
    outer: Features,
}

impl WallThickness {
    /// The quadratic form between two sets of facets, zero from `activation` on
    /// [m].
    ///
    /// # Errors
    /// [`SidesTouch`] if a vertex belongs to both sets.
    pub fn quadratic(
        name: &str,
        inner: &[[usize; 3]],
        outer: &[[usize; 3]],
        activation: f64,
    ) -> Result<Self, SidesTouch> {
        Self::new(name, inner, outer, Form::Quadratic { activation })
    }

    /// The log form between two sets of facets: infinite up to `minimum`, zero
    /// from `minimum + activation` on [m].
    ///
    /// # Errors
    /// [`SidesTouch`] if a vertex belongs to both sets.
    pub fn log(
        name: &str,
        inner: &[[usize; 3]],
        outer: &[[usize; 3]],
        minimum: f64,
        activation: f64,
    ) -> Result<Self, SidesTouch> {
        Self::new(name, inner, outer, Form::Log { minimum, activation })
    }

    fn new(
        name: &str,
        inner: &[[usize; 3]],
        outer: &[[usize; 3]],
        form: Form,
    ) -> Result<Self, SidesTouch> {
        let (inner, outer) = (Features::new(inner), Features::new(outer));
        let on_both = |v: &&usize| outer.vertices.binary_search(v).is_ok();
        let shared: Vec<usize> = inner.vertices.iter().filter(on_both).copied().collect();
        match shared.first() {
            Some(&first) => Err(SidesTouch { count: shared.len(), first }),
            None => Ok(Self { name: name.to_owned(), form, inner, outer }),
        }
    }

    /// J at rest positions.
    #[must_use]
    pub fn value_at(&self, rest: &[Vec3]) -> f64 {
        potential::value(&self.pairs(rest), rest, &|d2| self.form.density(d2))
    }

    /// Adds `weight` ∂J/∂X, three components per vertex; J must be finite.
    pub fn add_gradient_at(&self, rest: &[Vec3], weight: f64, out: &mut [f64]) {
        let density = |d2| self.form.density(d2);
        potential::add_gradient(&self.pairs(rest), rest, &density, weight, out);
    }

    /// Smallest distance between the two sides [m]; infinite if one is empty.
    #[must_use]
    pub fn min_distance(&self, rest: &[Vec3]) -> f64 {
        if self.outer.triangles.is_empty() {
            return f64::INFINITY;
        }
        let outer = SurfaceBvh::new(&topology::submesh(rest, &self.outer.triangles).0);
        let to_outer = |&v: &usize| outer.closest(&rest[v]).distance;
        // no pair but the closest ones is nearer than any vertex is
        let bound = self.inner.vertices.iter().map(to_outer).fold(f64::INFINITY, f64::min);
        let pairs = pairs_between(&self.inner, &self.outer, rest, bound);
        let distances = pairs.iter().map(|p| p.closest(&p.gather(rest)).d2.sqrt());
        distances.fold(bound, f64::min)
    }

    fn pairs(&self, rest: &[Vec3]) -> Vec<Pair> {
        pairs_between(&self.inner, &self.outer, rest, self.form.range())
    }
}

impl Objective for WallThickness {
    fn name(&self) -> &str {
        &self.name
    }

    fn admit(&self, rest: &[Vec3]) -> Result<(), String> {
        let Form::Log { minimum, .. } = self.form else { return Ok(()) };
        let found = self.min_distance(rest);
        if found > minimum {
            return Ok(());
        }
        Err(format!("the wall is {found:.3e} m thin, and must be thicker than {minimum:.3e} m"))
    }

    fn value(&self, at: &Equilibrium) -> f64 {
        self.value_at(at.rest)
    }

    fn add_du(&self, _: &Equilibrium, _: f64, _: &mut [f64]) {}

    fn add_drest(&self, at: &Equilibrium, weight: f64, out: &mut [f64]) {
        self.add_gradient_at(at.rest, weight, out);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::testing::{check_gradient, flat, points, sphere, square};

    /// Two bumpy squares at a distance of about `gap`.
    fn plates(gap: f64) -> (Vec<Vec3>, Vec<[usize; 3]>, Vec<[usize; 3]>) {
        let (a, b) = (square(5, 0.3), square(4, 0.2));
        let bump = |v: &Vec3| 0.02 * (3.0 * v.x + 2.0 * v.y).sin();
        let mut x: Vec<Vec3> = a.vertices.iter().map(|v| v + bump(v) * Vec3::z()).collect();
        let offset = x.len();
        x.extend(b.vertices.iter().map(|v| v + (gap - bump(v)) * Vec3::z()));
        let outer = b.triangles.iter().map(|t| t.map(|v| v + offset)).collect();
        (x, a.triangles, outer)
    }

    const FORMS: [Form; 2] =
        [Form::Quadratic { activation: 0.16 }, Form::Log { minimum: 0.04, activation: 0.12 }];

    #[test]
    fn gradient_belongs_to_the_value() {
        let (x, inner, outer) = plates(0.15);
        for form in FORMS {
            let wall = WallThickness::new("wall", &inner, &outer, form).unwrap();
            let mut gradient = vec![0.0; 3 * x.len()];
            wall.add_gradient_at(&x, 3.0, &mut gradient);
            let value = |y: &[f64]| 3.0 * wall.value_at(&points(y));
            check_gradient(&flat(&x), &gradient, 3e-4, value);
        }
    }

    /// One vertex 0.1 above the inside of one triangle, and nothing else in
    /// range: the closed form of a single pair.
    #[test]
    fn a_single_pair_has_its_closed_form() {
        let x = [
            [0.0, 0.0, 0.1],
            [0.0, 0.0, 9.0],
            [0.1, 0.0, 9.0],
            [-9.0, -9.0, 0.0],
            [9.0, -9.0, 0.0],
            [0.0, 9.0, 0.0],
        ]
        .map(Vec3::from);
        let value = |form| {
            let wall = WallThickness::new("wall", &[[0, 1, 2]], &[[3, 4, 5]], form);
            wall.unwrap().value_at(&x)
        };
        let quadratic = value(Form::Quadratic { activation: 0.12 });
        assert!((quadratic - (0.0144_f64 - 0.01).powi(2)).abs() < 1e-16);
        // s = 0.01 − 0.0064, ŝ = 0.0016 + 2 · 0.08 · 0.04
        let (s, activation) = (0.0036_f64, 0.008_f64);
        let expected = -(s - activation).powi(2) * (s / activation).ln();
        let log = value(Form::Log { minimum: 0.08, activation: 0.04 });
        assert!((log - expected).abs() < 1e-16);
        assert!(value(Form::Log { minimum: 0.11, activation: 0.04 }).is_infinite());
    }

    #[test]
    fn minimum_distance_is_the_gap_of_nested_spheres() {
        let ball = sphere(3);
        let offset = ball.vertices.len();
        let mut x: Vec<Vec3> = ball.vertices.iter().map(|v| v * 0.7).collect();
        x.extend(&ball.vertices);
        let outer: Vec<_> = ball.triangles.iter().map(|t| t.map(|v| v + offset)).collect();
        let wall = WallThickness::new("wall", &ball.triangles, &outer, FORMS[0]).unwrap();
        // facets of the outer sphere sag by h²/8 at most, h < 0.22
        let gap = wall.min_distance(&x);
        assert!(gap < 0.3 && gap > 0.3 - 0.22_f64.powi(2) / 8.0 * 1.4, "{gap}");
    }

    #[test]
    fn sides_that_touch_are_refused() {
        let surface = square(2, 0.0);
        let (inner, outer) = surface.triangles.split_at(2);
        let error = WallThickness::new("wall", inner, outer, FORMS[0]).err().unwrap();
        assert_eq!(error, SidesTouch { count: 3, first: 1 });
    }
}
