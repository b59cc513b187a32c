//! Force of contact and friction on a part of the bodies.
//!
//! along            J = d · F                    [N]
//! squared          J = |F|²                     [N²]
//! sum of squares   J = Σ_n |f_n|²               [N²]
//! sum              J = Σ_n √(|f_n|² + ε²) − ε   [N]
//!
//! f_n   force on node n, as it is simulated [N];   F = Σ_n f_n
//! d     a direction [1];   ε = 1 mN, so that J is smooth where a contact begins
//!
//! J depends on u and X through the forces alone. Where a part is pressed from
//! opposite sides, F cancels and both sums do not. The sum of squares depends on
//! the mesh, as a force is shared by more nodes on a finer one, and is largest
//! where one node carries everything; the sum of magnitudes is the total force.

use anyhow::bail;
use mechanics::element;
use program::Names;

use super::*;

pub(super) const ALONG: Kind = Kind {
    key: "contact-force",
    unit: "N",
    needs_contact: true,
    example: "on = 'top'\naxis = [0, 0, 1]",
    ..Kind::of::<AlongKeys>(&[List::Probe])
};

program::table! {
    /// force F of contact and friction on a tag or a body along an axis, a · F
    #[derive(Debug)]
    struct AlongKeys {
        /// tag, or one of several bodies
        on: String;
        /// a, of any length but 0
        axis: Axis;
    }
}

impl Specification for AlongKeys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let facets = site.body.facets(&self.on)?;
        Ok(Arc::new(ContactForce::on(&facets, site, Form::Along, self.axis.unit().normalize())))
    }
}

pub(super) const KIND: Kind = Kind {
    key: "contact-force",
    unit: "N or N²",
    may_be_maximised: true,
    needs_contact: true,
    example: "on = 'top'\nform = 'along'\ndirection = [0, 0, 1]",
    ..Kind::of::<Keys>(&[List::Objective])
};

program::table! {
    /// of the force F of contact and friction on nodes: d·F, |F|², Σ |f_n|², or Σ |f_n|
    #[derive(Debug)]
    struct Keys {
        /// tag, body, or list of them
        on: Names;
        /// "along", "squared", "sum-of-squares" or "sum"
        form: Form = Form::Squared;
        /// d, for "along"
        direction: Option<Axis> = None;
    }
}

#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
enum Form {
    // the component of the sum along a direction
    Along,
    // the square of the sum
    Squared,
    // the sum of the squares over nodes
    SumOfSquares,
    // the sum of the magnitudes over nodes, smooth below 1 mN
    Sum,
}

impl Specification for Keys {
    fn check(&self) -> Result<()> {
        match (self.form, &self.direction) {
            (Form::Along, None) => {
                bail!(misfit!(KeyPath::of("form"), " = \"along\" needs direction = [x, y, z]"))
            }
            (Form::Along, Some(_)) | (_, None) => Ok(()),
            (_, Some(_)) => bail!(misfit!(
                KeyPath::of("direction"),
                " is for form = \"along\" only; remove one of them"
            )),
        }
    }

    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let direction = self.direction.map_or_else(Vec3::zeros, |direction| direction.unit());
        Ok(Arc::new(ContactForce::on(&site.facets(&self.on)?, site, self.form, direction)))
    }
}

/// ε of the sum of magnitudes [N].
const SMOOTH: f64 = 1e-3;

/// √(|f|² + ε²).
fn magnitude(f: &Vec3) -> f64 {
    (f.norm_squared() + SMOOTH * SMOOTH).sqrt()
}

/// Force on some nodes, each of which counts once.
struct ContactForce {
    nodes: Vec<usize>,
    form: Form,
    /// Unit vector of [`Form::Along`].
    direction: Vec3,
}

impl ContactForce {
    /// The force on the nodes of facets.
    fn on(facets: &[[usize; 3]], site: &Site, form: Form, direction: Vec3) -> Self {
        let nodes = facets.iter().flat_map(|&f| site.space.facet_nodes(f)).collect();
        Self::new(nodes, form, direction)
    }

    fn new(mut nodes: Vec<usize>, form: Form, direction: Vec3) -> Self {
        nodes.sort_unstable();
        nodes.dedup();
        Self { nodes, form, direction }
    }

    fn sum(&self, f: &[f64]) -> Vec3 {
        self.nodes.iter().map(|&n| element::at(f, n)).sum()
    }
}

impl Quantity for ContactForce {
    fn value(&self, at: &Equilibrium) -> f64 {
        match self.form {
            Form::Along => self.direction.dot(&self.sum(at.contact)),
            Form::Squared => self.sum(at.contact).norm_squared(),
            Form::SumOfSquares => {
                self.nodes.iter().map(|&n| element::at(at.contact, n).norm_squared()).sum()
            }
            Form::Sum => {
                self.nodes.iter().map(|&n| magnitude(&element::at(at.contact, n)) - SMOOTH).sum()
            }
        }
    }

    fn uses_contact(&self) -> bool {
        true
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        let sum = self.sum(at.contact);
        for &n in &self.nodes {
            let by = match self.form {
                Form::Along => self.direction,
                Form::Squared => 2.0 * sum,
                Form::SumOfSquares => 2.0 * element::at(at.contact, n),
                Form::Sum => {
                    let f = element::at(at.contact, n);
                    f / magnitude(&f)
                }
            };
            element::add_at(out.contact, n, &(weight * by));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quantity::tests::Case;

    #[test]
    fn components_are_linear_and_nodes_count_once() {
        let mut case = Case::cube(1, 1.0);
        let force = |form| ContactForce::new(vec![4, 2, 4], form, Vec3::new(0.0, 0.6, 0.8));
        let along = force(Form::Along);
        let by = case.partials(&along, 10.0).contact;
        let expected = |n: usize| if n == 2 || n == 4 { [0.0, 6.0, 8.0] } else { [0.0; 3] };
        by.chunks_exact(3).enumerate().for_each(|(n, by)| {
            by.iter().zip(expected(n)).for_each(|(a, b)| assert!((a - b).abs() < 1e-14));
        });
        case.contact.fill(0.0);
        case.contact[6..9].copy_from_slice(&[1.0, 5.0, 10.0]);
        case.contact[12..15].copy_from_slice(&[-1.0, 0.0, -5.0]);
        assert!((along.value(&case.at()) - (3.0 + 4.0)).abs() < 1e-14);
        assert!((force(Form::Squared).value(&case.at()) - 50.0).abs() < 1e-13);
        assert!((force(Form::SumOfSquares).value(&case.at()) - 152.0).abs() < 1e-13);
        let (one, other) = (126f64.sqrt(), 26f64.sqrt());
        assert!((force(Form::Sum).value(&case.at()) - (one + other)).abs() < 2.1e-3);
    }
}
