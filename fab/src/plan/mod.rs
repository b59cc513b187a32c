//! How a body is to be molded: what is measured, what that decides, and why.

pub mod report;
