//! A file over what it includes.

use std::borrow::Cow;
use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// Lays `own` over `base`: tables with a header key by key, lists of tables by the names in them,
/// all else as a whole; so are tables with a `kind`, which says what their other keys are. `inline` says whether a table is written in braces, as a value is.
pub fn overlay<'a>(
    base: &mut DeTable<'a>,
    own: DeTable<'a>,
    inline: &impl Fn(&Range<usize>) -> bool,
) {
    for (key, mut value) in own {
        let place = value.span();
        if let Some(below) = base.get_mut(key.get_ref().as_ref()) {
            let whole = inline(&place) || inline(&below.span());
            match (below.get_mut(), value.get_mut()) {
                (DeValue::Table(below), DeValue::Table(over))
                    if !whole && !below.contains_key("kind") && !over.contains_key("kind") =>
                {
                    overlay(below, std::mem::replace(over, DeTable::new()), inline);
                    continue;
                }
                (DeValue::Array(below), DeValue::Array(over)) if are_named(below, over) => {
                    overlay_named(below, taken(over));
                    continue;
                }
                _ => {}
            }
        }
        // with its key, whose place is another now
        base.remove(key.get_ref().as_ref());
        base.insert(key, value);
    }
}

/// A table as from a text that begins later.
pub fn shifted(table: DeTable, by: usize) -> DeTable {
    let mut moved = DeTable::new();
    for (key, value) in table {
        let place = key.span();
        let key = Spanned::new(place.start + by..place.end + by, key.into_inner());
        moved.insert(key, shifted_value(value, by));
    }
    moved
}

/// A value as from a text that begins later.
pub fn shifted_value(value: Spanned<DeValue>, by: usize) -> Spanned<DeValue> {
    let place = value.span();
    let moved = match value.into_inner() {
        DeValue::Table(table) => DeValue::Table(shifted(table, by)),
        DeValue::Array(list) => {
            DeValue::Array(list.into_iter().map(|item| shifted_value(item, by)).collect())
        }
        other => other,
    };
    Spanned::new(place.start + by..place.end + by, moved)
}

/// What tells a table of a list from the others: its `name`, or else what it is `on`.
pub fn identity<'b>(value: &'b DeValue<'_>) -> Option<&'b str> {
    let table = value.as_table()?;
    table.get("name").or_else(|| table.get("on"))?.get_ref().as_str()
}

fn are_named(below: &DeArray, over: &DeArray) -> bool {
    let mut all = below.iter().chain(over.iter());
    !below.is_empty() && all.all(|item| identity(item.get_ref()).is_some())
}

/// A table stands in place of all with its name, where the first of them was.
fn overlay_named<'a>(below: &mut DeArray<'a>, over: DeArray<'a>) {
    let name = |item: &Spanned<DeValue>| identity(item.get_ref()).map(str::to_owned);
    let mut over: Vec<_> = over.into_iter().map(|item| (name(&item), Some(item))).collect();
    let mut merged = Vec::new();
    for item in taken(below) {
        let same = |name_of_over: &Option<String>| *name_of_over == name(&item);
        if over.iter().any(|(name, _)| same(name)) {
            let same = over.iter_mut().filter(|(name, _)| same(name));
            merged.extend(same.filter_map(|(_, item)| item.take()));
        } else {
            merged.push(item);
        }
    }
    merged.extend(over.into_iter().filter_map(|(_, item)| item));
    *below = merged.into_iter().collect();
}

/// All that is in a list, which is then empty.
fn taken<'a>(list: &mut DeArray<'a>) -> DeArray<'a> {
    std::mem::replace(list, DeArray::new())
}

/// Makes paths that a file in `folder` names relative to the file that includes it.
pub fn move_paths(table: &mut DeTable, keys: &[&str], folder: &Path) {
    for (key, value) in table.iter_mut() {
        let is_path = keys.contains(&key.get_ref().as_ref());
        match value.get_mut() {
            DeValue::String(path) if is_path => move_path(path, folder),
            DeValue::Table(below) => move_paths(below, keys, folder),
            DeValue::Array(list) => {
                for item in list.iter_mut() {
                    match item.get_mut() {
                        DeValue::Table(below) => move_paths(below, keys, folder),
                        DeValue::String(path) if is_path => move_path(path, folder),
                        _ => {}
                    }
                }
            }
            _ => {}
        }
    }
}

fn move_path(path: &mut Cow<'_, str>, folder: &Path) {
    *path = folder.join(path.as_ref()).display().to_string().into();
}

/// Whether a value of a table comes from a source.
pub fn uses(table: &DeTable, source: &Range<usize>) -> bool {
    fn value_uses(value: &Spanned<DeValue>, source: &Range<usize>) -> bool {
        match value.get_ref() {
            DeValue::Table(below) => uses(below, source),
            DeValue::Array(list) if !list.is_empty() => list.iter().any(|v| value_uses(v, source)),
            _ => source.contains(&value.span().start),
        }
    }
    table.iter().any(|(_, value)| value_uses(value, source))
}
