//! Displacement of a point.
//!
//! in the body    q = a · Σ φ_n(P) u_n                      [m]
//! on a tag       q = a · (ū + (R − I)(P − X̄))              [m]
//!
//! a        unit vector along the axis
//! φ_n(P)   basis at the point P; in a design the point moves with the element that it is in
//! X̄, ū     mean rest position and displacement of the tag over its rest area A
//! R        mean rotation of the tag: of all rotations the one that minimises
//!          ∫ |x − x̄ − R (X − X̄)|² dA, x = X + u
//!
//! R is the rotation of the polar decomposition M = R P of M = (1/A) ∫ (x − x̄)(X − X̄)ᵀ dA,
//! from M = U Σ Vᵀ: R = U D Vᵀ, P = V D Σ Vᵀ, D = diag(1, 1, det U Vᵀ). With p the diagonal of
//! D Σ and c = Rᵀ a, b = P − X̄,
//!
//! ∂(a · R b)/∂M = 2 R Y      (Vᵀ Y V)_ij = (Vᵀ ½ (c bᵀ − b cᵀ) V)_ij / (p_i + p_j)
//!
//! Source: Kabsch 1976, doi:10.1107/S0567739476001873 (R); Rᵀ ∂M − ∂Mᵀ R = Ω P + P Ω with
//! Ω = Rᵀ ∂R (its derivative).

use anyhow::Context as _;
use mechanics::element::{add_at, at, weights};
use mechanics::math::tensor::Mat3;

use super::*;

pub(super) const KIND: Kind = Kind {
    key: "point",
    unit: "m",
    example: "at = [0.3, 0.6, 0.45]\naxis = [0, 1, 1]",
    ..Kind::of::<Keys>(&[List::Probe])
};

program::table! {
    /// displacement of a point along an axis: of a point in the body; or of one that a tag carries, by its mean
    /// displacement and rotation
    #[derive(Debug)]
    struct Keys {
        /// rest position [m]
        at: [f64; 3], Range::FINITE.unit("m");
        /// tag that carries it, if it is not in the body
        on: Option<String> = None;
        /// a, of any length but 0
        axis: Axis;
    }
}

impl Specification for Keys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let (point, axis) = (Vec3::from(self.at), self.axis.unit());
        let Some(tag) = &self.on else {
            let rest = &site.body.mesh.vertices;
            let nodes = weights(site.space, rest, point).with_context(|| self.outside(rest))?;
            return Ok(Arc::new(Inside { nodes, axis }));
        };
        of_means(site, [tag], move |m| {
            let (value, by) = carried(&m[0], point, axis);
            (value, vec![by])
        })
    }
}

impl Keys {
    fn outside(&self, rest: &[Vec3]) -> String {
        let low = rest.iter().fold(rest[0], |low, x| low.inf(x));
        let high = rest.iter().fold(rest[0], |high, x| high.sup(x));
        format!(
            "at = {:?} m: lies in no element at rest; the mesh reaches from {:?} to {:?} m\n  move \
             it into the body, or name by on the tag that carries it",
            self.at,
            <[f64; 3]>::from(low),
            <[f64; 3]>::from(high)
        )
    }
}

/// A point of the body.
struct Inside {
    /// Nodes of its element, with their φ.
    nodes: Vec<(usize, f64)>,
    axis: Vec3,
}

impl Quantity for Inside {
    fn value(&self, state: &Equilibrium) -> f64 {
        self.nodes.iter().map(|&(node, phi)| phi * self.axis.dot(&at(state.u, node))).sum()
    }

    fn add_partials(&self, _: &Equilibrium, weight: f64, out: &mut Partials) {
        let add = |&(node, phi): &_| add_at(out.u, node, &(weight * phi * self.axis));
        self.nodes.iter().for_each(add);
    }
}

/// Displacement along an axis of a point that a tag carries, with its derivative by the means
/// over the tag.
fn carried(m: &Means, point: Vec3, axis: Vec3) -> (f64, Means) {
    let (arm, turn) = (point - m.rest, Polar::new(&m.moment()));
    let r = turn.rotation;
    let value = axis.dot(&(m.u + (r * arm - arm)));
    let by = m.by_moment(&turn.by_moment(&axis, &arm));
    let by_rest = axis - r.transpose() * axis + by.rest;
    (value, Means { rest: by_rest, u: axis + by.u, ..by })
}

/// The polar decomposition M = R P.
struct Polar {
    /// R.
    rotation: Mat3,
    /// V, the principal axes of P ...
    axes: Mat3,
    /// ... and p.
    stretches: Vec3,
}

impl Polar {
    fn new(moment: &Mat3) -> Self {
        let svd = moment.svd(true, true);
        let (u, v_t) = (svd.u.expect("asked for"), svd.v_t.expect("asked for"));
        // the sign belongs to the smallest value, which comes last
        let signs = Vec3::new(1.0, 1.0, (u * v_t).determinant().signum());
        Self {
            rotation: u * Mat3::from_diagonal(&signs) * v_t,
            axes: v_t.transpose(),
            stretches: svd.singular_values.component_mul(&signs),
        }
    }

    /// ∂(a · R b)/∂M.
    fn by_moment(&self, a: &Vec3, b: &Vec3) -> Mat3 {
        let (r, v, p) = (&self.rotation, &self.axes, &self.stretches);
        let c = r.transpose() * a;
        let skew = v.transpose() * (0.5 * (c * b.transpose() - b * c.transpose())) * v;
        let y = Mat3::from_fn(|i, j| if i == j { 0.0 } else { skew[(i, j)] / (p[i] + p[j]) });
        2.0 * r * v * y * v.transpose()
    }
}
