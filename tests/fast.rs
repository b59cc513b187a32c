//! Tests that run in seconds.
#![allow(missing_docs, clippy::unwrap_used)]

#[path = "fast/afloat.rs"]
mod afloat;
#[path = "fast/alike.rs"]
mod alike;
#[path = "fast/as_cast.rs"]
mod as_cast;
#[path = "fast/bad_design.rs"]
mod bad_design;
#[path = "fast/book.rs"]
mod book;
#[path = "fast/bounds.rs"]
mod bounds;
#[path = "fast/budgets.rs"]
mod budgets;
#[path = "fast/calibrate.rs"]
mod calibrate;
#[path = "fast/campaign.rs"]
mod campaign;
#[path = "fast/carry.rs"]
mod carry;
#[path = "fast/castable.rs"]
mod castable;
#[path = "fast/compare.rs"]
mod compare;
#[path = "fast/contact_failures.rs"]
mod contact_failures;
#[path = "fast/design_line.rs"]
mod design_line;
#[path = "fast/energy_in_time.rs"]
mod energy_in_time;
#[path = "fast/error_bars.rs"]
mod error_bars;
#[path = "fast/export.rs"]
mod export;
#[path = "fast/failures.rs"]
mod failures;
#[path = "fast/features.rs"]
mod features;
#[path = "fast/fibres.rs"]
mod fibres;
#[path = "fast/flat_element.rs"]
mod flat_element;
#[path = "fast/gallery.rs"]
mod gallery;
#[path = "fast/groove.rs"]
mod groove;
#[path = "fast/hostile_page.rs"]
mod hostile_page;
#[path = "fast/limit.rs"]
mod limit;
#[path = "fast/limits.rs"]
mod limits;
#[path = "fast/lines.rs"]
mod lines;
#[path = "fast/locking.rs"]
mod locking;
#[path = "fast/interrupted.rs"]
mod interrupted;
#[path = "fast/keep.rs"]
mod keep;
#[path = "fast/import.rs"]
mod import;
#[path = "fast/make_body.rs"]
mod make_body;
#[path = "fast/materials.rs"]
mod materials;
#[path = "fast/map.rs"]
mod map;
#[path = "fast/measured_rubber.rs"]
mod measured_rubber;
#[path = "fast/mold_report.rs"]
mod mold_report;
#[path = "fast/mullins.rs"]
mod mullins;
#[path = "fast/names.rs"]
mod names;
#[path = "fast/nested.rs"]
mod nested;
#[path = "fast/newton.rs"]
mod newton;
#[path = "fast/numbers.rs"]
mod numbers;
#[path = "fast/optimize.rs"]
mod optimize;
#[path = "fast/page.rs"]
mod page;
#[path = "fast/path_page.rs"]
mod path_page;
#[path = "fast/pick.rs"]
mod pick;
#[path = "fast/places.rs"]
mod places;
#[cfg(unix)]
#[path = "fast/planted.rs"]
mod planted;
#[path = "fast/plug.rs"]
mod plug;
#[path = "fast/polyfem.rs"]
mod polyfem;
#[path = "fast/probes.rs"]
mod probes;
#[path = "fast/python.rs"]
mod python;
#[path = "fast/python_page.rs"]
mod python_page;
#[path = "fast/reinforced_page.rs"]
mod reinforced_page;
#[path = "fast/refused.rs"]
mod refused;
#[path = "fast/rigid.rs"]
mod rigid;
#[path = "fast/samples.rs"]
mod samples;
#[path = "fast/scales.rs"]
mod scales;
#[path = "fast/scenarios.rs"]
mod scenarios;
#[path = "fast/schemas.rs"]
mod schemas;
#[path = "fast/set_from_outside.rs"]
mod set_from_outside;
#[path = "fast/solver_bad_input.rs"]
mod solver_bad_input;
#[path = "fast/solver_cli.rs"]
mod solver_cli;
#[path = "fast/solver_tools.rs"]
mod solver_tools;
#[path = "fast/sweep.rs"]
mod sweep;
#[path = "fast/symmetric_contact.rs"]
mod symmetric_contact;
#[path = "fast/symmetry.rs"]
mod symmetry;
#[path = "fast/terminal.rs"]
mod terminal;
#[path = "fast/threads.rs"]
mod threads;
#[path = "fast/tidy.rs"]
mod tidy;
#[path = "fast/validate.rs"]
mod validate;
