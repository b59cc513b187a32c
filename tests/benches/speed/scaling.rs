//! How cost grows with size: power laws through the bars.

use std::path::Path;

use anyhow::Result;
use solver::plot::{Axes, Series, Style, draw};

use crate::solves::Solve;

/// One measure over the sizes.
struct Curve {
    what: &'static str,
    unit: &'static str,
    points: Vec<(f64, f64)>,
}

/// y = c n^e by least squares in logarithms: (c, e).
fn power_law(points: &[(f64, f64)]) -> (f64, f64) {
    let logs: Vec<(f64, f64)> = points.iter().map(|p| (p.0.ln(), p.1.ln())).collect();
    let mean = |f: &dyn Fn(&(f64, f64)) -> f64| logs.iter().map(f).sum::<f64>() / logs.len() as f64;
    let (x, y) = (mean(&|p| p.0), mean(&|p| p.1));
    let exponent = mean(&|p| (p.0 - x) * (p.1 - y)) / mean(&|p| (p.0 - x).powi(2));
    ((y - exponent * x).exp(), exponent)
}

fn curves(solves: &[Solve]) -> Vec<Curve> {
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
pub fn report(solves: &[Solve], picture: &Path) -> Result<Option<String>> {
    if solves.len() < 3 {
        return Ok(None);
    }
    let (first, last) = (solves[0].dofs, solves[solves.len() - 1].dofs);
    let mut text = format!("cost of the bars from {first} to {last} degrees of freedom n:\n");
    let mut series = Vec::new();
    for (turn, curve) in curves(solves).into_iter().enumerate() {
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
        x: "degrees of freedom n".to_owned(),
        y: "time [s], memory [GB]".to_owned(),
        log_x: true,
        log_y: true,
    };
    draw(picture, &axes, &series)?;
    text += &format!("  picture: {}\n", picture.display());
    Ok(Some(text))
}
