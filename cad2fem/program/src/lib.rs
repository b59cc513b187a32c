//! What all programs share: command line and exit codes, configuration files, hashes,
//! progress messages and memory use.

mod cli;
mod configuration;
mod hash;
mod memory;
mod progress;

pub use cli::{Unusable, Verbosity, run};
pub use configuration::{parse_toml, read_checked, read_toml};
pub use hash::{sha256, sha256_file};
pub use memory::peak_rss_mb;
pub use progress::{Progress, Spinner};
