//! Families of fibres in a volume, beside the law of the matrix.
//!
//! E(u; X) = ∫ ψ(ε) dX      ε = H : C − 1 = 2 H : G      H = κ I + (1 − 3κ) a₀ ⊗ a₀
//! P = 2ψ′ F H              ∂P/∂F : δF = 4ψ″ (F H : δF) F H + 2ψ′ δF H
//!
//! G  Green–Lagrange strain ½ (FᵀF − I), formed from ∇u
//! a₀ direction at a quadrature point, [`Directions`]
//! ψ  law of the family, [`Fibre`]
//!
//! The Hessian of a node pair is 4ψ″ (F H ∇φ_a) ⊗ (F H ∇φ_b) + 2ψ′ (∇φ_a · H ∇φ_b) I. H and ψ″ are positive
//! semidefinite, so with ψ′ ≥ 0 the whole is: fibres that carry tension only never need projecting. Else the
//! projected Hessian has max(ψ′, 0).
//!
//! Shape derivative of L = λ · ∂E/∂u with nodal u fixed, for a velocity V of the rest vertices: that of an elastic
//! body, and with Λ = ∇λ the change of a₀ by its formula,
//!
//! δL = … + ∫ 2 (1 − 3κ) (M a₀) · (∂a₀/∂X V) dX      M = ∂L/∂H = ψ″ B 2G + 2ψ′ sym(FᵀΛ)      B = 2 F H : Λ
//!
//! Along an axis through P along the unit vector k, k₁ and α may be a [`Profile`] of the height z = k · (X − P):
//! k₁ = Σ c_i N_i(z) and α = Σ γ_i N_i(z), each with an axis of its own. Both then change with the place, so that
//!
//! ∂a₀/∂X = ∂a₀/∂X|_α + ∂a₀/∂α ⊗ α′ k      δL = … + ∫ (∂ψ′/∂k₁) B k₁′ k · V dX
//!
//! and by the control values ∂L/∂c_i = ∫ (∂ψ′/∂k₁) B N_i dX and ∂L/∂γ_i = ∫ 2 (1 − 3κ) (M a₀) · ∂a₀/∂α N_i dX.
//!
//! The parameters are k₁ or its control values, k₂, κ, and the angle α [rad] of a helical direction or its control
//! values; other directions have one α, which is 0.

mod batch;
mod direction;

use std::ops::Range;
use std::sync::Arc;

use mesh::Vec3;

use super::quadrature_points::{self, Element, points};
use super::{Iterate, Owner, Profile};
use crate::material::fibre::{Fibre, Response};
use crate::math::tensor::Mat3;

pub use direction::{Axis, Direction};

#[cfg(test)]
pub(super) mod tests;

/// Where the fibres of a family lead.
#[derive(Clone, Debug, PartialEq)]
pub enum Directions {
    /// By a formula of the rest position.
    Formula(Direction),
    /// Around the axis of a profile, at its angle [rad] to that.
    Twisting(Profile),
    /// Along a unit vector in each element, in their order, which stays as it is while the rest shape moves.
    Elements(Arc<[Vec3]>),
}

impl From<Direction> for Directions {
    fn from(direction: Direction) -> Self {
        Self::Formula(direction)
    }
}

impl Directions {
    /// The formula that holds at a rest position; none where each element has a vector.
    pub fn formula(&self, x: Vec3) -> Option<Direction> {
        match self {
            Self::Formula(direction) => Some(*direction),
            Self::Twisting(angle) => Some(helical(angle, x)),
            Self::Elements(_) => None,
        }
    }

    /// a₀ at a rest position in an element, which is given by its place in the family.
    fn at(&self, element: usize, x: Vec3) -> Vec3 {
        match self {
            Self::Formula(direction) => direction.at(x),
            Self::Twisting(angle) => helical(angle, x).at(x),
            Self::Elements(along) => along[element],
        }
    }

    /// ∂a₀/∂X [1/m].
    fn gradient(&self, x: Vec3) -> Mat3 {
        match self {
            Self::Formula(direction) => direction.gradient(x),
            Self::Twisting(angle) => {
                let (here, rise) = (helical(angle, x), angle.gradient(x));
                let turned = here.gradient(x);
                // where the angle does not change there may be no e_θ
                let turns = rise != Vec3::zeros();
                if turns { turned + here.by_angle(x) * rise.transpose() } else { turned }
            }
            Self::Elements(_) => Mat3::zeros(),
        }
    }

    /// ∂a₀/∂α [1/rad].
    fn by_angle(&self, x: Vec3) -> Vec3 {
        self.formula(x).map_or_else(Vec3::zeros, |direction| direction.by_angle(x))
    }

    /// Whether fibres are along one line in each element.
    fn is_constant(&self) -> bool {
        match self {
            Self::Formula(direction) => direction.is_constant(),
            Self::Twisting(_) => false,
            Self::Elements(_) => true,
        }
    }

    /// The angle along an axis, where it is none for all.
    fn profile(&self) -> Option<&Profile> {
        match self {
            Self::Twisting(angle) => Some(angle),
            Self::Formula(_) | Self::Elements(_) => None,
        }
    }
}

/// The direction that holds at a rest position, of an angle along an axis.
fn helical(angle: &Profile, x: Vec3) -> Direction {
    Direction::Helical(*angle.axis(), angle.at(x))
}

/// Number of the parameters of what may be a profile.
fn count(profile: Option<&Profile>) -> usize {
    profile.map_or(1, |profile| profile.values().len())
}

/// Adds a derivative by what may be a profile at a rest position: to its one value, or to its control values.
fn spread(profile: Option<&Profile>, x: Vec3, by: f64, out: &mut [f64]) {
    let Some(profile) = profile else {
        out[0] += by;
        return;
    };
    for (i, weight) in profile.basis(profile.height(x)).pairs() {
        out[i] += weight * by;
    }
}

/// A family of fibres in consecutive elements.
#[derive(Clone, Debug)]
pub struct Fibres {
    /// What the user calls it.
    pub name: String,
    /// The law.
    pub law: Fibre,
    /// k₁ along an axis [Pa], in place of the one of the law.
    pub stiffness: Option<Profile>,
    /// Where they lead.
    pub directions: Directions,
    elements: Range<usize>,
}

/// Measures of a family at a state.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FibreSummary {
    /// Rest volume that it is in [m³].
    pub volume: f64,
    /// E [J].
    pub energy: f64,
    /// Smallest and largest stretch along the fibres, √I₄.
    pub stretch: [f64; 2],
    /// Largest force of the fibres per rest area across them [Pa].
    pub stress: f64,
    /// Share of the volume in which they are in tension.
    pub taut: f64,
}

/// What the fibres of an element do, as a mean over its rest volume.
#[derive(Clone, Copy, Debug, Default)]
pub struct FibreMean {
    /// a₀, not of unit length where it varies.
    pub direction: Vec3,
    /// √I₄.
    pub stretch: f64,
    /// Force per rest area across the fibres, along them [Pa].
    pub stress: f64,
}

/// What fibres do at a quadrature point of an element.
struct Point<'a> {
    at: &'a quadrature_points::Point,
    /// Barycentric coordinates.
    lambda: [f64; 4],
    /// Rest position [m].
    place: Vec3,
    /// a₀.
    along: Vec3,
    /// H.
    structure: Mat3,
    /// ψ and its derivatives.
    response: Response,
}

impl Point<'_> {
    /// √I₄.
    fn stretch(&self) -> f64 {
        (self.at.k.f * self.along).norm()
    }

    /// P a₀ along the deformed fibres [Pa].
    fn stress(&self) -> f64 {
        let f = &self.at.k.f;
        let pull = 2.0 * self.response.slope * f * self.structure * self.along;
        pull.dot(&(f * self.along)) / self.stretch()
    }

    /// B = 2 F H : Λ.
    fn strain_along(&self, grad_l: &Mat3) -> f64 {
        2.0 * (self.at.k.f * self.structure).dot(grad_l)
    }

    /// M.
    fn by_structure(&self, grad_l: &Mat3) -> Mat3 {
        let product = self.at.k.f.transpose() * grad_l;
        2.0 * self.response.curvature * self.strain_along(grad_l) * self.at.k.green
            + self.response.slope * (product + product.transpose())
    }
}

impl Fibres {
    /// Who owns the numbers of a family, by its place among all.
    pub const fn owner(place: usize) -> Owner {
        Owner::new("fibre", place)
    }

    /// A family in consecutive elements.
    pub fn new(law: Fibre, directions: impl Into<Directions>, elements: Range<usize>) -> Self {
        let (name, directions) = (String::new(), directions.into());
        Self { name, law, stiffness: None, directions, elements }
    }

    /// This family with k₁ along an axis [Pa], in place of the one of its law.
    pub fn with_stiffness(self, stiffness: Option<Profile>) -> Self {
        Self { stiffness, ..self }
    }

    /// This family with a name.
    pub fn named(self, name: &str) -> Self {
        Self { name: name.to_owned(), ..self }
    }

    /// The elements that it is in.
    pub fn elements(&self) -> Range<usize> {
        self.elements.clone()
    }

    /// a₀ at a rest position in an element.
    fn along(&self, e: usize, x: Vec3) -> Vec3 {
        self.directions.at(e - self.elements.start, x)
    }

    /// The law at a rest position.
    pub fn law_at(&self, x: Vec3) -> Fibre {
        let k1 = self.stiffness.as_ref().map_or(self.law.k1, |stiffness| stiffness.at(x));
        Fibre { k1, ..self.law }
    }

    /// Whether stresses of linear displacements are the same all over an element.
    fn is_constant(&self) -> bool {
        self.directions.is_constant() && self.stiffness.is_none()
    }

    /// Numbers of the parameters of k₁ and α.
    fn counts(&self) -> [usize; 2] {
        [self.stiffness.as_ref(), self.directions.profile()].map(count)
    }

    /// H at a direction.
    fn structure(&self, along: &Vec3) -> Mat3 {
        let own = 1.0 - 3.0 * self.law.dispersion;
        self.law.dispersion * Mat3::identity() + own * along * along.transpose()
    }

    /// Calls `f` with an element and each quadrature point of it.
    fn for_each_point(&self, iterate: &Iterate, e: usize, mut f: impl FnMut(&Element, &Point)) {
        let corners = iterate.space.tets()[e].map(|v| iterate.rest[v]);
        let (element, own) = points(iterate, e, true);
        for at in own {
            let rule = &iterate.space.volume_table().points[at.place];
            let lambda = [rule[0], rule[1], rule[2], rule[3]];
            let place = corners.iter().zip(lambda).map(|(x, l)| l * x).sum();
            let along = self.along(e, place);
            let structure = self.structure(&along);
            let response = self.law_at(place).response(2.0 * structure.dot(&at.k.green));
            f(&element, &Point { at: &at, lambda, place, along, structure, response });
        }
    }

    /// Measures of the family at a state.
    pub fn summary(&self, iterate: &Iterate) -> FibreSummary {
        let stretch = [f64::INFINITY, 0.0];
        let mut all = FibreSummary { volume: 0.0, energy: 0.0, stretch, stress: 0.0, taut: 0.0 };
        for e in self.elements() {
            self.for_each_point(iterate, e, |_, p| {
                let (stretch, weight) = (p.stretch(), p.at.weight);
                all.stretch = [all.stretch[0].min(stretch), all.stretch[1].max(stretch)];
                all.volume += weight;
                all.energy += weight * p.response.energy;
                all.stress = all.stress.max(p.stress());
                all.taut += if p.response.slope > 0.0 { weight } else { 0.0 };
            });
        }
        all.taut /= all.volume;
        all
    }

    /// What the fibres of each of its elements do.
    pub fn means(&self, iterate: &Iterate) -> Vec<FibreMean> {
        let one = |e: usize| {
            let (mut mean, mut volume) = (FibreMean::default(), 0.0);
            self.for_each_point(iterate, e, |_, p| {
                mean.direction += p.at.weight * p.along;
                mean.stretch += p.at.weight * p.stretch();
                mean.stress += p.at.weight * p.stress();
                volume += p.at.weight;
            });
            let FibreMean { direction, stretch, stress } = mean;
            FibreMean {
                direction: direction / volume,
                stretch: stretch / volume,
                stress: stress / volume,
            }
        };
        self.elements().map(one).collect()
    }

    /// λᵀ ∂²E/∂u∂(k₁, k₂, κ, α) of an element, with the control values of what is a profile.
    fn element_parameters(&self, iterate: &Iterate, lambda: &[f64], e: usize) -> Vec<f64> {
        let [stiffnesses, angles] = self.counts();
        let (mut by_k1, mut by_law) = (vec![0.0; stiffnesses], [0.0; 2]);
        let mut by_angle = vec![0.0; angles];
        self.for_each_point(iterate, e, |element, p| {
            let grad_l = p.at.weight * p.at.gradient(element, lambda);
            let strain = 2.0 * p.structure.dot(&p.at.k.green);
            let [slope_by_k1, slope_by_k2] = self.law_at(p.place).slope_by_parameters(strain);
            let (along, by_structure) = (p.strain_along(&grad_l), p.by_structure(&grad_l));
            let own = 1.0 - 3.0 * self.law.dispersion;
            spread(self.stiffness.as_ref(), p.place, slope_by_k1 * along, &mut by_k1);
            by_law[0] += slope_by_k2 * along;
            let fan = Mat3::identity() - 3.0 * p.along * p.along.transpose();
            by_law[1] += by_structure.dot(&fan);
            let turned = self.directions.by_angle(p.place);
            let by = 2.0 * own * turned.dot(&(by_structure * p.along));
            spread(self.directions.profile(), p.place, by, &mut by_angle);
        });
        [&by_k1[..], &by_law, &by_angle].concat()
    }

    fn element_mixed(&self, iterate: &Iterate, lambda: &[f64], e: usize) -> [Vec3; 4] {
        let mut out = [Vec3::zeros(); 4];
        self.for_each_point(iterate, e, |element, p| {
            let grad_l = p.at.gradient(element, lambda);
            let Response { slope, curvature, .. } = p.response;
            let by_strain = 2.0 * p.at.k.f * p.structure;
            let stress = slope * by_strain;
            let pushed = curvature * p.strain_along(&grad_l) * by_strain
                + 2.0 * slope * grad_l * p.structure;
            let m = p.at.by_rest(&stress, &pushed, &grad_l);
            let own = 2.0 * (1.0 - 3.0 * self.law.dispersion);
            let mut by_place = own
                * self.directions.gradient(p.place).transpose()
                * (p.by_structure(&grad_l) * p.along);
            if let Some(stiffness) = &self.stiffness {
                let strain = 2.0 * p.structure.dot(&p.at.k.green);
                let [slope_by_k1, _] = self.law.slope_by_parameters(strain);
                let by_k1 = slope_by_k1 * p.strain_along(&grad_l);
                by_place += by_k1 * stiffness.gradient(p.place);
            }
            for ((out, c), lambda) in out.iter_mut().zip(element.corner_gradients()).zip(p.lambda) {
                *out += p.at.weight * (m * c + lambda * by_place);
            }
        });
        out
    }
}
