//! What all programs share: command line and exit codes, configuration files, hashes,
//! progress messages and memory use.

mod checkpoint;
mod child;
mod cli;
mod hash;
mod input;
mod interrupt;
mod json;
mod lock;
mod memory;
mod names;
mod nearest;
mod pattern;
mod picked;
mod progress;
pub mod schema;
mod settings;
mod shell;
pub mod table;
mod temporary;
mod terminal;
pub mod units;

pub use checkpoint::{check_unaltered, read_checkpoint, write_checkpoint};
pub use child::{Process, beside};
pub use cli::{Unusable, Verbosity, run};
pub use hash::{sha256, sha256_file};
pub use input::{InputFile, relative};
pub use json::write_json;
pub use lock::FolderLock;
pub use memory::peak_rss_mb;
pub use names::Names;
pub use nearest::{did_you_mean, nearest, unknown};
pub use pattern::fits;
pub use picked::{Picked, Recognized};
pub use progress::{Heartbeat, about};
pub use settings::{
    Change, Changes, KeyPath, Keys, Meaning, Misfit, Settings, VERSION, read_key, read_table,
    read_toml,
};
pub use shell::parse;
pub use temporary::temporary_folder;
pub use terminal::{Stdout, stdout};
