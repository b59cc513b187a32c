//! What to have and what to do, in words.

use std::collections::BTreeSet;

use geometry::MM;

use super::{Item, Pour, Sheet};
use crate::body::collar::FittedTube;
use crate::body::groove::Groove;
use crate::body::layer::LaidIn;
use crate::body::source::CastPart;
use crate::body::thread::Thread;
use crate::body::weight::Weight;
use crate::config::method::{Castings, Leaving};
use crate::files::report::{MoldReport, Outline, Role};
use crate::files::slicer;
use crate::mold::Purpose;

/// Radius of the hole for a bolt, and the bolt [mm].
const BOLTS: [(f64, &str); 4] = [(1.45, "M2.5"), (1.95, "M3"), (2.45, "M4"), (3.0, "M5")];

/// Bolts are sold in lengths that differ by this [mm]; a nut needs as much again.
const LENGTHS: f64 = 5.0;

/// Whether the casting is only a part of the body.
pub fn is_half(report: &MoldReport) -> bool {
    matches!(report.input.part, CastPart::Above(_) | CastPart::Below(_))
}

/// The bill of materials.
pub fn materials(sheet: &Sheet, report: &MoldReport, plastic: &str) -> Vec<Item> {
    let mut items: Vec<Item> = Vec::new();
    let mut add = |count, what: String| items.push(Item { count, what });
    add(1, format!("{:.0} g of {plastic}, if printed solid", sheet.plastic_g));
    for layer in &report.layers {
        let [width, depth] = layer.size();
        add(1, format!("{}, cut by `{}`: {width:.1} × {depth:.1} mm", layer.tag, layer.file()));
    }
    for thread in &report.threads {
        add(1, thread.item());
    }
    if let Some(filament) = report.method.core.filament {
        add(1, format!("{}, for the core", filament.item));
    }
    match &sheet.silicone {
        Some(Pour { name, mass_g: Some(mass), .. }) => add(1, format!("{mass:.0} g of {name}")),
        Some(Pour { name, .. }) => add(1, format!("{:.0} mL of {name}", sheet.mix_ml)),
        None => add(1, format!("{:.0} mL of silicone", sheet.mix_ml)),
    }
    add(1, "spray of release agent for silicone".into());
    add(1, "scale that shows 0.1 g, two cups, a stick, gloves".into());
    let bolts: Vec<String> = report.outlines(Purpose::Bolt).map(bolt).collect();
    let lengths: BTreeSet<&String> = bolts.iter().collect();
    for name in lengths {
        let count = bolts.iter().filter(|other| *other == name).count();
        add(count, format!("{name} with nut and washers"));
    }
    if bolts.is_empty() && !report.open {
        add(2, "clamps that span the closed mold, or strong rubber bands".into());
    }
    if let Some(collar) = report.collars.first() {
        add(report.collars.len(), collar.tube.clone());
    }
    let inlets = report.outlines(Purpose::Socket).count();
    if inlets > 0 && report.collars.is_empty() {
        add(inlets, "tube that fits the inlet, and silicone glue".into());
    }
    items
}

/// The bolt for a hole, as long as the hole and a nut.
fn bolt(hole: &Outline) -> String {
    let name = BOLTS.iter().find(|(radius, _)| hole.base_radius <= *radius);
    let length = mesh::Vec3::from(hole.axis).norm();
    let length = ((length / LENGTHS).ceil() + 1.0) * LENGTHS;
    match name {
        Some((_, name)) => format!("bolt {name} × {length:.0} mm"),
        None => format!("bolt of {:.1} mm × {length:.0} mm", 2.0 * hole.base_radius),
    }
}

/// What to do, in order.
pub fn steps(sheet: &Sheet, report: &MoldReport) -> Vec<String> {
    let shells = names(report, Role::Shell);
    let cores = names(report, Role::Core);
    let mut steps = vec![print(report)];
    steps.extend((!report.open).then(|| try_out(report, &cores)));
    if let Some(filament) = report.method.core.filament.filter(|_| !cores.is_empty()) {
        steps.push(format!("Print {} of {}.", and(&cores), filament.words));
    }
    steps.push(close(report, &shells, &cores));
    steps.extend(pour(sheet, report));
    steps.extend(open(sheet, report, &shells, &cores));
    if !report.open {
        steps.push("Cut off what stood in the sprue and the vents.".into());
    }
    steps.extend(sheet.weight.map(|weight| weigh(&weight)));
    steps.extend(report.groove.as_ref().map(Groove::in_words));
    steps.extend(report.threads.iter().map(Thread::in_words));
    if is_half(report) {
        steps.push(keep_clean(report).into());
        return steps;
    }
    if report.casting.first_shot {
        steps.push(into_second_mold(report, &cores));
        return steps;
    }
    if !report.chambers.is_empty() {
        steps.extend(finish(sheet.leak_test_kpa, report));
    }
    steps
}

/// What becomes of a casting that another one goes around.
fn into_second_mold(report: &MoldReport, cores: &[&str]) -> String {
    let inside =
        if cores.is_empty() { String::new() } else { format!(" with {} inside", and(cores)) };
    let pins = match report.holds.iter().any(|hold| !hold.lengths.is_empty()) {
        true => " Its pins go through the same holes.",
        false => "",
    };
    format!("Clean it with alcohol, and put it{inside} into the second mold.{pins}")
}

/// What the face is glued to where the casting is cut.
fn keep_clean(report: &MoldReport) -> &'static str {
    match (report.method.castings, &report.input.part) {
        (Castings::ChamberAndSheet, CastPart::Below(_)) => {
            "Keep the upper face of the sheet clean: the chamber is glued onto it, as the last steps say."
        }
        (Castings::ChamberAndSheet, _) => {
            "Keep the cut face clean: the sheet is glued to it, as the last steps say."
        }
        _ => "Keep the cut face clean: the other half is glued to it, as the last steps say.",
    }
}

/// What a scale says of the walls.
fn weigh(weight: &Weight) -> String {
    let less = match weight.per_tenth > 0.0 {
        true => {
            " Much less means walls that are thinner than designed, or air; much more, walls that are thicker."
        }
        false => " Much less means air inside.",
    };
    format!("Weigh the finished cast: it should be {}.{less}", weight.in_words())
}

/// What is left to do once the body is whole: tubes and the leak test.
pub fn finish(leak_test_kpa: Option<f64>, report: &MoldReport) -> Vec<String> {
    let mut steps = Vec::new();
    match &report.collars[..] {
        [] if report.chambers.len() > 1 => {
            steps.push(
                "Glue a tube into each inlet, and write the number of its chamber on it.".into(),
            );
        }
        [] => steps.push("Glue the tube into the inlet.".into()),
        [collar, ..] => steps.push(insert(collar, report)),
    }
    let pressure = leak_test_kpa;
    let pressure = pressure.map_or("its working pressure".into(), |p| format!("{p:.1} kPa"));
    let (each, others) = match report.chambers.len() {
        1 => ("", ""),
        _ => (
            ", one chamber after the other",
            ", and no other chamber may fill: hold the ends of their tubes under water, too",
        ),
    };
    steps.push(format!(
        "Hold it under water at {pressure} for a minute{each}: no bubble may rise{others}."
    ));
    steps
}

/// The mold is put together before it is needed, and whether that can be done wrong.
fn try_out(report: &MoldReport, cores: &[&str]) -> String {
    let once = "Put the mold together once while it is empty; ";
    let ways = match (report.one_way, cores.len()) {
        (true, 0 | 1) => "it fits one way only.",
        (true, _) => {
            "its cores can be mixed up: mark how they stand in exploded.png with a pen on cores and sockets."
        }
        (false, 1) => {
            "its core can be turned in its socket: mark how it stands in assembled.png with a pen on both."
        }
        (false, _) => {
            "its cores can be mixed up or turned in their sockets: mark how they stand in exploded.png with a pen \
             on cores and sockets."
        }
    };
    once.to_owned() + ways
}

/// Which core goes where.
fn put(cores: &[&str], report: &MoldReport) -> String {
    if let [core] = cores {
        let on = if report.cast.inside_ml > 0.0 { ", with what was cast on it," } else { "" };
        return format!(", put {core}{on} into its socket");
    }
    let chamber = |k: usize| match report.chambers.get(k).map_or("", String::as_str) {
        "" => String::new(),
        tag => format!(" for `{tag}`"),
    };
    let each = cores.iter().enumerate();
    let each: Vec<String> =
        each.map(|(k, core)| format!("{core}{} into socket {}", chamber(k), k + 1)).collect();
    let each: Vec<&str> = each.iter().map(String::as_str).collect();
    format!(", put {}", and(&each))
}

fn print(report: &MoldReport) -> String {
    let settings = report.parts.iter().any(|part| slicer::settings(report, part).is_some());
    let slice = match settings {
        true => " Load the printer's profile into PrusaSlicer and the part's .ini after it.",
        false => "",
    };
    format!(
        "Print the parts as they lie in their files, with supports where the table says so, \
         below shells from the bed only.{slice} Sand what touches the silicone until it is smooth."
    )
}

fn names(report: &MoldReport, role: Role) -> Vec<&str> {
    report.parts.iter().filter(|p| p.role == role).map(|p| p.name.as_str()).collect()
}

fn and(names: &[&str]) -> String {
    match names {
        [] => "nothing".into(),
        [one] => (*one).into(),
        [first @ .., last] => format!("{} and {last}", first.join(", ")),
    }
}

fn close(report: &MoldReport, shells: &[&str], cores: &[&str]) -> String {
    let all: Vec<&str> = shells.iter().chain(cores).copied().collect();
    let spray = format!("Spray {} with release agent and let it dry. ", and(&all));
    let (holder, others) = shells.split_last().map_or(("", &[][..]), |(h, o)| (*h, o));
    let mut words = format!("Stand {holder} on the table");
    if !cores.is_empty() {
        words += &put(cores, report);
    }
    if !others.is_empty() {
        let fix = if report.outlines(Purpose::Bolt).next().is_some() { "bolt" } else { "clamp" };
        words += &format!(", add {}, and {fix} them", and(others));
    }
    spray + &words + "."
}

/// How a tube is put into its collar.
fn insert(collar: &FittedTube, report: &MoldReport) -> String {
    let FittedTube { tube, outer, bore, length, .. } = collar;
    // What shrinks does so with its bore.
    let shrinks = report.scale() / MM;
    let bore = 2.0 * bore / shrinks;
    let each = match report.collars.len() {
        1 => "",
        _ => "For each chamber, and with its number on the tube: ",
    };
    format!(
        "{each}Cut the {tube} straight, wet it with alcohol and push it {:.0} mm into the collar, to the inlet and no \
         farther: the bore of {bore:.2} mm grips it, being {:.0} % narrower. Tie a thread twice around \
         the collar; glue it with silicone if it must not come out.",
        length / shrinks,
        100.0 * (1.0 - bore / outer)
    )
}

/// Mixing, pouring and curing.
fn pour(sheet: &Sheet, report: &MoldReport) -> Vec<String> {
    let vents = report.outlines(Purpose::Vent).count();
    let pour = match vents {
        _ if !report.layers.is_empty() => lay_in(sheet, report),
        _ if report.open => {
            "Pour a thin stream into one corner, up to the brim, and level it.".into()
        }
        0 => "Pour a thin stream into the sprue, slowly, until it stays full.".into(),
        n => format!(
            "Pour a thin stream into the sprue, the widest hole, slowly, until silicone stands \
             in it and in {n} vent{}.",
            if n == 1 { "" } else { "s" }
        ),
    };
    let cure = match sheet.silicone.as_ref().and_then(|s| s.cure_h) {
        Some(hours) => format!("Let it cure for {hours} h at 23 °C, longer when colder."),
        None => "Let it cure as long as its bulletin says.".into(),
    };
    let degas = "Degas the mix in a cup three times as high as the liquid, until it has risen, \
                 fallen back and only few bubbles come."
        .into();
    vec![mixing(sheet), degas, pour, cure]
}

/// Pouring in turns with the sheets that are laid in.
fn lay_in(sheet: &Sheet, report: &MoldReport) -> String {
    let grams = sheet.silicone.as_ref().and_then(|s| s.mass_g).map(|mass| mass / sheet.mix_ml);
    let mut words = String::new();
    for LaidIn { tag, height, below_ml, .. } in &report.layers {
        let mass = grams.map_or(String::new(), |density| format!(" ({:.1} g)", density * below_ml));
        words += &format!(
            "Pour {below_ml:.2} mL{mass} in a thin stream into one corner of the {}, until it stands {height:.1} mm \
             high, and level it. Lay {tag} onto it from one end to the other, so that no air stays below; it \
             must be soaked, and flat. ",
            and(&names(report, Role::Shell))
        );
    }
    words + "Pour the rest, up to the brim, and level it."
}

fn mixing(sheet: &Sheet) -> String {
    let haste = |minutes: f64| format!(" It must be in the mold within {minutes} min.");
    match &sheet.silicone {
        Some(Pour { parts_g: Some([a, b]), pot_life_min, .. }) => format!(
            "Weigh {a:.1} g of part A and {b:.1} g of part B into one cup and stir for three \
             minutes; scrape walls and bottom.{}",
            pot_life_min.map(haste).unwrap_or_default()
        ),
        _ => format!("Mix {:.1} mL of silicone as its bulletin says.", sheet.mix_ml),
    }
}

/// The mold is taken apart, the holes of pins are closed, and the cores leave.
fn open(sheet: &Sheet, report: &MoldReport, shells: &[&str], cores: &[&str]) -> Vec<String> {
    let taken: Vec<&str> = shells.iter().rev().copied().collect();
    let off = match taken[..] {
        [one] => format!("Peel the casting out of {one}."),
        _ => format!("Take off {}, in this order.", taken.join(", ")),
    };
    if report.casting.first_shot {
        return vec![
            off + " Leave the core inside, and the holes of pins open: a second casting goes around it.",
        ];
    }
    let (them, inlets) = match cores.len() {
        1 => ("it", "the inlet"),
        _ => ("them", "their inlets"),
    };
    let leaving = Leaving { cores: &and(cores), them, inlets };
    let out = (!cores.is_empty()).then(|| (report.method.core.leaves)(&leaving));
    match close_holes(sheet, report) {
        Some(close) => [off, close].into_iter().chain(out).collect(),
        None => vec![[Some(off), out].into_iter().flatten().collect::<Vec<_>>().join(" ")],
    }
}

/// The holes that pins leave, which the cores close below as long as they are there.
fn close_holes(sheet: &Sheet, report: &MoldReport) -> Option<String> {
    let lengths: Vec<f64> = report.holds.iter().flat_map(|hold| hold.lengths.clone()).collect();
    if lengths.is_empty() {
        return None;
    }
    let pin = report.outlines(Purpose::Pin).next()?;
    let play = report.holds.first()?.clearance;
    let plugs = report.holds.iter().map(|hold| hold.plugs).sum::<f64>() / 1e3;
    let grams = sheet.silicone.as_ref().and_then(|s| s.mass_g).map(|mass| mass / sheet.mix_ml);
    let mass = grams.map_or(String::new(), |density| format!(" ({:.2} g)", density * plugs));
    let deep: Vec<String> = lengths.iter().map(|length| format!("{length:.1} mm")).collect();
    let deep: Vec<&str> = deep.iter().map(String::as_str).collect();
    let (holes, each) = match lengths.len() {
        1 => ("the hole".into(), "it"),
        n => (format!("the {n} holes"), "each"),
    };
    Some(format!(
        "Close {holes} of {:.1} mm diameter that pins left, {} deep, while the core is still inside and closes \
         {each} below: clean {each} with alcohol, turn it up, fill it from a syringe with a drop of fresh silicone, the same, \
         from the bottom up, {plugs:.2} mL{mass} in all, and let it cure.",
        2.0 * (pin.base_radius - play),
        and(&deep),
    ))
}
