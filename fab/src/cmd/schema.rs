//! `fab schema`: the files that it reads.

use program::schema::Format;

use crate::config::Config;

/// What the verb can print.
pub const FORMATS: &[Format] = &[Format::of::<Config>("mold", "mold.toml")];
