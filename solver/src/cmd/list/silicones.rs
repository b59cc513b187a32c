//! Silicones and printed elastomers of the library with all their sources.

use library::{PrinterKind, kilopascals};
use mechanics::material::Parameter;
use scene::silicone::{Fit, Silicone};

use super::{joined, wrapped};

/// All silicones; then the sources, once each.
pub fn text(all: &[Silicone]) -> String {
    let mut sources: Vec<_> =
        all.iter().flat_map(|s| &s.fits).map(|fit| (&fit.entry.source, fit.source())).collect();
    sources.sort_unstable_by_key(|(key, _)| *key);
    sources.dedup_by_key(|(key, _)| *key);
    let source = |(key, source): &(&String, &library::Source)| {
        wrapped(&format!("{key}: "), &format!("{} [{}]", source.citation, source.licence))
    };
    let sources: String = sources.iter().map(source).collect();
    joined(all, one) + "\nsources\n" + &sources
}

fn one(silicone: &Silicone) -> String {
    let entry = silicone.entry;
    let mut facts = vec![format!("{}, {}", entry.name, entry.vendor)];
    facts.extend(entry.printed.as_ref().map(|of| {
        let what = match of.process {
            PrinterKind::Filament => "filament",
            PrinterKind::Resin => "resin",
        };
        format!("{what}, Shore {}A", of.hardness)
    }));
    facts.extend(entry.density.map(|d| format!("{d} kg/m³")));
    facts.extend(entry.mix.as_ref().map(|m| format!("mix {m}")));
    facts.extend(entry.pot_life_min.map(|t| format!("pot life {t} min")));
    facts.extend(entry.cure_h.map(|t| format!("demold after {t} h")));
    let mut text = format!("{}\n  {}\n", silicone.key, facts.join("; "));
    if let Some(default) = silicone.fits.first() {
        text += &wrapped("", &entry.modulus_in_words(default.entry));
    }
    if let Some(library::Softening { source, creep, mullins }) = &entry.softening {
        let percent = |part: f64| format!("{:.0} %", 100.0 * part);
        let creep = creep.map(|c| format!("strain grows by {} while a load is held", percent(c)));
        let mullins = mullins.map(|m| format!("stress falls by {} once stretched", percent(m)));
        let words: Vec<_> = creep.into_iter().chain(mullins).collect();
        text += &wrapped("", &format!("{} ({source})", words.join(", ")));
    }
    let fits = silicone.fits.iter().map(|fit| row(silicone, fit));
    text + &fits.collect::<String>()
}

/// What to write after the name, the shear modulus and how it was found; the law.
fn row(silicone: &Silicone, fit: &Fit) -> String {
    let s = &fit.specification;
    let one = |(p, values): (&Parameter, Vec<f64>)| {
        let values: Vec<_> = values.iter().map(|v| format!("{v}")).collect();
        format!("{} {}", p.name, values.join(" "))
    };
    let parameters: Vec<_> = s.law.named(&s.values).into_iter().map(one).collect();
    let range = s
        .stretch_range
        .map_or("range unknown".to_owned(), |[low, high]| format!("stretch {low} to {high}"));
    let r2 = fit.entry.r2.map_or(String::new(), |r2| format!(", R² {r2}"));
    let stiffening = fit.entry.stiffening.as_ref();
    let stiffening = stiffening.map_or(String::new(), |key| format!(", stiffening of {key}"));
    format!(
        "    /{:20} {:>4} kPa  {}{stiffening}\n{:30}{}: {}; {range}{r2}\n",
        silicone.selector(fit),
        kilopascals(s.moduli().shear),
        fit.entry.test.words(),
        "",
        s.law.key,
        parameters.join(", "),
    )
}
