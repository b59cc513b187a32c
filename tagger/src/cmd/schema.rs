//! `tagger schema`: the files that it reads.

use program::schema::Format;

use crate::config::FORMAT;

/// What the verb can print.
pub const FORMATS: &[Format] = &[FORMAT];
