//! Lattices of one map, kept from plan to plan: which edges are clear is found out once.

use crate::lattice::graph::Lattice;
use crate::map::field::Field;

/// Lattices that are kept.
const MAX_LATTICES: usize = 3;
/// Cells of a lattice that is kept, at most: about 20 bytes each.
const MAX_CELLS: usize = 4_000_000;

/// Lattices that nobody uses at the moment.
#[derive(Default)]
pub struct LatticeCache {
    lattices: Vec<Lattice>,
}

impl LatticeCache {
    /// A lattice of this `spacing` over `field`, which must be the map of this cache.
    pub fn take<F: Field>(&mut self, field: &F, spacing: f64, radius: f64) -> Lattice {
        let matches = |lattice: &Lattice| lattice.matches(field, spacing, radius);
        match self.lattices.iter().position(matches) {
            Some(index) => self.lattices.remove(index),
            None => Lattice::new(field, spacing, radius),
        }
    }

    /// Takes a lattice back; the one that was not used for longest goes when there are too many.
    pub fn give(&mut self, lattice: Lattice) {
        if lattice.size() > MAX_CELLS {
            return;
        }
        if self.lattices.len() == MAX_LATTICES {
            self.lattices.remove(0);
        }
        self.lattices.push(lattice);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Point;
    use crate::map::circles::Circles;

    #[test]
    fn a_lattice_comes_back_with_what_it_knows_and_old_ones_go() {
        let field = Circles::new(4.0, 4.0, vec![(Point::new(2.0, 2.0), 0.5)]);
        let mut cache = LatticeCache::default();
        for spacing in [0.5, 0.4, 0.25, 0.2] {
            let lattice = cache.take(&field, spacing, 0.1);
            cache.give(lattice);
        }
        let spacings: Vec<f64> = cache.lattices.iter().map(|l| l.spacing).collect();
        assert_eq!(spacings, [0.4, 0.25, 0.2]);
        let lattice = cache.take(&field, 0.25, 0.1);
        assert_eq!((lattice.spacing, cache.lattices.len()), (0.25, 2));
    }
}
