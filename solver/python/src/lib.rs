//! The module `softpuffer._native`: what the Python package calls of Puffer's crates.

use pyo3::prelude::*;

/// Holds what Python sees.
#[pymodule]
mod _native {
    use super::*;

    /// Version of Puffer that this module was built from.
    #[pyfunction]
    fn version() -> &'static str {
        env!("CARGO_PKG_VERSION")
    }
}
