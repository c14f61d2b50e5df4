//! What is kept from one plan to the next and repaired when the map changes (section 3.5): the tree, the legs between
//! stops, and a roadmap of the whole map.

pub mod elastic;
pub mod lazy_a_star;
pub mod leg_repair;
pub mod repaired_leg;
pub mod roadmap;
pub mod roadmap_construction;
pub mod roadmap_path;
pub mod state;
pub mod stop_name;
pub mod tour_repair;
pub mod tree_repair;
