//! Tables of the README, which `tests/fast/readme_tables.rs` compares with it.

use crate::energy::gas_law::Row;
use crate::material::Law;
use crate::objective::Kind;
use crate::probe;

/// The objectives of design problems; a star marks those that may be maximised.
pub fn objectives(kinds: &[Kind]) -> String {
    let row = |kind: &Kind| {
        let star = if kind.may_be_maximised { " *" } else { "" };
        let keys = kind.keys.iter().map(|(key, meaning)| format!("`{key}`: {meaning}"));
        [format!("`{}`{star}", kind.key), kind.formula.to_owned(), kind.unit.to_owned(), list(keys)]
    };
    table(["kind", "minimises", "unit", "keys"], kinds.iter().map(row))
}

/// The probes of scenes.
pub fn probes(kinds: &[probe::Kind]) -> String {
    let row = |kind: &probe::Kind| {
        let keys = kind.keys.iter().map(|(key, meaning)| format!("`{key}`: {meaning}"));
        [format!("`{}`", kind.key), kind.formula.to_owned(), kind.unit.to_owned(), list(keys)]
    };
    table(["kind", "measures", "unit", "keys"], kinds.iter().map(row))
}

/// The gas laws of chambers; the key that selects one is in bold.
pub fn gas_laws(laws: &[Row]) -> String {
    let row = |law: &Row| {
        let keys = law.keys.iter().map(|key| {
            let bold = if key.selects { "**" } else { "" };
            format!("{bold}`{}`{bold} [{}]: {}", key.name, key.unit, key.meaning)
        });
        [law.name.to_owned(), law.formula.to_owned(), list(keys), law.source.to_owned()]
    };
    table(["law", "formula", "keys", "source"], laws.iter().map(row))
}

/// The material laws, of bodies or of sheets.
pub fn materials<M: ?Sized>(laws: &[Law<M>]) -> String {
    let row = |law: &Law<M>| {
        let keys = law.parameters.iter().map(|p| {
            let many = if p.list { ", a list" } else { "" };
            format!("`{}` [{}]: {}{many}", p.name, p.unit, p.meaning)
        });
        [format!("`{}`", law.key), law.formula.to_owned(), list(keys), law.limits.to_owned()]
    };
    table(["kind", "energy density", "parameters", "limits"], laws.iter().map(row))
}

fn list(items: impl Iterator<Item = String>) -> String {
    items.collect::<Vec<_>>().join("; ")
}

fn table<const N: usize>(head: [&str; N], rows: impl Iterator<Item = [String; N]>) -> String {
    let line = |cells: [String; N]| format!("| {} |\n", cells.join(" | "));
    let escaped = |cells: [String; N]| cells.map(|cell| cell.replace('|', "\\|"));
    let rule = format!("|{}\n", "-|".repeat(N));
    let rows = rows.map(|cells| line(escaped(cells)));
    line(head.map(str::to_owned)) + &rule + &rows.collect::<String>()
}
