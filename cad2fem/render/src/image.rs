//! A picture in memory, and PNG files.

use std::path::Path;

use mesh::io::{IoError, write_atomic};

use super::color::{Rgb, mix};

/// Pixels in sRGB, 0 to 1, row by row from the upper left.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Pixels per row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    /// sRGB, 0 to 1.
    pub pixels: Vec<Rgb>,
}

impl Image {
    /// A picture of one colour.
    pub fn new(width: usize, height: usize, color: Rgb) -> Self {
        Self { width, height, pixels: vec![color; width * height] }
    }

    /// Lets `alpha` of a colour through; outside the picture nothing happens.
    pub fn blend(&mut self, x: i64, y: i64, color: Rgb, alpha: f32) {
        let (Ok(x), Ok(y)) = (usize::try_from(x), usize::try_from(y)) else { return };
        if x < self.width && y < self.height {
            let pixel = &mut self.pixels[y * self.width + x];
            *pixel = mix(*pixel, color, alpha);
        }
    }

    /// Fills a rectangle with corners in pixels; borders are anti-aliased.
    pub fn fill(&mut self, min: [f64; 2], max: [f64; 2], color: Rgb, alpha: f32) {
        let cover = |i: i64, lower: f64, upper: f64| {
            (upper.min(i as f64 + 1.0) - lower.max(i as f64)).clamp(0.0, 1.0) as f32
        };
        for y in min[1].floor() as i64..max[1].ceil() as i64 {
            for x in min[0].floor() as i64..max[0].ceil() as i64 {
                let covered = cover(x, min[0], max[0]) * cover(y, min[1], max[1]);
                self.blend(x, y, color, alpha * covered);
            }
        }
    }

    /// Copies another picture to an upper left corner; it must fit.
    pub fn paste(&mut self, other: &Self, left: usize, top: usize) {
        for (row, pixels) in other.pixels.chunks_exact(other.width).enumerate() {
            let start = (top + row) * self.width + left;
            self.pixels[start..start + other.width].copy_from_slice(pixels);
        }
    }

    /// Writes an 8-bit RGB PNG, which appears complete or not at all.
    pub fn write_png(&self, path: &Path) -> Result<(), IoError> {
        let bytes: Vec<u8> =
            self.pixels.iter().flatten().map(|v| (255.0 * v).round() as u8).collect();
        let side = |s: usize| u32::try_from(s).map_err(std::io::Error::other);
        write_atomic(path, |out| {
            let mut encoder = png::Encoder::new(out, side(self.width)?, side(self.height)?);
            encoder.set_color(png::ColorType::Rgb);
            encoder.set_depth(png::BitDepth::Eight);
            encoder.set_compression(png::Compression::High);
            encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
            encoder.write_header()?.write_image_data(&bytes)?;
            Ok(())
        })
    }
}
