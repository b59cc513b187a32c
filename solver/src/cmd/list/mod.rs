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
use scene::silicone;
use serde_json::{Value, json};

use scene::number;

/// Characters in a line.
const WIDTH: usize = 96;

/// List the material laws, silicones, sheets, gas laws or probes that a scene may name, its numbers, or objectives
///
/// A law is the kind of a table [material]; a silicone is named by
/// material = "its-name"; a sheet is the kind of the material of a [[membrane]]; a gas law is selected by a key of a [[chamber]]; a probe is
/// the kind of a [[probe]]; an objective is the kind of an [[objective]] of a design problem.
#[derive(clap::Args)]
pub struct Arguments {
    /// The silicones and printed elastomers in place of the laws
    #[arg(long)]
    silicones: bool,
    /// The laws of thin sheets in place of those of bodies
    #[arg(long, conflicts_with = "silicones")]
    sheets: bool,
    /// The gas laws of chambers in place of the material laws
    #[arg(long, conflicts_with_all = ["silicones", "sheets"])]
    gas_laws: bool,
    /// The probes of scenes in place of the laws
    #[arg(long, conflicts_with_all = ["silicones", "sheets", "gas_laws"])]
    probes: bool,
    /// The objectives of design problems in place of the laws
    #[arg(long, conflicts_with_all = ["silicones", "sheets", "gas_laws", "probes"])]
    objectives: bool,
    /// The numbers of a scene that may be calibrated, uncertain or other in a scenario, in place of the laws
    #[arg(long, conflicts_with_all = ["silicones", "sheets", "gas_laws", "probes", "objectives"])]
    numbers: bool,
    /// As JSON
    #[arg(long)]
    json: bool,
}

pub fn run(arguments: &Arguments) -> Result<()> {
    let Arguments { silicones, sheets, gas_laws, probes, objectives, numbers, json } = *arguments;
    let text = if numbers {
        rows(number::KINDS, json, number_json, |kinds| joined(kinds, number_text))?
    } else if objectives {
        quantities(List::Objective, &ObjectiveConfig::common_keys(), json)?
    } else if probes {
        quantities(List::Probe, &ProbeConfig::common_keys(), json)?
    } else if sheets {
        rows(sheet::LAWS, json, law_json, |laws| joined(laws, law_text))?
    } else if gas_laws {
        rows(GAS_LAWS, json, gas_law_json, |laws| joined(laws, gas_law_text))?
    } else if silicones {
        rows(silicone::all(), json, silicones::json, silicones::text)?
    } else {
        rows(LAWS, json, law_json, |laws| joined(laws, law_text))?
    };
    write!(std::io::stdout().lock(), "{text}")?;
    Ok(())
}

/// Rows as JSON or as text.
fn rows<T>(
    all: &[T],
    as_json: bool,
    json: fn(&T) -> Value,
    text: impl Fn(&[T]) -> String,
) -> Result<String> {
    if as_json { pretty(all.iter().map(json).collect()) } else { Ok(text(all)) }
}

fn joined<T>(all: &[T], text: fn(&T) -> String) -> String {
    all.iter().map(text).collect::<Vec<_>>().join("\n")
}

fn pretty(rows: Vec<Value>) -> Result<String> {
    Ok(serde_json::to_string_pretty(&rows)? + "\n")
}

/// The kinds of a list, with the keys that all of its entries have.
fn quantities(list: List, common: &[Key], json: bool) -> Result<String> {
    if json {
        return pretty(kinds::of(list).map(|kind| kind_json(kind, list)).collect());
    }
    let kinds: Vec<String> = kinds::of(list).map(|kind| kind_text(kind, list)).collect();
    Ok(kinds.join("\n") + "\nall\n" + &keys_text(common))
}

fn kind_text(kind: &Kind, list: List) -> String {
    let maximised = list == List::Objective && kind.may_be_maximised;
    let sense = if maximised { "; maximised by a negative weight" } else { "" };
    let head = format!("{} [{}{sense}]\n", kind.key, kind.unit);
    head + &wrapped("", kind.formula) + &keys_text(&kind.keys())
}

fn number_text(kind: &number::Kind) -> String {
    format!("{}\n", kind.path) + &wrapped("", kind.meaning)
}

fn number_json(kind: &number::Kind) -> Value {
    json!({ "path": kind.path, "meaning": kind.meaning })
}

/// Keys with their meanings, one under the other.
fn keys_text(keys: &[Key]) -> String {
    keys.iter().map(|key| wrapped(&format!("  {:12} ", key.name), &key.meaning)).collect()
}

fn kind_json(kind: &Kind, list: List) -> Value {
    let keys = kind.keys().into_iter();
    let mut row = json!({
        "kind": kind.key,
        "formula": kind.formula,
        "unit": kind.unit,
        "keys": keys.map(|key| json!({ "key": key.name, "meaning": key.meaning })).collect::<Value>(),
    });
    if list == List::Objective {
        row["may_be_maximised"] = json!(kind.may_be_maximised);
    }
    row
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

fn gas_law_json(law: &Row) -> Value {
    let keys = law.keys.iter().map(|key| {
        json!({ "key": key.name, "unit": key.unit, "meaning": key.meaning, "selects": key.selects })
    });
    json!({
        "law": law.name,
        "formula": law.formula,
        "keys": keys.collect::<Vec<_>>(),
        "source": law.source,
    })
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

fn law_json<M: ?Sized>(law: &Law<M>) -> Value {
    let parameter = |p: &mechanics::material::Parameter| json!({ "name": p.name, "unit": p.unit, "meaning": p.meaning, "list": p.list });
    json!({
        "kind": law.key,
        "formula": law.formula,
        "parameters": law.parameters.iter().map(parameter).collect::<Vec<_>>(),
        "shear_modulus": law.shear,
        "bulk_modulus": law.bulk,
        "limits": law.limits,
        "source": law.source,
    })
}
