//! Bodies that nothing holds: their loads must balance, and their rigid motions are taken out by a tiny mass.

use anyhow::{Result, ensure};
use mechanics::forward::Problem;
use mesh::Vec3;

use super::Scene;
use crate::supports::Supports;

/// Force along a free motion, over the sum of all forces, from which loads do not balance.
const UNBALANCED: f64 = 1e-6;

impl Scene {
    /// Refuses loads at rest that would carry a body away that nothing holds, and says which motions are taken out; none
    /// where planes of symmetry or guides hold it.
    pub(super) fn check_afloat(
        &self,
        problem: &Problem,
        supports: &Supports,
        rest: &[Vec3],
    ) -> Result<()> {
        let free = supports.free_motions(&problem.space);
        if free.is_empty() {
            return Ok(());
        }
        let zero = vec![0.0; problem.dofs()];
        let at = problem.iterate(rest, &zero, self.end());
        let mut forces = vec![0.0; problem.dofs()];
        let loads = problem.energies.terms().filter(|term| !term.nature().is_elastic());
        loads.for_each(|term| term.energy.add_gradient(&at, &mut forces));
        let total: f64 = forces.iter().map(|f| f.abs()).sum();
        for motion in &free {
            let along = motion.work(&forces);
            ensure!(
                along.abs() <= UNBALANCED * total,
                "{}: nothing holds the body, and its loads do not balance: it can {}, and {:.3e} N of {total:.3e} N push \
                 it that way\n  hold it with [[fixed]], or give it loads that balance, such as those of closed chambers",
                self.path.display(),
                motion.name,
                along.abs()
            );
        }
        let mut names: Vec<&str> = free.iter().map(|motion| motion.name).collect();
        names.dedup();
        log::info!("nothing holds the body: it could {}; that is taken out", names.join(", "));
        Ok(())
    }
}
