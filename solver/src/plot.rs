//! Curves and points as a picture, SVG or PNG.

use std::fmt::Display;
use std::ops::Range;
use std::path::Path;

use anyhow::{Result, anyhow, ensure};
use plotters::coord::Shift;
use plotters::coord::combinators::WithKeyPoints;
use plotters::coord::ranged1d::{AsRangedCoord, ValueFormatter};
use plotters::prelude::*;
use plotters::style::register_font;
use render::image::Image;

/// Colours that remain apart for colour-blind readers, by Okabe and Ito 2008.
const COLORS: [RGBColor; 6] = [
    RGBColor(0, 114, 178),
    RGBColor(213, 94, 0),
    RGBColor(0, 158, 115),
    RGBColor(204, 121, 167),
    RGBColor(230, 159, 0),
    RGBColor(86, 180, 233),
];

/// Pixels of the canvas per pixel of the picture: the library rounds to pixels,
/// and a curve should not show it.
const FINE: u8 = 8;

/// Width and height of the picture [pixels].
const SIZE: [u32; 2] = [900, 600];

/// What is drawn along the axes.
#[derive(Clone, Debug, Default)]
pub struct Axes {
    /// Name and unit of the abscissa.
    pub x: String,
    /// Name and unit of the ordinate.
    pub y: String,
    /// Whether the abscissa is logarithmic.
    pub log_x: bool,
    /// Whether the ordinate is logarithmic.
    pub log_y: bool,
}

/// How a series is drawn.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Style {
    /// A line of a width in pixels, in the colour of its turn.
    Line(u8),
    /// A line of a width in pixels, in the colour of its turn, with a dot at each point.
    Dotted(u8),
    /// Grey circles of a radius in pixels.
    Circles(u8),
    /// Rings of a radius in pixels, in the colour of their turn.
    Rings(u8),
    /// Grey bars, each between two points in a row.
    Bars,
}

/// Points in the order in which they are joined.
#[derive(Clone, Debug)]
pub struct Series {
    /// Name in the legend; none without.
    pub label: Option<String>,
    /// Points (x, y).
    pub points: Vec<(f64, f64)>,
    /// Look.
    pub style: Style,
    /// Series of the same turn have the same colour.
    pub turn: usize,
}

impl Series {
    fn color(&self) -> RGBColor {
        COLORS[self.turn % COLORS.len()]
    }

    /// What is drawn of points, but the dots on a line.
    fn marks<B: DrawingBackend, C: Copy + 'static>(
        &self,
        points: &[C],
    ) -> Vec<DynElement<'static, B, C>> {
        let (color, grey) = (self.color(), BLACK.mix(0.6).stroke_width(fine(1)));
        let circles = |size: u8, style: ShapeStyle| {
            let one = |p: &C| Circle::new(*p, fine(i32::from(size)), style).into_dyn();
            points.iter().map(one).collect()
        };
        match self.style {
            Style::Line(width) | Style::Dotted(width) => {
                let style = color.stroke_width(fine(width.into()));
                vec![PathElement::new(points, style).into_dyn()]
            }
            Style::Circles(size) => circles(size, grey),
            Style::Rings(size) => circles(size, color.stroke_width(fine(2))),
            Style::Bars => {
                points.chunks(2).map(|ends| PathElement::new(ends, grey).into_dyn()).collect()
            }
        }
    }
}

/// Draws series as SVG or, where the name ends with .png, the same as PNG.
pub fn draw(path: &Path, axes: &Axes, series: &[Series]) -> Result<()> {
    let context = |e| anyhow!("{}: {e}", path.display());
    let format = mesh::io::extension(path);
    ensure!(
        format == "svg" || format == "png",
        "{}: plots are written as SVG or PNG; the name of the output has to end with .svg or .png",
        path.display()
    );
    if format == "png" {
        pixels(axes, series).map_err(context)?.write_png(path)?;
    } else {
        let text = svg(axes, series).map_err(context)?;
        mesh::io::write_atomic(path, |out| out.write_all(text.as_bytes()))?;
    }
    Ok(())
}

/// Pixels of the canvas, along each side, that make one of a PNG: two for each of the picture.
const COARSER: usize = 4;

/// The picture as pixels, each the mean of a square of the canvas.
fn pixels(axes: &Axes, series: &[Series]) -> Result<Image> {
    let [width, height] = SIZE.map(fine);
    let [wide, high] = [width as usize, height as usize];
    let mut canvas = vec![0_u8; 3 * wide * high];
    let backend = BitMapBackend::with_buffer(&mut canvas, (width, height));
    paint(&backend.into_drawing_area(), axes, series)?;
    let mean = |x: usize, y: usize| {
        let at = |i: usize| 3 * ((COARSER * y + i / COARSER) * wide + COARSER * x + i % COARSER);
        let channel = |c: usize| (0..COARSER * COARSER).map(|i| u32::from(canvas[at(i) + c])).sum();
        [0, 1, 2].map(|c| -> f32 {
            let sum: u32 = channel(c);
            sum as f32 / (255 * COARSER * COARSER) as f32
        })
    };
    let (width, height) = (wide / COARSER, high / COARSER);
    let pixels = (0..width * height).map(|i| mean(i % width, i / width)).collect();
    Ok(Image { width, height, pixels })
}

fn svg(axes: &Axes, series: &[Series]) -> Result<String> {
    let mut text = String::new();
    let [width, height] = SIZE.map(fine);
    paint(&SVGBackend::with_string(&mut text, (width, height)).into_drawing_area(), axes, series)?;
    // the view box keeps the canvas; only the size to show it at changes
    let size = |[width, height]: [u32; 2]| format!("width=\"{width}\" height=\"{height}\"");
    Ok(text.replacen(&size(SIZE.map(fine)), &size(SIZE), 1))
}

/// Draws on an empty canvas.
fn paint<B: DrawingBackend>(
    canvas: &DrawingArea<B, Shift>,
    axes: &Axes,
    series: &[Series],
) -> Result<()> {
    let points = || series.iter().flat_map(|s| &s.points);
    ensure!(points().next().is_some(), "there is nothing to draw");
    let fits = |log: bool, value: f64| value.is_finite() && (!log || value > 0.0);
    if let Some((x, y)) = points().find(|p| !(fits(axes.log_x, p.0) && fits(axes.log_y, p.1))) {
        let along = |log: bool, name: &str| if log { name.to_owned() } else { String::new() };
        let positive =
            along(axes.log_x, ", positive along x") + &along(axes.log_y, ", positive along y");
        return Err(anyhow!(
            "the point ({x}, {y}) cannot be drawn: expected finite numbers{positive}"
        ));
    }
    // positions along the axes; on a logarithmic one, decades
    let x = room(points().map(|p| axes.position(p).0), 0.02);
    let y = room(points().map(|p| axes.position(p).1), 0.06);
    let corner = free_corner(points().map(|p| axes.position(p)));
    // the library asks for a typeface by this name
    register_font("sans-serif", FontStyle::Normal, render::font::REGULAR)
        .map_err(|_| anyhow!("the typeface of the program is no typeface"))?;
    canvas.fill(&WHITE).map_err(plain)?;
    match (axes.log_x, axes.log_y) {
        (false, false) => chart(canvas, axes, series, corner, x, y)?,
        (false, true) => chart(canvas, axes, series, corner, x, logarithmic(&y))?,
        (true, false) => chart(canvas, axes, series, corner, logarithmic(&x), y)?,
        (true, true) => chart(canvas, axes, series, corner, logarithmic(&x), logarithmic(&y))?,
    }
    canvas.present().map_err(plain)
}

impl Axes {
    /// Where a point lies along both axes.
    fn position(&self, (x, y): &(f64, f64)) -> (f64, f64) {
        let along = |log: bool, value: f64| if log { value.log10() } else { value };
        (along(self.log_x, *x), along(self.log_y, *y))
    }
}

/// A logarithmic axis over a range of decades.
fn logarithmic(decades: &Range<f64>) -> WithKeyPoints<LogCoord<f64>> {
    let numbers = 10_f64.powf(decades.start)..10_f64.powf(decades.end);
    numbers.log_scale().with_key_points(ticks(decades))
}

/// Round numbers in a range of decades: enough to read the axis, and no more
/// than fit beside it.
fn ticks(decades: &Range<f64>) -> Vec<f64> {
    let extent = decades.end - decades.start;
    let digits: &[f64] = match extent {
        e if e < 1.0 => &[1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0, 8.0, 9.0],
        e if e < 3.0 => &[1.0, 2.0, 5.0],
        _ => &[1.0],
    };
    let stride = (extent / 12.0).ceil().max(1.0) as usize;
    let powers = (decades.start.floor() as i32..=decades.end.floor() as i32).step_by(stride);
    let numbers = powers.flat_map(|p| digits.iter().map(move |d| d * 10_f64.powi(p)));
    numbers.filter(|n| (decades.start..=decades.end).contains(&n.log10())).collect()
}

/// The range of values with a margin on both sides.
fn room(values: impl Iterator<Item = f64> + Clone, margin: f64) -> Range<f64> {
    let low = values.clone().fold(f64::INFINITY, f64::min);
    let high = values.fold(f64::NEG_INFINITY, f64::max);
    let extent = if high > low { high - low } else { low.abs().max(1.0) };
    low - margin * extent..high + margin * extent
}

/// The corner with the fewest points, for the legend.
fn free_corner(points: impl Iterator<Item = (f64, f64)> + Clone) -> SeriesLabelPosition {
    let (x, y) = (room(points.clone().map(|p| p.0), 0.0), room(points.clone().map(|p| p.1), 0.0));
    let middle = (0.5 * (x.start + x.end), 0.5 * (y.start + y.end));
    let crowd = |right: bool, upper: bool| {
        points.clone().filter(|p| (p.0 > middle.0) == right && (p.1 > middle.1) == upper).count()
    };
    let corners = [
        (crowd(false, true), SeriesLabelPosition::UpperLeft),
        (crowd(true, true), SeriesLabelPosition::UpperRight),
        (crowd(false, false), SeriesLabelPosition::LowerLeft),
        (crowd(true, false), SeriesLabelPosition::LowerRight),
    ];
    corners.into_iter().min_by_key(|c| c.0).map_or(SeriesLabelPosition::UpperLeft, |c| c.1)
}

fn chart<B: DrawingBackend, X, Y>(
    canvas: &DrawingArea<B, Shift>,
    axes: &Axes,
    series: &[Series],
    corner: SeriesLabelPosition,
    x: X,
    y: Y,
) -> Result<()>
where
    X: AsRangedCoord<Value = f64>,
    X::CoordDescType: ValueFormatter<f64>,
    Y: AsRangedCoord<Value = f64>,
    Y::CoordDescType: ValueFormatter<f64>,
{
    let mut chart = ChartBuilder::on(canvas)
        .margin(fine(15))
        .x_label_area_size(fine(50))
        .y_label_area_size(fine(90))
        .build_cartesian_2d(x, y)
        .map_err(plain)?;
    chart
        .configure_mesh()
        .axis_style(BLACK.stroke_width(fine(1)))
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12).stroke_width(fine(1)))
        .set_all_tick_mark_size(fine(5))
        .x_label_formatter(&|x| tick(*x))
        .y_label_formatter(&|y| tick(*y))
        .x_desc(&axes.x)
        .y_desc(&axes.y)
        .axis_desc_style(("sans-serif", fine(20)))
        .label_style(("sans-serif", fine(16)))
        .draw()
        .map_err(plain)?;
    for one in series {
        let points = &one.points[..];
        let drawn = chart.draw_series(one.marks(points)).map_err(plain)?;
        if let Some(label) = &one.label {
            let one = Series { points: Vec::new(), ..one.clone() };
            drawn.label(label).legend(move |(x, y)| {
                let (x, ends) = (x + fine(12), [(x, y), (x + fine(24), y)]);
                let bar = [(x, y - fine(6)), (x, y + fine(6))];
                let points = match one.style {
                    Style::Line(_) | Style::Dotted(_) => &ends[..],
                    Style::Circles(_) | Style::Rings(_) => &[(x, y)],
                    Style::Bars => &bar,
                };
                one.marks(points).swap_remove(0)
            });
        }
        if let Style::Dotted(width) = one.style {
            let dot =
                |p: &(f64, f64)| Circle::new(*p, fine(i32::from(width) + 1), one.color().filled());
            chart.draw_series(points.iter().map(dot)).map_err(plain)?;
        }
    }
    if series.iter().any(|s| s.label.is_some()) {
        chart
            .configure_series_labels()
            .position(corner)
            .margin(fine(10))
            .legend_area_size(fine(34))
            .background_style(WHITE.mix(0.9))
            .border_style(BLACK.mix(0.3).stroke_width(fine(1)))
            .label_font(("sans-serif", fine(17)))
            .draw()
            .map_err(plain)?;
    }
    Ok(())
}

/// A number at the axis, short whatever its size.
fn tick(y: f64) -> String {
    if y == 0.0 || (1e-3..1e5).contains(&y.abs()) {
        let digits = format!("{y:.4}");
        return digits.trim_end_matches('0').trim_end_matches('.').to_owned();
    }
    format!("{y:.2e}")
}

/// Pixels of the canvas.
fn fine<T: std::ops::Mul<Output = T> + From<u8>>(pixels: T) -> T {
    pixels * T::from(FINE)
}

/// The library's errors borrow the backend; their text does not.
fn plain(error: impl Display) -> anyhow::Error {
    anyhow!("{error}")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(points: Vec<(f64, f64)>) -> Vec<Series> {
        vec![Series { label: Some("a & b".into()), points, style: Style::Dotted(2), turn: 0 }]
    }

    /// Equal factors are equal lengths on a logarithmic axis.
    #[test]
    fn both_axes_may_be_logarithmic() {
        let power_law = || line(vec![(1.0, 1e-2), (10.0, 1e-4), (1000.0, 1e-8)]);
        let axes = Axes { x: "time [s]".into(), y: "e".into(), log_x: true, log_y: true };
        let text = svg(&axes, &power_law()).expect("drawable");
        assert!(
            text.contains("time [s]") && text.contains("a &amp; b") && text.contains("polyline")
        );
        let center = |circle: &str| {
            let number = |key: &str| -> f64 {
                let (_, rest) = circle.split_once(&format!("{key}=\"")).expect("a coordinate");
                rest.split('"').next().and_then(|n| n.parse().ok()).expect("a number")
            };
            (number("cx"), number("cy"))
        };
        let centers: Vec<_> = text.split("<circle").skip(1).map(center).collect();
        let [a, b, c] = centers[..] else { panic!("{centers:?}") };
        // positions are rounded to whole pixels of the fine canvas
        for (first, second) in [(b.0 - a.0, c.0 - b.0), (b.1 - a.1, c.1 - b.1)] {
            assert!((second / first - 2.0).abs() < 0.01, "{first} {second}");
        }
        let error = svg(&axes, &line(vec![(0.0, 1.0)])).expect_err("0 has no logarithm");
        assert!(error.to_string().contains("positive along x"), "{error}");
    }

    #[test]
    fn logarithmic_axes_have_round_numbers_from_end_to_end() {
        let near = |found: Vec<f64>, expected: &[f64]| {
            assert_eq!(found.len(), expected.len(), "{found:?}");
            found.iter().zip(expected).for_each(|(a, b)| assert!((a / b - 1.0).abs() < 1e-12));
        };
        near(ticks(&(-0.75..0.6)), &[0.2, 0.5, 1.0, 2.0]);
        near(ticks(&(-0.2..0.5)), &[0.7, 0.8, 0.9, 1.0, 2.0, 3.0]);
        near(ticks(&(-4.1..0.1)), &[1e-4, 1e-3, 1e-2, 1e-1, 1.0]);
        assert!(ticks(&(-60.0..30.0)).len() < 13);
    }

    /// A PNG is the SVG in pixels: white, with the curve's colour and text in black.
    #[test]
    fn a_png_has_curve_and_text() {
        let axes = Axes { x: "pressure [kPa]".into(), y: "angle".into(), ..Axes::default() };
        let image = pixels(&axes, &line(vec![(0.0, 0.0), (1.0, 2.0)])).expect("drawable");
        assert_eq!([image.width, image.height], [1800, 1200]);
        let count = |color: [u8; 3]| {
            let same = |p: &&[f32; 3]| p.map(|v| (255.0 * v).round() as u8) == color;
            image.pixels.iter().filter(same).count()
        };
        assert!(count([255; 3]) > image.pixels.len() / 2, "{}", count([255; 3]));
        assert!(count([0, 114, 178]) > 2000, "{}", count([0, 114, 178]));
        // the name of the abscissa, below the axis
        let dark = |p: &[f32; 3]| p.iter().all(|v| *v < 0.3);
        let below = &image.pixels[1130 * 1800..];
        assert!(below.iter().filter(|p| dark(p)).count() > 300);
    }

    #[test]
    fn what_cannot_be_drawn_is_named() {
        let axes = Axes { log_y: true, ..Axes::default() };
        let error =
            svg(&axes, &line(vec![(1.0, 1.0), (2.0, -3.0)])).expect_err("-3 has no logarithm");
        assert!(error.to_string().contains("(2, -3)"), "{error}");
        assert!(svg(&Axes::default(), &line(Vec::new())).is_err());
        assert!(svg(&Axes::default(), &line(vec![(1.0, f64::NAN)])).is_err());
        // a single value has a range, too
        assert!(svg(&Axes::default(), &line(vec![(1.0, 0.0)])).is_ok());
    }
}
