//! Paths once they are found: simplification, the legs of a tour, the order of visit.

pub mod simplify;
pub mod tour;
pub mod visit_order;
