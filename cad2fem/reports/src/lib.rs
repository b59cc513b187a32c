//! What programs report, as types: who writes a report fills them, who reads it has them, and the
//! table of keys in the book is made from them.
//!
//! A number that is not finite is written as `null`, as JSON has no other way.

mod failed;
mod measured;
mod mullins;
mod numbers;
mod optimization;
mod simulation;
mod stability;
mod step;
mod terms;
mod validation;
mod windings;

pub use failed::{Crossing, Failed, Failure, Pivot, SoftestStiffness, WorstElement};
pub use measured::{
    Chamber, ErrorBar, ErrorBars, Locking, MaterialRange, Probe, StretchRange, Tag,
};
pub use mullins::{Inflated, Inflation, Mullins};
pub use numbers::{Numbers, numbers};
pub use optimization::{
    Castable, Designed, DesignedProbe, Ended, Handles, Iteration, Kept, LevelEnd, NoStart,
    Optimization, Remeshed, ScenarioRun,
};
pub use simulation::{
    CutPlane, End, EnergyBalance, Inputs, Material, Moduli, OneOrList, Silicone, Simulation,
    Status, Task, Timings,
};
pub use stability::{
    DirectIterate, Limit, LimitState, LimitStatus, PassedPoint, PathState, PointKind, Stability,
};
pub use step::{Collisions, ForceBalance, PairForce, RigidPart, Step};
pub use terms::*; // a section for each room, named there alone
pub use validation::{BandEnd, Comparison, MeasuredPoint, Validation};
pub use windings::{Segment, SegmentEnd, WINDINGS};
