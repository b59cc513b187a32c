//! Walls that are off: the rest shape of a scenario from the designed one.
//!
//! X_s = X + 𝓔 Σ d_k n_k(X)
//!
//! d_k      how far the walls with a tag, or all, are off, outward [m]
//! n_k(X)   moves of their vertices per distance, [`shifts`]
//! 𝓔        extension into the interior, of the body at the beginning of a level

use anyhow::{Result, anyhow};
use mechanics::body::Body;
use mechanics::element::at;
use mesh::Vec3;
use mesh::offset::{add_shifts_vjp, shifts};
use scene::config::ScenarioConfig;

use mechanics::extension::Extension;

/// The map of one scenario.
pub struct Offset {
    /// Facets, and how far they are off [m].
    walls: Vec<(Vec<[usize; 3]>, f64)>,
    extension: Extension,
}

impl Offset {
    /// The map for a body; none where no wall is off.
    pub fn new(config: &ScenarioConfig, body: &Body) -> Result<Option<Self>> {
        let mut walls = Vec::new();
        for (tag, distance) in config.walls() {
            let facets = match tag {
                None => body.boundary().to_vec(),
                Some(tag) => body.facets(tag)?,
            };
            walls.push((facets, distance));
        }
        if walls.is_empty() {
            return Ok(None);
        }
        let extension = Extension::new(body)
            .map_err(|_| anyhow!("wall: an element of the mesh is too flat to move with it"))?;
        Ok(Some(Self { walls, extension }))
    }

    /// X_s [m].
    pub fn apply(&self, designed: &[Vec3]) -> Vec<Vec3> {
        let mut moves = vec![Vec3::zeros(); designed.len()];
        for (facets, distance) in &self.walls {
            for (v, d) in shifts(designed, facets) {
                moves[v] += *distance * d;
            }
        }
        self.extension.apply(&mut moves);
        designed.iter().zip(moves).map(|(x, d)| x + d).collect()
    }

    /// Adds to the cotangent of X_s, three components per vertex, what makes it that of X.
    pub fn add_vjp(&self, designed: &[Vec3], bar: &mut [f64]) {
        let mut moves_bar: Vec<Vec3> = (0..designed.len()).map(|v| at(bar, v)).collect();
        self.extension.vjp(&mut moves_bar);
        let mut by_designed = vec![Vec3::zeros(); designed.len()];
        for (facets, distance) in &self.walls {
            let scaled: Vec<Vec3> = moves_bar.iter().map(|b| *distance * b).collect();
            add_shifts_vjp(designed, facets, &scaled, &mut by_designed);
        }
        for (v, by) in by_designed.iter().enumerate() {
            (0..3).for_each(|k| bar[3 * v + k] += by[k]);
        }
    }
}
