//! Measured points and fitted curves as a picture.

use std::fmt::Display;
use std::path::Path;

use anyhow::{Result, anyhow};
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

/// Points drawn of one test: more only blacken the picture.
const DRAWN: usize = 80;

/// Draws tests and fits, over the range of the data, as SVG.
///
/// # Errors
/// When the file cannot be written.
pub fn draw(path: &Path, tests: &[Test], fits: &[Fitted]) -> Result<()> {
    let mut text = String::new();
    chart(&mut text, tests, fits).map_err(|e| anyhow!("{}: {e}", path.display()))?;
    mesh::io::write_atomic(path, |out| out.write_all(text.as_bytes()))?;
    Ok(())
}

fn chart(text: &mut String, tests: &[Test], fits: &[Fitted]) -> Result<()> {
    let [left, right] = range(tests).map(|s| s.min(1e3));
    let stresses = || tests.iter().flat_map(|t| t.points.iter().map(|p| 1e-3 * p.1));
    let (low, high) = (stresses().fold(0.0, f64::min), stresses().fold(0.0, f64::max));
    let room = 0.06 * (high - low);
    let canvas = SVGBackend::with_string(text, (900, 600)).into_drawing_area();
    canvas.fill(&WHITE).map_err(plain)?;
    let mut chart = ChartBuilder::on(&canvas)
        .margin(15)
        .x_label_area_size(50)
        .y_label_area_size(80)
        .build_cartesian_2d(left.min(1.0)..right.max(1.0), low - room..high + room)
        .map_err(plain)?;
    chart
        .configure_mesh()
        .light_line_style(WHITE)
        .bold_line_style(BLACK.mix(0.12))
        .x_desc("stretch along the pull [1]")
        .y_desc("nominal stress [kPa]")
        .axis_desc_style(("sans-serif", 20))
        .label_style(("sans-serif", 16))
        .draw()
        .map_err(plain)?;
    for test in tests {
        let every = test.points.len().div_ceil(DRAWN);
        let points: Vec<_> = test.points.iter().step_by(every).map(|p| (p.0, 1e-3 * p.1)).collect();
        let mode = test.mode;
        chart
            .draw_series(points.into_iter().map(|p| EmptyElement::at(p) + marker(mode)))
            .map_err(plain)?
            .label(format!("{} test", mode.name()))
            .legend(move |(x, y)| EmptyElement::at((x + 12, y)) + marker(mode));
    }
    for (fit, color) in fits.iter().zip(COLORS.iter().cycle()) {
        let material = (fit.law().build)(&fit.values);
        for (i, test) in tests.iter().enumerate() {
            let own = range(std::slice::from_ref(test));
            let at = |k: i32| own[0] + (own[1] - own[0]) * f64::from(k) / 200.0;
            let stress = |s: f64| 1e-3 * test.mode.nominal_stress(material.as_ref(), s);
            let curve =
                LineSeries::new((0..=200).map(|k| (at(k), stress(at(k)))), color.stroke_width(2));
            let series = chart.draw_series(curve).map_err(plain)?;
            if i == 0 {
                let color = *color;
                series.label(format!("{}, R² {:.5}", fit.candidate.name, fit.quality.r2)).legend(
                    move |(x, y)| PathElement::new([(x, y), (x + 24, y)], color.stroke_width(2)),
                );
            }
        }
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::UpperLeft)
        .legend_area_size(34)
        .background_style(WHITE.mix(0.9))
        .border_style(BLACK.mix(0.3))
        .label_font(("sans-serif", 17))
        .draw()
        .map_err(plain)?;
    canvas.present().map_err(plain)
}

/// A circle for uniaxial tests; larger and smaller ones for the others.
fn marker(mode: Mode) -> Circle<(i32, i32), i32> {
    let size = match mode {
        Mode::Uniaxial => 3,
        Mode::Biaxial => 5,
        Mode::Planar => 2,
    };
    Circle::new((0, 0), size, BLACK.mix(0.6).stroke_width(1))
}

/// The library's errors borrow the backend; their text does not.
fn plain(error: impl Display) -> anyhow::Error {
    anyhow!("{error}")
}
