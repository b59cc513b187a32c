//! JSON Schemas of files in TOML, made of the types that the programs read them into, so that
//! editors complete and check what people write.

mod finish;
mod keys;
mod markdown;
mod tables;

use std::io::Write as _;

use anyhow::{Context as _, Result};
use schemars::JsonSchema;
use schemars::generate::SchemaSettings;
use serde_json::Value;

pub use keys::{Key, key_names, keys_of, take_keys};
pub use markdown::markdown;
pub use tables::{
    add_keys, add_kind, add_table, one_of, one_of_these, one_of_these_or_none, partial,
};

use crate::nearest::unknown;

/// A format of files that a program reads or writes.
pub struct Format {
    /// What the verb `schema` calls it.
    pub name: &'static str,
    /// What such a file is called mostly.
    pub file: &'static str,
    /// The schema.
    pub schema: fn() -> Value,
    /// Whether a program writes it, and nobody else.
    is_report: bool,
}

impl Format {
    /// The format that is read into a `T`.
    pub const fn of<T: JsonSchema>(name: &'static str, file: &'static str) -> Self {
        Self { name, file, schema: schema::<T>, is_report: false }
    }

    /// The format of a report that a `T` is written to.
    pub const fn of_report<T: JsonSchema>(name: &'static str, file: &'static str) -> Self {
        Self { name, file, schema: report::<T>, is_report: true }
    }
}

/// The schema (draft 7, which editors know) of a file that is read into a `T`, with the keys that every
/// file has.
fn schema<T: JsonSchema>() -> Value {
    let schema = SchemaSettings::draft07().into_generator().into_root_schema_for::<T>();
    finish::finish(schema.to_value())
}

/// The schema (draft 7) of a report that a `T` is written to.
fn report<T: JsonSchema>() -> Value {
    SchemaSettings::draft07().into_generator().into_root_schema_for::<T>().to_value()
}

/// Print the JSON Schema of a file that this program reads or writes, for editors and other programs
///
/// It is made of the same types as the program's own checks: unknown keys are refused, and every
/// key has its meaning and unit. What depends on several keys at once, or on a mesh, only the program checks.
#[derive(clap::Args, Clone, Debug)]
pub struct SchemaArguments {
    /// Which file; without it, those there are are listed
    format: Option<String>,
    /// The keys as tables in Markdown in place of the schema
    #[arg(long, requires = "format")]
    markdown: bool,
}

impl SchemaArguments {
    /// Prints one of these formats, or their names.
    pub fn print(&self, formats: &[Format]) -> Result<()> {
        let names = || formats.iter().map(|format| format.name);
        let text = match &self.format {
            None => formats.iter().map(|f| format!("{:12} {}\n", f.name, f.file)).collect(),
            Some(name) => {
                let found = formats.iter().find(|format| format.name == name);
                let format = found.with_context(|| {
                    let known = format!("expected one of {}", Vec::from_iter(names()).join(", "));
                    unknown(&format!("no file \"{name}\""), name, names(), ';', &known)
                })?;
                let schema = (format.schema)();
                match self.markdown {
                    true => markdown(&schema, format.is_report),
                    false => serde_json::to_string_pretty(&schema)? + "\n",
                }
            }
        };
        std::io::stdout().lock().write_all(text.as_bytes())?;
        Ok(())
    }
}
