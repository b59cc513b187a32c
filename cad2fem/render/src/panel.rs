//! One picture of one scene: visible fragments, light, ground and background.

use mesh::Vec3;
use rayon::prelude::*;

use super::camera::Camera;
use super::color::{Rgb, Scale, encode, from_hex, mix};
use super::image::Image;
use super::light::{Arriving, Lights, Point, single};
use super::raster::{self, Fragment, Lines, View};
use super::{Piece, bounds};

/// Share of the light that shadows on the ground take from the background.
const SHADOW: f32 = 0.75;
/// How far from the scene the ground is shaded, in radii of the scene.
const GROUND: f64 = 3.0;

/// How a scene is drawn.
#[derive(Clone, Copy, Debug)]
pub struct Look {
    /// Colours of field values.
    pub scale: Option<Scale>,
    /// Lines on surfaces.
    pub lines: Lines,
    /// Height z of the ground that shadows fall on, if any.
    pub ground: Option<f64>,
}

/// Rows of the whole sheet that a panel covers, for a background in one piece.
#[derive(Clone, Copy, Debug)]
pub struct Rows {
    /// First row of the panel.
    pub top: usize,
    /// Rows of the sheet.
    pub of: usize,
}

/// Linear colour of the background in a row of the sheet.
pub fn background(row: usize, of: usize) -> Rgb {
    let t = row as f32 / of.max(1) as f32;
    mix(from_hex(0xfbfcfd), from_hex(0xdfe4ea), t * t * (3.0 - 2.0 * t))
}

/// Draws pieces on a panel of `size` pixels.
pub fn draw(pieces: &[Piece], camera: &Camera, size: [usize; 2], look: &Look, rows: Rows) -> Image {
    let mut linear: Vec<Rgb> = (0..size[1])
        .flat_map(|y| std::iter::repeat_n(background(rows.top + y, rows.of), size[0]))
        .collect();
    if let Some(bounds) = bounds(pieces) {
        let view = View { pieces, camera, size, scale: look.scale, lines: look.lines };
        let fragments = raster::fragments(&view);
        let lights = Lights::new(pieces, bounds, &camera.frame);
        if let Some(height) = look.ground.filter(|_| camera.frame[2].z > 0.05) {
            let ground = Ground { height, bounds, lights: &lights, camera };
            let shares = ground.shares(size);
            linear.par_iter_mut().enumerate().for_each(|(i, color)| {
                let share = shares.at(i % size[0], i / size[0]);
                *color = color.map(|v| v * share);
            });
        }
        cover(&mut linear, &fragments, &lights, camera, look.scale.is_some());
    }
    let pixels = linear.into_par_iter().map(encode).collect();
    Image { width: size[0], height: size[1], pixels }
}

/// Puts lit fragments over what is there.
fn cover(
    linear: &mut [Rgb],
    fragments: &[Fragment],
    lights: &Lights,
    camera: &Camera,
    field: bool,
) {
    let points: Vec<Point> = fragments
        .par_iter()
        .map(|f| Point {
            position: f.point,
            normal: f.normal,
            toward: single(&camera.toward(&f.point)),
            blurred: false,
        })
        .collect();
    let arriving = lights.arriving(&points);
    let mut left: Vec<f32> = vec![1.0; linear.len()];
    for f in fragments {
        left[f.pixel as usize] -= f.coverage;
    }
    linear.iter_mut().zip(left).for_each(|(c, l)| *c = c.map(|v| v * l.max(0.0)));
    for (f, light) in fragments.iter().zip(&arriving) {
        let color = shade(f, light, field);
        let pixel = &mut linear[f.pixel as usize];
        *pixel = std::array::from_fn(|i| pixel[i] + f.coverage * color[i]);
    }
}

/// Linear colour of a lit fragment. Colours that stand for values are lit more
/// evenly, so that they stay near to those of the scale.
fn shade(f: &Fragment, light: &Arriving, field: bool) -> Rgb {
    let (lift, gloss) = if field { (0.3, 0.15) } else { (0.0, 0.16) };
    let lit: Rgb = std::array::from_fn(|i| {
        let matt = light.diffuse[i] * (1.0 - lift) + lift;
        shoulder(f.color[i] * matt + gloss * light.gloss)
    });
    mix(lit, from_hex(0x1c2430), f.line)
}

/// Identity up to 0.8, then a smooth approach to 1.
fn shoulder(v: f32) -> f32 {
    const KNEE: f32 = 0.8;
    if v <= KNEE { v } else { 1.0 - (1.0 - KNEE) * (-(v - KNEE) / (1.0 - KNEE)).exp() }
}

/// A plane that only shows the shadows on it.
struct Ground<'a> {
    height: f64,
    bounds: (Vec3, Vec3),
    lights: &'a Lights,
    camera: &'a Camera,
}

/// Shadows are soft: they are computed in every fourth pixel.
const STEP: usize = 4;

/// Share of light that the ground sends back, on a coarse grid of pixels.
struct Shares {
    columns: usize,
    values: Vec<f32>,
}

impl Ground<'_> {
    fn shares(&self, size: [usize; 2]) -> Shares {
        let [columns, rows] = size.map(|s| s / STEP + 2);
        let center = 0.5 * (self.bounds.0 + self.bounds.1);
        let reach = GROUND * 0.5 * (self.bounds.1 - self.bounds.0).norm();
        let places: Vec<(usize, Vec3)> = (0..columns * rows)
            .filter_map(|i| Some((i, self.hit((i % columns) * STEP, (i / columns) * STEP)?)))
            .filter(|(_, p)| (p - center).norm() < reach)
            .collect();
        let up = [0.0, 0.0, 1.0];
        let points: Vec<Point> = places
            .iter()
            .map(|(_, p)| Point { position: *p, normal: up, toward: up, blurred: true })
            .collect();
        let mut values = vec![1.0; columns * rows];
        for ((i, p), light) in places.iter().zip(self.lights.arriving(&points)) {
            let mean = light.diffuse.iter().sum::<f32>() / 3.0;
            let fade = 1.0 - ((p - center).norm() / reach).powi(4) as f32;
            let fade = fade * inner(i % columns, columns) * inner(i / columns, rows);
            values[*i] = 1.0 - SHADOW * fade * (1.0 - mean / light.unshadowed.max(1e-6));
        }
        Shares { columns, values }
    }

    /// Where the ray through a pixel meets the ground.
    fn hit(&self, x: usize, y: usize) -> Option<Vec3> {
        let (origin, direction) = self.camera.ray(x as f64 + 0.5, y as f64 + 0.5);
        let along = (self.height - origin.z) / direction.z;
        (along > 0.0).then(|| origin + along * direction)
    }
}

/// 0 at both ends of a range and 1 well inside, so that no shadow is cut off
/// by the border of its panel.
fn inner(i: usize, count: usize) -> f32 {
    let from_end = i.min(count.saturating_sub(3).saturating_sub(i)) as f32;
    let t = (from_end / (0.12 * count as f32)).min(1.0);
    t * t * (3.0 - 2.0 * t)
}

impl Shares {
    /// Bilinear between the places of the grid.
    fn at(&self, x: usize, y: usize) -> f32 {
        let corner = (y / STEP) * self.columns + x / STEP;
        let (u, v) = ((x % STEP) as f32 / STEP as f32, (y % STEP) as f32 / STEP as f32);
        let value = |offset: usize| self.values[corner + offset];
        (1.0 - v) * ((1.0 - u) * value(0) + u * value(1))
            + v * ((1.0 - u) * value(self.columns) + u * value(self.columns + 1))
    }
}
