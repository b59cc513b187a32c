//! `chamber`: the tags of the walls of the air chambers.

use program::{KeyPath, Misfit, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Tags of the walls of air chambers, in the order in which cores are numbered; none for a body
/// without a chamber. Written as one tag or as a list.
#[derive(Clone, Debug, Deserialize, JsonSchema, PartialEq, Eq, Serialize)]
#[serde(from = "Written", into = "Written")]
pub struct Chambers(Vec<String>);

#[derive(Deserialize, JsonSchema, Serialize)]
#[serde(untagged, expecting = "the tag of the chamber's wall, or a list of such tags")]
enum Written {
    One(String),
    List(Vec<String>),
}

impl Chambers {
    /// A single chamber.
    pub fn one(tag: &str) -> Self {
        Self(vec![tag.into()])
    }

    /// The tags.
    pub fn tags(&self) -> &[String] {
        &self.0
    }

    /// Whether no tag is named twice.
    pub fn check(key: &KeyPath, chambers: &Self) -> Result<(), Misfit> {
        let twice = |(i, tag): &(usize, &String)| chambers.0[..*i].contains(tag);
        match chambers.0.iter().enumerate().find(twice) {
            Some((_, tag)) => Err(misfit!(key.clone(), " names {tag:?} twice")),
            None => Ok(()),
        }
    }
}

impl From<Written> for Chambers {
    fn from(written: Written) -> Self {
        match written {
            Written::One(tag) => Self(vec![tag]),
            Written::List(tags) => Self(tags),
        }
    }
}

impl From<Chambers> for Written {
    fn from(Chambers(mut tags): Chambers) -> Self {
        match tags.len() {
            1 => Self::One(tags.remove(0)),
            _ => Self::List(tags),
        }
    }
}
