//! `cad2fem schema`: the files that it reads.

use implicit::Model;
use program::schema::Format;

use crate::tetmesh::config::Config;

/// What the verb can print.
pub const FORMATS: &[Format] =
    &[Format::of::<Model>("model", "model.toml"), Format::of::<Config>("cad2fem", "cad2fem.toml")];
