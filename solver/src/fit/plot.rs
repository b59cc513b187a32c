//! Measured points and fitted curves as a picture.

use std::path::Path;

use anyhow::Result;
use mechanics::material::response::Mode;

use super::{Fitted, Test, range};
use crate::plot::{Axes, Series, Style};

/// Points drawn of one test: more only blacken the picture.
const DRAWN: usize = 80;

/// Draws tests and fits over the range of the data; the chosen fit is drawn
/// thick.
pub fn draw(path: &Path, tests: &[Test], fits: &[Fitted], chosen: &Fitted) -> Result<()> {
    let axes = Axes {
        x: "stretch along the pull [1]".to_owned(),
        y: "nominal stress [kPa]".to_owned(),
        log_x: false,
        log_y: false,
    };
    let mut series: Vec<Series> = tests.iter().map(points).collect();
    for (turn, fit) in fits.iter().enumerate() {
        let width = if std::ptr::eq(fit, chosen) { 4 } else { 2 };
        for (i, test) in tests.iter().enumerate() {
            let label = format!("{}, R² {:.5}", fit.candidate.name, fit.quality.r2);
            series.push(Series {
                label: (i == 0).then_some(label),
                points: curve(test, fit),
                style: Style::Line(width),
                turn,
            });
        }
    }
    crate::plot::draw(path, &axes, &series)
}

fn points(test: &Test) -> Series {
    let size = match test.mode {
        Mode::Uniaxial => 3,
        Mode::Biaxial => 5,
        Mode::Planar => 2,
    };
    let drawn = test.points.iter().step_by(test.points.len().div_ceil(DRAWN));
    Series {
        label: Some(format!("{} test", test.mode.name())),
        points: drawn.map(|p| (p.0, 1e-3 * p.1)).collect(),
        style: Style::Circles(size),
        turn: 0,
    }
}

fn curve(test: &Test, fit: &Fitted) -> Vec<(f64, f64)> {
    let material = (fit.law().build)(&fit.values);
    let [start, end] = range(std::slice::from_ref(test));
    let point = |k: i32| {
        let stretch = start + (end - start) * f64::from(k) / 200.0;
        (stretch, 1e-3 * test.mode.nominal_stress(material.as_ref(), stretch))
    };
    (0..=200).map(point).collect()
}
