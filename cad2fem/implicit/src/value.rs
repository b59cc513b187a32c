//! What values of a model file may be.

use anyhow::{Result, ensure};
use program::{KeyPath, Misfit};
use toml::Value;

/// TOML has `nan` and `inf`; a length is neither.
pub fn require_finite(key: &str, path: KeyPath, value: &Value) -> Result<(), Misfit> {
    match value {
        Value::Float(x) if !x.is_finite() => {
            Err(path.told(format!("{key} is {x}; a finite number is needed")))
        }
        Value::Array(items) => items
            .iter()
            .enumerate()
            .try_for_each(|(i, item)| require_finite(key, path.clone().number(i + 1), item)),
        Value::Table(table) => table.iter().try_for_each(|(name, item)| {
            let key = format!("{key}.{name}");
            require_finite(key.trim_start_matches('.'), path.clone().key(name), item)
        }),
        _ => Ok(()),
    }
}

/// Names of regions and variants become names of files.
pub fn require_file_name(name: &str) -> Result<()> {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_".contains(c);
    ensure!(
        !name.is_empty() && name != "patches" && name.chars().all(plain),
        KeyPath::word(name).told(format!(
            "name {name:?} must consist of letters, digits, - and _ (it names a file), and not be `patches`"
        ))
    );
    Ok(())
}
