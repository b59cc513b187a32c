//! Measured points and fitted curves as a picture.

use std::fmt::Display;
use std::path::Path;

use anyhow::{Result, anyhow};
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::{Fitted, Test, range};
use crate::material::response::Mode;

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

/// Points drawn of one test: more only blacken the picture.
const DRAWN: usize = 80;

/// Width and height of the picture [pixels].
const SIZE: [u32; 2] = [900, 600];

/// Draws tests and fits, over the range of the data, as SVG; the chosen fit is
/// drawn thick.
///
/// # Errors
/// When the file cannot be written.
pub fn draw(path: &Path, tests: &[Test], fits: &[Fitted], chosen: &Fitted) -> Result<()> {
    let mut text = String::new();
    chart(&mut text, tests, fits, chosen).map_err(|e| anyhow!("{}: {e}", path.display()))?;
    // the view box keeps the canvas; only the size to show it at changes
    let size = |[width, height]: [u32; 2]| format!("width=\"{width}\" height=\"{height}\"");
    let text = text.replacen(&size(SIZE.map(fine)), &size(SIZE), 1);
    mesh::io::write_atomic(path, |out| out.write_all(text.as_bytes()))?;
    Ok(())
}

/// Axes of stretch [1] and nominal stress [kPa].
type Chart<'a> = ChartContext<'a, SVGBackend<'a>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

fn chart(text: &mut String, tests: &[Test], fits: &[Fitted], chosen: &Fitted) -> Result<()> {
    let [left, right] = range(tests);
    let stresses = || tests.iter().flat_map(|t| t.points.iter().map(|p| 1e-3 * p.1));
    let (low, high) = (stresses().fold(0.0, f64::min), stresses().fold(0.0, f64::max));
    let room = 0.06 * (high - low);
    let canvas = SVGBackend::with_string(text, (fine(SIZE[0]), fine(SIZE[1]))).into_drawing_area();
    canvas.fill(&WHITE).map_err(plain)?;
    let mut chart = ChartBuilder::on(&canvas)
        .margin(fine(15))
        .x_label_area_size(fine(50))
        .y_label_area_size(fine(80))
        .build_cartesian_2d(left.min(1.0)..right.max(1.0), low - room..high + room)
        .map_err(plain)?;
    chart
        .configure_mesh()
        .axis_style(BLACK.stroke_width(fine(1)))
        .light_line_style(TRANSPARENT)
        .bold_line_style(BLACK.mix(0.12).stroke_width(fine(1)))
        .set_all_tick_mark_size(fine(5))
        .x_desc("stretch along the pull [1]")
        .y_desc("nominal stress [kPa]")
        .axis_desc_style(("sans-serif", fine(20)))
        .label_style(("sans-serif", fine(16)))
        .draw()
        .map_err(plain)?;
    for test in tests {
        draw_points(&mut chart, test)?;
    }
    for (fit, color) in fits.iter().zip(COLORS.iter().cycle()) {
        let width = if std::ptr::eq(fit, chosen) { 4 } else { 2 };
        draw_curves(&mut chart, tests, fit, color.stroke_width(fine(width)))?;
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .margin(fine(10))
        .legend_area_size(fine(34))
        .background_style(WHITE.mix(0.9))
        .border_style(BLACK.mix(0.3).stroke_width(fine(1)))
        .label_font(("sans-serif", fine(17)))
        .draw()
        .map_err(plain)?;
    canvas.present().map_err(plain)
}

fn draw_points(chart: &mut Chart, test: &Test) -> Result<()> {
    let mode = test.mode;
    let points = test.points.iter().step_by(test.points.len().div_ceil(DRAWN));
    let markers = points.map(|p| EmptyElement::at((p.0, 1e-3 * p.1)) + marker(mode));
    chart
        .draw_series(markers)
        .map_err(plain)?
        .label(format!("{} test", mode.name()))
        .legend(move |(x, y)| EmptyElement::at((x + fine(12), y)) + marker(mode));
    Ok(())
}

fn draw_curves(chart: &mut Chart, tests: &[Test], fit: &Fitted, style: ShapeStyle) -> Result<()> {
    let material = (fit.law().build)(&fit.values);
    for (i, test) in tests.iter().enumerate() {
        let [start, end] = range(std::slice::from_ref(test));
        let point = |k: i32| {
            let stretch = start + (end - start) * f64::from(k) / 200.0;
            (stretch, 1e-3 * test.mode.nominal_stress(material.as_ref(), stretch))
        };
        let series =
            chart.draw_series(LineSeries::new((0..=200).map(point), style)).map_err(plain)?;
        if i == 0 {
            let line = move |(x, y)| PathElement::new([(x, y), (x + fine(24), y)], style);
            series.label(format!("{}, R² {:.5}", fit.candidate.name, fit.quality.r2)).legend(line);
        }
    }
    Ok(())
}

/// A circle for uniaxial tests, a larger and a smaller one for the others.
fn marker(mode: Mode) -> Circle<(i32, i32), i32> {
    let size = match mode {
        Mode::Uniaxial => 3,
        Mode::Biaxial => 5,
        Mode::Planar => 2,
    };
    Circle::new((0, 0), fine(size), BLACK.mix(0.6).stroke_width(fine(1)))
}

/// Pixels of the canvas.
fn fine<T: std::ops::Mul<Output = T> + From<u8>>(pixels: T) -> T {
    pixels * T::from(FINE)
}

/// The library's errors borrow the backend; their text does not.
fn plain(error: impl Display) -> anyhow::Error {
    anyhow!("{error}")
}
