//! What is seen: pieces → visible fragments, by a z-buffer.
//!
//! Every pixel has a square of samples. The samples of a pixel that show the
//! same smooth surface are merged into one fragment, which is lit once.

use mesh::Vec3;
use rayon::prelude::*;

use super::camera::{Camera, Projected};
use super::color::{Rgb, Scale, inside};
use super::zbuffer::{NOTHING, Samples, area2};
use super::{Cap, Facet, Piece};

/// Samples along each side of a pixel.
pub const SAMPLES: usize = 3;
/// Rows of pixels that one thread works on at a time.
const BAND: usize = 16;
/// Cosine of the angle between normals below which samples are not merged (25°).
const ALIKE: f32 = 0.9;
/// Added to the number of a piece to name its cut face.
const CAPS: u32 = 0xf000_0000;

/// Half the width of lines [px], their strength and whether to draw them.
#[derive(Clone, Copy, Debug)]
pub struct Lines {
    /// Draw the edges of the mesh.
    pub edges: bool,
    /// Draw creases and open borders.
    pub features: bool,
}

const EDGE: (f64, f32) = (0.5, 0.42);
const FEATURE: (f64, f32) = (0.75, 0.55);

/// A piece of one surface in one pixel.
#[derive(Clone, Copy, Debug)]
pub struct Fragment {
    /// Pixel, row by row.
    pub pixel: u32,
    /// Part of the pixel that it covers.
    pub coverage: f32,
    /// Mean position.
    pub point: Vec3,
    /// Unit normal towards the camera's side.
    pub normal: [f32; 3],
    /// Mean linear colour.
    pub color: Rgb,
    /// Mean darkness of lines, 0 to 1.
    pub line: f32,
}

/// What the rasteriser needs to know of a scene.
pub struct View<'a> {
    /// What to draw; the number of facets is below 2³¹.
    pub pieces: &'a [Piece],
    /// From where.
    pub camera: &'a Camera,
    /// Pixels per row and number of rows.
    pub size: [usize; 2],
    /// Colours of field values.
    pub scale: Option<Scale>,
    /// Lines to draw on surfaces.
    pub lines: Lines,
}

struct Facets<'a> {
    view: &'a View<'a>,
    all: Vec<&'a Facet>,
    /// Number of the first facet of each piece, and the number of all.
    starts: Vec<usize>,
    /// Corners in samples.
    corners: Vec<[Projected; 3]>,
}

/// The visible fragments, by pixel.
pub fn fragments(view: &View) -> Vec<Fragment> {
    let facets = Facets::new(view);
    let bands = facets.bands();
    let parts: Vec<Vec<Fragment>> =
        bands.par_iter().enumerate().map(|(b, members)| facets.band(b, members)).collect();
    parts.concat()
}

impl<'a> Facets<'a> {
    fn new(view: &'a View<'a>) -> Self {
        let all: Vec<&Facet> = view.pieces.iter().flat_map(|p| &p.facets).collect();
        let mut starts = vec![0];
        for piece in view.pieces {
            starts.push(starts[starts.len() - 1] + piece.facets.len());
        }
        let samples = |p: &Vec3| {
            let q = view.camera.project(p);
            Projected { x: q.x * SAMPLES as f64, y: q.y * SAMPLES as f64, ..q }
        };
        let corners = all.par_iter().map(|f| f.points.each_ref().map(samples)).collect();
        Self { view, all, starts, corners }
    }

    /// The facets that touch each band, in order.
    fn bands(&self) -> Vec<Vec<u32>> {
        let count = self.view.size[1].div_ceil(BAND);
        let rows = (BAND * SAMPLES) as f64;
        let mut bands = vec![Vec::new(); count];
        for (f, corners) in self.corners.iter().enumerate() {
            let low = corners.iter().map(|c| c.y).fold(f64::INFINITY, f64::min);
            let high = corners.iter().map(|c| c.y).fold(f64::NEG_INFINITY, f64::max);
            if high < 0.0 || low > rows * count as f64 {
                continue;
            }
            let last = ((high / rows) as usize).min(count - 1);
            for band in &mut bands[(low / rows).max(0.0) as usize..=last] {
                band.push(f as u32);
            }
        }
        bands
    }

    /// Fragments of one band of rows.
    fn band(&self, band: usize, members: &[u32]) -> Vec<Fragment> {
        let top = band * BAND;
        let rows = BAND.min(self.view.size[1] - top);
        let mut samples = Samples::new(self.view.size[0] * SAMPLES, rows * SAMPLES, top * SAMPLES);
        for (p, piece) in self.view.pieces.iter().enumerate() {
            let (from, to) = (self.starts[p], self.starts[p + 1]);
            let own = &members[members.partition_point(|&f| (f as usize) < from)
                ..members.partition_point(|&f| (f as usize) < to)];
            if piece.cap.is_some() {
                let mut alone = Samples::like(&samples);
                own.iter().for_each(|&f| alone.draw(f, &self.corners[f as usize]));
                self.draw_cap(p, &mut alone);
                samples.merge(&alone);
            } else {
                own.iter().for_each(|&f| samples.draw(f, &self.corners[f as usize]));
            }
        }
        self.collect(&samples, top, rows)
    }

    /// Where the nearest facet of a cut closed surface shows its back, the ray
    /// went in through the cut: the face of the cut is what is seen.
    fn draw_cap(&self, piece: usize, samples: &mut Samples) {
        let Some(cap) = self.view.pieces[piece].cap else { return };
        for i in 0..samples.ids.len() {
            if samples.ids[i] == NOTHING || area2(&self.corners[samples.ids[i] as usize]) > 0.0 {
                continue;
            }
            let (along, point) = self.on_cap(&cap, samples.place(i));
            let nearness = self.view.camera.project(&point).nearness;
            if nearness.is_finite() && along > 0.0 {
                samples.ids[i] = CAPS + piece as u32;
                samples.nearness[i] = nearness;
            }
        }
    }

    fn collect(&self, samples: &Samples, top: usize, rows: usize) -> Vec<Fragment> {
        let width = self.view.size[0];
        let mut fragments = Vec::new();
        for (y, x) in (0..rows).flat_map(|y| (0..width).map(move |x| (y, x))) {
            let first = fragments.len();
            for (j, i) in (0..SAMPLES).flat_map(|j| (0..SAMPLES).map(move |i| (j, i))) {
                let index = (y * SAMPLES + j) * samples.width + x * SAMPLES + i;
                if samples.ids[index] != NOTHING {
                    let mut seen = self.sample(samples.ids[index], samples.place(index));
                    if self.view.lines.features && self.on_outline(samples, index) {
                        seen.line = FEATURE.1;
                    }
                    add(&mut fragments, first, ((top + y) * width + x) as u32, &seen);
                }
            }
            fragments[first..].iter_mut().for_each(finish);
        }
        fragments
    }

    /// The cut face that a sample shows, if any: the piece it belongs to.
    fn cut_face(&self, id: u32) -> Option<usize> {
        match id {
            NOTHING => None,
            CAPS.. => Some((id - CAPS) as usize),
            _ if self.all[id as usize].section => {
                Some(self.starts.partition_point(|&s| s <= id as usize) - 1)
            }
            _ => None,
        }
    }

    /// Whether a sample shows a cut face that ends within a few samples.
    fn on_outline(&self, samples: &Samples, index: usize) -> bool {
        const REACH: usize = 2;
        let face = self.cut_face(samples.ids[index]);
        let (x, y) = (index % samples.width, index / samples.width);
        let ends = |x: usize, y: usize| self.cut_face(samples.ids[y * samples.width + x]) != face;
        face.is_some()
            && ((x >= REACH && ends(x - REACH, y))
                || (x + REACH < samples.width && ends(x + REACH, y))
                || (y >= REACH && ends(x, y - REACH))
                || (y + REACH < samples.height && ends(x, y + REACH)))
    }

    /// Position, normal and colour of what a sample shows.
    fn sample(&self, id: u32, (x, y): (f64, f64)) -> Fragment {
        if id >= CAPS {
            return self.sample_cap((id - CAPS) as usize, (x, y));
        }
        let facet = self.all[id as usize];
        let corners = &self.corners[id as usize];
        let screen = screen_weights(corners, x, y);
        let weights = self.view.camera.weights(corners, screen);
        let point = blend(&facet.points, weights);
        let front = area2(corners) > 0.0;
        let mut normal = blend(&facet.normals, weights);
        let own = match self.view.scale {
            Some(scale) if !facet.values[0].is_nan() => {
                let value = (0..3).map(|i| weights[i] * facet.values[i]).sum();
                scale.color(value)
            }
            _ => facet.color,
        };
        let color = if front { own } else { inside(own) };
        if !front {
            normal = -normal;
        }
        let length = normal.norm().max(1e-12);
        Fragment {
            pixel: 0,
            coverage: 0.0,
            point,
            normal: [normal.x, normal.y, normal.z].map(|c| (c / length) as f32),
            color,
            line: self.line(facet, corners, screen),
        }
    }

    /// Where the ray through a sample meets the plane of a cut, and how far from the beginning of the ray.
    fn on_cap(&self, cap: &Cap, (x, y): (f64, f64)) -> (f64, Vec3) {
        let (origin, direction) = self.view.camera.ray(x / SAMPLES as f64, y / SAMPLES as f64);
        let along = -cap.plane.beyond(&origin) / cap.plane.normal.dot(&direction);
        (along, origin + along * direction)
    }

    fn sample_cap(&self, piece: usize, place: (f64, f64)) -> Fragment {
        let cap = self.view.pieces[piece].cap.expect("only capped pieces are named so");
        let n = cap.plane.normal;
        Fragment {
            pixel: 0,
            coverage: 0.0,
            point: self.on_cap(&cap, place).1,
            normal: [n.x, n.y, n.z].map(|c| c as f32),
            color: cap.color,
            line: 0.0,
        }
    }

    /// Darkness of the strongest line through a sample.
    fn line(&self, facet: &Facet, corners: &[Projected; 3], screen: [f64; 3]) -> f32 {
        let Lines { edges, features } = self.view.lines;
        let mut darkness = 0.0_f32;
        let area = area2(corners).abs();
        for side in 0..3 {
            let (a, b) = (&corners[side], &corners[(side + 1) % 3]);
            let length = (b.x - a.x).hypot(b.y - a.y);
            // the weight of the opposite corner times the height over this side
            let distance = screen[(side + 2) % 3].abs() * area / length.max(1e-12);
            let pixels = distance / SAMPLES as f64;
            let on = |bits: u8| bits >> side & 1 == 1;
            for (wanted, bits, (half, strength)) in
                [(edges, facet.edges, EDGE), (features, facet.features, FEATURE)]
            {
                if wanted && on(bits) && pixels < half {
                    darkness = darkness.max(strength);
                }
            }
        }
        darkness
    }
}

/// Adds a sample to the fragment of its pixel that it belongs to.
fn add(fragments: &mut Vec<Fragment>, first: usize, pixel: u32, seen: &Fragment) {
    let alike = |f: &Fragment| {
        let dot: f32 = (0..3).map(|i| f.normal[i] * seen.normal[i]).sum();
        let near = f.color.iter().zip(seen.color).all(|(a, b)| (a / f.coverage - b).abs() < 0.1);
        dot > ALIKE * f.coverage && near
    };
    let part = 1.0 / (SAMPLES * SAMPLES) as f32;
    let index = fragments[first..].iter().position(alike).map_or(fragments.len(), |i| first + i);
    if index == fragments.len() {
        fragments.push(Fragment {
            pixel,
            point: Vec3::zeros(),
            normal: [0.0; 3],
            color: [0.0; 3],
            ..*seen
        });
        fragments[index].line = 0.0;
    }
    let f = &mut fragments[index];
    f.coverage += part;
    f.point += f64::from(part) * seen.point;
    f.line += part * seen.line;
    for i in 0..3 {
        f.normal[i] += part * seen.normal[i];
        f.color[i] += part * seen.color[i];
    }
}

/// Sums → means.
fn finish(f: &mut Fragment) {
    let scale = 1.0 / f.coverage;
    let length = f.normal.iter().map(|c| c * c).sum::<f32>().sqrt().max(1e-12);
    f.point *= f64::from(scale);
    f.line *= scale;
    f.normal = f.normal.map(|c| c / length);
    f.color = f.color.map(|c| c * scale);
}

fn blend(values: &[Vec3; 3], weights: [f64; 3]) -> Vec3 {
    weights[0] * values[0] + weights[1] * values[1] + weights[2] * values[2]
}

/// Barycentric coordinates on the screen.
fn screen_weights(corners: &[Projected; 3], x: f64, y: f64) -> [f64; 3] {
    let [a, b, c] = corners;
    let area = area2(corners);
    let part =
        |p: &Projected, q: &Projected| ((p.y - y) * (q.x - x) - (p.x - x) * (q.y - y)) / area;
    let (u, v) = (part(b, c), part(c, a));
    [u, v, 1.0 - u - v]
}
