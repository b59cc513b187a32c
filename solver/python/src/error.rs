//! Exceptions, with the messages of the programs.

use pyo3::exceptions::{PyRuntimeError, PyValueError};
use pyo3::{PyErr, create_exception};

create_exception!(softpuffer, InputError, PyValueError, "What was given cannot be used.");
create_exception!(softpuffer, NoEquilibrium, PyRuntimeError, "No equilibrium was found.");

/// Input that cannot be used.
pub fn refused(error: impl Into<anyhow::Error>) -> PyErr {
    InputError::new_err(format!("{:#}", error.into()))
}

/// Input that cannot be used, in words.
pub fn refused_as(message: String) -> PyErr {
    InputError::new_err(message)
}
