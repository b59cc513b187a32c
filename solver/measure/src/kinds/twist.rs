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
        let tags: Vec<_> =
            names.clone().map(|tag| site.body.facets(tag)).collect::<Result<_, _>>()?;
        for (name, facets) in names.zip(&tags) {
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
        let twist = move |m: &[Means]| {
            let signs: [f64; 2] = [1.0, -1.0];
            let each = m.iter().zip(signs).map(|(m, sign)| turned(m, &axis, sign.to_degrees()));
            let (values, by): (Vec<f64>, Vec<Means>) = each.unzip();
            (values.iter().sum(), by)
        };
        Ok(Arc::new(OfMeans::new(site.space, &tags, Box::new(twist))))
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

#[cfg(test)]
mod tests {
    use super::*;

    /// A square across the axis that is turned by 50° and moved, whatever it is stretched by.
    #[test]
    fn a_turn_about_the_axis_is_its_angle() {
        let axis = Vec3::new(0.3, -0.2, 1.0).normalize();
        let turn = nalgebra::Rotation3::from_axis_angle(
            &nalgebra::Unit::new_normalize(axis),
            50_f64.to_radians(),
        );
        let mut m = Means::ZERO;
        for rest in [
            Vec3::new(1.0, 0.0, 0.2),
            Vec3::new(0.0, 1.0, 0.0),
            Vec3::new(-1.0, 0.0, 0.0),
            Vec3::new(0.0, -1.0, 0.0),
        ] {
            let u = 1.3 * (turn * rest) + Vec3::new(0.1, 0.2, 0.3) - rest;
            m.rest += 0.25 * rest;
            m.u += 0.25 * u;
            m.rest_rest += 0.25 * rest * rest.transpose();
            m.u_rest += 0.25 * u * rest.transpose();
        }
        let (angle, _) = turned(&m, &axis, 1_f64.to_degrees());
        assert!((angle - 50.0).abs() < 1e-12, "{angle}");
    }
}
