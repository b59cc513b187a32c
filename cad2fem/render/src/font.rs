//! Text in pictures, and outlines of text for raised letters.
//!
//! The typeface is Inter, under the SIL Open Font License (see the folder `fonts`). A symbol
//! that it does not have is drawn as a question mark, with a warning.

use std::sync::LazyLock;

use ab_glyph_rasterizer::{Rasterizer, point};
use ttf_parser::{GlyphId, OutlineBuilder};

use super::color::Rgb;
use super::image::Image;

/// The file of the upright typeface, Inter (OpenType).
pub const REGULAR: &[u8] = include_bytes!("../fonts/Inter-Regular.otf");

/// Chords of a curved piece of an outline; they are then nowhere farther from it than 0.4 % of
/// the height of a capital.
const CHORDS: usize = 8;

/// Thickness of strokes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Weight {
    /// Strokes of about an eighth of the height of a capital.
    Regular,
    /// Upright strokes of a fifth and level ones of a sixth of the height of a capital.
    Bold,
}

/// Which point of a text is at the given position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Left end of the baseline.
    Left,
    /// Middle of the baseline.
    Center,
}

/// Size and colour of a text.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// Height of a capital [px].
    pub height: f64,
    /// Colour in sRGB.
    pub color: Rgb,
    /// Thickness of strokes.
    pub weight: Weight,
}

/// A closed polygon [height of a capital].
pub type Polygon = Vec<[f64; 2]>;

/// A font file.
struct Face {
    parsed: ttf_parser::Face<'static>,
    /// Height of a capital [font unit].
    capital: f64,
}

impl Weight {
    fn face(self) -> &'static Face {
        static FACES: LazyLock<[Face; 2]> = LazyLock::new(|| {
            [Face::new(REGULAR), Face::new(include_bytes!("../fonts/Inter-Bold.otf"))]
        });
        &FACES[self as usize]
    }
}

impl Face {
    fn new(file: &'static [u8]) -> Self {
        let parsed = ttf_parser::Face::parse(file, 0).expect("tests read the fonts");
        let capital = parsed.capital_height().expect("tests read the fonts");
        Self { parsed, capital: f64::from(capital) }
    }

    /// The glyph of a symbol; of an unknown one the question mark.
    fn glyph(&self, symbol: char) -> GlyphId {
        let known = self.parsed.glyph_index(symbol);
        known.or_else(|| self.parsed.glyph_index('?')).unwrap_or_default()
    }

    /// From the origin of a glyph to that of the next [height of a capital].
    fn advance(&self, glyph: GlyphId) -> f64 {
        f64::from(self.parsed.glyph_hor_advance(glyph).unwrap_or_default()) / self.capital
    }
}

/// Symbols of a text that the font does not have.
pub fn missing(text: &str) -> Vec<char> {
    let face = Weight::Regular.face();
    text.chars().filter(|&symbol| face.parsed.glyph_index(symbol).is_none()).collect()
}

/// The polygons that bound a text with its baseline on y = 0, from x = 0 to its width
/// [height of a capital]: outlines counter-clockwise, holes clockwise.
pub fn outlines(text: &str, weight: Weight) -> (Vec<Polygon>, f64) {
    let unknown = missing(text);
    if !unknown.is_empty() {
        log::warn!("the font has no {unknown:?} of {text:?}: drawn as ?");
    }
    let face = weight.face();
    let mut builder = Flattener { polygons: Vec::new(), left: 0.0, capital: face.capital };
    for symbol in text.chars() {
        let glyph = face.glyph(symbol);
        face.parsed.outline_glyph(glyph, &mut builder);
        builder.left += face.advance(glyph);
    }
    (builder.polygons, builder.left)
}

/// Width of a text [px].
pub fn width(text: &str, style: &Style) -> f64 {
    let face = style.weight.face();
    text.chars().map(|symbol| face.advance(face.glyph(symbol))).sum::<f64>() * style.height
}

/// Draws a line of text with its baseline at `at` [px].
pub fn draw(image: &mut Image, text: &str, at: [f64; 2], anchor: Anchor, style: &Style) {
    let (mut polygons, width) = outlines(text, style.weight);
    let shift = match anchor {
        Anchor::Left => 0.0,
        Anchor::Center => 0.5,
    };
    for p in polygons.iter_mut().flatten() {
        *p = [at[0] + (p[0] - shift * width) * style.height, at[1] - p[1] * style.height];
    }
    fill(image, &polygons, style.color);
}

/// Fills polygons [px], each pixel by the part of it that is inside.
fn fill(image: &mut Image, polygons: &[Polygon], color: Rgb) {
    if polygons.is_empty() {
        return;
    }
    let ends = || polygons.iter().flatten();
    let lower = |k: usize| ends().map(|p| p[k]).fold(f64::INFINITY, f64::min).floor();
    let upper = |k: usize| ends().map(|p| p[k]).fold(f64::NEG_INFINITY, f64::max).ceil();
    let [left, top] = [lower(0), lower(1)];
    let mut rasterizer = Rasterizer::new((upper(0) - left) as usize, (upper(1) - top) as usize);
    let within = |p: [f64; 2]| point((p[0] - left) as f32, (p[1] - top) as f32);
    for polygon in polygons {
        for (i, &p) in polygon.iter().enumerate() {
            let next = polygon[(i + 1) % polygon.len()];
            rasterizer.draw_line(within(p), within(next));
        }
    }
    rasterizer.for_each_pixel_2d(|x, y, covered| {
        image.blend(left as i64 + i64::from(x), top as i64 + i64::from(y), color, covered.min(1.0));
    });
}

/// Turns outlines into polygons.
struct Flattener {
    polygons: Vec<Polygon>,
    /// Where the glyph begins [height of a capital].
    left: f64,
    /// Height of a capital [font unit].
    capital: f64,
}

impl Flattener {
    fn place(&self, x: f32, y: f32) -> [f64; 2] {
        [self.left + f64::from(x) / self.capital, f64::from(y) / self.capital]
    }

    fn push(&mut self, p: [f64; 2]) {
        self.polygons.last_mut().expect("an outline begins with move_to").push(p);
    }

    fn end(&self) -> [f64; 2] {
        let polygon = self.polygons.last().expect("an outline begins with move_to");
        *polygon.last().expect("move_to adds a point")
    }
}

impl OutlineBuilder for Flattener {
    fn move_to(&mut self, x: f32, y: f32) {
        self.polygons.push(vec![self.place(x, y)]);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        self.push(self.place(x, y));
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        // the same curve as a cubic
        let ([x0, y0], [xc, yc], [xe, ye]) = (self.end(), self.place(x1, y1), self.place(x, y));
        let first = [x0 + (xc - x0) * 2.0 / 3.0, y0 + (yc - y0) * 2.0 / 3.0];
        let second = [xe + (xc - xe) * 2.0 / 3.0, ye + (yc - ye) * 2.0 / 3.0];
        self.cubic(first, second, [xe, ye]);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        self.cubic(self.place(x1, y1), self.place(x2, y2), self.place(x, y));
    }

    fn close(&mut self) {
        let polygon = self.polygons.last_mut().expect("an outline begins with move_to");
        if polygon.first() == polygon.last() {
            polygon.pop();
        }
    }
}

impl Flattener {
    /// Chords of the Bézier curve from the last point.
    fn cubic(&mut self, a: [f64; 2], b: [f64; 2], to: [f64; 2]) {
        let from = self.end();
        for i in 1..CHORDS {
            let t = i as f64 / CHORDS as f64;
            let s = 1.0 - t;
            let weights = [s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t];
            let at = |k: usize| {
                weights[0] * from[k] + weights[1] * a[k] + weights[2] * b[k] + weights[3] * to[k]
            };
            self.push([at(0), at(1)]);
        }
        self.push(to);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Signed area, positive counter-clockwise.
    fn area(polygon: &Polygon) -> f64 {
        let next = |i: usize| polygon[(i + 1) % polygon.len()];
        let cross = |(i, p): (usize, &[f64; 2])| p[0] * next(i)[1] - p[1] * next(i)[0];
        0.5 * polygon.iter().enumerate().map(cross).sum::<f64>()
    }

    #[test]
    fn every_printable_ascii_symbol_has_a_glyph_within_its_line() {
        for weight in [Weight::Regular, Weight::Bold] {
            for symbol in ('!'..='~').chain("−–±×·→°²³µαλσΔÄéß≤≥".chars()) {
                assert!(missing(&symbol.to_string()).is_empty(), "no glyph for {symbol:?}");
                let (polygons, width) = outlines(&symbol.to_string(), weight);
                assert!(!polygons.is_empty(), "{symbol:?} is empty");
                for &[x, y] in polygons.iter().flatten() {
                    assert!((-0.46..=1.45).contains(&y), "{symbol:?} {y}");
                    assert!((-0.1..=width + 0.1).contains(&x), "{symbol:?} {x} {width}");
                }
            }
        }
    }

    #[test]
    fn outlines_are_counter_clockwise_and_holes_clockwise() {
        let signs = |text| {
            let mut areas: Vec<f64> = outlines(text, Weight::Bold).0.iter().map(area).collect();
            areas.sort_by(f64::total_cmp);
            areas.iter().map(|a| *a > 0.0).collect::<Vec<_>>()
        };
        assert_eq!(signs("L"), [true]);
        assert_eq!(signs("O"), [false, true]);
        assert_eq!(signs("B8"), [false, false, false, false, true, true]);
    }

    #[test]
    fn unknown_symbols_are_question_marks() {
        assert_eq!(missing("aфb中"), ['ф', '中']);
        assert_eq!(outlines("中", Weight::Bold), outlines("?", Weight::Bold));
    }

    #[test]
    fn ink_covers_the_area_of_the_outline() {
        let style = Style { height: 28.0, color: [0.0; 3], weight: Weight::Regular };
        for text in ["I", "B", "8"] {
            let mut image = Image::new(60, 40, [1.0; 3]);
            draw(&mut image, text, [20.3, 34.6], Anchor::Left, &style);
            let ink: f32 = image.pixels.iter().map(|p| 1.0 - p[0]).sum();
            let expected =
                28.0 * 28.0 * outlines(text, style.weight).0.iter().map(area).sum::<f64>();
            assert!(
                (f64::from(ink) - expected).abs() < 0.02 * expected,
                "{text}: {ink} {expected}"
            );
        }
    }
}
