//! What all programs share: command line and exit codes, configuration files, hashes,
//! progress messages and memory use.

mod checkpoint;
mod child;
mod cli;
mod configuration;
mod hash;
mod interrupt;
mod lock;
mod memory;
mod progress;

pub use checkpoint::{check_unaltered, read_checkpoint, write_checkpoint};
pub use child::Process;
pub use cli::{Unusable, Verbosity, run};
pub use configuration::{parse_toml, read_checked, read_toml};
pub use hash::{sha256, sha256_file};
pub use lock::FolderLock;
pub use memory::peak_rss_mb;
pub use progress::{Progress, Spinner};
