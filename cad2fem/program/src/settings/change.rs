//! `--set PATH=VALUE`: a value from outside.

use std::borrow::Cow;
use std::fmt;
use std::ops::Range;
use std::str::FromStr;

use clap::Args;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use super::merge::{identity, shifted_value};
use crate::nearest::unknown;

/// Values from outside in place of those of a file; flatten it into the arguments of a verb.
#[derive(Args, Clone, Debug, Default)]
pub struct Changes {
    /// Another value for a key of the file, as in parameters.peak=30e3 or chamber.cavity.pressure=30e3
    ///
    /// Steps of PATH are keys; a table of a list is named by its `name`, or else by what it is
    /// `on`, or counted from 0. VALUE is TOML, or else a text. In a verb that reads a design,
    /// scene.PATH is a key of its scene. Can be given several times.
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub set: Vec<Change>,
}

impl Changes {
    /// Changes of the file itself, and changes of the scene that it names, whose paths begin with
    /// `scene.`.
    pub fn own_and_scene(&self) -> (Vec<Change>, Vec<Change>) {
        let (mut own, mut scene) = (Vec::new(), Vec::new());
        for change in &self.set {
            match change.text.strip_prefix(SCENE) {
                Some(text) => scene.push(Change { prefix: SCENE, text: text.to_owned() }),
                None => own.push(change.clone()),
            }
        }
        (own, scene)
    }
}

/// What paths begin with that lead into the scene of a design.
const SCENE: &str = "scene.";

/// A value from outside, and where it belongs.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Change {
    /// What led here.
    prefix: &'static str,
    /// `path=value`.
    text: String,
}

/// The steps of a path.
pub type Steps<'a> = Vec<Spanned<Cow<'a, str>>>;

/// What is wrong, and where it is written.
type Refusal = (String, Range<usize>);

impl FromStr for Change {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let change = Self { prefix: "", text: text.to_owned() };
        change.parsed(text, 0)?;
        Ok(change)
    }
}

impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}{}", self.prefix, self.text)
    }
}

impl Change {
    /// `path=value`, without what led to the file.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// The steps and the value of `text`, which begins at `start`.
    pub(super) fn parsed<'a>(
        &self,
        text: &'a str,
        start: usize,
    ) -> Result<(Steps<'a>, Spanned<DeValue<'a>>), String> {
        let expected = "expected PATH=VALUE, as in chamber.cavity.pressure=30e3";
        if text.contains(['\n', '\r']) {
            return Err(format!("a line break: {expected}"));
        }
        let equals = text.find('=').ok_or(expected)?;
        let path = format!("{}=0", &text[..equals]);
        let table = DeTable::parse(&path).map_err(|_| expected)?.into_inner();
        let (steps, _) = flattened(table, usize::MAX).ok_or(expected)?;
        let owned = |step: Spanned<Cow<str>>| {
            let place = step.span();
            let key = Cow::Owned(step.into_inner().into_owned());
            Spanned::new(start + place.start..start + place.end, key)
        };
        let value = DeTable::parse(text)
            .ok()
            .and_then(|table| flattened(table.into_inner(), steps.len()))
            .map_or_else(|| text_after(text, equals), |(_, value)| value);
        Ok((steps.into_iter().map(owned).collect(), shifted_value(value, start)))
    }
}

/// The keys that a dotted key of up to `most` steps consists of, and its value.
fn flattened<'a>(mut table: DeTable<'a>, most: usize) -> Option<(Steps<'a>, Spanned<DeValue<'a>>)> {
    let mut steps = Vec::new();
    loop {
        let (key, value) = table.into_iter().next()?;
        steps.push(key);
        let span = value.span();
        match value.into_inner() {
            DeValue::Table(below) if steps.len() < most => table = below,
            value => return Some((steps, Spanned::new(span, value))),
        }
    }
}

fn text_after(text: &str, equals: usize) -> Spanned<DeValue<'_>> {
    let after = &text[equals + 1..];
    let start = equals + 1 + (after.len() - after.trim_start().len());
    Spanned::new(start..start + after.trim().len(), DeValue::String(after.trim().into()))
}

/// Puts a value where a path leads. `named` are tables that get no new keys.
pub(super) fn apply<'a>(
    table: &mut DeTable<'a>,
    steps: &[Spanned<Cow<'a, str>>],
    value: Spanned<DeValue<'a>>,
    named: &[&str],
) -> Result<(), Refusal> {
    in_table("", table, steps, value, named)
}

fn in_table<'a>(
    name: &str,
    table: &mut DeTable<'a>,
    steps: &[Spanned<Cow<'a, str>>],
    value: Spanned<DeValue<'a>>,
    named: &[&str],
) -> Result<(), Refusal> {
    let Some((step, rest)) = steps.split_first() else { return Ok(()) };
    let key = step.get_ref().as_ref();
    if named.contains(&name) && !table.contains_key(key) {
        let known = table.keys().map(|key| key.get_ref().as_ref());
        return Err((nothing(&format!("[{name}]"), key, known), step.span()));
    }
    if rest.is_empty() {
        // with its key, whose place is another now
        table.remove(key);
        table.insert(step.clone(), value);
        return Ok(());
    }
    if !table.contains_key(key) {
        table.insert(step.clone(), Spanned::new(step.span(), DeValue::Table(DeTable::new())));
    }
    let Some(below) = table.get_mut(key) else { return Ok(()) };
    in_value(key, below, rest, value, named).map_err(|(what, span)| match what.is_empty() {
        true => (format!("{key} is no table, and has no {}", rest[0].get_ref()), span),
        false => (what, span),
    })
}

/// An empty refusal says that the value has nothing in it.
fn in_value<'a>(
    name: &str,
    at: &mut Spanned<DeValue<'a>>,
    steps: &[Spanned<Cow<'a, str>>],
    value: Spanned<DeValue<'a>>,
    named: &[&str],
) -> Result<(), Refusal> {
    if steps.is_empty() {
        *at = value;
        return Ok(());
    }
    match at.get_mut() {
        DeValue::Table(below) => in_table(name, below, steps, value, named),
        DeValue::Array(list) => {
            let (index, used) = element(name, list, steps)?;
            list.get_mut(index)
                .map_or(Ok(()), |item| in_value(name, item, &steps[used..], value, named))
        }
        _ => Err((String::new(), steps[0].span())),
    }
}

/// Which item of a list the first steps name, and how many they are: a name may have dots.
fn element(
    name: &str,
    list: &DeArray,
    steps: &[Spanned<Cow<str>>],
) -> Result<(usize, usize), Refusal> {
    let joined = |count: usize| {
        let steps: Vec<&str> = steps[..count].iter().map(|s| s.get_ref().as_ref()).collect();
        steps.join(".")
    };
    let called = |wanted: &str| -> Vec<usize> {
        (0..list.len()).filter(|i| identity(list[*i].get_ref()) == Some(wanted)).collect()
    };
    for count in 1..=steps.len() {
        match called(&joined(count))[..] {
            [] => {}
            [one] => return Ok((one, count)),
            [first, second, ..] => {
                let what = format!(
                    "several [[{name}]] are called {}: count them from 0, as in {name}.{first} \
                     and {name}.{second}",
                    joined(count)
                );
                return Err((what, steps[0].span()));
            }
        }
    }
    let step = steps[0].get_ref();
    match step.parse::<usize>() {
        Ok(index) if index < list.len() => Ok((index, 1)),
        Ok(_) => Err((format!("{name} has {}, counted from 0", list.len()), steps[0].span())),
        Err(_) => {
            let known = list.iter().filter_map(|item| identity(item.get_ref()));
            Err((nothing(&format!("[[{name}]]"), step, known), steps[0].span()))
        }
    }
}

fn nothing<'b>(table: &str, wanted: &str, known: impl Iterator<Item = &'b str>) -> String {
    let known: Vec<&str> = known.collect();
    let there = if known.is_empty() { "nothing".into() } else { known.join(", ") };
    unknown(&format!("{table} has no {wanted}"), wanted, known, ';', &format!("it has {there}"))
}
