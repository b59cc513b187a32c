//! `solver list`: what a scene or a design problem may name.

mod silicones;

use std::io::Write;

use anyhow::Result;
use measure::kinds;
use measure::quantity::{Kind, List};
use mechanics::energy::gas_law::{GAS_LAWS, Row};
use mechanics::material::{LAWS, Law, sheet};
use program::schema::Key;
use scene::config::{ObjectiveConfig, ProbeConfig};
use scene::number;
use scene::silicone;

/// Characters in a line.
const WIDTH: usize = 96;

/// List the material laws, silicones, sheets, gas laws or probes that a scene may name, its numbers, or objectives
///
/// A law is the kind of a table [material]; a silicone is named by
/// material = "its-name"; a sheet is the kind of the material of a [[membrane]]; a gas law is selected by a key of a [[chamber]]; a probe is
/// the kind of a [[probe]]; an objective is the kind of an [[objective]] of a design problem.
#[derive(clap::Args)]
#[group(multiple = false)]
pub struct Arguments {
    /// The silicones and printed elastomers in place of the laws
    #[arg(long)]
    silicones: bool,
    /// The laws of thin sheets in place of those of bodies
    #[arg(long)]
    sheets: bool,
    /// The gas laws of chambers in place of the material laws
    #[arg(long)]
    gas_laws: bool,
    /// The probes of scenes in place of the laws
    #[arg(long)]
    probes: bool,
    /// The objectives of design problems in place of the laws
    #[arg(long)]
    objectives: bool,
    /// The numbers of a scene that may be calibrated, uncertain or other in a scenario, in place of the laws
    #[arg(long)]
    numbers: bool,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let text = match arguments {
        Arguments { numbers: true, .. } => joined(&number::KINDS, number_text),
        Arguments { objectives: true, .. } => {
            quantities(List::Objective, &ObjectiveConfig::common_keys())
        }
        Arguments { probes: true, .. } => quantities(List::Probe, &ProbeConfig::common_keys()),
        Arguments { sheets: true, .. } => joined(sheet::LAWS, law_text),
        Arguments { gas_laws: true, .. } => joined(GAS_LAWS, gas_law_text),
        Arguments { silicones: true, .. } => silicones::text(silicone::all()),
        _ => joined(LAWS, law_text),
    };
    Ok(write!(std::io::stdout().lock(), "{text}")?)
}

fn joined<T>(all: &[T], text: fn(&T) -> String) -> String {
    all.iter().map(text).collect::<Vec<_>>().join("\n")
}

/// The kinds of a list, with the keys that all of its entries have.
fn quantities(list: List, common: &[Key]) -> String {
    let kinds: Vec<String> = kinds::of(list).map(|kind| kind_text(kind, list)).collect();
    kinds.join("\n") + "\nall\n" + &keys_text(common)
}

fn kind_text(kind: &Kind, list: List) -> String {
    let maximised = list == List::Objective && kind.may_be_maximised;
    let sense = if maximised { "; maximised by a negative weight" } else { "" };
    let head = format!("{} [{}{sense}]\n", kind.key, kind.unit);
    head + &wrapped("", &kind.formula()) + &keys_text(&kind.keys())
}

fn number_text(kind: &number::Kind) -> String {
    format!("{}\n", kind.paths) + &wrapped("", kind.meaning)
}

/// Keys with their meanings, one under the other.
fn keys_text(keys: &[Key]) -> String {
    keys.iter().map(|key| wrapped(&format!("  {:12} ", key.name), &key.meaning)).collect()
}

fn gas_law_text(law: &Row) -> String {
    let mut text = format!("{}\n  {}\n", law.name, law.formula);
    for key in law.keys {
        let label = format!("  {:14} {:5} ", key.name, format!("[{}]", key.unit));
        let selects = if key.selects { "; selects this law" } else { "" };
        text += &wrapped(&label, &format!("{}{selects}", key.meaning));
    }
    text + &wrapped("source: ", law.source)
}

fn law_text<M: ?Sized>(law: &Law<M>) -> String {
    let mut text = format!("{}\n  {}\n", law.key, law.formula);
    for p in law.parameters {
        text += &format!("    {:8} {:5} {}\n", p.name, format!("[{}]", p.unit), p.meaning);
    }
    text += &format!("  shear modulus at rest  {}\n", law.shear);
    text += &format!("  bulk modulus at rest   {}\n", law.bulk);
    if !law.limits.is_empty() {
        text += &wrapped("limits: ", law.limits);
    }
    text + &wrapped("source: ", law.source)
}

/// Words after a label, indented under it.
fn wrapped(label: &str, words: &str) -> String {
    let mut text = format!("  {label}");
    let indent = text.chars().count();
    let mut column = indent;
    for word in words.split_whitespace() {
        let length = word.chars().count();
        if column > indent && column + 1 + length > WIDTH {
            text += &format!("\n{:indent$}", "");
            column = indent;
        }
        if column > indent {
            text.push(' ');
            column += 1;
        }
        text += word;
        column += length;
    }
    text + "\n"
}
