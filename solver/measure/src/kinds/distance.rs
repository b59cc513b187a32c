//! Distance of two tags.
//!
//! q = |x̄₁ − x̄₂|      x̄ the mean deformed position over the tag's rest area   [m]

use super::*;

pub(super) const KIND: Kind = Kind {
    key: "distance",
    unit: "m",
    example: "on = 'top'\nto = 'left'",
    ..Kind::of::<Keys>(&[List::Probe])
};

program::table! {
    /// distance of the mean positions of two tags
    #[derive(Debug)]
    struct Keys {
        /// tag
        on: String;
        /// the other tag
        to: String;
    }
}

impl Specification for Keys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        of_means(site, [&self.on, &self.to], |m| {
            let apart = m[0].x() - m[1].x();
            let by = apart.try_normalize(0.0).unwrap_or_else(Vec3::zeros);
            (apart.norm(), vec![Means::by_x(by), Means::by_x(-by)])
        })
    }
}
