//! A row of the table of objectives.

use std::fmt::Debug;
use std::path::Path;
use std::sync::Arc;

use anyhow::{Context as _, Result, anyhow, bail};
use program::schema::add_kind;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Serialize;
use serde::de::DeserializeOwned;

use super::{Context, KINDS, Objective};

/// Keys that every `[[objective]]` has besides `kind`, with what they mean.
pub const COMMON_KEYS: [(&str, &str); 4] = [
    ("name", "as reports call it"),
    ("weight", "of the value, in the inverse of its unit"),
    ("share", "in place of weight: the part of the objective that the term is at the start"),
    (
        "over",
        "the time: \"final\" (default), { steps = [2, 5] } or { times = [0.4, 1.0] } for their mean, \
         or a sum [s]: \"uniform\", \"trapezoid\", \"simpson\"",
    ),
];

/// Keys that several kinds have.
pub(super) const TAGS: (&str, &str) = ("on", "tag, body, or list of them");
pub(super) const MEASURE: (&str, &str) = ("measure", "\"rest\" (default) or \"deformed\"");
pub(super) const AXES: (&str, &str) = ("components", "axes that count, such as \"xz\" (\"xyz\")");
pub(super) const BODY: (&str, &str) = ("on", "body; all if not given");

/// A kind of objective: what to write, what it means, how to read it.
#[derive(Debug)]
pub struct Kind {
    /// `kind` in an `[[objective]]`.
    pub key: &'static str,
    /// What it is.
    pub formula: &'static str,
    /// SI unit of its value; a weight has the inverse.
    pub unit: &'static str,
    /// Keys besides `kind` and [`COMMON_KEYS`], with what they mean.
    pub keys: &'static [(&'static str, &'static str)],
    /// Whether its weight may be negative, so that it is maximised.
    pub may_be_maximised: bool,
    /// Whether it looks at forces between surfaces, so that it needs `[contact]`.
    pub needs_contact: bool,
    /// How its own keys are read.
    pub(super) form: Form,
}

/// The type that the keys of a kind are read into.
#[derive(Debug)]
pub(super) struct Form {
    /// From a table of them, and the same with all defaults written.
    read: fn(toml::Table) -> Result<Read>,
    /// As a schema.
    schema: fn(&mut SchemaGenerator) -> Schema,
}

/// The form of the type `S`.
pub(super) const fn form<S>() -> Form
where
    S: Specification + Serialize + DeserializeOwned + JsonSchema + 'static,
{
    Form { read: read::<S>, schema: S::json_schema }
}

/// The keys of one kind, and the same as a table.
pub type Read = (Arc<dyn Specification>, toml::Table);

/// Builds a term with a name on a body; the files that the term names have been read.
pub type Builder = Box<dyn Fn(&str, &Context) -> Result<Box<dyn Objective>> + Send + Sync>;

/// One kind of `[[objective]]` as it is written, without the keys of all kinds.
pub trait Specification: Debug + Send + Sync {
    /// Checks what can be checked without a body.
    ///
    /// # Errors
    /// With what was found and what is needed.
    fn check(&self) -> Result<()> {
        Ok(())
    }
    /// Whether a negative weight has a sense, if it has for this kind.
    fn may_be_maximised(&self) -> bool {
        true
    }
    /// Whether it is made with the stress of the law at each point.
    fn reads_stress(&self) -> bool {
        false
    }
    /// The files that it names, from the folder of the design.
    fn files(&self) -> Vec<&Path> {
        Vec::new()
    }
    /// Reads its files, from the folder of the design.
    ///
    /// # Errors
    /// When one cannot be read, or does not fit.
    fn prepare(&self, folder: &Path) -> Result<Builder>;
}

impl Kind {
    /// The kind that is called so.
    ///
    /// # Errors
    /// When there is none; the message lists those there are.
    pub fn find(key: &str) -> Result<&'static Self> {
        KINDS.iter().find(|kind| kind.key == key).with_context(|| {
            let known: Vec<String> = KINDS.iter().map(|kind| format!("`{}`", kind.key)).collect();
            format!(
                "unknown kind `{key}`, expected one of {}\n  `solver list --objectives` explains \
                 them",
                known.join(", ")
            )
        })
    }

    /// Reads the keys of this kind alone.
    ///
    /// # Errors
    /// When one is unknown, missing or of the wrong type.
    pub fn read(&self, keys: toml::Table) -> Result<Read> {
        refuse_unknown(self.key, &keys, &COMMON_KEYS, self.keys)?;
        (self.form.read)(keys).with_context(|| format!("kind = \"{}\"", self.key))
    }

    /// The table of this kind, without [`COMMON_KEYS`].
    #[must_use]
    pub fn schema(&self, generator: &mut SchemaGenerator) -> Schema {
        let mut schema = (self.form.schema)(generator);
        let sense = if self.may_be_maximised { "; a negative weight maximises it" } else { "" };
        let about = format!("{} [{}]{sense}.", self.formula, self.unit);
        add_kind(&mut schema, self.key, &about, self.keys);
        schema
    }
}

/// Reads the keys of a kind as `S`.
fn read<S>(keys: toml::Table) -> Result<Read>
where
    S: Specification + Serialize + DeserializeOwned + 'static,
{
    let (found, table) = from_keys::<S>(keys)?;
    Ok((Arc::new(found), table))
}

/// Refuses keys that a kind does not have; `common` are those that every kind has, and that
/// were taken out before.
///
/// # Errors
/// With the key and those that are known.
pub fn refuse_unknown(
    kind: &str,
    keys: &toml::Table,
    common: &[(&str, &str)],
    own: &[(&str, &str)],
) -> Result<()> {
    let Some(unknown) = keys.keys().find(|name| !own.iter().any(|(key, _)| key == name)) else {
        return Ok(());
    };
    let known: Vec<String> = common.iter().chain(own).map(|(key, _)| format!("`{key}`")).collect();
    bail!("kind = \"{kind}\": unknown field `{unknown}`, expected one of {}", known.join(", "))
}

/// Keys as a type, and the same with all defaults written.
///
/// # Errors
/// When one is missing or of the wrong type.
pub fn from_keys<S: Serialize + DeserializeOwned>(keys: toml::Table) -> Result<(S, toml::Table)> {
    let found: S = keys
        .try_into()
        .map_err(|e: toml::de::Error| anyhow!("{}", e.to_string().trim_end().replace('\n', " ")))?;
    let table = toml::Table::try_from(&found)?;
    Ok((found, table))
}

/// Refuses a length that is not positive.
pub(super) fn positive(key: &str, length: f64) -> Result<()> {
    anyhow::ensure!(length.is_finite() && length > 0.0, "{key} = {length} m must be positive");
    Ok(())
}
