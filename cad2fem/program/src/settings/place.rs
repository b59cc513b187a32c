//! Where in a file an error is, and how that is shown.
//!
//! Errors of checks carry the keys that lead there ([`of_path`]). Messages are read ([`find`]) where there is nothing
//! else: of `toml` and of types that read themselves, as serde hands on texts alone, and below the keys of
//! checks that know only the table.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::key_path::{KeyPath, Step};
use super::merge::identity;

/// As much of a line is shown before a place, and twice as much from there on [bytes].
const AROUND: usize = 300;

/// The place that keys lead to, as far as they do; below it the keys that the rest of the message names.
pub fn of_path(tree: &DeTable, path: &KeyPath, message: &str) -> Option<Range<usize>> {
    let (mut table, mut list, mut found) = (Some(tree), None, None);
    for step in path.steps() {
        let (place, value) = match step {
            Step::Table(name) | Step::List(name) | Step::Key(name) => {
                let Some((key, value)) = table.and_then(|table| entry(table, name)) else { break };
                (key.start..end_on_its_line(&key, value), value)
            }
            _ => match list.and_then(|list| item_of(list, step)) {
                Some(item) => (item.span(), item),
                None => break,
            },
        };
        (table, list) = (value.get_ref().as_table(), value.get_ref().as_array());
        found = Some(place);
    }
    let rest = message.strip_prefix(&path.to_string()).unwrap_or_default();
    let below = |table| {
        let unknown = crate::nearest::unknown(rest).and_then(|(_, word, _)| holds(table, word));
        unknown.or_else(|| address(table, rest))
    };
    table.and_then(below).or(found)
}

/// The item of a list that a step stands for.
fn item_of<'t, 'a>(list: &'t DeArray<'a>, step: &Step) -> Option<&'t Spanned<DeValue<'a>>> {
    match step {
        Step::Named(name) | Step::On(name) => {
            list.iter().find(|item| identity(item.get_ref()) == Some(name))
        }
        Step::Number(number) => list.get(number.checked_sub(1)?),
        Step::Along(axis) => list.get(*axis),
        Step::Table(_) | Step::List(_) | Step::Key(_) => None,
    }
}

/// The place of an error that carries no keys. `span` is that of what did not fit: of a key or value it is the place,
/// in a table it is looked for. Without one the whole file is. There it is the word that the message
/// calls unknown, or the address that it begins or ends with.
pub fn find(tree: &DeTable, span: Option<Range<usize>>, message: &str) -> Option<Range<usize>> {
    let (table, span) = match span {
        None => (tree, None),
        Some(span) => match node(tree, &span, message) {
            None => return Some(span),
            Some((table, span)) => (table, Some(span)),
        },
    };
    let unknown = || holds(table, crate::nearest::unknown(message)?.1);
    // `toml` names a key without a place last
    let last = || {
        let (_, key) = message.strip_suffix('`')?.rsplit_once("in `")?;
        address(table, &format!("{key}:"))
    };
    unknown()
        .or_else(last)
        .or_else(|| address(tree, message))
        .or_else(|| address(table, message))
        .or(span)
}

/// The table at a place, with its own place. A list of tables has the place of its first one: there it is the first
/// that the message fits.
fn node<'t, 'a>(
    tree: &'t DeTable<'a>,
    span: &Range<usize>,
    message: &str,
) -> Option<(&'t DeTable<'a>, Range<usize>)> {
    tree.iter().find_map(|(_, value)| node_in(value, span, message))
}

fn node_in<'t, 'a>(
    value: &'t Spanned<DeValue<'a>>,
    span: &Range<usize>,
    message: &str,
) -> Option<(&'t DeTable<'a>, Range<usize>)> {
    match value.get_ref() {
        DeValue::Table(table) if value.span() == *span => Some((table, span.clone())),
        DeValue::Table(table) => node(table, span, message),
        DeValue::Array(list) if value.span() == *span => {
            let mut tables = list.iter().filter_map(|i| Some((i.get_ref().as_table()?, i.span())));
            tables.find(|(table, _)| fits(table, message))
        }
        DeValue::Array(list) => list.iter().find_map(|item| node_in(item, span, message)),
        _ => None,
    }
}

/// Whether a table lacks what the message misses, or has under the key that it begins with what it found.
fn fits(table: &DeTable, message: &str) -> bool {
    if let Some(missing) = message.strip_prefix("missing field `").and_then(|m| m.split_once('`')) {
        return table.get(missing.0).is_none();
    }
    let Some((key, what)) = message.split_once(": ") else { return true };
    let found = ["invalid type: ", "invalid value: "].iter().find_map(|m| what.strip_prefix(m));
    let (Some(found), Some(value)) = (found, table.get(key)) else { return found.is_none() };
    found.starts_with(match value.get_ref() {
        DeValue::String(_) => "string",
        DeValue::Integer(_) => "integer",
        DeValue::Float(_) => "floating point",
        DeValue::Boolean(_) => "boolean",
        DeValue::Array(_) => "sequence",
        DeValue::Table(_) | DeValue::Datetime(_) => "map",
    })
}

/// The first key or text of a table, at any depth, that is `word`.
fn holds(table: &DeTable, word: &str) -> Option<Range<usize>> {
    table.iter().find_map(|(key, value)| match key.get_ref() == word {
        true => Some(key.span()),
        false => value_holds(value, word),
    })
}

fn value_holds(value: &Spanned<DeValue>, word: &str) -> Option<Range<usize>> {
    match value.get_ref() {
        DeValue::String(text) if text == word => Some(value.span()),
        DeValue::Table(below) => holds(below, word),
        DeValue::Array(list) => list.iter().find_map(|item| value_holds(item, word)),
        _ => None,
    }
}

/// Follows the address that a message begins with: `[table]`, `[[table]] "name"`,
/// `[[table]] on "tag"`, `[[table]] 2`, `table "name"`, and keys before `:`, ` =` or ` is`.
fn address(tree: &DeTable, message: &str) -> Option<Range<usize>> {
    let (mut table, mut rest, mut found) = (tree, message, None);
    loop {
        rest = rest.trim_start_matches([' ', ':', ',', '\n']);
        let Some(step) = step(rest) else { return found };
        let Some((key, value)) = entry(table, step.name) else { return found };
        let (mut place, mut next) = (key.start..end_on_its_line(&key, value), value);
        rest = step.rest;
        if let DeValue::Array(list) = value.get_ref()
            && let Some((item, after)) = item(list, rest)
        {
            (place, next, rest) = (item.span(), item, after);
        }
        found = Some(place);
        let DeValue::Table(below) = next.get_ref() else { return found };
        table = below;
    }
}

/// A key in a message, and what follows it.
struct Word<'m> {
    name: &'m str,
    rest: &'m str,
}

fn step(message: &str) -> Option<Word<'_>> {
    for (open, close) in [("[[", "]]"), ("[", "]")] {
        if let Some(inside) = message.strip_prefix(open) {
            let (name, rest) = inside.split_once(close)?;
            return Some(Word { name, rest });
        }
    }
    let end = message.find(|c: char| !(c.is_alphanumeric() || "_-.".contains(c)))?;
    let (name, rest) = message.split_at(end);
    let follows = [":", " =", " is ", " \""].iter().any(|after| rest.starts_with(after));
    (end > 0 && follows).then_some(Word { name, rest })
}

/// The entry of a dotted key: the place of the last key, and the value.
fn entry<'t, 'a>(
    table: &'t DeTable<'a>,
    name: &str,
) -> Option<(Range<usize>, &'t Spanned<DeValue<'a>>)> {
    if let Some((key, value)) = table.get_key_value(name) {
        return Some((key.span(), value));
    }
    let (first, rest) = name.split_once('.')?;
    match table.get(first)?.get_ref() {
        DeValue::Table(below) => entry(below, rest),
        _ => None,
    }
}

/// The item of a list that ` "name"`, ` on "tag"` or ` 2`, counted from 1, stands for.
fn item<'t, 'a, 'm>(
    list: &'t [Spanned<DeValue<'a>>],
    message: &'m str,
) -> Option<(&'t Spanned<DeValue<'a>>, &'m str)> {
    let rest = message.strip_prefix(' ')?;
    let rest = rest.strip_prefix("on ").unwrap_or(rest);
    if let Some((name, after)) = rest.strip_prefix('"').and_then(|rest| rest.split_once('"')) {
        let found = list.iter().find(|item| identity(item.get_ref()) == Some(name))?;
        return Some((found, after));
    }
    let digits = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    let number: usize = rest[..digits].parse().ok()?;
    Some((list.get(number.checked_sub(1)?)?, &rest[digits..]))
}

/// Where a key and its value end, if both are in one line; else where the key ends.
fn end_on_its_line(key: &Range<usize>, value: &Spanned<DeValue>) -> usize {
    match value.get_ref() {
        DeValue::Table(_) | DeValue::Array(_) => key.end,
        _ => value.span().end.max(key.end),
    }
}

/// The error with the name of its file, line and column, and the line with carets.
pub fn shown(file: &str, text: &str, place: Range<usize>, what: &str) -> String {
    let (line, column) = position(text, place.start);
    let file = if file.is_empty() { "line " } else { &format!("{file}:") };
    let gutter = " ".repeat(line.to_string().len());
    format!(
        "{file}{line}:{column}: {what}\n{gutter} |\n{line} | {}",
        underlined(text, place, &format!("{gutter} | "))
    )
}

/// The error in a text that has one line and no file.
pub fn shown_alone(name: &str, text: &str, place: Range<usize>, what: &str) -> String {
    format!("{name}: {what}\n  | {}", underlined(text, place, "  | "))
}

/// Line and column, counted from 1.
fn position(text: &str, at: usize) -> (usize, usize) {
    let before = &text[..floor(text, at)];
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().map_or(0, |line| line.chars().count()) + 1;
    (line, column)
}

/// The line of a place, and carets under it.
fn underlined(text: &str, place: Range<usize>, margin: &str) -> String {
    let at = floor(text, place.start);
    let begin = text[..at].rfind('\n').map_or(0, |end| end + 1);
    let end = text[begin..].find(['\n', '\r']).map_or(text.len(), |length| begin + length);
    let until = floor(text, place.end.clamp(at.min(end), end));
    let at = at.min(until);
    // of a long line what is around the place
    let from = floor(text, at.saturating_sub(AROUND)).max(begin);
    let to = floor(text, (at + 2 * AROUND).min(end));
    let until = until.min(to);
    let (before, after) = (if from > begin { "…" } else { "" }, if to < end { "…" } else { "" });
    // tabs stay tabs, so that the carets stand below
    let indent: String = before
        .chars()
        .chain(text[from..at].chars())
        .map(|c| if c == '\t' { c } else { ' ' })
        .collect();
    let count = text[at..until].chars().count().max(1);
    format!("{before}{}{after}\n{margin}{indent}{}", &text[from..to], "^".repeat(count))
}

fn floor(text: &str, at: usize) -> usize {
    (0..=at.min(text.len())).rev().find(|i| text.is_char_boundary(*i)).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]
    use super::*;

    /// `toml` gives a list of tables one place, which is the place of the first table.
    #[test]
    fn the_table_of_a_list_that_an_error_means_is_found() {
        let text = "[[chamber]]\non = 'a'\nfill = 1\n\n[[chamber]]\non = ['b']\n";
        let tree = DeTable::parse(text).unwrap();
        let list = tree.get_ref()["chamber"].span();
        let found = |message: &str| find(tree.get_ref(), Some(list.clone()), message).unwrap();
        let starts = |message: &str| &text[found(message).start..];
        assert!(starts("on: invalid type: sequence, expected a string").starts_with("on = ['b']"));
        assert!(starts("on: invalid type: string \"a\", expected a list").starts_with("on = 'a'"));
        assert_eq!(found("missing field `fill`").start, text.rfind("[[").unwrap());
        assert_eq!(found("missing field `pressure`").start, 0);
    }
}
