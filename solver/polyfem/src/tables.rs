//! Tables of our scene.

use toml::{Table, Value};

/// A table of these keys.
pub fn table<const N: usize>(keys: [(&str, Value); N]) -> Table {
    keys.map(|(key, value)| (key.to_owned(), value)).into_iter().collect()
}

/// Adds a table to the list of a scene with this name.
pub fn push(scene: &mut Table, list: &str, table: Table) {
    let list = scene.entry(list).or_insert_with(|| Value::Array(Vec::new()));
    if let Value::Array(list) = list {
        list.push(table.into());
    }
}
