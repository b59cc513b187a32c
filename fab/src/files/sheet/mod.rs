//! `cast.json`: what to weigh for a mold, and what to do in which order.
//!
//! A mold of volume V is filled with V (1 + w) of silicone, w the share that stays in
//! the cup; its mass is that times the density, and is divided by the mix ratio.

mod steps;

use std::path::Path;

use anyhow::Result;
use geometry::overhang::needs_supports;
use library::{Chemistry, Printer, PrinterKind, Silicone, kilopascals};
use program::write_json;
use serde::Serialize;

use crate::body::weight::Weight;
use crate::files::report::MoldReport;

/// Its file, beside mold.json.
pub const FILE: &str = "cast.json";

/// Everything a person needs to cast a body.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Sheet {
    /// Program and version.
    pub program: String,
    /// The silicone, if one was named.
    pub silicone: Option<Pour>,
    /// The body [mL].
    pub body_ml: f64,
    /// What the casting weighs when it is finished, if the density of its silicone is known.
    pub weight: Option<Weight>,
    /// What is cast already and lies in the mold [mL].
    pub inside_ml: f64,
    /// The body with sprue and vents, less what lies in the mold [mL].
    pub mold_ml: f64,
    /// What stays in the cup, as a share of `mold_ml` [1].
    pub waste: f64,
    /// What to mix [mL].
    pub mix_ml: f64,
    /// What to print.
    pub printed: Vec<Printed>,
    /// The plastic of all parts when printed solid [g].
    pub plastic_g: f64,
    /// What else to have, and how many.
    pub materials: Vec<Item>,
    /// Gauge pressure of the leak test [kPa], if one was set.
    pub leak_test_kpa: Option<f64>,
    /// What can go wrong.
    pub warnings: Vec<String>,
    /// What to do, in order.
    pub steps: Vec<String>,
    /// What to do once the whole body is there, where the casting is a part of it: tubes and the leak test.
    pub finish: Vec<String>,
    /// Where the numbers come from.
    pub sources: Vec<String>,
}

/// A silicone by weight and time.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pour {
    /// Name on the bottle.
    pub name: String,
    /// Who sells it.
    pub vendor: String,
    /// Parts by weight, if known.
    pub mix: Option<String>,
    /// What to mix [g], if the density is known.
    pub mass_g: Option<f64>,
    /// Masses of parts A and B [g], if density and mix are known.
    pub parts_g: Option<[f64; 2]>,
    /// Time to pour after mixing [min], if known.
    pub pot_life_min: Option<f64>,
    /// Time to demold at 23 °C [h], if known.
    pub cure_h: Option<f64>,
    /// Shear modulus that simulations take by default [kPa].
    pub shear_modulus_kpa: f64,
    /// Smallest and largest shear modulus of all sources [kPa].
    pub shear_modulus_range_kpa: [f64; 2],
}

/// A part to print.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Printed {
    /// The name.
    pub name: String,
    /// The file.
    pub file: String,
    /// The volume [mL].
    pub volume_ml: f64,
    /// The mass when printed solid [g].
    pub mass_g: f64,
    /// Whether it hangs over so that it needs supports.
    pub supports: bool,
}

/// Something to have.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Item {
    /// How many.
    pub count: usize,
    /// What.
    pub what: String,
}

/// Cubic millimetres per millilitre.
const MM3: f64 = 1e3;

impl Sheet {
    /// The sheet of a mold.
    pub fn new(report: &MoldReport) -> Self {
        let casting = &report.casting;
        let (silicone, printer) = (casting.silicone(), casting.printer());
        let (plastic, density) = printer.map_or(PrinterKind::Filament, |p| p.kind).plastic();
        let mold_ml = report.cast.silicone_ml;
        let mix_ml = mold_ml * (1.0 + casting.waste);
        let printed: Vec<Printed> = report
            .parts
            .iter()
            .map(|part| Printed {
                name: part.name.clone(),
                file: part.file.clone(),
                volume_ml: part.volume / MM3,
                mass_g: part.volume / MM3 * density * 1e-3,
                supports: needs_supports(part.overhang),
            })
            .collect();
        let silicone_sources = silicone.and_then(Silicone::citation).map(str::to_owned);
        let mut sheet = Self {
            program: report.program.clone(),
            silicone: silicone.map(|s| Pour::new(s, mix_ml)),
            body_ml: report.cast.volume / MM3,
            weight: report.cast.weight,
            inside_ml: report.cast.inside_ml,
            mold_ml,
            waste: casting.waste,
            mix_ml,
            plastic_g: printed.iter().map(|part| part.mass_g).sum(),
            printed,
            materials: Vec::new(),
            leak_test_kpa: casting.leak_test.map(|pressure| pressure * 1e-3),
            warnings: warnings(report, silicone, printer),
            steps: Vec::new(),
            finish: Vec::new(),
            sources: silicone_sources
                .into_iter()
                .chain(printer.map(|p| p.citation().into()))
                .chain(report.collars.first().map(|collar| collar.source.clone()))
                .collect(),
        };
        sheet.materials = steps::materials(&sheet, report, plastic);
        sheet.steps = steps::steps(&sheet, report);
        if steps::is_half(report) && !report.chambers.is_empty() {
            sheet.finish = steps::finish(sheet.leak_test_kpa, report);
        }
        sheet
    }

    /// Writes it into `folder`.
    pub fn write(&self, folder: &Path) -> Result<()> {
        write_json(&folder.join(FILE), self)
    }

    /// What to pour, in rows of a word and a value.
    pub fn rows(&self) -> Vec<(&str, String)> {
        let mut rows = Vec::new();
        if let Some(pour) = &self.silicone {
            rows.push(("silicone", format!("{}, {}", pour.name, pour.vendor)));
        }
        rows.push(("body", format!("{:.2} mL", self.body_ml)));
        if self.inside_ml > 0.0 {
            rows.push(("… cast before, in the mold", format!("{:.2} mL", self.inside_ml)));
        }
        let poured = if self.inside_ml > 0.0 {
            "left, with sprue and vents"
        } else {
            "with sprue and vents"
        };
        rows.push((poured, format!("{:.2} mL", self.mold_ml)));
        rows.push((
            "to mix",
            format!("{:.1} mL, {:.0} % of it for the cup", self.mix_ml, 100.0 * self.waste),
        ));
        let Some(pour) = &self.silicone else { return rows };
        let [low, high] = pour.shear_modulus_range_kpa.map(|m| kilopascals(1e3 * m));
        let spread = if low == high {
            "one source".into()
        } else {
            format!("sources give {low} to {high} kPa")
        };
        let default = kilopascals(1e3 * pour.shear_modulus_kpa);
        rows.push(("shear modulus", format!("{default} kPa; {spread}")));
        if let (Some(mass), Some([a, b]), Some(mix)) = (pour.mass_g, pour.parts_g, &pour.mix) {
            rows.push(("mass", format!("{mass:.1} g")));
            rows.push(("part A", format!("{a:.1} g")));
            rows.push(("part B", format!("{b:.1} g, {mix} by weight")));
        }
        rows.extend(self.weight.map(|weight| ("finished cast", weight.in_words())));
        rows.extend(pour.pot_life_min.map(|t| ("pot life", format!("{t} min"))));
        rows.extend(pour.cure_h.map(|t| ("demold after", format!("{t} h at 23 °C"))));
        rows
    }
}

impl Pour {
    /// What the spread of moduli means for the pressure.
    ///
    /// In equilibrium the elastic energy U and the volume V of the chamber balance: δU = p δV.
    /// U is in proportion to the moduli. With all of them s times as large, p is s times as
    /// large for the same shape, however large its strains; weight would not grow along.
    pub fn pressure_in_words(&self) -> String {
        let [low, high] = self.shear_modulus_range_kpa;
        let kpa = |modulus: f64| kilopascals(1e3 * modulus);
        let proportion = "Without weight, the same shape needs a pressure in proportion to the \
                          shear modulus. A pressure computed with";
        if low == high {
            return format!("{proportion} μ kPa has to be multiplied by {}/μ.", kpa(low));
        }
        let [least, most] = [low, high].map(|m| m / self.shear_modulus_kpa);
        format!(
            "{proportion} {} kPa has to be multiplied by a factor between {least:.2} and {most:.2}, \
             by what sources say of {}; one computed with μ kPa by a factor between {}/μ and {}/μ. \
             Begin with the lowest.",
            kpa(self.shear_modulus_kpa),
            self.name,
            kpa(low),
            kpa(high)
        )
    }

    fn new(silicone: &Silicone, volume_ml: f64) -> Self {
        // 1 kg/m³ is 10⁻³ g/mL.
        let mass_g = silicone.density.map(|density| volume_ml * density * 1e-3);
        let shares = silicone.shares();
        Self {
            name: silicone.name.clone(),
            vendor: silicone.vendor.clone(),
            mix: silicone.mix.clone(),
            mass_g,
            parts_g: mass_g.zip(shares).map(|(mass, shares)| shares.map(|share| share * mass)),
            pot_life_min: silicone.pot_life_min,
            cure_h: silicone.cure_h,
            shear_modulus_kpa: 1e-3 * silicone.fits[0].shear_modulus,
            shear_modulus_range_kpa: silicone.shear_moduli().map(|m| 1e-3 * m),
        }
    }
}

fn warnings(
    report: &MoldReport,
    silicone: Option<&Silicone>,
    printer: Option<&Printer>,
) -> Vec<String> {
    let mut warnings: Vec<String> =
        report.findings.iter().map(|note| format!("{}: {}", note.rule, note.message)).collect();
    match silicone {
        None => warnings.push(
            "No silicone is named: no masses and times. Set `casting.silicone` in mold.toml."
                .into(),
        ),
        Some(s) if s.density.is_none() || s.casting.is_none() => warnings.push(format!(
            "Not all that casting {} needs is known here: read the bulletin of {}.",
            s.name, s.vendor
        )),
        Some(_) => {}
    }
    let platinum = silicone
        .and_then(|s| s.casting.as_ref())
        .is_none_or(|facts| facts.chemistry == Chemistry::Platinum);
    if platinum && printer.is_some_and(|p| p.kind == PrinterKind::Resin) {
        warnings.push(
            "Uncured resin inhibits platinum-cured silicone: it stays sticky on the mold. Wash \
             the parts twice, cure them fully with light and warmth, seal them with clear acrylic \
             lacquer, and cast a test patch on each first."
                .into(),
        );
    }
    if platinum {
        warnings.push("No latex gloves, sulphur or tin near platinum-cured silicone.".into());
    }
    warnings
}
