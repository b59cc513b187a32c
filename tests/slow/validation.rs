//! `make validation`: the tolerances of pipelines/validation/README.md, which were stated before
//! the simulations.

use solver::validation::{Comparison, Config};
use tests::workdir::repository;

use crate::make;

/// Simulations "after" of the rows whose names begin with `body`, beside what was measured.
fn after(body: &str) -> Vec<Comparison> {
    make(&format!("build/validation/{body}/after/report.json"));
    let folder = repository().join("pipelines/validation");
    let mut config: Config = program::read_toml(&folder.join("validation.toml")).unwrap();
    config.row.retain(|row| row.name.starts_with(body));
    config.row.iter_mut().for_each(|row| row.run.retain(|run| run.name == "after"));
    config.compare(&folder).unwrap()
}

#[test]
#[ignore = "simulates a cantilever: runs in make test-all"]
fn the_beam_droops_as_measured() {
    let rows = after("beam");
    assert_eq!(rows.len(), 3);
    for row in rows {
        assert!(row.simulated.len() == 2 && !row.fitted);
        assert_eq!(row.tolerance, [-0.15, 0.15]);
        assert!(row.within, "{}: {:.3} at most", row.row, row.largest);
    }
}
