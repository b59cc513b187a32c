//! `fab schema`: the files that it reads, and the report that it writes.

use program::schema::Format;

use crate::config::Config;
use crate::files::report::MoldReport;

/// What the verb can print.
pub const FORMATS: &[Format] = &[
    Format::of::<Config>("mold", "mold.toml"),
    Format::of_report::<MoldReport>("mold-report", "mold.json"),
];
