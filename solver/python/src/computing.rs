//! How Python's threads compute: without its lock, with what is warned of, in the process that began, and until Ctrl-C.

use std::cell::RefCell;
use std::ops::ControlFlow;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use log::{Level, LevelFilter, Log, Metadata, Record};
use mechanics::forward::{Event, Watch};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3_log::{Caching, Logger};

/// The process in which the threads of the solver are; 0 before there are any.
static OWNER: AtomicU32 = AtomicU32::new(0);

thread_local! {
    /// Warnings of the computation of this thread, where they are collected.
    static WARNINGS: RefCell<Option<Vec<String>>> = const { RefCell::new(None) };
}

/// Hands warnings to who collects them, and all else to Python's `logging`.
struct Told(Logger);

impl Log for Told {
    fn enabled(&self, of: &Metadata) -> bool {
        of.level() == Level::Warn || self.0.enabled(of)
    }

    fn log(&self, record: &Record) {
        let collected = record.level() == Level::Warn
            && WARNINGS.with_borrow_mut(|warnings| {
                warnings.as_mut().map(|all| all.push(record.args().to_string())).is_some()
            });
        if !collected && self.0.enabled(record.metadata()) {
            self.0.log(record);
        }
    }

    fn flush(&self) {
        self.0.flush();
    }
}

/// Hands on what is logged. Another module of this process may have done so.
pub fn hear(py: Python<'_>) -> PyResult<()> {
    let told = Told(Logger::new(py, Caching::LoggersAndLevels)?);
    if log::set_boxed_logger(Box::new(told)).is_ok() {
        log::set_max_level(LevelFilter::Debug);
    }
    Ok(())
}

/// Computes without Python's lock.
pub fn compute<T: Send>(py: Python<'_>, work: impl FnOnce() -> T + Send) -> PyResult<T> {
    let own = std::process::id();
    let owner = OWNER.compare_exchange(0, own, Ordering::Relaxed, Ordering::Relaxed);
    if owner.is_err_and(|owner| owner != own) {
        return Err(PyRuntimeError::new_err(
            "this process was forked from one in which softpuffer has threads, which are not in it, so that it would wait \
             for ever: begin processes by multiprocessing.get_context(\"spawn\"), or run cases beside each other in threads, \
             as softpuffer.simulate_all does",
        ));
    }
    Ok(py.detach(work))
}

/// What a computation finds, and what it warns of.
pub fn collect<T>(work: impl FnOnce() -> T) -> (T, Vec<String>) {
    let before = WARNINGS.replace(Some(Vec::new()));
    let found = work();
    (found, WARNINGS.replace(before).unwrap_or_default())
}

/// Where an exception lies that has broken off a computation.
#[derive(Clone, Default)]
pub struct Break(Arc<Mutex<Option<PyErr>>>);

impl Break {
    /// The exception, if there is one.
    pub fn take(&self) -> Option<PyErr> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).take()
    }

    /// Calls Python at every iterate, and breaks off where that raises, or Ctrl-C was pressed. Other events are for
    /// the watch of the scene.
    pub fn watch(&self, mut scene: Option<Watch>, progress: Option<Py<PyAny>>) -> Watch {
        let own = self.clone();
        Box::new(move |event| {
            let told = match *event {
                Event::Iterate { time, iteration, residual, wanted } => {
                    Some((time, iteration, residual, wanted))
                }
                Event::Adjoint { .. } => None,
                _ => return scene.as_mut().map_or(ControlFlow::Continue(()), |watch| watch(event)),
            };
            let mut raised = own.0.lock().unwrap_or_else(PoisonError::into_inner);
            // after a failure next to another run, a second search from rest would ignore the break
            if raised.is_some() {
                return ControlFlow::Break(());
            }
            let said = Python::attach(|py| {
                py.check_signals()?;
                match (&progress, told) {
                    (Some(call), Some(told)) => call.call1(py, told).map(drop),
                    _ => Ok(()),
                }
            });
            *raised = said.err();
            if raised.is_some() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
        })
    }
}
