//! The module `softpuffer._native`: what the Python package calls of Puffer's crates.
//!
//! Python gives names, numbers and NumPy's arrays, and gets them; checks and messages are those of
//! the programs. Computations release Python's lock, and end where Ctrl-C is pressed.

mod body;
mod error;
mod run;
mod scene;

use pyo3::prelude::*;

/// Holds what Python sees.
#[pymodule]
mod _native {
    use super::*;

    #[pymodule_export]
    use super::body::Body;
    #[pymodule_export]
    use super::error::{InputError, NoEquilibrium};
    #[pymodule_export]
    use super::run::Run;
    #[pymodule_export]
    use super::scene::Scene;

    /// Version of Puffer that this module was built from.
    #[pyfunction]
    fn version() -> &'static str {
        env!("CARGO_PKG_VERSION")
    }
}
