//! Sampling planners (section 3.4 of the paper): trees of random samples.

pub mod rrt;
pub mod rrt_connect;
pub mod rrt_star;
pub mod search_tree;
