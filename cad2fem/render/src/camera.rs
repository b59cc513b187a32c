//! Projection of the scene onto a panel.

use mesh::Vec3;

use super::view::View;

/// Focal length relative to the smaller side of the panel (an angle of 25°).
const FOCAL: f64 = 2.2;
/// Room between the scene and the border of its panel.
const MARGIN: f64 = 0.06;

/// How depth is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Projection {
    /// Far things are smaller.
    Perspective,
    /// Parallel lines stay parallel.
    Orthographic,
}

/// A point on the panel.
#[derive(Clone, Copy, Debug, Default)]
pub struct Projected {
    /// Pixels from the left border.
    pub x: f64,
    /// Pixels from the upper border.
    pub y: f64,
    /// Larger is nearer; affine over the image of a plane. The reciprocal of
    /// the depth in perspective, minus the depth otherwise.
    pub nearness: f64,
}

/// Where the scene appears on a panel.
#[derive(Clone, Copy, Debug)]
pub struct Camera {
    /// Unit vectors to the right, up and from the scene to the camera.
    pub frame: [Vec3; 3],
    projection: Projection,
    center: Vec3,
    /// From the camera to `center`; the scene is never behind the camera.
    distance: f64,
    /// Pixels per unit of x / depth, or per unit of x.
    focal: f64,
    /// Image of the axis [px].
    offset: [f64; 2],
}

impl Camera {
    /// A camera that shows all `points` on a panel of `size` pixels.
    pub fn fit(view: View, projection: Projection, points: &[Vec3], size: [usize; 2]) -> Self {
        let size = size.map(|s| s as f64);
        let (min, max) = mesh::measure::bounds(points);
        let radius = (0.5 * (max - min).norm()).max(f64::MIN_POSITIVE);
        let focal = FOCAL * size[0].min(size[1]);
        let mut camera = Self {
            frame: view.frame(),
            projection,
            center: 0.5 * (min + max),
            distance: 4.0 * radius,
            focal: if projection == Projection::Perspective {
                focal
            } else {
                focal / (4.0 * radius)
            },
            offset: [0.5 * size[0], 0.5 * size[1]],
        };
        // The image shrinks nearly as 1/distance, so that a few rounds are enough.
        for _ in 0..8 {
            let [width, height] = camera.extent(points);
            let room = size.map(|s| (1.0 - 2.0 * MARGIN) * s);
            let excess = (width / room[0]).max(height / room[1]).max(1e-6);
            match projection {
                Projection::Perspective => {
                    camera.distance = (camera.distance * excess).max(1.5 * radius);
                }
                Projection::Orthographic => camera.focal /= excess,
            }
        }
        let (min, max) = camera.image(points);
        for k in 0..2 {
            camera.offset[k] += 0.5 * (size[k] - min[k] - max[k]);
        }
        camera
    }

    /// Where a point appears.
    pub fn project(&self, p: &Vec3) -> Projected {
        let q = p - self.center;
        let [x, y, z] = self.frame.map(|axis| axis.dot(&q));
        let depth = self.distance - z;
        let (scale, nearness) = match self.projection {
            Projection::Perspective => (self.focal / depth, 1.0 / depth),
            Projection::Orthographic => (self.focal, -depth),
        };
        Projected { x: self.offset[0] + scale * x, y: self.offset[1] - scale * y, nearness }
    }

    /// The ray through a place on the panel: origin and unit direction.
    pub fn ray(&self, x: f64, y: f64) -> (Vec3, Vec3) {
        let [right, up, toward] = self.frame;
        let (x, y) = ((x - self.offset[0]) / self.focal, (self.offset[1] - y) / self.focal);
        let eye = self.center + self.distance * toward;
        match self.projection {
            Projection::Perspective => (eye, (x * right + y * up - toward).normalize()),
            Projection::Orthographic => (eye + x * right + y * up, -toward),
        }
    }

    /// Unit direction from a point to the camera.
    pub fn toward(&self, p: &Vec3) -> Vec3 {
        match self.projection {
            Projection::Perspective => {
                (self.center + self.distance * self.frame[2] - p).normalize()
            }
            Projection::Orthographic => self.frame[2],
        }
    }

    /// Weights of the corners of a triangle at a place with screen weights `s`.
    pub fn weights(&self, corners: &[Projected; 3], s: [f64; 3]) -> [f64; 3] {
        match self.projection {
            Projection::Orthographic => s,
            Projection::Perspective => {
                let w: [f64; 3] = std::array::from_fn(|i| s[i] * corners[i].nearness);
                let sum = w[0] + w[1] + w[2];
                w.map(|w| w / sum)
            }
        }
    }

    /// Width and height of the smallest frame around the image of the points.
    pub fn extent(&self, points: &[Vec3]) -> [f64; 2] {
        let (min, max) = self.image(points);
        [max[0] - min[0], max[1] - min[1]]
    }

    /// Upper left and lower right corner of that frame.
    fn image(&self, points: &[Vec3]) -> ([f64; 2], [f64; 2]) {
        let (mut min, mut max) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
        for p in points.iter().map(|p| self.project(p)) {
            min = [min[0].min(p.x), min[1].min(p.y)];
            max = [max[0].max(p.x), max[1].max(p.y)];
        }
        (min, max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fits_and_rays_go_through_what_they_show() {
        let points: Vec<Vec3> = (0..8)
            .map(|i| {
                Vec3::new(f64::from(i & 1), 2.0 * f64::from(i >> 1 & 1), 0.5 * f64::from(i >> 2))
            })
            .collect();
        for projection in [Projection::Perspective, Projection::Orthographic] {
            let view = View { azimuth: 20.0, elevation: 35.0 };
            let camera = Camera::fit(view, projection, &points, [400, 300]);
            let [width, height] = camera.extent(&points);
            let filled = (width / 400.0).max(height / 300.0);
            // eight rounds shrink the error of the fit far below a tenth of a per cent
            assert!((filled - (1.0 - 2.0 * MARGIN)).abs() < 1e-3, "{filled}");
            for p in &points {
                let at = camera.project(p);
                let (origin, direction) = camera.ray(at.x, at.y);
                let miss = (p - origin).cross(&direction).norm();
                assert!(miss < 1e-12, "{miss}"); // rounding of coordinates of order 10
            }
        }
    }
}
