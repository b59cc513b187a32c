//! From design variables to rest shape and loads, each map with its transposed derivative:
//! free-form deformation of surfaces by handles with bounded biharmonic weights, an
//! extension into the interior, and schedules of pressures.

mod biharmonic;
mod carry;
mod design_map;
mod geodesic;
mod handles;
mod held;
mod isometry;
mod load_map;
mod metric;
mod patch;
mod pressure_curve;
mod sampling;

pub use carry::{carry, check_same_body};
pub use design_map::DesignMap;
pub use load_map::LoadMap;
