//! A camera's footprint on the ground, as cells around the robot.

use std::collections::BTreeMap;

use crate::viewpoint::grid::{Grid, Span};

/// No cell of the hull.
const NO_CELL: u32 = u32::MAX;

/// Cells of the footprint for one heading, relative to the robot's cell.
pub struct Footprint {
    /// Its rows.
    pub spans: Vec<Span>,
    /// Rows of its convex hull with the robot: what could hide it lies there.
    pub hull: Vec<Span>,
    /// Cells of the hull by distance from the robot.
    cells: Vec<Cell>,
}

struct Cell {
    dx: i32,
    dy: i32,
    /// The next cell towards the robot; `NO_CELL` for the robot's own.
    before: u32,
    /// It is part of the footprint.
    counted: bool,
}

/// Rows of cells whose centres lie in a convex polygon, cells.
fn spans(polygon: &[(f64, f64)]) -> Vec<Span> {
    let low = polygon.iter().fold(f64::INFINITY, |a, p| a.min(p.1)).ceil() as i32;
    let high = polygon
        .iter()
        .fold(f64::NEG_INFINITY, |a, p| a.max(p.1))
        .floor() as i32;
    let mut spans = Vec::new();
    for dy in low..=high {
        let y = f64::from(dy);
        let (mut left, mut right) = (f64::INFINITY, f64::NEG_INFINITY);
        for index in 0..polygon.len() {
            let (a, b) = (polygon[index], polygon[(index + 1) % polygon.len()]);
            if (a.1 <= y && b.1 >= y) || (b.1 <= y && a.1 >= y) {
                let crossings = if a.1 == b.1 {
                    [a.0, b.0]
                } else {
                    let x = a.0 + (b.0 - a.0) * (y - a.1) / (b.1 - a.1);
                    [x, x]
                };
                for x in crossings {
                    left = left.min(x);
                    right = right.max(x);
                }
            }
        }
        if left <= right && left.ceil() <= right.floor() {
            spans.push((dy, left.ceil() as i32, right.floor() as i32));
        }
    }
    spans
}

/// Convex hull (Andrew's monotone chain) of the footprint and the robot itself.
fn hull_with_origin(polygon: &[(f64, f64)]) -> Vec<(f64, f64)> {
    let mut points = polygon.to_vec();
    points.push((0.0, 0.0));
    points.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.total_cmp(&b.1)));
    let turn = |a: (f64, f64), b: (f64, f64), c: (f64, f64)| {
        (b.0 - a.0) * (c.1 - a.1) - (b.1 - a.1) * (c.0 - a.0)
    };
    let half = |order: &mut dyn Iterator<Item = (f64, f64)>| {
        let mut chain: Vec<(f64, f64)> = Vec::new();
        for p in order {
            while chain.len() >= 2 && turn(chain[chain.len() - 2], chain[chain.len() - 1], p) <= 0.0
            {
                chain.pop();
            }
            chain.push(p);
        }
        chain.pop();
        chain
    };
    let mut hull = half(&mut points.iter().copied());
    hull.extend(half(&mut points.iter().rev().copied()));
    hull
}

impl Footprint {
    /// `polygon`: convex footprint in cells, already turned to the heading.
    pub fn new(polygon: &[(f64, f64)]) -> Self {
        let spans_of_footprint = spans(polygon);
        let hull = spans(&hull_with_origin(polygon));
        let mut cells: Vec<Cell> = Vec::new();
        for &(dy, left, right) in &hull {
            let span = spans_of_footprint.iter().find(|span| span.0 == dy);
            for dx in left..=right {
                cells.push(Cell {
                    dx,
                    dy,
                    before: NO_CELL,
                    counted: span.is_some_and(|&(_, l, r)| (l..=r).contains(&dx)),
                });
            }
        }
        cells.sort_by_key(|cell| (cell.dx * cell.dx + cell.dy * cell.dy, cell.dy, cell.dx));
        let positions: BTreeMap<(i32, i32), u32> = cells
            .iter()
            .enumerate()
            .map(|(index, cell)| ((cell.dx, cell.dy), index as u32))
            .collect();
        for cell in &mut cells {
            let length = cell.dx.abs().max(cell.dy.abs());
            if length > 0 {
                let shrink = f64::from(length - 1) / f64::from(length);
                let back = (
                    (f64::from(cell.dx) * shrink).round() as i32,
                    (f64::from(cell.dy) * shrink).round() as i32,
                );
                cell.before = positions.get(&back).copied().unwrap_or(NO_CELL);
            }
        }
        Self {
            spans: spans_of_footprint,
            hull,
            cells,
        }
    }

    /// Number of unseen cells of the footprint that no blocked cell hides from the robot at (x, y). `lit` is scratch memory.
    pub fn visible(&self, grid: &Grid, x: i32, y: i32, lit: &mut Vec<bool>) -> u32 {
        lit.clear();
        let mut sum = 0;
        for cell in &self.cells {
            let (column, row) = (x + cell.dx, y + cell.dy);
            let inside =
                column >= 0 && row >= 0 && column < grid.columns as i32 && row < grid.rows as i32;
            let reached =
                cell.before == NO_CELL || lit.get(cell.before as usize).copied().unwrap_or(true);
            if !inside {
                lit.push(false);
                continue;
            }
            let index = row as usize * grid.columns + column as usize;
            sum += u32::from(reached && cell.counted && grid.unseen[index] != 0);
            // A blocked cell is seen itself and hides what lies behind it.
            lit.push(reached && grid.blocked[index] == 0);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Three cells wide, two to four cells ahead along x.
    fn ahead() -> Footprint {
        Footprint::new(&[(2.0, -1.0), (4.0, -1.0), (4.0, 1.0), (2.0, 1.0)])
    }

    #[test]
    fn the_footprint_is_the_cells_whose_centres_lie_in_the_polygon() {
        assert_eq!(ahead().spans, [(-1, 2, 4), (0, 2, 4), (1, 2, 4)]);
    }

    #[test]
    fn the_hull_reaches_back_to_the_robot() {
        assert!(ahead().hull.contains(&(0, 0, 4)));
    }

    #[test]
    fn a_blocked_cell_hides_what_lies_behind_it_and_is_seen_itself() {
        let (columns, rows) = (7, 3);
        let unseen = vec![1u8; columns * rows];
        let mut blocked = vec![0u8; columns * rows];
        let count = |blocked: &[u8]| {
            let grid = Grid {
                unseen: &unseen,
                blocked,
                columns,
                rows,
            };
            ahead().visible(&grid, 1, 1, &mut Vec::new())
        };
        assert_eq!(count(&blocked), 9);
        blocked[columns + 4] = 1; // three cells ahead
        assert_eq!(count(&blocked), 8);
    }
}
