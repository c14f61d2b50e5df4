//! Clearance near obstacles, computed tile by tile when it is first asked for: a plan looks at little of a large map, and
//! a map that has just changed costs nothing where nobody goes.

use std::sync::OnceLock;

/// Cells along a tile's side.
const SIDE: usize = 32;
/// Cells beyond which an obstacle is only known to be far.
const REACH: usize = 16;
/// Cells along a tile's side and its surroundings.
const WINDOW: usize = SIDE + 2 * REACH;
/// Rows since the last blocked cell when there was none; its squared gap still fits an i16.
const NEVER: i16 = 60;

type Tile = Box<[f32; SIDE * SIDE]>;

/// A map of blocked cells as the tiles read it.
pub struct Cells<'a> {
    /// Row-major; not 0 is blocked.
    pub blocked: &'a [u8],
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
}

/// The tiles of a map, each computed once.
pub struct Tiles {
    across: usize,
    tiles: Vec<OnceLock<Tile>>,
}

impl Tiles {
    /// Distances in cells from here on are not exact: they only say "at least this".
    pub const LIMIT: f32 = REACH as f32 + 0.5;

    /// Tiles for a map of this size; none is computed yet.
    pub fn new(columns: usize, rows: usize) -> Self {
        let across = columns.div_ceil(SIDE);
        let mut tiles = Vec::new();
        tiles.resize_with(across * rows.div_ceil(SIDE), OnceLock::new);
        Self { across, tiles }
    }

    /// Cells from a cell's centre to the nearest blocked square, at most `LIMIT`.
    pub fn clearance(&self, cells: &Cells, column: usize, row: usize) -> f32 {
        let (across, down) = (column / SIDE, row / SIDE);
        let tile = self.tiles[down * self.across + across]
            .get_or_init(|| clearance_of(cells, across * SIDE, down * SIDE));
        tile[(row % SIDE) * SIDE + column % SIDE]
    }
}

/// The tile whose first cell is (`left`, `top`), exactly: gaps along columns first, then the least sum of squares along
/// rows. Gaps are counted in half cells, because a square d cells off begins d - 1/2 cells from a centre.
fn clearance_of(cells: &Cells, left: usize, top: usize) -> Tile {
    let mut lines = [[0u8; WINDOW]; WINDOW];
    let first = left.saturating_sub(REACH);
    let last = (left + SIDE + REACH).min(cells.columns);
    for (offset, line) in lines.iter_mut().enumerate() {
        let Some(row) = (top + offset)
            .checked_sub(REACH)
            .filter(|&r| r < cells.rows)
        else {
            continue;
        };
        let into = first + REACH - left;
        line[into..into + last - first].copy_from_slice(
            &cells.blocked[row * cells.columns + first..row * cells.columns + last],
        );
    }
    let mut since = [[NEVER; WINDOW]; SIDE];
    let mut count = [NEVER; WINDOW];
    for (offset, line) in lines[..SIDE + REACH].iter().enumerate() {
        pass(&mut count, line);
        if let Some(row) = offset.checked_sub(REACH) {
            since[row] = count;
        }
    }
    count = [NEVER; WINDOW];
    for (offset, line) in lines[REACH..].iter().enumerate().rev() {
        pass(&mut count, line);
        if let Some(row) = since.get_mut(offset) {
            for (least, &other) in row.iter_mut().zip(&count) {
                *least = (*least).min(other);
            }
        }
    }
    let mut tile = Box::new([0.0f32; SIDE * SIDE]);
    for (row, out) in since.iter_mut().zip(tile.chunks_exact_mut(SIDE)) {
        for gap in row.iter_mut() {
            *gap = half_cells_squared(*gap);
        }
        let mut least = [i16::MAX; SIDE];
        for shift in 0..=2 * REACH {
            let across = half_cells_squared((shift as i16 - REACH as i16).abs());
            for (value, &down) in least.iter_mut().zip(&row[shift..shift + SIDE]) {
                *value = (*value).min(down + across);
            }
        }
        for (value, &squared) in out.iter_mut().zip(&least) {
            *value = (0.5 * f32::from(squared).sqrt()).min(Tiles::LIMIT);
        }
    }
    tile
}

/// One more row: cells since the last blocked one in each column.
fn pass(count: &mut [i16; WINDOW], line: &[u8; WINDOW]) {
    for (count, &cell) in count.iter_mut().zip(line) {
        *count = if cell != 0 {
            0
        } else {
            (*count + 1).min(NEVER)
        };
    }
}

/// Square of the gap to a square so many cells off, in half cells.
fn half_cells_squared(cells: i16) -> i16 {
    let gap = (2 * cells - 1).max(0);
    gap * gap
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::distance_transform;
    use crate::random::Random;

    #[test]
    fn tiles_agree_with_the_whole_maps_transform_up_to_their_limit() {
        let (columns, rows) = (75, 50);
        let mut random = Random::new(4);
        for share in [0.002, 0.02, 0.3] {
            let blocked: Vec<u8> = (0..columns * rows)
                .map(|_| u8::from(random.uniform() < share))
                .collect();
            let cells = Cells {
                blocked: &blocked,
                columns,
                rows,
            };
            let tiles = Tiles::new(columns, rows);
            let whole = distance_transform::clearance(&blocked, columns, rows);
            for row in 0..rows {
                for column in 0..columns {
                    let expected = whole[row * columns + column].min(Tiles::LIMIT);
                    assert!((tiles.clearance(&cells, column, row) - expected).abs() < 1e-4);
                }
            }
        }
    }
}
