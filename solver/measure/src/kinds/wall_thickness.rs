//! Minimum thickness of the wall between parts of the surface.
//!
//! quadratic   J = Σ_k m_k (d_k² − d̂²)²                            for d_k < d̂
//! log         J = Σ_k m_k b(d_k² − d₀², d̂² + 2 d₀ d̂),  +∞ for d_k ≤ d₀,
//!                                                     acts for d_k < d₀ + d̂
//!
//! d_k   distance of pair k: a vertex of one part and a triangle of another,
//!       or an edge of each [m]
//! m_k   parallel-edge mollifier, one for vertex–triangle pairs [1]
//! d̂     activation distance [m];   d₀ minimum distance [m]
//! b     log barrier of [`density`](mechanics::contact::density) [m⁴]
//!
//! J is in m⁴, of the flat triangles between vertices at rest or displaced. Both
//! forms are in *squared* distances and every pair counts once, as in the
//! published scenes, so that their weights (10⁶ … 10⁷ m⁻⁴) carry over; near d̂ the
//! quadratic form is 4 d̂² (d − d̂)². J grows with the number of facets of a thin
//! region.
//!
//! Parts must not touch: next to a common rim every pair would be "thin",
//! whatever the shape. An open chamber is therefore compared with the outer skin
//! only, and the seat that holds its rim belongs to neither side.
//!
//! Where planes of symmetry cut the body, the parts are those of the whole, and J is the
//! body's share of it.
//!
//! Source: Gjoka et al. 2024, equations (14) and (15); the published scenes have
//! the rest shape.

use mechanics::contact::density::{Density, Repulsion};
use mechanics::contact::rest_potential;
use program::Names;

use super::*;
use crate::quantity::ClosePairs;
use crate::written::DensitySchema;

pub(super) const KIND: Kind = Kind {
    key: "wall-thickness",
    unit: "m⁴",
    example: "on = 'left'\nagainst = ['right']\nminimum = 0.5\nactivation = 1.0",
    ..Kind::of::<Keys>(&[List::Objective])
};

program::table! {
    /// barrier on walls thinner than minimum + activation
    #[derive(Debug)]
    struct Keys {
        /// tag, body, or list of them
        on: Names;
        /// tags of the other side, no common vertex; without them, each two of on
        against: Vec<String> = Vec::new();
        /// "log", infinite at minimum, or "quadratic", without it
        #[schemars(with = "DensitySchema")]
        density: Density = Density::default();
        /// thinnest wall [m]
        minimum: Option<f64> = None, Range::POSITIVE.unit("m");
        /// [m]
        activation: f64, Range::POSITIVE.unit("m");
        /// "rest" or "deformed"
        measure: Measure = Measure::Rest;
    }
}

impl Specification for Keys {
    fn check(&self) -> Result<()> {
        ensure!(
            !self.against.is_empty() || self.on.all().len() > 1,
            misfit!(
                KeyPath::of("on"),
                " = {:?}: one side of a wall; name the other by against = [...], or two tags or \
             more in on",
                self.on.all()
            )
        );
        ensure!(
            self.minimum.is_some() == self.density.is_barrier(),
            "a density that is a barrier, \"log\" or \"log-squared\", needs a minimum [m], \"quadratic\" has none"
        );
        Ok(())
    }

    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let Self { density, activation, measure, .. } = *self;
        let limits = Repulsion { density, minimum: self.minimum.unwrap_or(0.0), activation };
        let parts = if self.against.is_empty() {
            site.each(&self.on)?
        } else {
            vec![site.facets(&self.on)?, site.facets(&Names::Several(self.against.clone()))?]
        };
        let close = ClosePairs::between(&site.body.planes, &parts)?;
        Ok(Arc::new(Barrier { close, limits, measure }))
    }
}

/// Penalty on what is close.
pub(super) struct Barrier {
    /// What counts.
    pub close: ClosePairs,
    /// How close it may be: β with d₀ and d̂.
    pub limits: Repulsion,
    /// The shape of which distances are.
    pub measure: Measure,
}

impl Barrier {
    /// J at positions of the vertices.
    pub fn value_at(&self, x: &[Vec3]) -> f64 {
        let (pairs, x) = self.close.at(x, self.limits.range());
        self.close.whole.share() * rest_potential::value(&pairs, &x, &self.limits)
    }
}

impl Quantity for Barrier {
    fn admit(&self, rest: &[Vec3]) -> Result<(), String> {
        if !self.limits.density.is_barrier() || self.measure == Measure::Deformed {
            return Ok(());
        }
        let (pairs, x) = self.close.at(rest, self.limits.range());
        let mut all: Vec<(f64, Vec3)> = pairs
            .iter()
            .map(|pair| (pair.closest(&pair.gather(&x)).d2, x[pair.corners()[0]]))
            .collect();
        all.retain(|(d2, _)| self.limits.is_violated(*d2));
        let Some((d2, at)) = all.iter().min_by(|a, b| a.0.total_cmp(&b.0)) else { return Ok(()) };
        Err(format!(
            "{} at ({:.5}, {:.5}, {:.5}) m, one of {} such pairs; expected more than {:.3e} m",
            self.close.in_words(d2.sqrt()),
            at.x,
            at.y,
            at.z,
            all.len(),
            self.limits.minimum
        ))
    }

    fn value(&self, at: &Equilibrium) -> f64 {
        self.value_at(&at.vertices(self.measure))
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        let (pairs, x) = self.close.at(&at.vertices(self.measure), self.limits.range());
        let weight = weight * self.close.whole.share();
        let (mut by_x, mut by) = (vec![0.0; 3 * x.len()], vec![0.0; 3 * at.rest.len()]);
        rest_potential::add_gradient(&pairs, &x, &self.limits, weight, &mut by_x);
        self.close.whole.add_to_vertices(&by_x, &mut by);
        let add = |out: &mut [f64]| out.iter_mut().zip(&by).for_each(|(o, g)| *o += g);
        add(out.rest);
        if self.measure == Measure::Deformed {
            // the first nodes are the vertices
            add(out.u);
        }
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use mechanics::testing::square;

    use super::*;
    use crate::quantity::PartsTouch;

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

    const QUADRATIC: Repulsion =
        Repulsion { density: Density::Quadratic, minimum: 0.0, activation: 0.16 };

    fn between(parts: &[Vec<[usize; 3]>], limits: Repulsion) -> Result<Barrier, PartsTouch> {
        let close = ClosePairs::between(&[], parts)?;
        Ok(Barrier { close, limits, measure: Measure::Rest })
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
        let value = |density, minimum, activation| {
            let limits = Repulsion { density, minimum, activation };
            between(&[vec![[0, 1, 2]], vec![[3, 4, 5]]], limits).unwrap().value_at(&x)
        };
        let quadratic = value(Density::Quadratic, 0.0, 0.12);
        assert!((quadratic - (0.0144_f64 - 0.01).powi(2)).abs() < 1e-16);
        // s = 0.01 − 0.0064, ŝ = 0.0016 + 2 · 0.08 · 0.04
        let (s, activation) = (0.0036_f64, 0.008_f64);
        let expected = -(s - activation).powi(2) * (s / activation).ln();
        let log = value(Density::Log, 0.08, 0.04);
        assert!((log - expected).abs() < 1e-16);
        assert!(value(Density::Log, 0.11, 0.04).is_infinite());
    }

    #[test]
    fn sides_that_touch_are_refused() {
        let surface = square(2, 0.0);
        let (inner, outer) = surface.triangles.split_at(2);
        let error = between(&[inner.to_vec(), outer.to_vec()], QUADRATIC).err().unwrap();
        assert_eq!(error, PartsTouch { parts: [1, 2], count: 3, vertex: 1 });
    }

    #[test]
    fn each_two_of_several_parts_are_compared() {
        let (x, inner, outer) = plates(0.15);
        let n = x.len();
        let third = outer.iter().map(|t| t.map(|v| v + n)).collect();
        let mut all = x.clone();
        all.extend(x.iter().map(|v| v + 0.12 * Vec3::z()));
        let value = |parts: &[_]| between(parts, QUADRATIC).unwrap().value_at(&all);
        let parts = [inner, outer, third];
        let among = value(&parts);
        let pairs = [[0, 1], [0, 2], [1, 2]].map(|pair| pair.map(|i: usize| parts[i].clone()));
        let sum: f64 = pairs.map(|pair| value(&pair)).iter().sum();
        assert!(among > 0.0 && (among - sum).abs() < 1e-12 * sum);
    }
}
