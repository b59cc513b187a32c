//! Displacement or position of a part of the surface against a wanted one (trajectory
//! tracking).
//!
//! J(u, X) = ∫_Γ Σ_k (u_k − w_k)² dA     displacement
//! J(u, X) = ∫_Γ Σ_k (x_k − w_k)² dA     position, x = ΠX + u
//!
//! k        the axes that count
//! w(X, t)  wanted displacement or position [m], as it is written, from t = 0 on
//!
//! J is in m⁴; over time it makes a point follow a trajectory. Rest shape and
//! displacement also enter through the area, see
//! [`surface_integral`](super::Patch).
//!
//! Source: Gjoka et al. 2024, the worm's and the walker's objective.

use mechanics::schedule::{Field, WrittenField, axes};
use program::Names;

use super::*;
use crate::quantity::surface_integral::{Density, Place};
use crate::written::{FieldSchema, some_axes};

pub(super) const DISPLACEMENT: Kind = Kind {
    key: "displacement",
    unit: "m⁴",
    example: "on = ['top', 'left']\ndisplacement = [0.03, '0.1*t', 0]",
    ..Kind::of::<DisplacementKeys>(&[List::Objective])
};

pub(super) const POSITION: Kind = Kind {
    key: "position",
    unit: "m⁴",
    example: "on = 'top'\nposition = [0, 0, 1]\ncomponents = 'zx'\nmeasure = 'deformed'",
    ..Kind::of::<PositionKeys>(&[List::Objective])
};

/// Keys, one of which is called as what is wanted.
macro_rules! keys {
    ($about:literal, $name:ident, $wanted:ident, $compared:expr) => {
        program::table! {
            #[doc = $about]
            #[derive(Debug)]
            struct $name {
                /// tag, body, or list of them
                on: Names;
                /// w [m]: numbers, expressions in t, x, y, z, or tables
                #[schemars(with = "FieldSchema")]
                $wanted: WrittenField;
                /// axes that count, such as "xz"
                components: String = "xyz".to_owned(), some_axes;
                /// "rest" or "deformed"
                measure: Measure = Measure::Rest;
            }
        }

        impl Specification for $name {
            fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
                let facets = site.facets(&self.on)?;
                let wanted = site.wanted(stringify!($wanted), &self.$wanted, &facets)?;
                let patch = Patch::new(site.space, &facets, self.measure);
                let axes = axes(&self.components);
                Ok(Arc::new(Motion { patch, compared: $compared, wanted, axes }))
            }
        }
    };
}

keys!("∫ Σ (u_i − w_i)² dA", DisplacementKeys, displacement, Compared::Displacement);
keys!("∫ Σ (x_i − w_i)² dA, x = X + u", PositionKeys, position, Compared::Position);

/// What of a point is compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Compared {
    /// u.
    Displacement,
    /// ΠX + u.
    Position,
}

/// Squared distance of a patch to a wanted displacement or position [m] along some axes.
struct Motion {
    patch: Patch,
    compared: Compared,
    wanted: Field,
    axes: [bool; 3],
}

impl Motion {
    fn density(&self, place: &Place, time: f64) -> Density {
        let is_place = f64::from(u8::from(self.compared == Compared::Position));
        let (mut value, mut by_u, mut by_rest) = (0.0, Vec3::zeros(), Vec3::zeros());
        for k in (0..3).filter(|&k| self.axes[k]) {
            let wanted = self.wanted.0[k].as_written(place.rest, time);
            let gap = place.u[k] + is_place * place.rest[k] - wanted.value;
            value += gap * gap;
            by_u[k] += 2.0 * gap;
            by_rest[k] += 2.0 * gap * is_place;
            by_rest -= 2.0 * gap * wanted.gradient;
        }
        Density { value, by_u, by_rest }
    }
}

impl Quantity for Motion {
    fn value(&self, at: &Equilibrium) -> f64 {
        self.patch.value(at, &|place| self.density(place, at.time))
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        self.patch.add_partials(at, &|place| self.density(place, at.time), weight, out);
    }
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;
    use crate::quantity::tests::Case;

    /// The top of a cube that is lifted by 0.3 where 0.1 + 0.2 t is wanted, with
    /// t = 0.7, and shifted along x, where nothing is wanted of it.
    #[test]
    fn a_shifted_face_has_its_closed_form() {
        let mut case = Case::cube(2, 1.0);
        case.u.chunks_exact_mut(3).for_each(|u| u.copy_from_slice(&[0.0, 0.9, 0.3]));
        let top = case.facets_where(|x| x.z > 0.99);
        let value = |compared, wanted: &str| {
            let wanted = Field([0.0.into(), 0.0.into(), wanted.parse().unwrap()]);
            let patch = Patch::new(&case.space, &top, Measure::Deformed);
            Motion { patch, compared, wanted, axes: [false, false, true] }.value(&case.at())
        };
        let expected = (0.3_f64 - 0.24).powi(2);
        assert!((value(Compared::Displacement, "0.1 + 0.2*t") - expected).abs() < 1e-15);
        assert!((value(Compared::Position, "1.1 + 0.2*t") - expected).abs() < 1e-14);
    }
}
