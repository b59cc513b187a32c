//! The module `softpuffer._native`: what the Python package calls of Puffer's crates.
//!
//! Python gives names, numbers and NumPy's arrays, and gets them; checks and messages are those of
//! the programs. What these log goes to Python's `logging`. Computations release Python's lock, and end where Ctrl-C is pressed.

mod body;
mod course;
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

    /// Hands on what is logged. Another module of this process may have done so.
    #[pymodule_init]
    fn init(_module: &Bound<'_, PyModule>) -> PyResult<()> {
        let _one_is_enough = pyo3_log::try_init();
        Ok(())
    }

    /// Version of Puffer that this module was built from.
    #[pyfunction]
    fn version() -> &'static str {
        env!("CARGO_PKG_VERSION")
    }
}
