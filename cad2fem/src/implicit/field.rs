//! The implicit function of a list of primitives: smooth unions and the rest.
//!
//! smin(a, b, k) = min(a, b) − h²k/4 with h = max(k − |a − b|, 0)/k blends two
//! bodies over a width k (I. Quilez's quadratic polynomial smooth minimum).

use mesh::Vec3;

use super::model::{Op, Primitive};
use super::shape::{Shape, smoothstep};

/// Evaluates a list of primitives in order.
pub struct Field {
    steps: Vec<Step>,
}

struct Step {
    shape: Shape,
    op: Op,
    blend: f64,
    /// Index of the primitive, shared by mirror images.
    source: usize,
    is_body: bool,
}

impl Field {
    /// The function of `primitives`; ornaments are left out unless `fine`.
    #[must_use]
    pub fn new(primitives: &[Primitive], fine: bool) -> Self {
        let mut steps = Vec::new();
        for (source, p) in primitives.iter().enumerate().filter(|(_, p)| fine || !p.fine) {
            let mirror = p.mirror.then(|| p.shape.mirrored());
            for shape in std::iter::once(p.shape.clone()).chain(mirror) {
                let step = Step { shape, op: p.op, blend: p.blend, source, is_body: p.is_body() };
                steps.push(step);
            }
        }
        Self { steps }
    }

    /// Negative inside, zero on the surface; a distance to first order near it,
    /// +∞ without primitives [unit].
    #[must_use]
    pub fn at(&self, p: &Vec3) -> f64 {
        self.steps.iter().fold(f64::INFINITY, |d, step| step.apply(d, step.shape.distance(p)))
    }

    /// The body whose own surface is nearest to `p`, as an index into the list of
    /// primitives.
    #[must_use]
    pub fn nearest(&self, p: &Vec3) -> Option<usize> {
        let bodies = self.steps.iter().filter(|s| s.is_body);
        bodies
            .map(|s| (s.shape.distance(p), s.source))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, source)| source)
    }
}

impl Step {
    fn apply(&self, d: f64, e: f64) -> f64 {
        if matches!(self.shape, Shape::Crease { .. }) {
            return d + e;
        }
        match self.op {
            Op::Union => smooth_min(d, e, self.blend),
            Op::Difference => -smooth_min(-d, e, self.blend),
            Op::Intersection => -smooth_min(-d, -e, self.blend),
            Op::Emboss { height, width } => d - height * smoothstep(0.5 - e / (2.0 * width)),
        }
    }
}

fn smooth_min(a: f64, b: f64, k: f64) -> f64 {
    let overlap = k - (a - b).abs();
    if overlap <= 0.0 { a.min(b) } else { a.min(b) - overlap * overlap / (4.0 * k) }
}
