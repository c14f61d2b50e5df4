//! One plan, from a request to an outcome.

pub mod best;
pub mod connect_goals;
pub mod first_solution;
pub mod improvement;
pub mod leg_search;
pub mod plan;
pub mod request;
pub mod restarts;
pub mod stages;
pub mod start_recovery;
pub mod tour_search;
