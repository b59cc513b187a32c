//! A body as what is on the inner side of several surfaces: those of its cuts, of the solid and of
//! the cavity.

use anyhow::{Result, ensure};
use mesh::Vec3;

use super::model::Model;
use super::range::Range;
use super::skin::Part;
use super::{Field, Fields};

/// How often a point is put onto the planes of its cuts in turn: one turn does for one plane, oblique
/// ones converge.
const TURNS: usize = 20;

/// Step of the differences that give gradients [grid].
const STEP: f64 = 1e-4;

/// A function whose zero set bounds the body, negative inside.
pub enum Side<'a> {
    /// Unit normal and offset of a plane [unit].
    Cut(Vec3, f64),
    /// The body is where this is negative.
    Solid(&'a Field),
    /// The body is where this is positive.
    Cavity(&'a Field),
}

impl Side<'_> {
    /// A distance to first order near its zero, negative inside [unit].
    pub fn at(&self, p: &Vec3) -> f64 {
        match self {
            Self::Cut(normal, offset) => normal.dot(p) - offset,
            Self::Solid(field) => field.at(p),
            Self::Cavity(field) => -field.at(p),
        }
    }

    /// The gradient, by central differences over 2 `step`.
    pub fn gradient(&self, p: &Vec3, step: f64) -> Vec3 {
        match self {
            Self::Cut(normal, _) => *normal,
            Self::Solid(field) => field.gradient(p, step),
            Self::Cavity(field) => -field.gradient(p, step),
        }
    }

    /// Bounds over the ball around `c` with the radius `r` [unit].
    pub fn range(&self, c: &Vec3, r: f64) -> Range {
        match self {
            Self::Cut(..) => (self.at(c) - r, self.at(c) + r),
            Self::Solid(field) => field.range(c, r),
            Self::Cavity(field) => {
                let (low, high) = field.range(c, r);
                (-high, -low)
            }
        }
    }
}

/// All sides of a body. Their order is that in which they are carved: planes first.
pub struct Sides<'a> {
    /// The cuts, the solid and, if there is one, the cavity.
    pub list: Vec<Side<'a>>,
    /// Length of a unit [m].
    pub metres: f64,
    /// Edge length of the triangles [unit].
    pub grid: f64,
    cuts: usize,
}

impl<'a> Sides<'a> {
    pub fn new(model: &Model, fields: &'a Fields, grid: f64) -> Result<Self> {
        let cut = |c: &super::Cut| Side::Cut(Vec3::from(c.normal).normalize(), c.offset);
        let mut list: Vec<Side> = model.cut.iter().map(cut).collect();
        ensure!(list.len() <= 60, "{} cuts; at most 60 can be made", list.len());
        list.push(Side::Solid(&fields.solid));
        if !model.cavity.is_empty() {
            list.push(Side::Cavity(&fields.cavity));
        }
        Ok(Self { list, metres: model.unit.metres(), grid, cuts: model.cut.len() })
    }

    /// What is bounded by side `k`.
    pub fn part(&self, k: usize) -> Part {
        match k - k.min(self.cuts) {
            _ if k < self.cuts => Part::Cut(k),
            0 => Part::Outside,
            _ => Part::Cavity,
        }
    }

    /// The value of side `k` at a point in metres [unit].
    pub fn at(&self, k: usize, p: &Vec3) -> f64 {
        self.list[k].at(&(p / self.metres))
    }

    /// How far outside the body a point is, negative inside [unit].
    pub fn depth(&self, p: &Vec3) -> f64 {
        self.list.iter().map(|side| side.at(p)).fold(f64::NEG_INFINITY, f64::max)
    }

    /// The direction in which the depth rises at `p`; zero where it does not.
    pub fn outward(&self, p: &Vec3) -> Vec3 {
        let step = STEP * self.grid;
        let slope = Vec3::from_fn(|k, _| {
            let e = Vec3::from_fn(|i, _| if i == k { step } else { 0.0 });
            self.depth(&(p + e)) - self.depth(&(p - e))
        });
        slope.try_normalize(0.0).unwrap_or_default()
    }

    /// The point [m] as files keep it, in the planes of those cuts whose bits are set in `on`.
    pub fn settle(&self, p: &Vec3, on: u64) -> Vec3 {
        let mut p = p / self.metres;
        for _ in 0..if on & ((1 << self.cuts) - 1) == 0 { 0 } else { TURNS } {
            for (k, side) in self.list[..self.cuts].iter().enumerate() {
                if let (Side::Cut(normal, _), true) = (side, on >> k & 1 == 1) {
                    p -= normal * side.at(&p);
                }
            }
        }
        // Adding zero turns -0 into +0.
        (p * self.metres).map(|x| f64::from(x as f32) + 0.0)
    }
}
