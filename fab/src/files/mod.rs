//! What is written: surfaces rounded for printing, `mold.json`, 3MF, settings of the slicer,
//! the sheet for casting and its page, pictures.

pub mod assembly;
pub mod export;
pub mod output;
pub mod page;
pub mod picture;
pub mod report;
pub mod sheet;
pub mod slicer;
pub mod undercut;
