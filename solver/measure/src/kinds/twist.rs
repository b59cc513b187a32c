//! How far a tag has turned about an axis.
//!
//! q = ϑ(on) − ϑ(to)                                                     [deg]
//! ϑ = atan2(S, C)   S = a · ∫ (X − X̄) × (x − x̄) dA,  C = ∫ (X − X̄)·(I − a aᵀ)(x − x̄) dA
//!
//! over the rest area of the tag: of all angles about a the one that carries its rest positions, seen along a, nearest to where
//! they are (the plane problem of Kabsch 1976, doi:10.1107/S0567739476001873). With M = (1/A) ∫ (x − x̄)(X − X̄)ᵀ dA,
//! S/A = Σ ε_kij a_k M_ji and C/A = tr (I − a aᵀ) M, so that ∂ϑ/∂M = (C ∂S − S ∂C) / (C² + S²). From −180° to 180°.

use mechanics::math::tensor::Mat3;

use super::*;

pub(super) const KIND: Kind = Kind {
    key: "twist",
    unit: "deg",
    example: "on = 'top'\nto = 'left'\naxis = [0, 0.2, 1]",
    ..Kind::of::<Keys>(&[List::Probe])
};

/// Part of the mean square distance of a tag from its middle that is across the axis, at least.
const ACROSS: f64 = 1e-3;

program::table! {
    /// angle about an axis by which a tag has turned against another one, or against its rest position, in the
    /// mean over its area; from -180 to 180
    #[derive(Debug)]
    struct Keys {
        /// tag
        on: String;
        /// the other tag; the rest position if not given
        to: Option<String> = None;
        /// along the body that is twisted, of any length but 0; positive by the right-hand rule
        axis: Axis;
    }
}

impl Specification for Keys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let axis = self.axis.unit();
        let names = std::iter::once(&self.on).chain(&self.to);
        for name in names.clone() {
            let facets = site.body.facets(name)?;
            let rest = facets.iter().flatten().map(|&v| site.body.mesh.vertices[v]);
            let middle = rest.clone().sum::<Vec3>() / (3 * facets.len()) as f64;
            let far = |x: Vec3| {
                [(x - middle).norm_squared(), across(&axis, &(x - middle)).norm_squared()]
            };
            let [all, turned] = rest.map(far).fold([0.0; 2], |[a, b], [c, d]| [a + c, b + d]);
            ensure!(
                turned > ACROSS * all,
                "tag \"{name}\": lies along the axis, about which it then does not turn"
            );
        }
        of_means(site, names, move |m| {
            let signs: [f64; 2] = [1.0, -1.0];
            let each = m.iter().zip(signs).map(|(m, sign)| turned(m, &axis, sign.to_degrees()));
            let (values, by): (Vec<f64>, Vec<Means>) = each.unzip();
            (values.iter().sum(), by)
        })
    }
}

/// What is across the axis.
fn across(axis: &Vec3, x: &Vec3) -> Vec3 {
    x - axis.dot(x) * axis
}

/// ϑ of a tag times a factor, with its derivative by the means.
fn turned(m: &Means, axis: &Vec3, factor: f64) -> (f64, Means) {
    let moment = m.moment();
    // S = dot(by_s, M) and C = dot(by_c, M)
    let by_s = axis.cross_matrix();
    let by_c = Mat3::identity() - axis * axis.transpose();
    let (s, c) = (by_s.dot(&moment), by_c.dot(&moment));
    let by = (c * by_s - s * by_c) * (factor / (c * c + s * s));
    (factor * s.atan2(c), m.by_moment(&by))
}
