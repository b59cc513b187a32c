//! Mean displacement of a tag, and how far it moves, whichever way.
//!
//! q = a · (1/A) ∫ u dA      over the rest area A, a the unit vector along the axis   [m]
//! q = (1/A) ∫ |u| dA                                                                 [m]

use super::*;

pub(super) const ALONG: Kind = Kind {
    key: "displacement",
    unit: "m",
    example: "on = 'top'\naxis = [1, 0, 2]",
    ..Kind::of::<Keys>(&[List::Probe])
};

program::table! {
    /// mean displacement of a tag along an axis, a · ∫ u dA / A over its rest area
    #[derive(Debug)]
    struct Keys {
        /// tag
        on: String;
        /// a, of any length but 0
        axis: Axis;
    }
}

impl Specification for Keys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let a = self.axis.unit();
        of_means(site, [&self.on], move |m| (a.dot(&m[0].u), vec![Means { u: a, ..Means::ZERO }]))
    }
}

pub(super) const MAGNITUDE: Kind = Kind {
    key: "displacement-magnitude",
    unit: "m",
    example: "on = 'top'",
    ..Kind::of::<MagnitudeKeys>(&[List::Probe])
};

program::table! {
    /// mean length of a tag's displacement, ∫ |u| dA / A over its rest area
    #[derive(Debug)]
    struct MagnitudeKeys {
        /// tag
        on: String;
    }
}

impl Specification for MagnitudeKeys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let one = Means { length: 1.0, ..Means::ZERO };
        of_means(site, [&self.on], move |m| (m[0].length, vec![one]))
    }
}
