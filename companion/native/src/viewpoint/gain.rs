//! How many unseen cells a camera would see from a position and heading.

use crate::viewpoint::footprint::Footprint;
use crate::viewpoint::grid::{prefix_sums, sum_over, Grid};

/// The footprint at a set of headings, prepared once for many questions.
pub struct Views {
    footprints: Vec<Footprint>,
}

impl Views {
    /// `polygon`: convex, in base_link, metres.
    pub fn new(polygon: &[(f64, f64)], headings: &[f64], resolution: f64) -> Self {
        let footprints = headings
            .iter()
            .map(|heading| {
                let (sin, cos) = heading.sin_cos();
                let turned: Vec<(f64, f64)> = polygon
                    .iter()
                    .map(|&(x, y)| {
                        (
                            (cos * x - sin * y) / resolution,
                            (sin * x + cos * y) / resolution,
                        )
                    })
                    .collect();
                Footprint::new(&turned)
            })
            .collect();
        Self { footprints }
    }

    /// Number of headings.
    pub fn count(&self) -> usize {
        self.footprints.len()
    }

    /// Unseen cells of the footprint for each position (column, row) and heading, nothing hidden: positions × headings.
    pub fn open_gains(&self, grid: &Grid, positions: &[(i32, i32)]) -> Vec<u32> {
        let unseen = prefix_sums(grid.unseen, grid.columns);
        let mut gains = Vec::with_capacity(positions.len() * self.footprints.len());
        for &(x, y) in positions {
            for footprint in &self.footprints {
                gains.push(sum_over(&footprint.spans, &unseen, grid, x, y));
            }
        }
        gains
    }

    /// Unseen cells that no blocked cell hides, for each (column, row, heading's number).
    pub fn gains(&self, grid: &Grid, views: &[(i32, i32, usize)]) -> Vec<u32> {
        let unseen = prefix_sums(grid.unseen, grid.columns);
        let blocked = prefix_sums(grid.blocked, grid.columns);
        let mut lit = Vec::new();
        views
            .iter()
            .map(|&(x, y, heading)| {
                let Some(footprint) = self.footprints.get(heading) else {
                    return 0;
                };
                let open = sum_over(&footprint.spans, &unseen, grid, x, y);
                if open > 0 && sum_over(&footprint.hull, &blocked, grid, x, y) > 0 {
                    footprint.visible(grid, x, y, &mut lit)
                } else {
                    open
                }
            })
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn open_gains_count_the_unseen_cells_of_the_footprint_at_each_heading() {
        let polygon = [(1.0, -0.5), (2.0, -0.5), (2.0, 0.5), (1.0, 0.5)];
        let views = Views::new(&polygon, &[0.0, std::f64::consts::PI], 0.5);
        let mut unseen = vec![0u8; 100];
        unseen[57] = 1; // row 5, column 7: 1 m to the right of column 5
        let grid = Grid {
            unseen: &unseen,
            blocked: &[],
            columns: 10,
            rows: 10,
        };
        assert_eq!(views.open_gains(&grid, &[(5, 5), (9, 5)]), [1, 0, 0, 1]);
    }
}
