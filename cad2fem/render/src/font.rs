//! A stroke font: every glyph is a few straight strokes and elliptic arcs,
//! drawn with a round pen from exact distances, so that it is sharp at any
//! size and needs no font file.

use super::color::Rgb;
use super::image::Image;

/// Strokes of a glyph in units of a seventh of the height of a capital,
/// baseline at 0, y upwards.
struct Glyph {
    symbol: char,
    /// Width without the space to the next glyph.
    width: f64,
    /// `l x y x y ...` is a polyline, `a x y rx ry from to` an arc in degrees.
    strokes: &'static str,
}

const fn glyph(symbol: char, width: f64, strokes: &'static str) -> Glyph {
    Glyph { symbol, width, strokes }
}

/// Space between glyphs.
const TRACKING: f64 = 1.9;
/// Width of a blank.
const BLANK: f64 = 1.6;
/// Radius of the pen.
const PEN: f64 = 0.43;
/// Height of a capital.
const CAPITAL: f64 = 7.0;

#[rustfmt::skip]
const GLYPHS: &[Glyph] = &[
    glyph('a', 3.8, "a 1.9 2.5 1.9 2.5 0 360 l 3.8 5 3.8 0"),
    glyph('b', 3.8, "l 0 7.4 0 0 a 1.9 2.5 1.9 2.5 0 360"),
    glyph('c', 3.3, "a 1.9 2.5 1.9 2.5 45 315"),
    glyph('d', 3.8, "l 3.8 7.4 3.8 0 a 1.9 2.5 1.9 2.5 0 360"),
    glyph('e', 3.8, "a 1.9 2.5 1.9 2.5 0 312 l 0 2.5 3.8 2.5"),
    glyph('f', 2.4, "l 0.9 0 0.9 6 a 2.3 6 1.4 1.4 90 180 l 0 5 2.3 5"),
    glyph('g', 3.8, "a 1.9 2.5 1.9 2.5 0 360 l 3.8 5 3.8 -0.3 a 1.9 -0.3 1.9 1.9 215 360"),
    glyph('h', 3.6, "l 0 7.4 0 0 a 1.8 3.2 1.8 1.8 0 180 l 3.6 3.2 3.6 0"),
    glyph('i', 0.0, "l 0 5 0 0 l 0 7 0 7.1"),
    glyph('j', 0.6, "l 0.6 5 0.6 -0.6 a -0.8 -0.6 1.4 1.4 270 360 l 0.6 7 0.6 7.1"),
    glyph('k', 3.3, "l 0 7.4 0 0 l 3.1 5 0 1.8 l 1.2 3 3.3 0"),
    glyph('l', 0.0, "l 0 7.4 0 0"),
    glyph('m', 6.0, "l 0 5 0 0 a 1.5 3.5 1.5 1.5 0 180 l 3 3.5 3 0 a 4.5 3.5 1.5 1.5 0 180 l 6 3.5 6 0"),
    glyph('n', 3.6, "l 0 5 0 0 a 1.8 3.2 1.8 1.8 0 180 l 3.6 3.2 3.6 0"),
    glyph('o', 4.0, "a 2 2.5 2 2.5 0 360"),
    glyph('p', 3.8, "l 0 5 0 -2.2 a 1.9 2.5 1.9 2.5 0 360"),
    glyph('q', 3.8, "l 3.8 5 3.8 -2.2 a 1.9 2.5 1.9 2.5 0 360"),
    glyph('r', 2.3, "l 0 5 0 0 a 1.8 3.2 1.8 1.8 65 180"),
    glyph('s', 3.1, "a 1.55 3.75 1.4 1.25 40 270 a 1.55 1.25 1.55 1.25 -145 90"),
    glyph('t', 2.5, "l 0.9 6.7 0.9 1.4 a 2.3 1.4 1.4 1.4 180 280 l 0 5 2.4 5"),
    glyph('u', 3.6, "l 0 5 0 1.8 a 1.8 1.8 1.8 1.8 180 360 l 3.6 5 3.6 0"),
    glyph('v', 3.6, "l 0 5 1.8 0 3.6 5"),
    glyph('w', 5.8, "l 0 5 1.45 0 2.9 5 4.35 0 5.8 5"),
    glyph('x', 3.4, "l 0 5 3.4 0 l 3.4 5 0 0"),
    glyph('y', 3.6, "l 0 5 1.8 0 l 3.6 5 1.01 -2.2"),
    glyph('z', 3.2, "l 0 5 3.2 5 0 0 3.2 0"),
    glyph('A', 5.2, "l 0 0 2.6 7 5.2 0 l 0.9 2.4 4.3 2.4"),
    glyph('B', 4.4, "l 2.4 0 0 0 0 7 2.3 7 a 2.3 5.3 1.7 1.7 -90 90 l 0 3.6 2.4 3.6 a 2.4 1.8 2 1.8 -90 90"),
    glyph('C', 5.2, "a 3 3.5 3 3.5 46 314"),
    glyph('D', 4.9, "l 1.7 0 0 0 0 7 1.7 7 a 1.7 3.5 3.2 3.5 -90 90"),
    glyph('E', 3.8, "l 3.8 7 0 7 0 0 3.8 0 l 0 3.6 3.4 3.6"),
    glyph('F', 3.6, "l 3.6 7 0 7 0 0 l 0 3.5 3.2 3.5"),
    glyph('G', 5.6, "a 3 3.5 3 3.5 46 346 l 5.9 2.6 5.9 3.3 3.5 3.3"),
    glyph('H', 4.8, "l 0 7 0 0 l 4.8 7 4.8 0 l 0 3.6 4.8 3.6"),
    glyph('I', 0.0, "l 0 7 0 0"),
    glyph('J', 2.8, "l 2.8 7 2.8 1.8 a 1.2 1.8 1.6 1.8 200 360"),
    glyph('K', 4.4, "l 0 7 0 0 l 4.2 7 0 2.6 l 1.5 4.1 4.4 0"),
    glyph('L', 3.5, "l 0 7 0 0 3.5 0"),
    glyph('M', 6.0, "l 0 0 0 7 3 1.6 6 7 6 0"),
    glyph('N', 4.8, "l 0 0 0 7 4.8 0 4.8 7"),
    glyph('O', 6.2, "a 3.1 3.5 3.1 3.5 0 360"),
    glyph('P', 4.2, "l 0 0 0 7 2.3 7 a 2.3 5.1 1.9 1.9 -90 90 l 2.3 3.2 0 3.2"),
    glyph('Q', 6.2, "a 3.1 3.5 3.1 3.5 0 360 l 3.8 1.8 5.8 -0.5"),
    glyph('R', 4.4, "l 0 0 0 7 2.3 7 a 2.3 5.1 1.9 1.9 -90 90 l 2.3 3.2 0 3.2 l 2.2 3.2 4.4 0"),
    glyph('S', 4.2, "a 2.1 5.25 1.9 1.75 35 270 a 2.1 1.75 2.1 1.75 -150 90"),
    glyph('T', 4.8, "l 0 7 4.8 7 l 2.4 7 2.4 0"),
    glyph('U', 4.8, "l 0 7 0 2.4 a 2.4 2.4 2.4 2.4 180 360 l 4.8 2.4 4.8 7"),
    glyph('V', 5.0, "l 0 7 2.5 0 5 7"),
    glyph('W', 7.2, "l 0 7 1.8 0 3.6 7 5.4 0 7.2 7"),
    glyph('X', 4.6, "l 0 7 4.6 0 l 4.6 7 0 0"),
    glyph('Y', 4.8, "l 0 7 2.4 3.4 4.8 7 l 2.4 3.4 2.4 0"),
    glyph('Z', 4.4, "l 0 7 4.4 7 0 0 4.4 0"),
    glyph('0', 4.0, "a 2 3.5 2 3.5 0 360"),
    glyph('1', 4.0, "l 0.9 5.8 2.4 7 2.4 0"),
    glyph('2', 4.0, "a 1.95 5.05 1.95 1.95 -42 165 l 3.4 3.75 0 0 4 0"),
    glyph('3', 4.0, "a 1.9 5.3 1.75 1.7 -90 150 l 1.3 3.6 1.9 3.6 a 1.9 1.8 2 1.8 -150 90"),
    glyph('4', 4.0, "l 3 0 3 7 0 2 4.1 2"),
    glyph('5', 4.0, "l 3.7 7 0.8 7 0.5 4 a 1.9 2.25 2.1 2.25 -150 130"),
    glyph('6', 4.0, "a 2 2.2 2 2.2 0 360 l 0.25 3.3 2.4 7"),
    glyph('7', 4.0, "l 0 7 4 7 1.3 0"),
    glyph('8', 4.0, "a 2 5.3 1.7 1.7 0 360 a 2 1.8 2 1.8 0 360"),
    glyph('9', 4.0, "a 2 4.8 2 2.2 0 360 l 3.75 3.7 1.6 0"),
    glyph('.', 0.0, "l 0 0 0 0.1"),
    glyph(',', 0.2, "l 0.2 0 -0.2 -1.3"),
    glyph(':', 0.0, "l 0 0 0 0.1 l 0 4.2 0 4.3"),
    glyph(';', 0.2, "l 0.2 0 -0.2 -1.3 l 0.2 4.2 0.2 4.3"),
    glyph('!', 0.0, "l 0 7 0 2 l 0 0 0 0.1"),
    glyph('?', 3.4, "a 1.7 5.3 1.7 1.7 -60 165 l 2.5 3.8 1.7 3 1.7 2 l 1.7 0 1.7 0.1"),
    glyph('-', 2.2, "l 0 2.7 2.2 2.7"),
    glyph('−', 3.4, "l 0 3 3.4 3"),
    glyph('–', 3.8, "l 0 2.7 3.8 2.7"),
    glyph('+', 3.6, "l 0 3 3.6 3 l 1.8 4.8 1.8 1.2"),
    glyph('=', 3.6, "l 0 3.9 3.6 3.9 l 0 2 3.6 2"),
    glyph('±', 3.6, "l 0 4 3.6 4 l 1.8 5.8 1.8 2.2 l 0 0.6 3.6 0.6"),
    glyph('×', 3.2, "l 0 4.5 3.2 1.3 l 3.2 4.5 0 1.3"),
    glyph('·', 0.0, "l 0 2.9 0 3"),
    glyph('*', 2.6, "l 1.3 7 1.3 4 l 0 6.2 2.6 4.8 l 2.6 6.2 0 4.8"),
    glyph('/', 3.0, "l 0 -1 3 7.6"),
    glyph('\\', 3.0, "l 3 -1 0 7.6"),
    glyph('|', 0.0, "l 0 -1.5 0 7.8"),
    glyph('_', 3.6, "l 0 -1.2 3.6 -1.2"),
    glyph('(', 1.4, "a 3.4 2.9 3.4 6 130 230"),
    glyph(')', 1.4, "a -2 2.9 3.4 6 -50 50"),
    glyph('[', 1.3, "l 1.3 7.6 0 7.6 0 -1.4 1.3 -1.4"),
    glyph(']', 1.3, "l 0 7.6 1.3 7.6 1.3 -1.4 0 -1.4"),
    glyph('{', 1.9, "l 1.9 7.6 1.1 7.2 1.1 3.8 0.2 3.1 1.1 2.4 1.1 -1 1.9 -1.4"),
    glyph('}', 1.9, "l 0 7.6 0.8 7.2 0.8 3.8 1.7 3.1 0.8 2.4 0.8 -1 0 -1.4"),
    glyph('<', 3.2, "l 3.2 5.2 0 3 3.2 0.8"),
    glyph('>', 3.2, "l 0 5.2 3.2 3 0 0.8"),
    glyph('→', 4.6, "l 0 3 4.6 3 l 3 4.6 4.6 3 3 1.4"),
    glyph('\'', 0.0, "l 0 7.4 0 5.6"),
    glyph('"', 1.4, "l 0 7.4 0 5.6 l 1.4 7.4 1.4 5.6"),
    glyph('`', 1.0, "l 0 7.4 1 6.2"),
    glyph('^', 2.6, "l 0 5.4 1.3 7.2 2.6 5.4"),
    glyph('~', 3.6, "a 0.9 2.7 0.9 0.8 0 180 a 2.7 2.7 0.9 0.8 180 360"),
    glyph('°', 1.8, "a 0.9 6.3 0.9 0.9 0 360"),
    glyph('%', 5.6, "a 1.2 5.6 1.2 1.4 0 360 a 4.4 1.4 1.2 1.4 0 360 l 4.6 7 1 0"),
    glyph('#', 4.4, "l 1.6 7 0.9 0 l 3.6 7 2.9 0 l 0 4.7 4.4 4.7 l 0 2.3 4.4 2.3"),
    glyph('&', 4.8, "l 4.8 0 0.9 4.8 a 2.2 5.7 1.4 1.3 -30 215 l 3.4 5 0.7 2.9 a 1.9 1.6 1.9 1.6 120 330 l 3.6 0.8 4.6 2.8"),
    glyph('@', 6.4, "a 3.2 2.9 1.4 1.6 0 360 l 4.6 4.5 4.6 2.4 a 5.4 2.3 0.8 0.9 180 340 a 3.2 2.9 3.2 3.8 -10 310"),
    glyph('$', 4.0, "a 2 5.1 1.8 1.6 35 270 a 2 1.8 2 1.7 -150 90 l 2 7.9 2 -1"),
    glyph('²', 2.4, "a 1.15 6.5 1.15 1.1 -42 165 l 2 5.76 0 3.7 2.4 3.7"),
    glyph('³', 2.4, "a 1.1 6.7 1.05 0.95 -90 150 a 1.1 4.7 1.2 1.05 -150 90"),
    glyph('µ', 3.6, "l 0 5 0 -2.2 l 0 5 0 1.8 a 1.8 1.8 1.8 1.8 180 360 l 3.6 5 3.6 0"),
];

/// Drawn for symbols that the font does not have.
const MISSING: Glyph = glyph('\u{fffd}', 3.6, "l 0 0 0 7 3.6 7 3.6 0 0 0");

fn find(symbol: char) -> Option<&'static Glyph> {
    (symbol != ' ').then(|| GLYPHS.iter().find(|g| g.symbol == symbol).unwrap_or(&MISSING))
}

/// Which point of a text is at the given position.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Left end of the baseline.
    Left,
    /// Middle of the baseline.
    Center,
    /// Right end of the baseline.
    Right,
}

/// Size and colour of a text.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// Height of a capital [px].
    pub height: f64,
    /// Colour in sRGB.
    pub color: Rgb,
    /// Pen relative to the regular one: 1.3 is bold.
    pub weight: f64,
}

/// Width of a text [px].
#[must_use]
pub fn width(text: &str, style: &Style) -> f64 {
    let advance = |c| find(c).map_or(BLANK + TRACKING, |g| g.width + TRACKING);
    let units: f64 = text.chars().map(advance).sum::<f64>() - TRACKING;
    units.max(0.0) * style.height / CAPITAL
}

/// Draws a line of text with its baseline at `at` [px].
pub fn draw(image: &mut Image, text: &str, at: [f64; 2], anchor: Anchor, style: &Style) {
    let unit = style.height / CAPITAL;
    let shift = match anchor {
        Anchor::Left => 0.0,
        Anchor::Center => 0.5,
        Anchor::Right => 1.0,
    };
    let mut x = at[0] - shift * width(text, style);
    for symbol in text.chars() {
        let Some(glyph) = find(symbol) else {
            x += (BLANK + TRACKING) * unit;
            continue;
        };
        let strokes = segments(glyph.strokes)
            .into_iter()
            .map(|s| s.map(|[u, v]| [x + unit * u, at[1] - unit * v]))
            .collect::<Vec<_>>();
        ink(image, &strokes, PEN * unit * style.weight, style.color);
        x += (glyph.width + TRACKING) * unit;
    }
}

/// Straight pieces of the strokes of a glyph.
fn segments(strokes: &str) -> Vec<[[f64; 2]; 2]> {
    let mut pieces = Vec::new();
    let mut words = strokes.split(' ').peekable();
    while let Some(kind) = words.next() {
        let mut numbers = Vec::new();
        while let Some(number) = words.peek().and_then(|word| word.parse::<f64>().ok()) {
            numbers.push(number);
            words.next();
        }
        let points = if kind == "a" { arc(&numbers) } else { pairs(&numbers) };
        pieces.extend(points.windows(2).map(|w| [w[0], w[1]]));
    }
    pieces
}

fn pairs(numbers: &[f64]) -> Vec<[f64; 2]> {
    numbers.chunks_exact(2).map(|p| [p[0], p[1]]).collect()
}

/// Points on an elliptic arc, 12° apart or less.
fn arc(numbers: &[f64]) -> Vec<[f64; 2]> {
    let &[x, y, rx, ry, from, to] = numbers else { return vec![] };
    let count = ((to - from) / 12.0).abs().ceil() as usize;
    let angle = |i: usize| (from + (to - from) * i as f64 / count as f64).to_radians();
    (0..=count).map(|i| [x + rx * angle(i).cos(), y + ry * angle(i).sin()]).collect()
}

/// Draws strokes with a round pen; the border is one pixel of linear ramp.
fn ink(image: &mut Image, strokes: &[[[f64; 2]; 2]], radius: f64, color: Rgb) {
    let reach = radius + 1.0;
    let ends = || strokes.iter().flatten();
    let lower = |i: usize| ends().map(|p| p[i]).fold(f64::INFINITY, f64::min) - reach;
    let upper = |i: usize| ends().map(|p| p[i]).fold(f64::NEG_INFINITY, f64::max) + reach;
    for y in lower(1).floor() as i64..=upper(1).ceil() as i64 {
        for x in lower(0).floor() as i64..=upper(0).ceil() as i64 {
            let p = [x as f64 + 0.5, y as f64 + 0.5];
            let distance = strokes.iter().map(|s| to_segment(p, s)).fold(f64::INFINITY, f64::min);
            let alpha = (radius + 0.5 - distance).clamp(0.0, 1.0);
            if alpha > 0.0 {
                image.blend(x, y, color, alpha as f32);
            }
        }
    }
}

/// Distance from a point to a segment.
fn to_segment([x, y]: [f64; 2], [a, b]: &[[f64; 2]; 2]) -> f64 {
    let (dx, dy) = (b[0] - a[0], b[1] - a[1]);
    let length2 = dx * dx + dy * dy;
    let along = (x - a[0]) * dx + (y - a[1]) * dy;
    let t = if length2 > 0.0 { (along / length2).clamp(0.0, 1.0) } else { 0.0 };
    (x - a[0] - t * dx).hypot(y - a[1] - t * dy)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_printable_ascii_symbol_has_a_glyph_within_its_line() {
        for symbol in '!'..='~' {
            let glyph = GLYPHS.iter().find(|g| g.symbol == symbol);
            assert!(glyph.is_some(), "no glyph for {symbol:?}");
            for [x, y] in segments(glyph.map_or("", |g| g.strokes)).into_iter().flatten() {
                assert!((-3.2..=8.0).contains(&y) && (-2.3..=7.3).contains(&x), "{symbol:?}");
            }
        }
    }

    #[test]
    fn ink_covers_what_the_pen_covers() {
        let paper = [1.0; 3];
        let mut image = Image::new(60, 40, paper);
        let style = Style { height: 28.0, color: [0.0; 3], weight: 1.0 };
        draw(&mut image, "I", [20.0, 34.0], Anchor::Left, &style);
        let ink: f32 = image.pixels.iter().map(|p| 1.0 - p[0]).sum();
        let pen = PEN * 4.0;
        // a stroke of 28 px with two round ends; the ramp blurs the ends by a pixel at most
        let expected = 28.0 * 2.0 * pen + std::f64::consts::PI * pen * pen;
        assert!((f64::from(ink) - expected).abs() < 2.0 * pen, "{ink} {expected}");
    }

    #[test]
    fn anchors_use_the_width() {
        let style = Style { height: 14.0, color: [0.0; 3], weight: 1.0 };
        let first_dark = |anchor| {
            let mut image = Image::new(200, 30, [1.0; 3]);
            draw(&mut image, "max 12.5 mm", [100.0, 20.0], anchor, &style);
            (0..200).find(|x| (0..30).any(|y| image.pixels[y * 200 + x][0] < 0.5))
        };
        let width = width("max 12.5 mm", &style);
        let left = |shift: f64| Some((100.0 - shift * width - PEN * 2.0).round() as usize);
        assert_eq!(first_dark(Anchor::Left), left(0.0));
        assert_eq!(first_dark(Anchor::Center), left(0.5));
        assert_eq!(first_dark(Anchor::Right), left(1.0));
    }
}
