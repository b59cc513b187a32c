//! One name, or several, as files have them.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// One name, or a list of names.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(untagged, expecting = "expected a name in quotes, or a list of names")]
pub enum Names {
    /// One.
    One(String),
    /// A list.
    Several(Vec<String>),
}

impl Names {
    /// All of them.
    pub fn all(&self) -> &[String] {
        match self {
            Self::One(name) => std::slice::from_ref(name),
            Self::Several(names) => names,
        }
    }
}
