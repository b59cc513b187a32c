//! What one can buy: silicones, printers and tubes, each with the source of its numbers.
//!
//! The numbers are in `solver/silicones.toml`, `fab/printers.toml` and `fab/fittings.toml`.

pub mod fitting;
pub mod printer;
pub mod silicone;
