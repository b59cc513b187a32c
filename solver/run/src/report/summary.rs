//! What a run found, in a few words, from the report of a run.
//!
//! Lengths are told in mm, volumes in mL, pressures in kPa; reports have them in SI.

use std::collections::BTreeMap;

use reports::{DesignedProbe, End, Inflated, Inflation, Kept, StretchRange};

/// Units of reports that people read better in another: factor and its name.
const READABLE: &[(&str, f64, &str)] =
    &[("m", 1e3, "mm"), ("m³", 1e6, "mL"), ("Pa", 1e-3, "kPa"), ("deg", 1.0, "°")];

/// The inflation that is told beside the first.
const TENTH: usize = 10;

/// How far the body moves, how far it is stretched, each chamber and each probe.
pub fn in_words(found: &End) -> String {
    let mut parts = Vec::new();
    let moved = found.tags.values().map(|tag| tag.max_displacement);
    if let Some(largest) = moved.reduce(f64::max) {
        parts.push(format!("largest displacement {}", quantity(largest, "m")));
    }
    parts.push(stretch(&found.stretch_range));
    for (name, chamber) in &found.chambers {
        let at = [quantity(chamber.volume, "m³"), quantity(chamber.pressure, "Pa")].join(" at ");
        parts.push(format!("{name} {at}"));
    }
    for (name, probe) in found.probes.iter().flatten() {
        parts.push(format!("{name} {}", quantity(probe.value.unwrap_or(f64::NAN), &probe.unit)));
    }
    parts.join(", ")
}

/// What a constraint that holds a design back is worth: what the objective would fall by with a tenth less or more.
pub fn of_constraint(name: &str, kept: &Kept) -> Option<String> {
    let Kept { unit, least, most, found, worth } = kept;
    let (side, bound, way) = match (least, most) {
        (Some(least), _) => ("least", *least, "less"),
        (None, Some(most)) => ("most", *most, "more"),
        (None, None) => return None,
    };
    let fall = 0.1 * bound.abs() * worth;
    (fall > 0.0).then(|| {
        let found = found.map_or_else(String::new, |found| format!(" {found:.4e}"));
        format!(
            "\"{name}\"{found} of at {side} {bound:.4e} {unit} holds the design back: with a tenth {way} the objective \
             would be lower by about {fall:.2e}"
        )
    })
}

/// Each chamber's first inflation, and its tenth or, of fewer, the last: volume and probes at half of the
/// largest pressure on the way up, and there.
pub fn inflations(found: &End) -> Vec<String> {
    let all = found.inflations.as_deref().unwrap_or_default();
    let told = |inflation: &&Inflation| {
        let count = all.iter().filter(|other| other.chamber == inflation.chamber).count();
        [1, count.min(TENTH)].contains(&inflation.number)
    };
    let words = |inflation: &Inflation| {
        let Inflation { chamber, number, peak, halfway } = inflation;
        let states = halfway.iter().chain([peak]).map(|state| inflated(state, found));
        format!("inflation {number} of {chamber}: {}", states.collect::<Vec<_>>().join("; "))
    };
    all.iter().filter(told).map(words).collect()
}

fn inflated(state: &Inflated, found: &End) -> String {
    let Inflated { t, pressure, volume, probes } = state;
    let at = [quantity(*volume, "m³"), quantity(*pressure, "Pa")].join(" at ");
    let mut text = format!("t = {t:.4} s {at}");
    for (name, value) in probes.iter().flatten() {
        let unit = found.probes.iter().flatten().find(|(probe, _)| *probe == name);
        let unit = unit.map_or("", |(_, probe)| &probe.unit);
        text += &format!(", {name} {}", quantity(value.unwrap_or(f64::NAN), unit));
    }
    text
}

/// The largest principal stretch, beside that at which the silicone tears, and its place at rest.
fn stretch(range: &StretchRange) -> String {
    let mut text = format!("largest stretch {:.2}", range.largest);
    if let Some(at_break) = range.at_break {
        text += &format!(" of {at_break:.1} at break");
    }
    let [x, y, z] = range.largest_at.map(|x| x * 1e3);
    text + &format!(" at ({x:.1}, {y:.1}, {z:.1}) mm")
}

/// What a design came to: each probe before and after, with what was wanted, and the part `fall` by
/// which the objective fell where no number was wanted.
pub fn of_design(probes: Option<&BTreeMap<String, DesignedProbe>>, fall: f64) -> String {
    let mut parts = Vec::new();
    let mut is_wanted = false;
    for (name, DesignedProbe { unit, before, after, wanted }) in probes.into_iter().flatten() {
        let (Some(before), Some(after)) = (before, after) else { continue };
        let number = |value: f64| quantity(value, unit);
        let wanted = wanted.map(|wanted| format!(" (wanted {})", number(wanted)));
        is_wanted |= wanted.is_some();
        let (before, after) = (number(*before), number(*after));
        parts.push(format!("{name} {before} → {after}{}", wanted.unwrap_or_default()));
    }
    if !is_wanted {
        parts.push(format!("the objective fell by {:.1} %", 100.0 * fall));
    }
    parts.join(", ")
}

/// A number with four digits and a unit that people read.
pub fn quantity(value: f64, unit: &str) -> String {
    let known = READABLE.iter().find(|row| row.0 == unit);
    let (value, unit) = known.map_or((value, unit), |(_, factor, name)| (value * factor, name));
    let digits = match value.abs() {
        0.0 => 0,
        size if !(1e-3..1e5).contains(&size) => return format!("{value:.3e} {unit}"),
        size => (3 - size.log10().floor() as i32).clamp(0, 6) as usize,
    };
    let gap = if unit == "°" { "" } else { " " };
    format!("{value:.digits$}{gap}{unit}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_design_is_told_by_its_quantities() {
        let probe = |before, after, wanted, unit: &str| DesignedProbe {
            unit: unit.to_owned(),
            before: Some(before),
            after: Some(after),
            wanted,
        };
        let mut probes = BTreeMap::from([
            ("bending".to_owned(), probe(37.3, 59.9, Some(60.0), "deg")),
            ("sag".to_owned(), probe(1e-3, 2e-3, None, "m")),
        ]);
        assert_eq!(
            of_design(Some(&probes), 0.5),
            "bending 37.30° → 59.90° (wanted 60.00°), sag 1.000 mm → 2.000 mm"
        );
        probes.remove("bending");
        assert_eq!(
            of_design(Some(&probes), 0.5),
            "sag 1.000 mm → 2.000 mm, the objective fell by 50.0 %"
        );
        assert_eq!(of_design(None, 0.5), "the objective fell by 50.0 %");
    }

    #[test]
    fn a_run_is_told_in_units_that_people_read() {
        let still = json!({"area": 1.0, "reaction": [0.0, 0.0, 0.0], "mean_displacement": 0.0,
            "mean_displacement_vector": [0.0, 0.0, 0.0], "max_displacement": 0.0});
        let (mut skin, none) = (still.clone(), json!({"wall_s": 0.0, "processor_s": 0.0}));
        skin["max_displacement"] = json!(6.1234e-3);
        let report = json!({
            "tags": {"seat": still, "skin": skin},
            "stretch_range": {"largest": 1.314, "at_break": 10.0, "largest_at": [1e-3, 0.0, -2.55e-2],
                "smallest": 1.0, "volume_beyond": 0.0},
            "chambers": {"cavity": {"volume": 1.45e-6, "pressure": 12e3, "volume_rest": 1e-6, "closed": true}},
            "probes": {"bend": {"kind": "gap", "value": -0.51e-3, "unit": "m"},
                "tip": {"kind": "angle", "value": 59.9, "unit": "deg"}},
            "tolerance_met": true, "newton_iterations": 1, "energies": {},
            "energy_balance": {"work_of_loads": 0.0, "elastic": 0.0},
            "force_balance": {"out_of_balance": 0.0}, "equilibrium_s": 1.0, "wall_s": 1.0,
            "timings": {"ordering": none, "assembly": none, "contact": none, "factor": none, "solve": none,
                "collision": none, "certificate": none, "output": none, "factorizations": 1,
                "failed_factorizations": 0, "predicted_s": 1.0},
        });
        let report: End = serde_json::from_value(report).expect("a report");
        assert_eq!(
            in_words(&report),
            "largest displacement 6.123 mm, largest stretch 1.31 of 10.0 at break at (1.0, 0.0, -25.5) mm, \
             cavity 1.450 mL at 12.00 kPa, bend -0.5100 mm, tip 59.90°"
        );
        assert_eq!(quantity(2.5e-7, "N"), "2.500e-7 N");
        assert_eq!(quantity(0.0, "N"), "0 N");
    }
}
