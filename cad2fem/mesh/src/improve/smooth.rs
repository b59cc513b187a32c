//! Vertices move to where the worst tetrahedron about them is best.

use super::complex::Complex;
use super::shape::{energy, shape, slack};
use crate::Vec3;

/// Newton steps at most; convergence is quadratic.
const STEPS: usize = 8;

/// A move counts as one if it makes the worst tetrahedron better by this share.
const GAIN: f64 = 1e-2;

/// Moves every interior vertex whose worst tetrahedron gets better by it and near
/// which something changed since the time `since`; returns their number.
pub(super) fn smooth(complex: &mut Complex, since: usize) -> usize {
    let mut moved = 0;
    for v in 0..complex.points.len() {
        let waits = complex.star(v).is_empty() || !complex.changed_since(v, since);
        if !complex.is_interior(v) || waits {
            continue;
        }
        let link = complex.link_points(v);
        let target = relocate(&link, complex.points[v]);
        let worst = complex.worst(complex.star(v));
        if worst_about(&link, &target) > worst + GAIN * worst.abs() {
            complex.move_vertex(v, target);
            moved += 1;
        }
    }
    moved
}

/// Moves the interior vertices of inverted tetrahedra to where these weigh least;
/// returns their number.
pub(super) fn untangle(complex: &mut Complex) -> usize {
    let mut moved = 0;
    for v in 0..complex.points.len() {
        if !complex.is_interior(v) || complex.worst(complex.star(v)) > 0.0 {
            continue;
        }
        let link = complex.link_points(v);
        complex.move_vertex(v, relocate(&link, complex.points[v]));
        moved += 1;
    }
    moved
}

/// The smallest shape of the tetrahedra between `x` and the triangles `link`.
pub(super) fn worst_about(link: &[[Vec3; 3]], x: &Vec3) -> f64 {
    link.iter().map(|&[a, b, c]| shape([a, b, c, *x])).fold(f64::INFINITY, f64::min)
}

/// The place of least energy between the triangles `link`, found by Newton's
/// method from `start`; `start` itself if it does not see all of them.
pub(super) fn relocate(link: &[[Vec3; 3]], start: Vec3) -> Vec3 {
    let mut x = start;
    let slack = slack(link, &start);
    let Some(mut now) = energy(link, &x, slack) else { return start };
    for _ in 0..STEPS {
        let Some(factor) = now.hessian.cholesky() else { break };
        let step = -factor.solve(&now.gradient);
        let slope = now.gradient.dot(&step);
        // What is left to gain is 10⁻⁵ of the mean ratio, whose 8th power it is.
        if slope > -1e-4 * now.value {
            break;
        }
        let mut length = 1.0;
        let next = loop {
            let candidate = x + step * length;
            match energy(link, &candidate, slack) {
                Some(e) if e.value < now.value + 1e-4 * length * slope => {
                    break Some((candidate, e));
                }
                _ if length < 1e-3 => break None,
                _ => length *= 0.5,
            }
        };
        let Some((candidate, e)) = next else { break };
        (x, now) = (candidate, e);
    }
    x
}
