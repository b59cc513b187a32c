//! The module `softpuffer._native`: what the Python package calls of Puffer's crates.
//!
//! Python gives names, numbers and NumPy's arrays, and gets them; checks and messages are those of
//! the programs. What these log goes to Python's `logging`, and what they warn of a run to the run. Computations release
//! Python's lock, and end where Ctrl-C is pressed.

mod body;
mod computing;
mod error;
mod run;
mod saved;
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

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        crate::computing::hear(module.py())
    }

    /// Refuses a process that was forked from one in which there are threads.
    #[pyfunction]
    fn check_process(py: Python<'_>) -> PyResult<()> {
        crate::computing::compute(py, || ())
    }

    /// Version of Puffer that this module was built from.
    #[pyfunction]
    fn version() -> &'static str {
        env!("CARGO_PKG_VERSION")
    }
}
