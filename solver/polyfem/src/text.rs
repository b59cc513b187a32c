//! TOML as a person would write it.

use std::fmt::Write;

/// The text of a TOML file.
#[derive(Debug, Default)]
pub struct Text(pub String);

impl Text {
    /// Begins with comments.
    pub fn new(comments: &[String]) -> Self {
        let mut text = Self::default();
        for comment in comments {
            text.0 += &format!("# {comment}\n");
        }
        text.0.push('\n');
        text
    }

    /// A header such as `[time]` or `[[body]]`.
    pub fn table(&mut self, header: &str) -> &mut Self {
        self.0 += &format!("\n{header}\n");
        self
    }

    /// A key with its value in TOML.
    pub fn key(&mut self, name: &str, value: &str) -> &mut Self {
        // Writing to a String cannot fail.
        let _ = writeln!(self.0, "{name} = {value}");
        self
    }

    /// A key with a text.
    pub fn name(&mut self, name: &str, value: &str) -> &mut Self {
        self.key(name, &quoted(value))
    }

    /// A key with a number.
    pub fn number(&mut self, name: &str, value: f64) -> &mut Self {
        self.key(name, &number(value))
    }
}

/// A number that is read back as the same, and as no whole one.
pub fn number(value: f64) -> String {
    format!("{value:?}")
}

/// A text in quotes.
pub fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}

/// A name that is not among `names`, with a number where it has to differ.
pub fn unused(name: &str, between: char, names: &mut Vec<String>) -> String {
    let numbered = (2..).map(|number| format!("{name}{between}{number}"));
    let mut all = std::iter::once(name.to_owned()).chain(numbered);
    let name = all.find(|name| !names.contains(name)).expect("numbers do not end");
    names.push(name.clone());
    name
}

/// A list of values in TOML.
pub fn list(values: impl IntoIterator<Item = String>) -> String {
    format!("[{}]", values.into_iter().collect::<Vec<_>>().join(", "))
}
