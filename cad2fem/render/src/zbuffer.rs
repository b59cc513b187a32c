//! The z-buffer: what is nearest at every sample of a band of rows.

use super::camera::Projected;

/// The name of nothing at all.
pub const NOTHING: u32 = u32::MAX;

/// Twice the area on the screen; positive if the front is seen (y points down).
pub fn area2([a, b, c]: &[Projected; 3]) -> f64 {
    (b.y - a.y) * (c.x - a.x) - (b.x - a.x) * (c.y - a.y)
}

/// The z-buffer of a band.
pub struct Samples {
    /// Samples per row.
    pub width: usize,
    /// Rows of samples.
    pub height: usize,
    /// Row of samples of the picture that is the first here.
    pub top: usize,
    /// What is seen; [`NOTHING`] for the background.
    pub ids: Vec<u32>,
    /// How near it is.
    pub nearness: Vec<f64>,
}

impl Samples {
    /// Nothing in sight.
    pub fn new(width: usize, height: usize, top: usize) -> Self {
        let count = width * height;
        Self {
            width,
            height,
            top,
            ids: vec![NOTHING; count],
            nearness: vec![f64::NEG_INFINITY; count],
        }
    }

    /// An empty one for the same rows.
    pub fn like(other: &Self) -> Self {
        Self::new(other.width, other.height, other.top)
    }

    /// Centre of a sample.
    pub fn place(&self, index: usize) -> (f64, f64) {
        let (x, y) = (index % self.width, self.top + index / self.width);
        (x as f64 + 0.5, y as f64 + 0.5)
    }

    /// Keeps what is nearer.
    pub fn merge(&mut self, other: &Self) {
        for i in 0..self.ids.len() {
            if other.nearness[i] > self.nearness[i] {
                self.nearness[i] = other.nearness[i];
                self.ids[i] = other.ids[i];
            }
        }
    }

    /// Draws one triangle row by row: each side bounds the span from one end.
    pub fn draw(&mut self, id: u32, corners: &[Projected; 3]) {
        let area = area2(corners);
        if area == 0.0 || !area.is_finite() {
            return;
        }
        let [a, b, c] = corners;
        let gradient = |f: fn(&Projected) -> f64| {
            let (du, dv) = (f(b) - f(a), f(c) - f(a));
            let x = (dv * (b.y - a.y) - du * (c.y - a.y)) / area;
            let y = (du * (c.x - a.x) - dv * (b.x - a.x)) / area;
            (x, y)
        };
        let (slope_x, slope_y) = gradient(|p| p.nearness);
        let low = a.y.min(b.y).min(c.y) - self.top as f64;
        let high = a.y.max(b.y).max(c.y) - self.top as f64;
        let first = (low - 0.5).ceil().max(0.0) as usize;
        let last = ((high - 0.5).floor() + 1.0).clamp(0.0, self.height as f64) as usize;
        for row in first..last {
            let y = (self.top + row) as f64 + 0.5;
            let Some((left, right)) = span(corners, y) else { continue };
            let from = (left - 0.5).ceil().max(0.0) as usize;
            let to = ((right - 0.5).floor() + 1.0).clamp(0.0, self.width as f64) as usize;
            let start = a.nearness + slope_y * (y - a.y) + slope_x * (0.5 - a.x);
            for x in from..to {
                let nearness = start + slope_x * x as f64;
                let index = row * self.width + x;
                if nearness > self.nearness[index] {
                    self.nearness[index] = nearness;
                    self.ids[index] = id;
                }
            }
        }
    }
}

/// Where the line at height y enters and leaves a triangle.
fn span(corners: &[Projected; 3], y: f64) -> Option<(f64, f64)> {
    let mut span: Option<(f64, f64)> = None;
    for side in 0..3 {
        let (a, b) = (&corners[side], &corners[(side + 1) % 3]);
        if (a.y <= y) != (b.y <= y) {
            let x = a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y));
            span = Some(span.map_or((x, x), |(left, right)| (left.min(x), right.max(x))));
        }
    }
    span
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64, nearness: f64) -> Projected {
        Projected { x, y, nearness }
    }

    #[test]
    fn nearer_triangles_hide_farther_ones_in_any_order() {
        let far = [at(0.0, 0.0, 1.0), at(0.0, 8.0, 1.0), at(8.0, 0.0, 1.0)];
        // tilted: nearer than `far` left of x = 4
        let tilted = [at(0.0, 0.0, 1.4), at(0.0, 8.0, 1.4), at(8.0, 0.0, 0.6)];
        let count = |order: [(u32, &[Projected; 3]); 2]| {
            let mut samples = Samples::new(8, 8, 0);
            order.iter().for_each(|(id, corners)| samples.draw(*id, corners));
            [0, 1, NOTHING].map(|id| samples.ids.iter().filter(|&&i| i == id).count())
        };
        // centres with x + y ≤ 8: 8 + 7 + ... + 1 = 36; of these 8 + 7 + 6 + 5 have x < 4
        assert_eq!(count([(0, &far), (1, &tilted)]), [10, 26, 28]);
        assert_eq!(count([(1, &tilted), (0, &far)]), [10, 26, 28]);
    }
}
