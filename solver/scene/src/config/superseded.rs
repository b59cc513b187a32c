//! Tables of older files: what to write in their place.

use anyhow::{Result, bail};
use program::Settings;
use toml::{Table, Value};

/// An old table: its name, and the new names of those of its keys that have one.
type Old = (&'static str, &'static [(&'static str, &'static str)]);

/// Tables of scenes that are `[[chamber]]` now.
const SCENE: &[Old] = &[
    ("pressure", &[]),
    ("gas", &[]),
    ("volume", &[("change", "volume_change"), ("factor", "volume_factor")]),
];
/// Tables of designs that are `[[chamber]]` now.
const DESIGN: &[Old] = &[("pressure", &[])];

/// Refuses a scene with tables of an older form.
///
/// # Errors
/// With the same tables in today's form.
pub(super) fn refuse_in_scene(settings: &Settings) -> Result<()> {
    refuse(settings, SCENE)
}

/// Refuses a design with tables of an older form.
///
/// # Errors
/// With the same tables in today's form.
pub(super) fn refuse_in_design(settings: &Settings) -> Result<()> {
    refuse(settings, DESIGN)
}

fn refuse(settings: &Settings, old: &[Old]) -> Result<()> {
    let file: Table = settings.parse()?;
    if let Some(value) = file.get("pressure").filter(|value| !value.is_table() && !value.is_array())
    {
        bail!(
            "{}: pressure = {value}: a pressure is that of a chamber: [[chamber]] with on = \"TAG\" and \
             pressure = {value}; from outside --set chamber.TAG.pressure={value}",
            settings.file().path.display()
        );
    }
    let found: Vec<&Old> = old.iter().filter(|(name, _)| file.contains_key(*name)).collect();
    if found.is_empty() {
        return Ok(());
    }
    let names: Vec<String> = found.iter().map(|(name, _)| format!("[[{name}]]")).collect();
    let tables: Vec<String> = found.iter().flat_map(|old| today(&file, old)).collect();
    bail!(
        "{}: {} {} now [[chamber]]: write\n\n{}",
        settings.file().path.display(),
        names.join(" and "),
        if names.len() == 1 { "is" } else { "are" },
        tables.join("\n")
    );
}

/// The tables of one old name as they are written today.
fn today(file: &Table, (name, renamed): &Old) -> Vec<String> {
    let tables = match file.get(*name) {
        Some(Value::Array(tables)) => tables.clone(),
        Some(table) => vec![table.clone()],
        None => Vec::new(),
    };
    let new_name = |key: &str| {
        renamed.iter().find(|(old, _)| *old == key).map_or(key, |(_, new)| new).to_owned()
    };
    let one = |table: &Value| {
        let Value::Table(table) = table else { return format!("[[chamber]]  # {table}\n") };
        let line = |(key, value): (&String, &Value)| format!("{} = {value}\n", new_name(key));
        // `on` first, whatever order the keys are read in
        let (on, others): (Vec<_>, Vec<_>) = table.iter().partition(|(key, _)| *key == "on");
        format!("[[chamber]]\n{}", on.into_iter().chain(others).map(line).collect::<String>())
    };
    tables.iter().map(one).collect()
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use crate::config::{DesignConfig, SimConfig};

    #[test]
    fn a_pressure_of_nothing_is_told_where_it_belongs() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("sim.toml");
        std::fs::write(&path, "mesh = \"a.msh\"\npressure = 3\n").unwrap();
        let message = format!("{:#}", SimConfig::read(&path).unwrap_err());
        assert!(message.contains("--set chamber.TAG.pressure=3"), "{message}");
    }

    #[test]
    fn old_tables_are_written_anew_with_their_values() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("old.toml");
        std::fs::write(
            &path,
            "[[gas]]\non = 'b'\nfill = '2e4*t'\nambient = 101.3e3\nexponent = 1.4\n\
             [[volume]]\non = 'c'\nfactor = { t = [0, 1], value = [1, 1.5] }\n\
             [[pressure]]\non = 'a'\npressure = 55e3\n",
        )
        .unwrap();
        let scene = SimConfig::read(&path).unwrap_err().to_string();
        for words in [
            "old.toml: [[pressure]] and [[gas]] and [[volume]] are now [[chamber]]: write",
            "[[chamber]]\non = \"a\"\npressure = 55000.0\n",
            "[[chamber]]\non = \"b\"\nambient = 101300.0\nexponent = 1.4\nfill = \"2e4*t\"\n",
            "[[chamber]]\non = \"c\"\nvolume_factor = { t = [0, 1], value = [1, 1.5] }\n",
        ] {
            assert!(scene.contains(words), "{words}\n{scene}");
        }
        std::fs::write(&path, "scene = 's'\n[[pressure]]\non = 'a'\nslope = [-1, 2e3]\n").unwrap();
        let design = DesignConfig::read(&path).unwrap_err().to_string();
        let words = "[[pressure]] is now [[chamber]]: write\n\n[[chamber]]\non = \"a\"\nslope = ";
        assert!(design.contains(words), "{design}");
    }
}
