//! Title, captions, colour scale and legend.

use super::color::{Rgb, Scale, encode, viridis};
use super::font::{Anchor, Style, Weight, draw, width};
use super::image::Image;

const INK: Rgb = [0.13, 0.16, 0.20];
const PALE: Rgb = [0.36, 0.40, 0.45];

/// Text sizes that go with a sheet.
#[derive(Clone, Copy, Debug)]
pub struct Type {
    /// Height of a capital in running text [px].
    pub height: f64,
}

impl Type {
    /// Sizes for a sheet of this many pixels.
    pub fn for_sheet(size: [usize; 2]) -> Self {
        let side = (size[0] as f64 * 0.62).min(size[1] as f64);
        Self { height: (side / 62.0).clamp(6.0, 60.0) }
    }

    /// Style of the title.
    pub fn title(&self) -> Style {
        Style { height: 1.45 * self.height, color: INK, weight: Weight::Bold }
    }

    /// Style of captions and names.
    pub fn text(&self) -> Style {
        Style { height: self.height, color: INK, weight: Weight::Regular }
    }

    /// Style of numbers on a scale.
    pub fn number(&self) -> Style {
        Style { height: 0.9 * self.height, color: PALE, weight: Weight::Regular }
    }
}

/// A colour scale or a list of names with their colours, to the right of the panels.
#[derive(Clone, Debug)]
pub enum Key {
    /// Nothing to explain.
    None,
    /// Field values.
    Scale {
        /// Name of the field.
        name: String,
        /// The unit; empty if it has none.
        unit: String,
        /// Range and colours.
        scale: Scale,
    },
    /// Names, each with a linear colour.
    Names(Vec<(String, Rgb)>),
}

impl Key {
    /// Width that the key needs [px].
    pub fn width(&self, ty: &Type) -> f64 {
        match self {
            Self::None => 0.0,
            Self::Scale { name, unit, scale } => {
                let labels = Labels::new(scale, unit);
                let numbers = labels.ticks.iter().map(|(_, text)| width(text, &ty.number()));
                let numbers = numbers.fold(0.0, f64::max) + 3.6 * ty.height;
                numbers.max(width(&labels.title(name), &ty.text())) + 4.0 * ty.height
            }
            Self::Names(names) => {
                let widest = names.iter().map(|(n, _)| width(n, &ty.text())).fold(0.0, f64::max);
                widest + 7.0 * ty.height
            }
        }
    }

    /// Draws the key with its left border at `left`, between rows `top` and `bottom`.
    pub fn draw(&self, image: &mut Image, ty: &Type, left: f64, top: f64, bottom: f64) {
        match self {
            Self::None => {}
            Self::Scale { name, unit, scale } => {
                let labels = Labels::new(scale, unit);
                draw_scale(image, ty, name, &labels, [left, top, bottom]);
            }
            Self::Names(names) => draw_names(image, ty, names, [left, top, bottom]),
        }
    }
}

fn draw_scale(
    image: &mut Image,
    ty: &Type,
    name: &str,
    labels: &Labels,
    [left, top, bottom]: [f64; 3],
) {
    let h = ty.height;
    let room = bottom - top;
    let (low, high) = ((bottom - 0.16 * room).round(), (top + 0.16 * room).round());
    let (left, right) = (left.round(), (left + 1.7 * h).round());
    draw(image, &labels.title(name), [left, high - 2.0 * h], Anchor::Left, &ty.text());
    for y in high as i64..low as i64 {
        let t = (low - 0.5 - y as f64) / (low - high);
        let color = encode(viridis(t));
        image.fill([left, y as f64], [right, y as f64 + 1.0], color, 1.0);
    }
    frame(image, [left, high], [right, low]);
    for (t, text) in &labels.ticks {
        let y = low - t * (low - high);
        image.fill([right, y - 0.5], [right + 0.5 * h, y + 0.5], PALE, 1.0);
        let at = [right + 1.1 * h, y + 0.45 * h];
        draw(image, text, at, Anchor::Left, &ty.number());
    }
}

fn frame(image: &mut Image, min: [f64; 2], max: [f64; 2]) {
    for (from, to) in [
        ([min[0], min[1]], [max[0], min[1] + 1.0]),
        ([min[0], max[1] - 1.0], [max[0], max[1]]),
        ([min[0], min[1]], [min[0] + 1.0, max[1]]),
        ([max[0] - 1.0, min[1]], [max[0], max[1]]),
    ] {
        image.fill(from, to, PALE, 0.8);
    }
}

fn draw_names(
    image: &mut Image,
    ty: &Type,
    names: &[(String, Rgb)],
    [left, top, bottom]: [f64; 3],
) {
    let h = ty.height;
    let line = (2.6 * h).min((bottom - top) / names.len().max(1) as f64);
    let first = 0.5 * (top + bottom) - 0.5 * line * names.len() as f64;
    for (i, (name, color)) in names.iter().enumerate() {
        let y = (first + (i as f64 + 0.5) * line).round();
        let (min, max) = ([left, y - 0.75 * h], [left + 1.5 * h, y + 0.75 * h]);
        image.fill(min, max, encode(*color), 1.0);
        draw(image, name, [left + 2.5 * h, y + 0.5 * h], Anchor::Left, &ty.text());
    }
}

/// What is written beside a scale.
struct Labels {
    unit: String,
    /// Place between 0 and 1, and number.
    ticks: Vec<(f64, String)>,
}

impl Labels {
    fn new(scale: &Scale, unit: &str) -> Self {
        let (factor, unit) = readable(scale.min.abs().max(scale.max.abs()), unit);
        let (min, max) = (scale.min * factor, scale.max * factor);
        let span = max - min;
        if span <= 0.0 {
            return Self { unit, ticks: vec![(0.5, number(min, min.abs()))] };
        }
        let step = nice_step(span / 5.0);
        let inner = ((min / step).ceil() as i64..=(max / step).floor() as i64)
            .map(|k| k as f64 * step)
            .map(|v| ((v - min) / span, v))
            .filter(|(t, _)| (0.07..=0.93).contains(t));
        let all = [(0.0, min)].into_iter().chain(inner).chain([(1.0, max)]);
        Self { unit, ticks: all.map(|(t, v)| (t, number(v, step))).collect() }
    }

    fn title(&self, name: &str) -> String {
        if self.unit.is_empty() { name.to_owned() } else { format!("{name} [{}]", self.unit) }
    }
}

/// Factor and prefixed unit that bring a size to between 1 and 1000.
fn readable(size: f64, unit: &str) -> (f64, String) {
    const PREFIXES: [(i32, &str); 7] =
        [(-9, "n"), (-6, "µ"), (-3, "m"), (0, ""), (3, "k"), (6, "M"), (9, "G")];
    if !["m", "Pa", "N", "J"].contains(&unit) || size <= 0.0 || !size.is_finite() {
        return (1.0, unit.replace('-', ""));
    }
    let exponent = (size.log10() / 3.0 + 1e-9).floor() as i32 * 3;
    let (exponent, prefix) = PREFIXES[((exponent.clamp(-9, 9) + 9) / 3) as usize];
    (10.0_f64.powi(-exponent), format!("{prefix}{unit}"))
}

/// 1, 2 or 5 times a power of ten, at least `rough`.
fn nice_step(rough: f64) -> f64 {
    let power = 10.0_f64.powf(rough.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|m| m * power);
    steps.into_iter().find(|s| *s >= rough * (1.0 - 1e-9)).unwrap_or(10.0 * power)
}

/// A number with the digits that steps of this size need.
fn number(value: f64, step: f64) -> String {
    let size = value.abs().max(step);
    if size != 0.0 && !(1e-3..1e5).contains(&size) {
        return format!("{value:.2e}").replace('-', "−");
    }
    let digits = (1.0 - step.max(1e-6).log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{value:.digits$}");
    let text =
        if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0".into() } else { text.replace('-', "−") }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_in_a_readable_unit() {
        let scale = Scale { min: 0.0, max: 0.0123 };
        let labels = Labels::new(&scale, "m");
        assert_eq!(labels.title("displacement"), "displacement [mm]");
        let texts: Vec<&str> = labels.ticks.iter().map(|(_, t)| t.as_str()).collect();
        assert_eq!(texts, ["0", "5", "10", "12.3"]);
        let scale = Scale { min: -0.4, max: 0.4 };
        let texts: Vec<String> = Labels::new(&scale, "").ticks.into_iter().map(|t| t.1).collect();
        assert_eq!(texts, ["−0.4", "−0.2", "0", "0.2", "0.4"]);
    }

    #[test]
    fn prefixes_keep_three_digits_before_the_point() {
        for (size, expected) in [(55e3, "kPa"), (1e6, "MPa"), (999.0, "Pa"), (2e-3, "mPa")] {
            assert_eq!(readable(size, "Pa").1, expected);
        }
        assert_eq!(readable(1e-12, "m").1, "nm");
        assert_eq!(readable(3.0, "m²"), (1.0, "m²".to_owned()));
    }
}
