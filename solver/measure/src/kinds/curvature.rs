//! Curvature along a line of tags.
//!
//! q = mean of κ over each three consecutive tags                       [1/m]
//! κ = 2 |e₁ × e₂| / (|e₁| |e₂| |e₁ + e₂|),   e₁ = x̄₂ − x̄₁,  e₂ = x̄₃ − x̄₂
//!
//! κ is the curvature of the circle through the tags' mean deformed positions x̄: exact for tags
//! on an arc. It has no sign, and no derivative where the line is straight.
//!
//! Source: Menger curvature.

use super::*;

pub(super) const KIND: Kind = Kind {
    key: "curvature",
    unit: "1/m",
    example: "on = ['left', 'top', 'right', 'bottom']",
    ..Kind::of::<Keys>(&[List::Probe])
};

program::table! {
    /// mean curvature of the circles through the mean positions of each three consecutive tags
    #[derive(Debug)]
    struct Keys {
        /// three tags or more, in their order along the line
        on: Vec<String>;
    }
}

impl Specification for Keys {
    fn check(&self) -> Result<()> {
        ensure!(
            self.on.len() >= 3,
            misfit!(
                KeyPath::of("on"),
                " = {:?}: found {} tags, a curvature needs three or more",
                self.on,
                self.on.len()
            )
        );
        let repeated = |(i, tag): &(usize, &String)| self.on[..*i].contains(tag);
        if let Some((_, tag)) = self.on.iter().enumerate().find(repeated) {
            anyhow::bail!(misfit!(KeyPath::of("on"), " = {:?}: \"{tag}\" occurs twice", self.on));
        }
        Ok(())
    }

    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        of_means(site, &self.on, curvature)
    }
}

fn curvature(m: &[Means]) -> (f64, Vec<Means>) {
    let x: Vec<Vec3> = m.iter().map(Means::x).collect();
    let share = 1.0 / (x.len() - 2) as f64;
    let (mut value, mut by) = (0.0, vec![Vec3::zeros(); x.len()]);
    for i in 2..x.len() {
        let (kappa, [by1, by2]) = of_edges(&(x[i - 1] - x[i - 2]), &(x[i] - x[i - 1]));
        value += share * kappa;
        by[i - 2] -= share * by1;
        by[i - 1] += share * (by1 - by2);
        by[i] += share * by2;
    }
    (value, by.into_iter().map(Means::by_x).collect())
}

/// κ, with its derivatives by the two edges.
fn of_edges(e1: &Vec3, e2: &Vec3) -> (f64, [Vec3; 2]) {
    let (cross, chord) = (e1.cross(e2), e1 + e2);
    let lengths = e1.norm() * e2.norm() * chord.norm();
    let kappa = 2.0 * cross.norm() / lengths;
    let Some(normal) = cross.try_normalize(0.0) else {
        return (kappa, [Vec3::zeros(); 2]);
    };
    let by_chord = -kappa / chord.norm_squared() * chord;
    let by1 = 2.0 / lengths * e2.cross(&normal) - kappa / e1.norm_squared() * e1 + by_chord;
    let by2 = 2.0 / lengths * normal.cross(e1) - kappa / e2.norm_squared() * e2 + by_chord;
    (kappa, [by1, by2])
}
