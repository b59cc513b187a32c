//! Decks of CalculiX (`ccx`), which are those of Abaqus.
//!
//! Energies are as in the manual of CalculiX 2.20, section *HYPERELASTIC; the tests run it where it is installed.
//!
//! Lengths are mm and forces µN, so that stresses stay Pa: CalculiX takes an unbalanced force below 1e-6 for none, which
//! in N is 1 % of what moves a body of grams.

use std::fmt::{Display, Write as _};

use anyhow::Result;
use mechanics::material::Lame;

use super::{Deck, Format, Held, Volume, ids, in_one_line, no_law};

const PROGRAM: &str = "CalculiX";

pub const FORMAT: Format = Format { program: PROGRAM, ending: "inp", write };

/// Number of the face opposite each corner: 1-2-3, 1-4-2, 2-4-3, 3-4-1.
const FACES: [usize; 4] = [3, 4, 2, 1];
/// Millimetres in a metre.
const LENGTH: f64 = 1e3;
/// Micronewtons in a newton.
const FORCE: f64 = 1e6;
/// Ids in one line of a set.
const IN_LINE: usize = 10;
/// D of a term of (J − 1)⁴ or higher that is not there. With 0 CalculiX 2.20 takes a value of its own, which made a
/// bar of Yeoh's law 1.4 % stiffer.
const NO_TERM: &str = "1e20";
/// Terms of Ogden's law at most.
const OGDEN_TERMS: usize = 3;

/// What the volumetric terms have in common and in which they differ.
const QUADRATIC: &str = "(K/2) (J - 1)^2 in place of (K/2) ln^2 J, with the same bulk modulus K: at the same J its \
    pressure is 1 + 3/2 (J - 1) times ours, to first order";
const ARRUDA_BOYCE: &str = "(K/2) ((J^2 - 1)/2 - ln J) in place of (K/2) ln^2 J, with the same bulk modulus K: at the \
    same J its pressure is 1 + (J - 1) times ours, to first order";
const NEO_HOOKEAN: &str = "(mu/2) (J^(-2/3) I1 - 3) + (K/2) (J - 1)^2 in place of (mu/2) (I1 - 3 - 2 ln J) + \
    (lambda/2) ln^2 J, with the same moduli at rest: the same where J = 1";

fn write(deck: &Deck) -> Result<String> {
    let mut out = String::new();
    for line in deck.head(PROGRAM, "mm, uN, Pa") {
        writeln!(out, "** {line}")?;
    }
    let (volumes, tags) = deck.set_names();
    write_mesh(deck, &volumes, &mut out)?;
    for (tag, name) in deck.tags.iter().zip(&tags) {
        writeln!(out, "** tag \"{}\"\n*NSET, NSET=N{name}", in_one_line(&tag.name))?;
        write_ids(&tag.nodes, &mut out)?;
        writeln!(out, "*SURFACE, NAME={name}, TYPE=ELEMENT")?;
        for facet in &tag.facets {
            writeln!(out, "{}, S{}", facet.element + 1, FACES[facet.opposite])?;
        }
    }
    for held in &deck.held {
        writeln!(out, "*NSET, NSET={}", held.name)?;
        write_ids(&held.nodes, &mut out)?;
    }
    for (volume, set) in deck.volumes.iter().zip(&volumes) {
        let (text, differs) = law(volume)?;
        let (name, law) = (in_one_line(&volume.name), volume.material.law);
        writeln!(out, "** {name}: {} of Puffer, {}", law.key, law.formula)?;
        if let Some(differs) = differs {
            let text = format!("{}: {PROGRAM} has another energy: {differs}", volume.name);
            log::warn!("{text}");
            writeln!(out, "** {}", in_one_line(&text))?;
        }
        writeln!(
            out,
            "*MATERIAL, NAME=M{set}\n{text}*SOLID SECTION, ELSET={set}, MATERIAL=M{set}"
        )?;
    }
    write_step(deck, &mut out)?;
    Ok(out)
}

fn write_mesh(deck: &Deck, volumes: &[String], out: &mut String) -> Result<()> {
    writeln!(out, "*NODE, NSET=NALL")?;
    for (i, x) in deck.nodes.iter().map(|x| LENGTH * x).enumerate() {
        writeln!(out, "{}, {}, {}, {}", i + 1, number(x.x), number(x.y), number(x.z))?;
    }
    let kind = if deck.degree == 1 { "C3D4" } else { "C3D10" };
    for (volume, set) in deck.volumes.iter().zip(volumes) {
        writeln!(out, "*ELEMENT, TYPE={kind}, ELSET={set}")?;
        for element in volume.elements.clone() {
            // our order of nodes, VTK's, is that of CalculiX
            writeln!(out, "{}, {}", element + 1, ids(&deck.elements[element], ", "))?;
        }
    }
    Ok(())
}

/// One static step with geometric nonlinearity. CalculiX neglects that pressures turn with the wall when it seeks the next
/// iterate, so that these come nearer by a factor of about two, and ends by default when forces balance to 0.5 %: this
/// asks for 1e-5 and allows many iterations.
fn write_step(deck: &Deck, out: &mut String) -> Result<()> {
    writeln!(out, "*STEP, NLGEOM, INC=1000\n*STATIC\n0.1, 1., 1e-6, 0.25")?;
    writeln!(out, "*CONTROLS, PARAMETERS=TIME INCREMENTATION\n20, 40, 20, 200, 60, 4, , 8, ,")?;
    writeln!(out, "*CONTROLS, PARAMETERS=FIELD\n1e-5, 1e-5, , , 1e-5, 1e-12, 1e-9, 1e-12")?;
    for held in &deck.held {
        write_support(held, out)?;
    }
    for &(tag, pressure) in &deck.pressures {
        let tag = &deck.tags[tag];
        let name = in_one_line(&tag.name);
        writeln!(out, "** {pressure} Pa in \"{name}\", following the wall\n*DLOAD")?;
        for facet in &tag.facets {
            let face = FACES[facet.opposite];
            writeln!(out, "{}, P{face}, {}", facet.element + 1, number(pressure))?;
        }
    }
    if !deck.forces.is_empty() {
        writeln!(out, "** gravity, body forces and tractions, as nodal forces\n*CLOAD")?;
    }
    for (node, force) in &deck.forces {
        for (axis, value) in (1..).zip(force.iter()).filter(|(_, value)| **value != 0.0) {
            writeln!(out, "{}, {axis}, {}", node + 1, number(FORCE * value))?;
        }
    }
    writeln!(out, "*NODE PRINT, NSET=NALL\nU\n*NODE FILE\nU\n*EL FILE\nS\n*END STEP")?;
    Ok(())
}

fn write_support(held: &Held, out: &mut String) -> Result<()> {
    writeln!(out, "*BOUNDARY")?;
    for axis in (0..3).filter(|&axis| held.axes[axis]) {
        let mut line = |of: &dyn Display, u: f64| {
            writeln!(out, "{of}, {}, {}, {}", axis + 1, axis + 1, number(LENGTH * u))
        };
        match held.uniform(axis) {
            Some(u) => line(&held.name, u)?,
            None => {
                let mut each = held.nodes.iter().zip(&held.displacement);
                each.try_for_each(|(node, u)| line(&(node + 1), u[axis]))?;
            }
        }
    }
    Ok(())
}

/// The law in CalculiX' words, and its energy, where that is another one than ours.
fn law(volume: &Volume) -> Result<(String, Option<&'static str>)> {
    let p = &volume.material.values;
    // its D is 2/K
    let d = number(2.0 / volume.material.moduli().bulk);
    let n = |k: usize| number(p[k]);
    Ok(match volume.material.law.key {
        "mooney-rivlin" => (mooney_rivlin(p), Some(QUADRATIC)),
        "mooney-rivlin-quadratic" => (mooney_rivlin(p), None),
        "yeoh" => {
            let terms = format!("{}, {}, {}, {d}, {NO_TERM}, {NO_TERM}", n(0), n(1), n(2));
            (format!("*HYPERELASTIC, YEOH\n{terms}\n"), Some(QUADRATIC))
        }
        "ogden" => (ogden(volume)?, Some(QUADRATIC)),
        "arruda-boyce" => {
            let text = format!("*HYPERELASTIC, ARRUDA-BOYCE\n{}, {}, {d}\n", n(0), n(1));
            (text, Some(ARRUDA_BOYCE))
        }
        "neo-hookean" => {
            let Lame { mu, .. } = Lame::new(p[0], p[1]);
            let text = format!("*HYPERELASTIC, NEO HOOKE\n{}, {d}\n", number(0.5 * mu));
            (text, Some(NEO_HOOKEAN))
        }
        "saint-venant-kirchhoff" => (format!("*ELASTIC\n{}, {}\n", n(0), n(1)), None),
        _ => return no_law(volume, PROGRAM, ""),
    })
}

/// Σ C_ij (Ī₁ − 3)^i (Ī₂ − 3)^j + (J − 1)²/D₁, of c₁, c₂, c₃ = C₁₁ and d₁ = 1/D₁.
fn mooney_rivlin(p: &[f64]) -> String {
    let [c1, c2, c3, d] = [p[0], p[1], p[2], 1.0 / p[3]].map(number);
    if p[2] == 0.0 {
        return format!("*HYPERELASTIC, MOONEY-RIVLIN\n{c1}, {c2}, {d}\n");
    }
    format!("*HYPERELASTIC, POLYNOMIAL, N=2\n{c1}, {c2}, 0., {c3}, 0., {d}, {NO_TERM}\n")
}

/// Σ 2μ/α² (λ̄₁^α + …) in place of our Σ μ/α (…): its μ is ½ μ α.
fn ogden(volume: &Volume) -> Result<String> {
    let p = &volume.material.values;
    let terms = p.len() / 2;
    if terms > OGDEN_TERMS {
        return no_law(volume, PROGRAM, &format!(" of more than {OGDEN_TERMS} terms"));
    }
    let both = (0..terms).flat_map(|i| [0.5 * p[i] * p[terms + i], p[terms + i]]);
    let mut values: Vec<String> = both.map(number).collect();
    values.push(number(2.0 / p[2 * terms]));
    values.extend((1..terms).map(|_| NO_TERM.to_owned()));
    // a line has eight values
    let lines: Vec<String> = values.chunks(8).map(|line| line.join(", ")).collect();
    Ok(format!("*HYPERELASTIC, OGDEN, N={terms}\n{}\n", lines.join("\n")))
}

fn write_ids(nodes: &[usize], out: &mut String) -> Result<()> {
    Ok(nodes.chunks(IN_LINE).try_for_each(|line| writeln!(out, "{},", ids(line, ", ")))?)
}

/// A number in the 20 letters that CalculiX reads of one.
fn number(value: f64) -> String {
    format!("{value:.12e}")
}
