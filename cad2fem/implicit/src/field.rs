//! The implicit function of a list of primitives: smooth unions and the rest.
//!
//! smin(a, b, k) = min(a, b) − h²k/4 with h = max(k − |a − b|, 0)/k blends two
//! bodies over a width k (I. Quilez's quadratic polynomial smooth minimum).

use mesh::Vec3;

use super::model::{Op, Primitive};
use super::range::Range;
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
    pub fn at(&self, p: &Vec3) -> f64 {
        self.steps.iter().fold(f64::INFINITY, |d, step| step.apply(d, step.shape.distance(p)))
    }

    /// Bounds of [`Field::at`] over the ball around `c` with the radius `r` [unit].
    pub fn range(&self, c: &Vec3, r: f64) -> Range {
        let nothing = (f64::INFINITY, f64::INFINITY);
        self.steps.iter().fold(nothing, |d, step| step.apply_range(d, step.shape.range(c, r)))
    }

    /// The gradient at `p`, by central differences over 2 `step`.
    pub fn gradient(&self, p: &Vec3, step: f64) -> Vec3 {
        Vec3::from_fn(|k, _| {
            let e = Vec3::from_fn(|i, _| if i == k { step } else { 0.0 });
            (self.at(&(p + e)) - self.at(&(p - e))) / (2.0 * step)
        })
    }

    /// The direction in which the function rises at `p`, by central differences over 2 `step`; zero
    /// where it does not.
    pub fn outward(&self, p: &Vec3, step: f64) -> Vec3 {
        self.gradient(p, step).try_normalize(0.0).unwrap_or_default()
    }

    /// The body whose own surface is nearest to `p`, as an index into the list of
    /// primitives.
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

impl Step {
    /// Bounds of what [`Self::apply`] makes of values within bounds: it rises with d, and rises or
    /// falls with e.
    fn apply_range(&self, d: Range, e: Range) -> Range {
        let fall = matches!(self.op, Op::Difference | Op::Emboss { height: ..0.0, .. });
        let e = if fall { (e.1, e.0) } else { e };
        (self.apply(d.0, e.0), self.apply(d.1, e.1))
    }
}

fn smooth_min(a: f64, b: f64, k: f64) -> f64 {
    let overlap = k - (a - b).abs();
    if overlap <= 0.0 { a.min(b) } else { a.min(b) - overlap * overlap / (4.0 * k) }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    fn field(primitives: &str, fine: bool) -> Field {
        #[derive(serde::Deserialize)]
        struct List {
            solid: Vec<Primitive>,
        }
        let list: List = toml::from_str(primitives).unwrap();
        Field::new(&list.solid, fine)
    }

    const BALL: &str = "solid = [{ name = 'a', shape.sphere = { center = [0, 3, 0], radius = 2 }";

    #[test]
    fn a_mirror_image_is_the_same_on_both_sides() {
        let field = field(&format!("{BALL}, mirror = true }}]"), false);
        assert_eq!(field.at(&Vec3::new(0.0, 3.0, 0.0)), -2.0);
        assert_eq!(field.at(&Vec3::new(0.0, -3.0, 0.0)), -2.0);
        assert_eq!(field.nearest(&Vec3::new(0.0, -4.0, 0.0)), Some(0));
    }

    #[test]
    fn a_blend_adds_a_quarter_of_its_width_midway() {
        let two = format!(
            "{BALL} }}, {{ name = 'b', blend = 4, shape.sphere = {{ center = [0, -3, 0], radius = 2 }} }}]"
        );
        // Midway both distances are 1, so that smin = 1 − 4/4.
        assert_eq!(field(&two, false).at(&Vec3::zeros()), 0.0);
        assert_eq!(field(&two, false).nearest(&Vec3::new(0.0, -0.1, 0.0)), Some(1));
    }

    #[test]
    fn operations_remove_keep_raise_and_engrave() {
        let with = |second: &str| {
            let text = format!(
                "{BALL} }}, {{ name = 'b', {second}, shape.sphere = {{ center = [0, 5, 0], radius = 1 }} }}]"
            );
            field(&text, true)
        };
        let (shared, alone) = (Vec3::new(0.0, 4.5, 0.0), Vec3::new(0.0, 2.0, 0.0));
        let inside = |f: &Field| (f.at(&shared) < 0.0, f.at(&alone) < 0.0);
        assert_eq!(inside(&with("op = 'difference'")), (false, true));
        assert_eq!(inside(&with("op = 'intersection'")), (true, false));
        let raised = with("op.emboss = { height = 0.3, width = 0.1 }");
        // Deep inside the second ball the surface is raised by the full height.
        assert!((raised.at(&Vec3::new(0.0, 5.0, 0.0)) + 0.3).abs() < 1e-12);
        assert_eq!(raised.at(&alone), -1.0);
        let ornament = with("fine = true");
        assert_eq!(ornament.at(&Vec3::new(0.0, 5.0, 0.0)), -1.0);
    }

    #[test]
    fn a_crease_is_engraved_where_it_has_risen() {
        let text = format!(
            "{BALL} }}, {{ name = 'c', shape.crease = {{ normal = [0, 0, 1], offset = 0, width = 0.2, \
             depth = 0.5, fade = [-1, 1] }} }}]"
        );
        let field = field(&text, false);
        let right = Vec3::new(2.0, 3.0, 0.0);
        assert_eq!(field.at(&right), 0.5);
        assert_eq!(field.at(&Vec3::new(-2.0, 3.0, 0.0)), 0.0);
        assert_eq!(field.nearest(&right), Some(0));
    }
}
