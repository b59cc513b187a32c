//! How cost grows with size: power laws.

use std::path::Path;

use anyhow::Result;
use solver::plot::{Axes, Series, Style, draw};

use crate::solves::Solve;

/// One measure over the sizes.
pub struct Curve {
    /// What is measured.
    pub what: &'static str,
    /// In which unit.
    pub unit: &'static str,
    /// Size and measure.
    pub points: Vec<(f64, f64)>,
}

/// y = c n^e by least squares in logarithms: (c, e).
fn power_law(points: &[(f64, f64)]) -> (f64, f64) {
    let logs: Vec<(f64, f64)> = points.iter().map(|p| (p.0.ln(), p.1.ln())).collect();
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let exponent = mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x).powi(2));
    ((y - exponent * x).exp(), exponent)
}

/// Cost of the bars over their degrees of freedom.
pub fn of_bars(solves: &[Solve]) -> Vec<Curve> {
    let measure = |what, unit, f: &dyn Fn(&Solve) -> f64| {
        let points = solves.iter().map(|s| (s.dofs as f64, f(s))).collect();
        Curve { what, unit, points }
    };
    vec![
        measure("whole solve", "s", &Solve::total_s),
        measure("set-up", "s", &|s| s.setup_s),
        measure("gradient and Hessian", "s", &|s| s.assembly_once_s),
        measure("factorisation", "s", &|s| s.factor_once_s),
        measure("peak memory", "GB", &|s| s.peak_mb * 1.048_576e-3),
        measure("entries of the factor", "M", &|s| 1e-6 * s.factor_len as f64),
        measure("operations", "GFlop", &|s| 1e-9 * s.factor_flops),
    ]
}

/// The fits as lines of text, and as a picture; none for fewer than three sizes.
/// `bodies` are of a `size` in words.
pub fn report(
    bodies: &str,
    size: &str,
    curves: Vec<Curve>,
    picture: &Path,
) -> Result<Option<String>> {
    let sizes = || curves.iter().flat_map(|c| c.points.iter().map(|p| p.0));
    if curves.iter().any(|c| c.points.len() < 3) {
        return Ok(None);
    }
    let (first, last) = (sizes().fold(f64::INFINITY, f64::min), sizes().fold(0.0, f64::max));
    let mut text = format!("cost of the {bodies} from {first} to {last} {size} n:\n");
    let mut series = Vec::new();
    for (turn, curve) in curves.into_iter().enumerate() {
        let (c, exponent) = power_law(&curve.points);
        let at_100k = c * 1e5_f64.powf(exponent);
        let Curve { what, unit, points } = curve;
        text += &format!("  {what:<22} {at_100k:9.3} {unit} (n / 100 000)^{exponent:.2}\n");
        let fitted = points.iter().map(|p| (p.0, c * p.0.powf(exponent))).collect();
        // what follows from the mesh alone is no measurement
        if ["M", "GFlop"].contains(&unit) {
            continue;
        }
        let label = Some(format!("{what} [{unit}], n^{exponent:.2}"));
        series.push(Series { label, points: fitted, style: Style::Line(2), turn });
        series.push(Series { label: None, points, style: Style::Circles(4), turn });
    }
    let axes = Axes {
        x: format!("{size} n"),
        y: "time [s], memory [GB]".to_owned(),
        log_x: true,
        log_y: true,
    };
    draw(picture, &axes, &series)?;
    text += &format!("  picture: {}\n", picture.display());
    Ok(Some(text))
}
