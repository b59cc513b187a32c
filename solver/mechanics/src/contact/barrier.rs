//! The barrier κ σ b(d²) that keeps simulated surfaces apart: its numbers, and how its
//! pairs are weighted.
//!
//! b is a barrier of [`density`](super::density).
//!
//! Sources: Li et al. 2020, doi:10.1145/3386569.3392425, eq. 6; scale of the
//! convergent form: Li et al. 2023, "Convergent Incremental Potential Contact",
//! arXiv:2307.15908.

use serde::{Deserialize, Serialize};

use super::density::{Density, Repulsion};

/// How pairs are weighted.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Form {
    /// By areas, so that the potential is that of a surface and converges as
    /// meshes are refined.
    #[default]
    Convergent,
    /// By areas as well, but nearly all of it by vertices and triangles, so that it
    /// does not depend on how meshes lie on each other: between flat surfaces each
    /// edge meets several others, of which the convergent form counts all.
    Even,
    /// Every pair alike, so that it grows with the number of facets.
    Plain,
}

/// What edges with edges have of the even form. It makes them a barrier still; an
/// edge of one skin that crosses five of the other adds 0.8 % to what it should.
const EDGES: f64 = 1e-3;

impl Form {
    /// What areas of vertices, and those of edges, count with their features. All
    /// together count an area of two surfaces once where each edge of one crosses
    /// one of the other.
    pub fn shares(self) -> [f64; 2] {
        match self {
            Self::Convergent | Self::Plain => [0.25, 0.25],
            Self::Even => [0.5 - EDGES, EDGES],
        }
    }

    /// 1/σ of a density with its derivative by d̂: d̂ (d̂ + 2 d₀)² where areas weigh [m³],
    /// so that pressures are the same for any d̂; else one.
    pub fn divisor(self, repulsion: &Repulsion) -> [f64; 2] {
        let full = repulsion.activation + 2.0 * repulsion.minimum;
        match self {
            Self::Convergent | Self::Even => {
                [repulsion.activation * full * full, full * (full + 2.0 * repulsion.activation)]
            }
            Self::Plain => [1.0, 0.0],
        }
    }
}

/// The barrier κ σ b between surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Barrier {
    /// How pairs are weighted.
    pub form: Form,
    /// b.
    pub density: Density,
    /// d̂ [m].
    pub activation: f64,
    /// κ [Pa]; [J/m⁴] in the plain form.
    pub stiffness: f64,
    /// d₀ [m].
    pub thickness: f64,
}

impl Barrier {
    /// b, which acts for d₀ < d < d₀ + d̂.
    pub fn repulsion(&self) -> Repulsion {
        let (minimum, activation) = (self.thickness, self.activation);
        Repulsion { density: self.density, minimum, activation }
    }

    /// Distance below which it acts, d₀ + d̂ [m].
    pub fn range(&self) -> f64 {
        self.repulsion().range()
    }

    /// κ σ, with σ = 1 / (d̂ (d̂ + 2 d₀)²) where areas weigh, else one
    /// [J/m⁶; J/m⁴].
    pub fn scale(&self) -> f64 {
        self.stiffness / self.form.divisor(&self.repulsion())[0]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Gaps at which a wall presses on a plate, from a table that was solved
    /// for independently: κ = 10⁵ Pa, weight one per area.
    #[test]
    fn pressures_leave_the_known_gaps_for_any_activation() {
        for activation in [1.0, 1e-3, 5e-5] {
            let (form, density) = (Form::Convergent, Density::Log);
            let barrier = Barrier { form, density, activation, stiffness: 1e5, thickness: 0.0 };
            for (pressure, gap) in [(1e2, 0.9935), (1e3, 0.979), (1e4, 0.934), (6e4, 0.833)] {
                let force = |gap: f64| {
                    let d = gap * activation;
                    -barrier.scale() * barrier.repulsion().at(d * d)[1] * 2.0 * d
                };
                // the gaps are given to three or four digits
                let digits = if gap > 0.99 { 0.5e-4 } else { 0.5e-3 };
                assert!(force(gap - digits) > pressure && force(gap + digits) < pressure);
            }
        }
    }
}
