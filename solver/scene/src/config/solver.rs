//! `[solver]`: numerical settings.

use anyhow::{Result, ensure};
use program::table::Range;
use program::{KeyPath, misfit};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::SimConfig;

/// First increment of the load of a path that is followed by its arc length.
const FIRST_OF_PATH: f64 = 0.05;

program::table! {
    /// Numerical settings of the equilibrium.
    #[derive(Clone, Debug)]
    pub struct SolverConfig {
        /// First load increment as a fraction of a time step, in a static scene of the full load [1].
        first_load_step: Option<f64> = None => "the largest", Range::above(0.0).at_most(1.0);
        /// Largest load increment, for smooth curves over the load [1].
        largest_load_step: Option<f64> = None => "1, or 0.1 with `simulate --curve`", Range::above(0.0);
        /// Increment below which the load counts as unreachable [1].
        smallest_load_step: f64 = 1e-3, Range::above(0.0);
        /// Newton iterations allowed in one load step.
        newton_iterations: Option<usize> = None => "30, or 200 with contact, where an impact takes many", Range::POSITIVE;
        /// Unbalanced force relative to the forces that balance, and gap of a
        /// prescribed volume relative to it [1].
        relative_tolerance: f64 = 1e-10, Range::above(0.0).below(1.0);
        /// Unbalanced force that counts as none [N]. If not given, that which would strain the bodies by
        /// 1e-11, shear modulus times volume to the power 2/3, but at most 1e-6 of the forces that balance.
        absolute_tolerance: Option<f64> = None, Range::NOT_NEGATIVE.unit("N");
        /// Where the change of volume counts: what a law says of it alone, such as ½ bulk ln²J.
        dilatation: Dilatation = Dilatation::Pointwise;
        /// What becomes of an equilibrium in which an element is turned inside out somewhere.
        inside_out: InsideOut = InsideOut::Refused;
        /// When `solver simulate` estimates by how much the state at the end would change with elements of
        /// the next degree, or with `dilatation = "mean"`. That costs an assembly and a factorisation with those.
        locking: Locking = Locking::Likely;
        /// What leads from one state of a static scene to the next.
        follow: Follow = Follow::Load;
        /// Number of states at which a path that is followed by its arc length ends, if it has not come to the
        /// full load.
        path_states: Option<usize> = None => "200", Range::POSITIVE;
        /// Volume of a chamber over that at rest, beyond which such a path ends [1].
        path_volume_factor: Option<f64> = None, Range::above(1.0);
        /// Whether the path alone is wanted: a run that ends after `path_states` before it has come to the full load is
        /// usable then.
        path_only: bool = false;
        /// Whether `solver simulate` reports the stability of the state at the end. That costs a factorisation
        /// in double precision; of states that are followed by their arc length it is always reported.
        stability: bool = false;
    }
}

/// What leads from one state of a static scene to the next.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Follow {
    /// The load, which grows from 0 to 1. Where it has a maximum, as the pressure of a balloon has, there is no
    /// equilibrium beyond.
    #[default]
    Load,
    /// The arc length of the path of equilibria: the load may fall and rise again, below 0, too. The path ends
    /// where it comes to the full load from below. Loads given as numbers or in proportion to t have a meaning
    /// below t = 0. Not with [time], friction or [[relaxation]].
    ArcLength,
}

impl Follow {
    /// Whether it is the load.
    pub fn is_load(&self) -> bool {
        *self == Self::Load
    }
}

/// Where the change of volume of an element counts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Dilatation {
    /// At every point.
    #[default]
    Pointwise,
    /// As a whole (mean dilatation), in elements of degree 2 by the mean of J, in those of degree 3 by the linear
    /// polynomial that is nearest to J: they do not lock, however large the bulk modulus. Two shear moduli of it count at
    /// every point all the same. With degree 1 there is no difference. Not for the laws `saint-venant-kirchhoff` and `linear-elastic`, nor with an objective `stress`.
    Mean,
}

/// When it is estimated what elements hold back.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Locking {
    /// Where it is likely: with the next degree for degree 1, and for degree 2 at a bulk modulus of more than 1000 shear
    /// moduli; with `dilatation = "mean"`, which costs no more than an iteration, from 50 shear moduli on.
    #[default]
    Likely,
    /// Always, for degrees 1 and 2, with the next degree and the same `dilatation`.
    Always,
    /// Never.
    Never,
}

/// What becomes of an equilibrium in which an element is turned inside out between its quadrature
/// points, where its energy does not see it.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum InsideOut {
    /// It counts as none.
    #[default]
    Refused,
    /// It is taken as it is, as programs do that do not look; `smallest_volume_ratio` of its load
    /// step is not positive.
    Tolerated,
}

impl SolverConfig {
    /// First load increment: as large as it may be, if none is given; a smaller one of a path.
    pub fn first_load_step(&self) -> f64 {
        let first = if self.follow.is_load() { 1.0 } else { FIRST_OF_PATH };
        self.first_load_step.unwrap_or(self.largest_load_step().min(first))
    }

    /// Largest load increment: all of it, if none is given.
    pub fn largest_load_step(&self) -> f64 {
        self.largest_load_step.unwrap_or(1.0)
    }

    /// Takes the load in ten steps where no largest one is given.
    pub fn step_for_curves(&mut self) {
        self.largest_load_step.get_or_insert(self.first_load_step.unwrap_or(0.0).max(0.1));
    }

    pub(super) fn check(&self) -> Result<()> {
        let (first, largest) = (self.first_load_step(), self.largest_load_step());
        let key = |key: &str| KeyPath::table("solver").key(key);
        ensure!(
            self.smallest_load_step <= first,
            misfit!(
                key("smallest_load_step"),
                " = {}: must be at most first_load_step = {first}",
                self.smallest_load_step
            )
        );
        ensure!(
            largest >= first,
            misfit!(
                key("largest_load_step"),
                " = {largest}: must be at least first_load_step = {first}"
            )
        );
        Ok(())
    }
}

impl SimConfig {
    /// Checks what a path that is followed by its arc length cannot have.
    pub(super) fn check_path(&self) -> Result<()> {
        let s = &self.solver;
        let refused =
            |key: &str, what: &str| KeyPath::table("solver").key(key).told(format!("{key} {what}"));
        if s.follow.is_load() {
            let alone = "is for follow = \"arc-length\": set that, or leave it away";
            ensure!(s.path_states.is_none(), refused("path_states", alone));
            ensure!(s.path_volume_factor.is_none(), refused("path_volume_factor", alone));
            ensure!(!s.path_only, refused("path_only", alone));
            return Ok(());
        }
        let history = [
            (self.time.is_some(), "[time]: states of a path have no order in time"),
            (!self.relaxation.is_empty(), "[[relaxation]]: a path has no rates"),
            (self.uncertainty.is_some(), "[uncertainty]: error bars are those of the full load"),
            (self.has_friction(), "friction: it depends on the way, not on the load alone"),
        ];
        if let Some((_, why)) = history.iter().find(|(found, _)| *found) {
            let what = format!("= \"arc-length\" does not go with {why}; leave one of both away");
            return Err(refused("follow", &what).into());
        }
        ensure!(
            s.path_volume_factor.is_none() || !self.chamber.is_empty(),
            refused("path_volume_factor", "needs a [[chamber]], of which there is none")
        );
        Ok(())
    }

    /// Whether surfaces rub against each other.
    pub(super) fn has_friction(&self) -> bool {
        self.contact().is_some_and(|contact| contact.friction > 0.0)
    }
}
