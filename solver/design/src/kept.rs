//! What a level keeps: its constraints as linear inequalities in the variables, and the way back to them.
//!
//! A shape that violates some of them is moved as little as possible, in the mean square of the motion of the surface:
//!
//! d = M⁻¹ Aᵀ (A M⁻¹ Aᵀ)⁻¹ v      v what the violated ones lack, A their derivatives
//!
//! again and again, as distances are not linear in the variables. No run is simulated for that.

use measure::constraint::{Constraint, Inequality};
use mesh::Vec3;
use variables::step::{LeastMotion, Row};
use variables::vectors::along;

use super::{Level, Rejected};

/// Part of a gap by which it may close in a step, to first order.
const MOST_CLOSED: f64 = 0.8;
/// Steps on the way back.
const STEPS: usize = 30;
/// Longest of these, over the mean edge.
const LONGEST: f64 = 0.5;
/// What is aimed at beyond the constraint, over its tolerance.
const AIM: f64 = 0.5;
/// Inequalities that are restored at once.
const AT_ONCE: usize = 300;

impl Level {
    /// The inequalities of the constraints that a step that moves the surface by at most `motion` [m] may violate.
    pub fn kept_rows(&self, theta: &[f64], motion: f64) -> Vec<Row> {
        if self.constraints.is_empty() {
            return Vec::new();
        }
        let rest = self.map.surface(theta);
        let of_one = |(index, kept): (usize, &Constraint)| {
            self.as_rows(theta, Some(index), kept.near(&rest, motion))
        };
        self.constraints.iter().enumerate().flat_map(of_one).collect()
    }

    /// Inequalities by which no gap of the surface closes by more than a part in one step.
    pub fn open_rows(&self, theta: &[f64], motion: f64) -> Vec<Row> {
        if self.map.moving().is_empty() {
            return Vec::new();
        }
        let mut gaps = self.path.gaps(&self.map.surface(theta), motion);
        gaps.iter_mut().for_each(|gap| gap.value *= MOST_CLOSED);
        self.as_rows(theta, None, gaps)
    }

    /// Inequalities in the variables; what the level does not move is as it is.
    fn as_rows(&self, theta: &[f64], of: Option<usize>, all: Vec<Inequality>) -> Vec<Row> {
        let one = |c: Inequality| {
            let a = self.map.by_surface(theta, &c.by);
            Row { a, c: c.value, of }
        };
        all.into_iter().map(one).filter(|row| !row.a.is_empty()).collect()
    }

    /// The worst inequality of each constraint at a rest shape.
    fn worst(&self, rest: &[Vec3]) -> Vec<Option<Inequality>> {
        let least = |kept: &Constraint| {
            let near = kept.near(rest, 0.0).into_iter();
            near.min_by(|a, b| a.value.total_cmp(&b.value))
        };
        self.constraints.iter().map(least).collect()
    }

    /// How far one may be violated.
    pub fn tolerance(&self, row: &Row) -> f64 {
        let of_shape = self.constraints.len();
        match row.of {
            None => 0.0,
            Some(index) if index < of_shape => self.constraints[index].tolerance,
            Some(index) => self.bounds()[index - of_shape].tolerance(),
        }
    }

    /// Whether a rest shape keeps all constraints, to their tolerances.
    pub fn check_kept(&self, rest: &[Vec3]) -> Result<(), Rejected> {
        let rests = |worst: &Inequality| {
            let zero = vec![0.0; self.variables()];
            self.map.by_surface(&zero, &worst.by).is_empty()
        };
        let one = |(kept, worst): (&Constraint, Option<Inequality>)| {
            let worst = worst.filter(|worst| worst.value < -kept.tolerance)?;
            let [x, y, z] = worst.at.into();
            let place = if rests(&worst) { ", which the level does not move," } else { "" };
            Some(format!(
                "[[constraint]] \"{}\": {} at ({x:.5}, {y:.5}, {z:.5}) m{place} where at least {} is to be kept",
                kept.name,
                kept.in_words(kept.least + worst.value),
                kept.in_words(kept.least)
            ))
        };
        let said: Vec<String> =
            self.constraints.iter().zip(self.worst(rest)).filter_map(one).collect();
        if said.is_empty() { Ok(()) } else { Err(Rejected::new(said.join("; "))) }
    }

    /// The variables next to these at which all constraints are kept.
    pub fn restored(&self, theta: &[f64]) -> Result<Vec<f64>, Rejected> {
        let mut theta = theta.to_vec();
        if self.constraints.is_empty() || self.map.shape_variables() == 0 {
            return Ok(theta);
        }
        let mut back = None;
        for _ in 0..STEPS {
            let mut rows = self.kept_rows(&theta, 0.0);
            let tolerance = |row: &Row| self.tolerance(row);
            rows.retain(|row| row.c < 0.0);
            if rows.iter().all(|row| row.c >= -AIM * tolerance(row)) {
                break;
            }
            rows.sort_by(|a, b| (a.c / tolerance(a)).total_cmp(&(b.c / tolerance(b))));
            rows.truncate(AT_ONCE);
            let lacks: Vec<f64> = rows.iter().map(|row| AIM * tolerance(row) - row.c).collect();
            let back = back.get_or_insert_with(|| self.least_motion(&theta));
            let Some(d) = back.step(&rows, &lacks, theta.len()) else { break };
            let motion = self.map.motion(&theta, &along(&theta, &d, 1.0));
            let part = (LONGEST * self.map.mean_edge / motion).min(1.0);
            theta = along(&theta, &d, part);
        }
        self.check_kept(&self.map.surface(&theta)).map_err(|rejected| {
            Rejected::new(format!("no shape was found next to this one that keeps all constraints: the last one has {rejected}"))
        })?;
        Ok(theta)
    }

    /// In the metric of the level; that of free vertices is the same in all directions.
    fn least_motion(&self, theta: &[f64]) -> LeastMotion {
        LeastMotion::new(self.is_small().then(|| self.map.metric(theta)))
    }
}
