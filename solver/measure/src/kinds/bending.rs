//! How far a body bends.
//!
//! q = ϑ(on) − ϑ(to) + 360° k                                       [deg]
//! ϑ = angle about the axis a from N₀ to N, both across a         N = ∫ n da of a tag
//! ∂ϑ/∂N = a × N / |N − a a·N|²,  ∂ϑ/∂N₀ = −a × N₀ / |N₀ − a a·N₀|²
//!
//! N₀ is N at rest, so that q is 0 there. It has a sign, by the right-hand rule about a. The whole
//! turns k are counted along a chain of neighbouring tetrahedra from one tag to the other: the
//! rotation of each, atan2(F₂₁ − F₁₂, F₁₁ + F₂₂) across a, differs by less than half a turn from
//! that of the one before. So q needs no history, and goes beyond 180°.

use std::collections::{BTreeMap, BTreeSet, VecDeque};
use std::f64::consts::TAU;

use anyhow::Context as _;
use mechanics::math::tensor::Mat3;

use super::*;
use crate::quantity::Normal;

pub(super) const KIND: Kind = Kind {
    key: "bending",
    unit: "deg",
    example: "on = 'top'\nto = 'left'\naxis = [0.3, 2, 0.4]",
    ..Kind::of::<Keys>(&[List::Probe])
};

/// Sine of the angle between a normal and the axis below which a tag does not turn about it.
const ALONG: f64 = 0.1;

program::table! {
    /// angle about an axis by which a tag has turned against another one since rest; has a sign, and counts
    /// whole turns
    #[derive(Debug)]
    struct Keys {
        /// tag
        on: String;
        /// the other tag
        to: String;
        /// across the plane in which the body bends, of any length but 0; positive by the right-hand
        /// rule
        axis: Axis;
    }
}

impl Specification for Keys {
    fn build(&self, site: &Site) -> Result<Arc<dyn Quantity>> {
        let axis = self.axis.unit();
        let side = |tag: &str| {
            let normal = Normal::new(tag, site)?;
            let n = normal.at(site.space, &site.space.node_positions(&site.body.mesh.vertices));
            let across = across(&axis, &n).norm() / n.norm();
            ensure!(
                across > ALONG,
                "tag \"{tag}\": its mean normal is {:.0}° from the axis, about which it then does \
                 not turn; the axis is across the plane in which the body bends",
                across.asin().to_degrees()
            );
            Ok(normal)
        };
        let sides = [side(&self.on)?, side(&self.to)?];
        let [to, on] = [&self.to, &self.on].map(|tag| site.body.facets(tag));
        let chain = chain(site.space.tets(), &to?, &on?).with_context(|| {
            format!(
                "tags \"{}\" and \"{}\" are on bodies that do not hang together, so that whole \
                 turns cannot be counted",
                self.on, self.to
            )
        })?;
        Ok(Arc::new(Bending { axis, sides, chain }))
    }
}

/// A shortest chain of tetrahedra that share facets, from one tag to another.
fn chain(tets: &[[usize; 4]], from: &[[usize; 3]], to: &[[usize; 3]]) -> Option<Vec<usize>> {
    let facets = |t: usize| {
        let [a, b, c, d] = tets[t];
        [[b, c, d], [a, c, d], [a, b, d], [a, b, c]].map(sorted)
    };
    let mut beside: BTreeMap<[usize; 3], Vec<usize>> = BTreeMap::new();
    for t in 0..tets.len() {
        facets(t).into_iter().for_each(|facet| beside.entry(facet).or_default().push(t));
    }
    let behind = |tag: &[[usize; 3]]| -> BTreeSet<usize> {
        tag.iter().flat_map(|&facet| beside[&sorted(facet)].iter().copied()).collect()
    };
    let (ends, mut queue) = (behind(to), VecDeque::from_iter(behind(from)));
    let mut before: BTreeMap<usize, Option<usize>> = queue.iter().map(|&t| (t, None)).collect();
    while let Some(t) = queue.pop_front() {
        if ends.contains(&t) {
            let back = |t: &usize| before[t];
            let mut chain: Vec<usize> = std::iter::successors(Some(t), back).collect();
            chain.reverse();
            return Some(chain);
        }
        for next in facets(t).iter().flat_map(|facet| beside[facet].iter().copied()) {
            before.entry(next).or_insert_with(|| {
                queue.push_back(next);
                Some(t)
            });
        }
    }
    None
}

fn sorted(mut facet: [usize; 3]) -> [usize; 3] {
    facet.sort_unstable();
    facet
}

/// What of a vector is across the axis.
fn across(axis: &Vec3, v: &Vec3) -> Vec3 {
    v - axis * axis.dot(v)
}

/// The angle nearest to `near` that is `angle` but for whole turns.
fn unwrapped(angle: f64, near: f64) -> f64 {
    angle + TAU * ((near - angle) / TAU).round()
}

/// The angle by which one wall turns against another.
struct Bending {
    axis: Vec3,
    sides: [Normal; 2],
    /// Tetrahedra from the second wall to the first.
    chain: Vec<usize>,
}

impl Bending {
    /// ϑ from N₀ to N, but for whole turns.
    fn turn(&self, from: &Vec3, to: &Vec3) -> f64 {
        let cos = across(&self.axis, from).dot(&across(&self.axis, to));
        self.axis.dot(&from.cross(to)).atan2(cos)
    }

    /// ∂ϑ/∂N.
    fn by_normal(&self, n: &Vec3) -> Vec3 {
        self.axis.cross(n) / across(&self.axis, n).norm_squared()
    }

    /// Rotation about the axis of one tetrahedron with straight edges, but for whole turns.
    fn rotation(&self, tet: [usize; 4], [rest, now]: [&[Vec3]; 2]) -> f64 {
        let edges = |x: &[Vec3]| {
            let [a, b, c, d] = tet.map(|v| x[v]);
            Mat3::from_columns(&[b - a, c - a, d - a])
        };
        let Some(to_rest) = edges(rest).try_inverse() else { return 0.0 };
        let f = edges(now) * to_rest;
        let spin = Vec3::new(f.m32 - f.m23, f.m13 - f.m31, f.m21 - f.m12);
        let stretch = f.trace() - self.axis.dot(&(f * self.axis));
        self.axis.dot(&spin).atan2(stretch)
    }

    /// Adds `weight` ∂q/∂x at nodes at `x`.
    fn add_by_nodes(&self, state: &Equilibrium, measure: Measure, weight: f64, out: &mut [f64]) {
        let x = state.nodes(measure);
        for (side, sign) in self.sides.iter().zip([1.0, -1.0]) {
            let by = sign * weight.to_degrees() * self.by_normal(&side.at(state.space, &x));
            side.add_by_nodes(state.space, &x, &by, out);
        }
    }
}

impl Quantity for Bending {
    fn value(&self, state: &Equilibrium) -> f64 {
        let [rest, now] = [Measure::Rest, Measure::Deformed].map(|measure| state.nodes(measure));
        let [on, to] = self
            .sides
            .each_ref()
            .map(|side| self.turn(&side.at(state.space, &rest), &side.at(state.space, &now)));
        let along = self.chain.iter().fold(to, |near, &t| {
            unwrapped(self.rotation(state.space.tets()[t], [&rest, &now]), near)
        });
        (unwrapped(on, along) - to).to_degrees()
    }

    fn add_partials(&self, at: &Equilibrium, weight: f64, out: &mut Partials) {
        self.add_by_nodes(at, Measure::Deformed, weight, out.u);
        let mut nodal = vec![0.0; 3 * at.space.node_count()];
        self.add_by_nodes(at, Measure::Deformed, weight, &mut nodal);
        self.add_by_nodes(at, Measure::Rest, -weight, &mut nodal);
        at.space.add_to_vertices(&nodal, out.rest);
    }
}
