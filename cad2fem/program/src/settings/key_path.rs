//! Keys that lead to a value in settings, as errors carry them.

use std::fmt::{Display, Formatter, Result};

/// Keys that lead to a value, and how messages write them: `[time]: steps`, `[[chamber]] on "cavity": pressure`.
///
/// As the context of an error it says where that is; [`Self::says`] makes an error of its own.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct KeyPath(Vec<Step>);

/// A step to what is below.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) enum Step {
    /// A table of the file.
    Table(String),
    /// A list of tables of the file.
    List(String),
    /// What is below a key, perhaps with dots.
    Key(String),
    /// The item of a list with this name.
    Named(String),
    /// The item of a list on this tag.
    On(String),
    /// The item of a list with this number, counted from 1.
    Number(usize),
    /// The component of a vector along this axis.
    Along(usize),
    /// The value of a key, without the key.
    Value(String),
    /// The item of a list with this number, counted from 1, without what is called so.
    Item(usize),
    /// The key or value that is this word, here or anywhere below.
    Word(String),
}

impl KeyPath {
    /// The table `[name]` of the file.
    pub fn table(name: &str) -> Self {
        Self(vec![Step::Table(name.to_owned())])
    }

    /// The tables `[[name]]` of the file.
    pub fn list(name: &str) -> Self {
        Self(vec![Step::List(name.to_owned())])
    }

    /// A key of the file, or of the table that a context says; perhaps with dots.
    pub fn of(key: &str) -> Self {
        Self::default().key(key)
    }

    /// What is below a key here.
    pub fn key(self, key: &str) -> Self {
        self.then(Step::Key(key.to_owned()))
    }

    /// The table that is the value of this key: at the top of the file it is written `[key]`.
    pub fn as_table(self) -> Self {
        match &self.0[..] {
            [Step::Key(name)] => Self::table(name),
            _ => self,
        }
    }

    /// The one of these tables with this name.
    pub fn named(self, name: &str) -> Self {
        self.then(Step::Named(name.to_owned()))
    }

    /// The one of these tables on this tag.
    pub fn on(self, tag: &str) -> Self {
        self.then(Step::On(tag.to_owned()))
    }

    /// The one of these tables with this number, counted from 1.
    pub fn number(self, number: usize) -> Self {
        self.then(Step::Number(number))
    }

    /// The component of this vector along an axis: 0, 1 or 2.
    pub fn along(self, axis: usize) -> Self {
        self.then(Step::Along(axis))
    }

    /// The key or text that is this word, wherever it is in the table that a context says.
    pub fn word(word: &str) -> Self {
        Self(vec![Step::Word(word.to_owned())])
    }

    /// The error that is there: `what` follows the keys in its message.
    pub fn says(self, what: impl Display) -> Misfit {
        Misfit { message: format!("{self}{what}"), path: self }
    }

    /// The error that is there, whose message names the keys itself.
    pub fn told(self, what: impl Display) -> Misfit {
        Misfit { message: what.to_string(), path: self }
    }

    /// The error of what is below these keys, with a title.
    pub fn around(self, title: impl Display, error: &anyhow::Error) -> Misfit {
        let below = Self::told_by(error, None).titled(title);
        Misfit { path: self.with(below.path), ..below }
    }

    /// The message of an error, with the keys that it carries: those of a context, and of what is in it. `meaning` is
    /// what errors of other crates have.
    pub(super) fn told_by(error: &anyhow::Error, meaning: Option<Meaning>) -> Misfit {
        let mut path = error.downcast_ref::<Self>().cloned().unwrap_or_default();
        let mut told = Vec::new();
        for cause in error.chain() {
            let misfit = cause.downcast_ref::<Misfit>().cloned();
            match misfit.or_else(|| meaning.and_then(|meaning| meaning(cause))) {
                Some(misfit) => {
                    path = path.with(misfit.path);
                    told.push(misfit.message);
                }
                None => told.push(cause.to_string()),
            }
        }
        path.told(told.join(": "))
    }

    /// The keys below these.
    pub fn with(mut self, below: Self) -> Self {
        self.0.extend(below.0);
        self
    }

    /// The keys with numbers of items, for values that are in no file: `chamber 1 fill`.
    pub(super) fn words(&self) -> String {
        let word = |step: &Step| match step {
            Step::Table(name) | Step::List(name) | Step::Key(name) | Step::Value(name) => {
                Some(name.clone())
            }
            Step::Item(number) | Step::Number(number) => Some(number.to_string()),
            Step::Named(_) | Step::On(_) | Step::Along(_) | Step::Word(_) => None,
        };
        self.0.iter().filter_map(word).collect::<Vec<_>>().join(" ")
    }

    pub(super) fn steps(&self) -> &[Step] {
        &self.0
    }

    fn then(mut self, step: Step) -> Self {
        self.0.push(step);
        self
    }
}

impl Display for KeyPath {
    fn fmt(&self, f: &mut Formatter) -> Result {
        for (i, step) in self.0.iter().enumerate() {
            match step {
                Step::Table(name) => write!(f, "[{name}]")?,
                Step::List(name) => write!(f, "[[{name}]]")?,
                Step::Key(key) => write!(f, "{}{key}", if i > 0 { ": " } else { "" })?,
                Step::Named(name) => write!(f, " \"{name}\"")?,
                Step::On(tag) => write!(f, " on \"{tag}\"")?,
                Step::Number(number) => write!(f, " {number}")?,
                Step::Along(axis) => write!(f, " along {}", ["x", "y", "z"][*axis])?,
                Step::Value(_) | Step::Item(_) | Step::Word(_) => {}
            }
        }
        Ok(())
    }
}

/// What settings have and should not, or lack, with the keys that lead there.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub struct Misfit {
    /// Where it is, below what contexts say.
    pub(super) path: KeyPath,
    message: String,
}

/// What an error of a crate that knows no settings means for them.
pub type Meaning = fn(&(dyn std::error::Error + 'static)) -> Option<Misfit>;

impl Misfit {
    /// Puts a title before the message.
    pub fn titled(self, title: impl Display) -> Self {
        Self { message: format!("{title}: {}", self.message), ..self }
    }

    /// Puts a step before the keys.
    pub(super) fn below(mut self, step: Step) -> Self {
        self.path.0.insert(0, step);
        self
    }
}

impl From<Misfit> for String {
    fn from(misfit: Misfit) -> Self {
        misfit.message
    }
}

/// A [`Misfit`] at a [`KeyPath`], whose message goes on after the keys as `format!` has it.
#[macro_export]
macro_rules! misfit {
    ($path:expr, $($what:tt)+) => { $path.says(format!($($what)+)) };
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_written_as_in_messages() {
        let chamber = KeyPath::list("chamber").on("cavity").key("pressure");
        for (path, written) in [
            (KeyPath::of("degree"), "degree"),
            (KeyPath::of("gravity").along(2), "gravity along z"),
            (KeyPath::table("time").key("steps"), "[time]: steps"),
            (KeyPath::list("probe").named("tip"), "[[probe]] \"tip\""),
            (KeyPath::list("row").number(2), "[[row]] 2"),
            (chamber.clone(), "[[chamber]] on \"cavity\": pressure"),
        ] {
            assert_eq!(path.to_string(), written);
        }
        assert_eq!(
            misfit!(chamber, " = {}", 3).to_string(),
            "[[chamber]] on \"cavity\": pressure = 3"
        );
    }
}
