//! Squared distances between two features given by four points.
//!
//! d² = |r|²,   r = Σᵢ cᵢ xᵢ,   Σᵢ cᵢ = 0
//!
//! x   corners of both features [m]
//! c   barycentric coefficients of the two closest points, negative for the
//!     second feature [1]
//! r   vector from the closest point of the second feature to that of the
//!     first [m]
//!
//! The coefficients minimise |r| under bounds, so their change does not show in
//! the first derivative: ∂d²/∂xᵢ = 2 cᵢ r. A coefficient that is exactly zero
//! marks a corner that the closest feature does not contain. Degenerate
//! features (a triangle without area, an edge without length) are treated as
//! the edges or the point that they are. Thresholds are relative, so results do
//! not depend on the unit of length.
//!
//! Within a region, that is as long as the same corners take part, c = c⁰ + Σ sₖ eₖ
//! with free s, and ∂d²/∂s = 0 gives s and its change with x:
//!
//! ∂²d²/∂x² = 2 (c cᵀ ⊗ I − G M⁻¹ Gᵀ)      Gₖ = c ⊗ tₖ + eₖ ⊗ r
//! tₖ = Σᵢ eᵢₖ xᵢ      Mₖₗ = tₖ · tₗ
//!
//! d² is once continuously differentiable, except for edges that are parallel
//! and side by side, where the closest points are not unique; see
//! [`mollifier`](super::mollifier).

use mesh::Vec3;
use nalgebra::SMatrix;

use crate::math::tensor::{Mat12, Vec12};

/// sin² of the angle below which two directions count as parallel [1].
const PARALLEL: f64 = 2.5e-16;

type Vec4 = nalgebra::Vector4<f64>;

/// The closest points of two features.
#[derive(Clone, Copy, Debug)]
pub struct Closest {
    /// cᵢ of the four corners [1].
    pub coefficients: [f64; 4],
    /// r, from the second feature to the first [m].
    pub offset: Vec3,
    /// d² [m²].
    pub d2: f64,
}

impl Closest {
    fn new(x: &[Vec3; 4], coefficients: [f64; 4]) -> Self {
        // differences to one corner first, so that an offset common to all
        // corners costs no digits
        let offset = (1..4).map(|i| coefficients[i] * (x[i] - x[0])).sum::<Vec3>();
        Self { coefficients, offset, d2: offset.norm_squared() }
    }

    /// ∂d²/∂xᵢ [m].
    pub fn d2_gradient(&self) -> [Vec3; 4] {
        self.coefficients.map(|c| 2.0 * c * self.offset)
    }

    fn closer(self, other: Self) -> Self {
        if other.d2 < self.d2 { other } else { self }
    }
}

/// Which corners of two features their closest points lie between.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct Region {
    /// Number of corners of the first feature: 1 for a point, 2 for an edge.
    pub first: usize,
    /// Whether each of the four corners takes part.
    pub active: [bool; 4],
}

impl Region {
    /// The region of closest points.
    pub fn of(first: usize, closest: &Closest) -> Self {
        Self { first, active: closest.coefficients.map(|c| c != 0.0) }
    }

    /// The closest points if they are in this region.
    pub fn closest(&self, x: &[Vec3; 4]) -> Closest {
        let free = self.free();
        let mut c = free.start;
        let r: Vec3 = c.iter().zip(x).map(|(c, p)| *c * (p - x[0])).sum();
        let s = match (free.count, free.tangents(x)) {
            (0, _) => [0.0; 2],
            (1, [t, _]) => [-t.dot(&r) / t.norm_squared(), 0.0],
            (_, [a, b]) => {
                let n = a.cross(&b);
                [b.cross(&r).dot(&n), r.cross(&a).dot(&n)].map(|v| v / n.norm_squared())
            }
        };
        for (e, s) in free.directions.iter().zip(s) {
            c.iter_mut().zip(e).for_each(|(c, e)| *c += s * e);
        }
        Closest::new(x, c)
    }

    /// ∂²d²/∂x² at the closest points, which are in this region [1].
    pub fn d2_hessian(&self, x: &[Vec3; 4], closest: &Closest) -> Mat12 {
        let c = &closest.coefficients;
        let mut hessian = Mat12::zeros();
        for i in 0..4 {
            for j in 0..4 {
                let mut block = hessian.fixed_view_mut::<3, 3>(3 * i, 3 * j);
                block.fill_diagonal(2.0 * c[i] * c[j]);
            }
        }
        let free = self.free();
        let t = free.tangents(x);
        let g: [Vec12; 2] = std::array::from_fn(|k| {
            let of_corner = |i: usize| c[i] * t[k] + free.directions[k][i] * closest.offset;
            corners([0, 1, 2, 3].map(of_corner))
        });
        let (aa, ab, bb) = (t[0].norm_squared(), t[0].dot(&t[1]), t[1].norm_squared());
        match free.count {
            0 => {}
            1 => hessian -= g[0] * (g[0] * (2.0 / aa)).transpose(),
            _ => {
                let by = 2.0 / t[0].cross(&t[1]).norm_squared();
                hessian -= g[0] * ((g[0] * bb - g[1] * ab) * by).transpose();
                hessian -= g[1] * ((g[1] * aa - g[0] * ab) * by).transpose();
            }
        }
        hessian
    }

    /// Cotangents of the corners, given those of the coefficients and the offset of
    /// closest points in this region.
    ///
    /// From tₖ · r = 0: Σ M σ = s̄ with s̄ₖ = c̄ · eₖ + r̄ · tₖ, and
    /// x̄ᵢ = cᵢ r̄ − Σₖ σₖ (cᵢ tₖ + eᵢₖ r).
    pub fn closest_vjp(
        &self,
        x: &[Vec3; 4],
        closest: &Closest,
        (by_coefficients, by_offset): (&[f64; 4], &Vec3),
    ) -> [Vec3; 4] {
        let free = self.free();
        let t = free.tangents(x);
        let by_free: [f64; 2] = std::array::from_fn(|k| {
            let own: f64 = free.directions[k].iter().zip(by_coefficients).map(|(e, b)| e * b).sum();
            own + by_offset.dot(&t[k])
        });
        let (aa, ab, bb) = (t[0].norm_squared(), t[0].dot(&t[1]), t[1].norm_squared());
        let sigma = match free.count {
            0 => [0.0; 2],
            1 => [by_free[0] / aa, 0.0],
            _ => {
                let by = 1.0 / t[0].cross(&t[1]).norm_squared();
                let [p, q] = by_free;
                [(bb * p - ab * q) * by, (aa * q - ab * p) * by]
            }
        };
        std::array::from_fn(|i| {
            let c = closest.coefficients[i];
            let moved = |k: usize| sigma[k] * (c * t[k] + free.directions[k][i] * closest.offset);
            c * by_offset - moved(0) - moved(1)
        })
    }

    /// Orthonormal vectors that span the range of ∂²d²/∂x² and contain ∂d²/∂x;
    /// zero from their number on.
    pub fn range(&self, closest: &Closest) -> SMatrix<f64, 12, 5> {
        let normal = closest.offset.normalize();
        let coefficients = Vec4::from(closest.coefficients).normalize();
        let mut basis = SMatrix::<f64, 12, 5>::zeros();
        let mut set = |k: usize, c: &Vec4, direction: &Vec3| {
            basis.set_column(k, &corners([0, 1, 2, 3].map(|i| c[i] * direction)));
        };
        let [s, t] = tangents(&normal);
        set(0, &coefficients, &s);
        set(1, &coefficients, &t);
        set(2, &coefficients, &normal);
        let free = self.free();
        let mut found = vec![coefficients];
        for e in &free.directions[..free.count] {
            let mut e = Vec4::from(*e);
            // twice, as rounding of the first time may be all that is left
            for other in found.iter().chain(&found) {
                e -= other * other.dot(&e);
            }
            let e = e.normalize();
            set(2 + found.len(), &e, &normal);
            found.push(e);
        }
        basis
    }

    fn free(&self) -> Free {
        let mut free = Free { start: [0.0; 4], directions: [[0.0; 4]; 2], count: 0 };
        let mut base = [None; 2];
        for i in (0..4).filter(|&i| self.active[i]) {
            let (feature, sign) = if i < self.first { (0, 1.0) } else { (1, -1.0) };
            if let Some(base) = base[feature] {
                free.directions[free.count][i] = sign;
                free.directions[free.count][base] = -sign;
                free.count += 1;
            } else {
                free.start[i] = sign;
                base[feature] = Some(i);
            }
        }
        free
    }
}

/// c⁰ and the directions eₖ, at most two, in which the coefficients are free.
struct Free {
    start: [f64; 4],
    directions: [[f64; 4]; 2],
    count: usize,
}

impl Free {
    /// tₖ, zero from the number of directions on.
    fn tangents(&self, x: &[Vec3; 4]) -> [Vec3; 2] {
        self.directions.map(|e| e.iter().zip(x).map(|(e, p)| *e * (p - x[0])).sum())
    }
}

/// Two unit vectors orthogonal to a unit vector and to each other.
pub fn tangents(normal: &Vec3) -> [Vec3; 2] {
    // the axis that is least along the normal
    let mut axis = Vec3::zeros();
    axis[normal.iamin()] = 1.0;
    let first = normal.cross(&axis).normalize();
    [first, normal.cross(&first)]
}

/// One vector of the components of four.
pub fn corners(vectors: [Vec3; 4]) -> Vec12 {
    Vec12::from_fn(|i, _| vectors[i / 3][i % 3])
}

/// Point `x[0]` to triangle `x[1..4]`.
pub fn point_triangle(x: &[Vec3; 4]) -> Closest {
    if let Some([a, b]) = projection(x) {
        return Closest::new(x, [1.0, a + b - 1.0, -a, -b]);
    }
    let edge = |i: usize, j: usize| point_edge(x, 0, [i, j]);
    edge(1, 2).closer(edge(2, 3)).closer(edge(3, 1))
}

/// Corner `point` to the edge of corners i and j of the other feature.
pub fn point_edge(x: &[Vec3; 4], point: usize, [i, j]: [usize; 2]) -> Closest {
    let t = segment_parameter(&x[point], &x[i], &x[j]);
    let sign = if point < i { 1.0 } else { -1.0 };
    let mut c = [0.0; 4];
    c[point] = sign;
    c[i] = -sign * (1.0 - t);
    c[j] = -sign * t;
    Closest::new(x, c)
}

/// Edge `x[0..2]` to edge `x[2..4]`.
pub fn edge_edge(x: &[Vec3; 4]) -> Closest {
    if let Some([s, t]) = crossing(x) {
        return Closest::new(x, [1.0 - s, s, t - 1.0, -t]);
    }
    point_edge(x, 0, [2, 3])
        .closer(point_edge(x, 1, [2, 3]))
        .closer(point_edge(x, 2, [0, 1]))
        .closer(point_edge(x, 3, [0, 1]))
}

/// Parameter in [0, 1] of the point of segment `a`–`b` closest to `p`.
fn segment_parameter(p: &Vec3, a: &Vec3, b: &Vec3) -> f64 {
    let edge = b - a;
    let length2 = edge.norm_squared();
    if length2 == 0.0 { 0.0 } else { ((p - a).dot(&edge) / length2).clamp(0.0, 1.0) }
}

/// Barycentric coordinates of corners 2 and 3 at the projection of the point
/// onto the plane of the triangle, if it lies strictly inside.
fn projection(x: &[Vec3; 4]) -> Option<[f64; 2]> {
    let (e1, e2, q) = (x[2] - x[1], x[3] - x[1], x[0] - x[1]);
    let n = e1.cross(&e2);
    let n2 = n.norm_squared();
    if n2 <= PARALLEL * e1.norm_squared() * e2.norm_squared() {
        return None;
    }
    let (a, b) = (q.cross(&e2).dot(&n) / n2, e1.cross(&q).dot(&n) / n2);
    (a > 0.0 && b > 0.0 && a + b < 1.0).then_some([a, b])
}

/// Parameters of the closest points of the two lines, if both lie strictly
/// inside the segments and the lines are not parallel.
fn crossing(x: &[Vec3; 4]) -> Option<[f64; 2]> {
    let (a, b, w) = (x[1] - x[0], x[3] - x[2], x[2] - x[0]);
    let n = a.cross(&b);
    let n2 = n.norm_squared();
    if n2 <= PARALLEL * a.norm_squared() * b.norm_squared() {
        return None;
    }
    let (s, t) = (w.cross(&b).dot(&n) / n2, w.cross(&a).dot(&n) / n2);
    let inside = |v: f64| v > 0.0 && v < 1.0;
    (inside(s) && inside(t)).then_some([s, t])
}

#[cfg(test)]
mod tests;
