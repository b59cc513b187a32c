//! Where in a file an error is, and how that is shown.

use std::ops::Range;

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::key_path::{KeyPath, Step};
use super::merge::identity;

/// As much of a line is shown before a place, and twice as much from there on [bytes].
const AROUND: usize = 60;

/// The place that keys lead to, as far as they do; words are looked for where that is.
pub fn of_path(tree: &DeTable, path: &KeyPath) -> Option<Range<usize>> {
    let (mut table, mut list, mut found, mut lost) = (Some(tree), None, None, false);
    for step in path.steps() {
        let next = match step {
            Step::Table(name) | Step::List(name) | Step::Key(name) => table
                .and_then(|table| entry(table, name))
                .map(|(key, value)| (key.start..end_on_its_line(&key, value), Some(value))),
            Step::Value(name) => table
                .and_then(|table| table.get(name.as_str()))
                .map(|value| (value.span(), Some(value))),
            Step::Word(word) => {
                let place = table.and_then(|table| holds(table, word));
                place.or_else(|| list_holds(list?, word)).map(|place| (place, None))
            }
            _ => list.and_then(|list| item_of(list, step)).map(|item| (item.span(), Some(item))),
        };
        let next = next.filter(|_| !lost || matches!(step, Step::Word(_)));
        let Some((place, value)) = next else {
            lost = true;
            continue;
        };
        table = value.and_then(|value| value.get_ref().as_table());
        list = value.and_then(|value| value.get_ref().as_array());
        found = Some(place);
    }
    found
}

/// The item of a list that a step stands for.
fn item_of<'t, 'a>(list: &'t DeArray<'a>, step: &Step) -> Option<&'t Spanned<DeValue<'a>>> {
    match step {
        Step::Named(name) | Step::On(name) => {
            list.iter().find(|item| identity(item.get_ref()) == Some(name))
        }
        Step::Number(number) | Step::Item(number) => list.get(number.checked_sub(1)?),
        Step::Along(axis) => list.get(*axis),
        _ => None,
    }
}

/// The key of a table that is `word`, or the first key or value below.
fn holds(table: &DeTable, word: &str) -> Option<Range<usize>> {
    let own = table.get_key_value(word).map(|(key, _)| key.span());
    own.or_else(|| table.values().find_map(|value| value_holds(value, word)))
}

fn list_holds(list: &DeArray, word: &str) -> Option<Range<usize>> {
    list.iter().find_map(|item| value_holds(item, word))
}

fn value_holds(value: &Spanned<DeValue>, word: &str) -> Option<Range<usize>> {
    let is_word = match value.get_ref() {
        DeValue::Table(below) => return holds(below, word),
        DeValue::Array(list) => return list_holds(list, word),
        DeValue::String(text) => text == word,
        DeValue::Integer(number) => number.as_str() == word,
        DeValue::Boolean(value) => word == if *value { "true" } else { "false" },
        DeValue::Float(_) | DeValue::Datetime(_) => false,
    };
    is_word.then(|| value.span())
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

    #[test]
    fn of_a_long_line_little_is_shown() {
        let text = format!("{}?{}", "a".repeat(5000), "b".repeat(5000));
        let shown = shown("a.toml", &text, 5000..5001, "what");
        assert!(shown.len() < 500 && shown.contains("aaa?bbb") && shown.ends_with('^'), "{shown}");
    }

    #[test]
    fn keys_lead_to_keys_and_to_values() {
        let text = "[[chamber]]\non = 'a'\n\n[[chamber]]\non = ['b', 'c']\nfill.t = 1\n";
        let tree = DeTable::parse(text).unwrap();
        let found = |path: KeyPath| &text[of_path(tree.get_ref(), &path).unwrap()];
        let second = || KeyPath::list("chamber").number(2);
        for (path, words) in [
            (second(), "[[chamber]]"),
            (KeyPath::list("chamber").on("a").key("on"), "on = 'a'"),
            (second().key("fill.t"), "t = 1"),
            (second().key("none"), "[[chamber]]"),
            (second().key("none").key("on"), "[[chamber]]"),
            (second().key("none").with(KeyPath::word("c")), "'c'"),
            (second().with(KeyPath::word("t")), "t"),
            (second().with(KeyPath::word("c")), "'c'"),
            (second().key("on").with(KeyPath::word("b")), "'b'"),
            (KeyPath::list("chamber").with(KeyPath::word("a")), "'a'"),
            (KeyPath::word("1"), "1"),
        ] {
            assert_eq!(found(path.clone()), words, "{path:?}");
        }
        assert_eq!(of_path(tree.get_ref(), &KeyPath::of("none")), None);
    }
}
