//! Shortest paths among circles: tangents, and arcs between them. Exact, so no passage is too narrow.

pub mod arcs;
pub mod path;
pub mod search;
