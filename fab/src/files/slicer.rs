//! `<part>.ini`: how PrusaSlicer is to slice a part for the named printer.
//!
//! Keys and their meaning: `prusa-slicer --help-fff`. Here are only those that follow from
//! the part and from `printers.toml`; temperatures, speeds and start code are those of the
//! printer's own profile, which is loaded before.

use std::path::Path;

use geometry::overhang::needs_supports;
use library::{Printer, PrinterKind};
use mesh::io::{IoError, write_atomic};

use crate::files::report::{MoldReport, Part, Role};

/// Lines along every outline: what makes a wall tight.
const PERIMETERS: usize = 3;

/// Share of the inside that is printed [%].
const INFILL: usize = 20;

/// Width of a brim [mm].
const BRIM: f64 = 5.0;

/// A part this many times as high as a square of its area on the bed is wide gets a brim.
const TALL: f64 = 3.0;

/// The file of a part, beside its STL file.
pub fn file(part: &Part) -> String {
    format!("{}.ini", part.name)
}

/// The settings of a part; none without a named filament printer.
pub fn settings(report: &MoldReport, part: &Part) -> Option<String> {
    let printer = report.casting.printer()?;
    (printer.kind == PrinterKind::Filament).then(|| text(printer, report, part))
}

/// Writes the settings of all parts that have some.
pub fn write(folder: &Path, report: &MoldReport) -> Result<(), IoError> {
    report.parts.iter().try_for_each(|part| match settings(report, part) {
        Some(text) => write_atomic(&folder.join(file(part)), |out| out.write_all(text.as_bytes())),
        None => Ok(()),
    })
}

fn text(printer: &Printer, report: &MoldReport, part: &Part) -> String {
    let shell = part.role == Role::Shell;
    let (plastic, density) = match report.method.core.filament.filter(|_| !shell) {
        Some(filament) => (filament.name, filament.density),
        None => (printer.kind.plastic().0, printer.kind.plastic().1 * 1e-3),
    };
    let layer = (printer.nozzle / 2.0).clamp(printer.layer[0], printer.layer[1]);
    let supports = needs_supports(part.overhang);
    let brim = if part.height > TALL * part.bed.sqrt() { BRIM } else { 0.0 };
    let mut lines = vec![format!("# {} of {}, by {}", part.name, printer.name, report.program)];
    let mut set = |key: &str, value: String| lines.push(format!("{key} = {value}"));
    if let Some([x, y, z]) = printer.volume {
        set("bed_shape", format!("0x0,{x}x0,{x}x{y},0x{y}"));
        set("max_print_height", z.to_string());
    }
    set("nozzle_diameter", printer.nozzle.to_string());
    set("filament_diameter", "1.75".into());
    set("filament_type", plastic.into());
    set("filament_density", density.to_string());
    set("layer_height", layer.to_string());
    set("first_layer_height", layer.to_string());
    // Lines of even width: Arachne's Voronoi diagrams stumble over edges of micrometres.
    set("perimeter_generator", "classic".into());
    set("perimeters", PERIMETERS.to_string());
    set("thin_walls", "1".into());
    set("fill_density", format!("{INFILL}%"));
    set("fill_pattern", "gyroid".into());
    set("brim_width", brim.to_string());
    set("support_material", u8::from(supports).to_string());
    set("support_material_auto", "1".into());
    // The slicer counts from the horizontal.
    set("support_material_threshold", (90.0 - printer.overhang).to_string());
    // On a shell they stand on the bed only, not on what shapes the silicone.
    set("support_material_buildplate_only", u8::from(shell).to_string());
    lines.join("\n") + "\n"
}
