//! Probes of means over tags.
//!
//! q = q(m₁, m₂, …)      m of each tag: the means of X, u, X Xᵀ, u Xᵀ and |u|
//!
//! over the tag's rest area A, (1/A) ∫ … dA. With m̄ = ∂q/∂m,
//!
//! ∂q = Σ (1/A) ∂∫ m̄ · (m(x) − m) dA      at fixed m̄ and m
//!
//! Where a point does not move, |u| has no derivative; zero is taken, the least of its subgradients.

use std::sync::Arc;

use anyhow::Result;
use mechanics::math::tensor::Mat3;
use mesh::Vec3;

use super::surface_integral::{Density, Patch, Place};
use super::{Equilibrium, Measure, Partials, Quantity, Site};

/// Means over a tag; as a derivative, the partial derivatives by them.
#[derive(Clone, Copy, Debug)]
pub struct Means {
    /// Mean of X [m].
    pub rest: Vec3,
    /// Mean of u [m].
    pub u: Vec3,
    /// Mean of X Xᵀ [m²].
    pub rest_rest: Mat3,
    /// Mean of u Xᵀ [m²].
    pub u_rest: Mat3,
    /// Mean of |u| [m].
    pub length: f64,
}

impl Means {
    /// All zero.
    pub const ZERO: Self = Self {
        rest: Vec3::new(0.0, 0.0, 0.0),
        u: Vec3::new(0.0, 0.0, 0.0),
        rest_rest: Mat3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        u_rest: Mat3::new(0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        length: 0.0,
    };

    /// Mean deformed position [m].
    pub fn x(&self) -> Vec3 {
        self.rest + self.u
    }

    /// Mean of (x − x̄)(X − X̄)ᵀ [m²].
    pub fn moment(&self) -> Mat3 {
        self.rest_rest + self.u_rest - self.x() * self.rest.transpose()
    }

    /// The derivative by [`Self::moment`] as one by the means.
    pub fn by_moment(&self, by: &Mat3) -> Self {
        let u = -by * self.rest;
        let rest = u - by.transpose() * self.x();
        Self { rest, u, rest_rest: *by, u_rest: *by, length: 0.0 }
    }

    /// The derivative by [`Self::x`] as one by the means.
    pub fn by_x(by: Vec3) -> Self {
        Self { rest: by, u: by, ..Self::ZERO }
    }

    fn of(place: &Place) -> Self {
        let Place { rest, u } = *place;
        let (rest_rest, u_rest) = (rest * rest.transpose(), u * rest.transpose());
        Self { rest, u, rest_rest, u_rest, length: u.norm() }
    }

    fn add(&mut self, weight: f64, other: &Self) {
        self.rest += weight * other.rest;
        self.u += weight * other.u;
        self.rest_rest += weight * other.rest_rest;
        self.u_rest += weight * other.u_rest;
        self.length += weight * other.length;
    }

    fn dot(&self, other: &Self) -> f64 {
        self.rest.dot(&other.rest)
            + self.u.dot(&other.u)
            + self.rest_rest.dot(&other.rest_rest)
            + self.u_rest.dot(&other.u_rest)
            + self.length * other.length
    }
}

/// A function of means over tags: q and m̄ of each tag.
struct OfMeans<F> {
    patches: Vec<Patch>,
    function: F,
}

/// The quantity that a function of the means over tags is, which has q and m̄ of each tag.
pub fn of_means<'a, F>(
    site: &Site,
    tags: impl IntoIterator<Item = &'a String>,
    function: F,
) -> Result<Arc<dyn Quantity>>
where
    F: Fn(&[Means]) -> (f64, Vec<Means>) + Send + Sync + 'static,
{
    let patch = |tag: &String| Ok(Patch::new(site.space, &site.body.facets(tag)?, Measure::Rest));
    let patches = tags.into_iter().map(patch).collect::<Result<_>>()?;
    Ok(Arc::new(OfMeans { patches, function }))
}

impl<F> OfMeans<F> {
    /// Area [m²] and means of each tag.
    fn means(&self, at: &Equilibrium) -> Vec<(f64, Means)> {
        let of_tag = |patch: &Patch| {
            let points = patch.points(at);
            let area: f64 = points.iter().map(|(_, area)| area).sum();
            let mut means = Means::ZERO;
            points.iter().for_each(|(place, part)| means.add(part / area, &Means::of(place)));
            (area, means)
        };
        self.patches.iter().map(of_tag).collect()
    }
}

impl<F> Quantity for OfMeans<F>
where
    F: Fn(&[Means]) -> (f64, Vec<Means>) + Send + Sync,
{
    fn value(&self, at: &Equilibrium) -> f64 {
        let means: Vec<Means> = self.means(at).into_iter().map(|(_, means)| means).collect();
        (self.function)(&means).0
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        let all = self.means(at);
        let means: Vec<Means> = all.iter().map(|(_, means)| *means).collect();
        let (_, bars) = (self.function)(&means);
        for ((patch, (area, means)), bar) in self.patches.iter().zip(&all).zip(&bars) {
            let own = bar.dot(means);
            let density = |place: &Place| {
                let direction = place.u.try_normalize(0.0).unwrap_or_default();
                let by_u = bar.u + bar.u_rest * place.rest + bar.length * direction;
                let by_product = bar.rest_rest + bar.rest_rest.transpose();
                let by_rest = bar.rest + by_product * place.rest + bar.u_rest.transpose() * place.u;
                Density {
                    value: (bar.dot(&Means::of(place)) - own) / area,
                    by_u: by_u / *area,
                    by_rest: by_rest / *area,
                }
            };
            patch.add_partials(at, &density, weight, out);
        }
    }
}
