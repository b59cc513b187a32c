//! Barrier against self-contact of the rest surface.
//!
//! J = Σ_k m_k b(d_k², d̂²)
//!
//! d_k   distance of pair k of features of the surface without a common
//!       vertex [m]
//! m_k   parallel-edge mollifier, one for vertex–triangle pairs [1]
//! d̂     activation distance [m]
//! b     log barrier of [`density`](mechanics::contact::density) [m⁴]
//!
//! J is in m⁴: with d̂ = 5·10⁻⁵ m and weight one, as in the published scenes, it
//! is about 10⁻¹⁷ and only its becoming infinite matters. Facets that have
//! already passed through each other are not detected here: a design checks its shapes for that.
//!
//! Where planes of symmetry cut the body, the surface is that of the whole, and J is the
//! body's share of it.
//!
//! Source: Li et al. 2020, doi:10.1145/3386569.3392425, applied to the rest shape.

use mechanics::contact::density::{Density, Repulsion};

use super::wall_thickness::Barrier;
use super::*;
use crate::quantity::ClosePairs;

pub(super) const KIND: Kind = Kind {
    key: "clearance",
    unit: "m⁴",
    example: "activation = 0.6",
    ..Kind::of::<Keys>(&[List::Objective])
};

program::table! {
    /// log barrier between parts of the rest surface that are not neighbours
    #[derive(Debug)]
    struct Keys {
        /// distance below which it acts [m]
        activation: f64, Range::POSITIVE.unit("m");
    }
}

impl Specification for Keys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let close = ClosePairs::within(&site.body.planes, site.body.boundary());
        Ok(Arc::new(barrier(close, self.activation)))
    }
}

/// The barrier that acts below `activation` [m].
pub(super) fn barrier(close: ClosePairs, activation: f64) -> Barrier {
    let limits = Repulsion { density: Density::Log, minimum: 0.0, activation };
    Barrier { close, limits, measure: Measure::Rest }
}

#[cfg(test)]
mod tests {
    use mechanics::testing::square;

    use super::*;

    #[test]
    fn a_flat_sheet_costs_nothing_and_touching_is_infinite() {
        let sheet = square(6, 0.0);
        let term = barrier(ClosePairs::within(&[], &sheet.triangles), 0.05);
        assert!(term.value_at(&sheet.vertices) == 0.0);
        let mut folded = sheet.vertices;
        let (first, last) = (0, folded.len() - 1);
        folded[first] = folded[last];
        assert!(term.value_at(&folded).is_infinite());
    }
}
