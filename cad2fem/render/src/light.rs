//! Light: a sky, a bounce from below, a soft key light, and their shadows.
//!
//! The light is a fixed set of directions, each with its own depth map of the
//! scene, so that creases, cavities and the ground below a body darken as they
//! do under a real sky. Nothing is random: the same scene gives the same
//! picture on any number of threads.

use mesh::Vec3;
use rayon::prelude::*;

use super::color::{Rgb, mix};
use super::{Facet, Piece};

/// Directions that share the sky, and those that share the key light.
const SKY: usize = 128;
const KEY: usize = 48;
/// Half the angle of the cone of the key light [rad].
const KEY_SPREAD: f64 = 0.24;
/// Texels along each side of a depth map.
const TEXELS: usize = 512;
/// Texels along each side of the blocks whose nearest depth is kept.
const BLOCK: usize = 16;
/// Maps that exist at the same time.
const BATCH: usize = 8;
/// Offset along the normal against self-shadowing [texels].
const BIAS: f32 = 1.8;
/// Distance between the places of a blurred shadow [texels].
const BLUR: f32 = 4.5;

/// A point that is to be lit.
#[derive(Clone, Copy, Debug)]
pub struct Point {
    /// Position.
    pub position: Vec3,
    /// Unit normal.
    pub normal: [f32; 3],
    /// Unit direction to the camera.
    pub toward: [f32; 3],
    /// Whether shadows are blurred over the gap between neighbouring
    /// directions, for large even receivers where single shadows would show.
    pub blurred: bool,
}

/// Light that arrives at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Arriving {
    /// What a matt white surface sends back.
    pub diffuse: Rgb,
    /// The gloss of the key light.
    pub gloss: f32,
    /// What would arrive if nothing stood in the way.
    pub unshadowed: f32,
}

struct Ray {
    direction: [f32; 3],
    across: [[f32; 3]; 2],
    radiance: Rgb,
    glossy: bool,
}

/// A scene in a sphere of radius 1 around the origin, as the lights see it.
pub struct Lights {
    rays: Vec<Ray>,
    center: Vec3,
    scale: f64,
    facets: Vec<Occluder>,
}

/// A facet that can cast shadows.
struct Occluder {
    corners: [[f32; 3]; 3],
    normal: [f32; 3],
    /// Whether its back is never the first thing that light meets.
    closed: bool,
}

struct DepthMap {
    nearest: Vec<f32>,
    /// Nearest depth in each block of texels.
    blocks: Vec<f32>,
}

impl Lights {
    /// Lights for a scene within `bounds`, seen from `frame` (right, up, toward).
    pub fn new(pieces: &[Piece], bounds: (Vec3, Vec3), frame: &[Vec3; 3]) -> Self {
        let center = 0.5 * (bounds.0 + bounds.1);
        let radius = 0.5 * (bounds.1 - bounds.0).norm();
        let scale = 1.0 / radius.max(f64::MIN_POSITIVE);
        let unit = |p: &Vec3| single(&((p - center) * scale));
        let occluder = |facet: &Facet, closed: bool| {
            let [a, b, c] = facet.points;
            let normal = single(&(b - a).cross(&(c - a)));
            Occluder { corners: facet.points.each_ref().map(unit), normal, closed }
        };
        let of_piece =
            |p: &Piece| p.facets.iter().map(|f| occluder(f, p.closed)).collect::<Vec<_>>();
        let facets = pieces.iter().flat_map(of_piece).collect();
        Self { rays: rays(frame), center, scale, facets }
    }

    /// The light that arrives at each point.
    pub fn arriving(&self, points: &[Point]) -> Vec<Arriving> {
        let mut arriving = vec![Arriving::default(); points.len()];
        let mut maps: Vec<DepthMap> = (0..BATCH).map(|_| DepthMap::empty()).collect();
        for batch in self.rays.chunks(BATCH) {
            maps.par_iter_mut().zip(batch).for_each(|(map, ray)| map.fill(ray, &self.facets));
            arriving.par_iter_mut().zip(points).for_each(|(sum, point)| {
                let position = single(&((point.position - self.center) * self.scale));
                for (ray, map) in batch.iter().zip(&maps) {
                    ray.add(map, position, point, sum);
                }
            });
        }
        arriving
    }
}

impl Ray {
    fn new(direction: &Vec3, radiance: Rgb, glossy: bool) -> Self {
        let other = if direction.z.abs() < 0.9 { Vec3::z() } else { Vec3::x() };
        let u = direction.cross(&other).normalize();
        let across = [single(&u), single(&direction.cross(&u))];
        Self { direction: single(direction), across, radiance, glossy }
    }

    /// Adds what arrives along this ray.
    fn add(&self, map: &DepthMap, position: [f32; 3], point: &Point, sum: &mut Arriving) {
        let cosine = dot(self.direction, point.normal);
        if cosine <= 0.0 {
            return;
        }
        let lift = BIAS * 2.0 / TEXELS as f32;
        let lifted = std::array::from_fn(|i| position[i] + lift * point.normal[i]);
        let (texel, depth) = (self.texel(lifted), dot(self.direction, lifted));
        let visible =
            if point.blurred { map.blurred(texel, depth) } else { map.visible(texel, depth) };
        let mean = (self.radiance[0] + self.radiance[1] + self.radiance[2]) / 3.0;
        sum.unshadowed += cosine * mean;
        if visible <= 0.0 {
            return;
        }
        for i in 0..3 {
            sum.diffuse[i] += visible * cosine * self.radiance[i];
        }
        if self.glossy {
            let half: [f32; 3] = std::array::from_fn(|i| self.direction[i] + point.toward[i]);
            let shine = dot(half, point.normal) / dot(half, half).sqrt().max(1e-6);
            sum.gloss += visible * mean * shine.max(0.0).powi(48);
        }
    }

    /// Place on the map, in texels.
    fn texel(&self, p: [f32; 3]) -> [f32; 2] {
        self.across.map(|axis| (0.5 + 0.5 * dot(axis, p)) * TEXELS as f32 - 0.5)
    }
}

impl DepthMap {
    fn empty() -> Self {
        let across = TEXELS / BLOCK;
        let nothing = f32::NEG_INFINITY;
        Self { nearest: vec![nothing; TEXELS * TEXELS], blocks: vec![nothing; across * across] }
    }

    /// Draws all facets as the light of a ray sees them.
    fn fill(&mut self, ray: &Ray, facets: &[Occluder]) {
        self.nearest.fill(f32::NEG_INFINITY);
        self.blocks.fill(f32::NEG_INFINITY);
        for facet in facets.iter().filter(|f| !f.closed || dot(f.normal, ray.direction) > 0.0) {
            let on_map = facet.corners.map(|p| {
                let [x, y] = ray.texel(p);
                [x, y, dot(ray.direction, p)]
            });
            self.draw(&on_map);
        }
        for (row, texels) in self.nearest.chunks_exact(TEXELS).enumerate() {
            let blocks = &mut self.blocks[row / BLOCK * (TEXELS / BLOCK)..];
            for (block, part) in blocks.iter_mut().zip(texels.chunks_exact(BLOCK)) {
                *block = part.iter().fold(*block, |nearest, &depth| nearest.max(depth));
            }
        }
    }

    fn draw(&mut self, [a, b, c]: &[[f32; 3]; 3]) {
        let e: [f32; 3] = std::array::from_fn(|i| b[i] - a[i]);
        let f: [f32; 3] = std::array::from_fn(|i| c[i] - a[i]);
        let area = e[0] * f[1] - e[1] * f[0];
        if area.abs() < 1e-9 {
            return; // seen edge-on, it hides nothing
        }
        let dx = (e[2] * f[1] - f[2] * e[1]) / area;
        let dy = (f[2] * e[0] - e[2] * f[0]) / area;
        let sides = [(a, b), (b, c), (c, a)].map(|(p, q)| {
            let (low, high) = if p[1] <= q[1] { (p, q) } else { (q, p) };
            (low[1], high[1], low[0], (high[0] - low[0]) / (high[1] - low[1]))
        });
        let above = |v: f32| (v.clamp(0.0, TEXELS as f32 - 1.0) + 0.999_999) as usize;
        let below = |v: f32| (v + 1.0).clamp(0.0, TEXELS as f32) as usize;
        let low = a[1].min(b[1]).min(c[1]);
        let high = a[1].max(b[1]).max(c[1]);
        for row in above(low)..below(high) {
            let y = row as f32;
            let mut span = (f32::INFINITY, f32::NEG_INFINITY);
            for (from, to, x, slope) in sides {
                if from <= y && y < to {
                    let x = x + slope * (y - from);
                    span = (span.0.min(x), span.1.max(x));
                }
            }
            let start = a[2] + dy * (y - a[1]) - dx * a[0];
            for x in above(span.0)..below(span.1) {
                let depth = start + dx * x as f32;
                let texel = &mut self.nearest[row * TEXELS + x];
                *texel = texel.max(depth);
            }
        }
    }

    /// How much of the four texels around a place has nothing nearer to the light.
    fn visible(&self, [x, y]: [f32; 2], depth: f32) -> f32 {
        let inside = 0.0..TEXELS as f32 - 1.0;
        if !inside.contains(&x) || !inside.contains(&y) {
            return 1.0;
        }
        let (left, top) = (x as usize, y as usize);
        let (u, v) = (x - left as f32, y - top as f32);
        let corner = top * TEXELS + left;
        let open = |offset: usize| f32::from(u8::from(self.nearest[corner + offset] <= depth));
        (1.0 - v) * ((1.0 - u) * open(0) + u * open(1))
            + v * ((1.0 - u) * open(TEXELS) + u * open(TEXELS + 1))
    }

    /// Mean of [`Self::visible`] over a square of 5 × 5 places.
    fn blurred(&self, [x, y]: [f32; 2], depth: f32) -> f32 {
        let reach = 2.0 * BLUR + 1.0;
        let block = |v: f32| v.clamp(0.0, TEXELS as f32 - 1.0) as usize / BLOCK;
        let mut blocks = (block(y - reach)..=block(y + reach))
            .flat_map(|j| (block(x - reach)..=block(x + reach)).map(move |i| (i, j)));
        if blocks.all(|(i, j)| self.blocks[j * (TEXELS / BLOCK) + i] <= depth) {
            return 1.0;
        }
        let offsets = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k| k * BLUR);
        let places = offsets.iter().flat_map(|dy| offsets.iter().map(move |dx| [x + dx, y + dy]));
        places.map(|place| self.visible(place, depth)).sum::<f32>() / 25.0
    }
}

/// All light, scaled so that a matt white surface facing the camera and open
/// to the sky sends back about 1.
fn rays(frame: &[Vec3; 3]) -> Vec<Ray> {
    let [right, up, toward] = frame;
    // from the upper left behind the camera, but never from below
    let mut key = 0.8 * toward - 0.6 * right + 0.7 * up + 0.9 * Vec3::z();
    key.z = key.z.max(0.5 * key.norm());
    let key = key.normalize();
    let level = 0.5 * (toward - toward.z * Vec3::z());
    let sky = |d: &Vec3| {
        let height = 0.5 + 0.5 * d.z as f32;
        let color = mix([0.50, 0.47, 0.45], [0.98, 1.03, 1.10], height);
        let front = 1.0 + 0.45 * d.dot(&(toward * 0.6 + level)) as f32;
        color.map(|c| c * front * 2.3 / SKY as f32)
    };
    let sun = [1.06, 1.0, 0.92].map(|c| c * 0.62 / KEY as f32);
    let spherical = spiral(SKY, -1.0, &Vec3::z());
    let cone = spiral(KEY, KEY_SPREAD.cos(), &key);
    let from_sky = spherical.iter().map(|d| Ray::new(d, sky(d), false));
    from_sky.chain(cone.iter().map(|d| Ray::new(d, sun, true))).collect()
}

/// Evenly spread directions with d · axis ≥ `lowest`, along a golden spiral.
fn spiral(count: usize, lowest: f64, axis: &Vec3) -> Vec<Vec3> {
    let golden = std::f64::consts::PI * (3.0 - 5.0_f64.sqrt());
    let other = if axis.z.abs() < 0.9 { Vec3::z() } else { Vec3::x() };
    let u = axis.cross(&other).normalize();
    let v = axis.cross(&u);
    (0..count)
        .map(|i| {
            let height = 1.0 - (1.0 - lowest) * (i as f64 + 0.5) / count as f64;
            let radius = (1.0 - height * height).sqrt();
            let angle = golden * i as f64;
            height * axis + radius * (angle.cos() * u + angle.sin() * v)
        })
        .collect()
}

fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// A vector in single precision.
pub fn single(v: &Vec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}
