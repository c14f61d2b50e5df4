//! Greatest heights over squares of a height raster, so that a ray can skip the ground that lies below it.

/// A ray in cells (columns, rows, from the centre of cell (0, 0)) and metres of height; its parameter is that of the
/// direction it was made from.
pub struct Ray {
    /// Where it begins: column, row, height.
    pub eye: [f32; 3],
    /// Change of column, row and height with the parameter.
    pub slope: [f32; 3],
    /// One over each of the slopes.
    pub inverse: [f32; 3],
}

impl Ray {
    /// Column, row and height at parameter `t`.
    #[inline]
    pub fn at(&self, t: f32) -> (f32, f32, f32) {
        (
            self.eye[0] + t * self.slope[0],
            self.eye[1] + t * self.slope[1],
            self.eye[2] + t * self.slope[2],
        )
    }
}

/// Cells along the side of a tile.
const SIDE: usize = 16;

/// Square parts of a height raster, each with its greatest height.
pub struct Tiles {
    columns: usize,
    rows: usize,
    tops: Vec<f32>,
    highest: f32,
}

impl Tiles {
    /// Of a row-major raster of heights in metres.
    pub fn new(height: &[f32], columns: usize) -> Self {
        let rows = height.len() / columns;
        let (tile_columns, tile_rows) = (columns.div_ceil(SIDE), rows.div_ceil(SIDE));
        let mut tops = vec![f32::NEG_INFINITY; tile_columns * tile_rows];
        // One cell more on each side: bilinear interpolation at the rim reads the neighbours.
        let span = |tile: usize, size: usize| {
            (tile * SIDE).saturating_sub(1)..((tile + 1) * SIDE + 1).min(size)
        };
        for (index, top) in tops.iter_mut().enumerate() {
            for row in span(index / tile_columns, rows) {
                let line = &height[row * columns..(row + 1) * columns];
                let part = &line[span(index % tile_columns, columns)];
                *top = part.iter().fold(*top, |max, h| max.max(*h));
            }
        }
        let highest = tops
            .iter()
            .fold(f32::NEG_INFINITY, |max, top| max.max(*top));
        Self {
            columns: tile_columns,
            rows: tile_rows,
            tops,
            highest,
        }
    }

    /// Follows a descending ray from tile to tile between two parameters (Amanatides and Woo) and calls
    /// `search(from, to)` for the part of it that lies below a tile's greatest height; ends at the first answer.
    #[inline]
    pub fn walk(
        &self,
        ray: &Ray,
        start: f32,
        end: f32,
        search: impl Fn(f32, f32) -> Option<f32>,
    ) -> Option<f32> {
        let (column, row, _) = ray.at(start);
        let (mut i, mut next_column, column_stride, column_turn) = axis(column, start, ray, 0);
        let (mut j, mut next_row, row_stride, row_turn) = axis(row, start, ray, 1);
        let mut enter = start;
        loop {
            let leave = next_column.min(next_row).min(end);
            // Beyond the rim nothing is known of the ground but its greatest height.
            let inside = (i as usize) < self.columns && (j as usize) < self.rows;
            let top = if inside {
                self.tops[j as usize * self.columns + i as usize]
            } else {
                self.highest
            };
            if ray.at(leave).2 <= top {
                let reach = (top - ray.eye[2]) * ray.inverse[2];
                let hit = search(enter.max(reach), leave);
                if hit.is_some() {
                    return hit;
                }
            }
            if leave >= end {
                return None;
            }
            if next_column < next_row {
                i += column_stride;
                next_column += column_turn;
            } else {
                j += row_stride;
                next_row += row_turn;
            }
            enter = leave;
        }
    }
}

/// One axis of the walk at `position` (cells) and parameter `t`: the tile, the parameter at which the ray leaves it,
/// the sign of its way, and the parameter that a whole tile takes.
#[inline]
fn axis(position: f32, t: f32, ray: &Ray, index: usize) -> (i32, f32, i32, f32) {
    let side = SIDE as f32;
    // Tiles are counted from the corner of cell (0, 0), positions from its centre.
    let tile = ((position + 0.5) * (1.0 / side)).floor();
    let (slope, inverse) = (ray.slope[index], ray.inverse[index]);
    if slope.abs() < 1e-9 {
        return (tile as i32, f32::INFINITY, 0, f32::INFINITY);
    }
    let ahead = if slope > 0.0 { tile + 1.0 } else { tile };
    let leave = t + ((ahead * side - 0.5 - position) * inverse).max(0.0);
    let stride = if slope > 0.0 { 1 } else { -1 };
    (tile as i32, leave, stride, side * inverse.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn down(column: f32, row: f32, slope: [f32; 3]) -> Ray {
        Ray {
            eye: [column, row, 1.0],
            slope,
            inverse: slope.map(|s| 1.0 / s),
        }
    }

    #[test]
    fn only_the_tiles_that_can_hide_something_are_searched() {
        let mut height = vec![0.0_f32; 64 * 64];
        height[20 * 64 + 40] = 0.5;
        let tiles = Tiles::new(&height, 64);
        let ray = down(2.0, 20.0, [60.0, 0.0, -0.8]);
        let searched = std::cell::RefCell::new(Vec::new());
        let hit = tiles.walk(&ray, 0.0, 1.0, |from, to| {
            searched.borrow_mut().push((ray.at(from).0, ray.at(to).0));
            None
        });
        assert_eq!(hit, None);
        let searched = searched.into_inner();
        assert!(!searched.is_empty());
        assert!(
            searched.iter().all(|(from, to)| *to > 31.0 && *from < 48.0),
            "{searched:?}"
        );
    }

    #[test]
    fn the_first_answer_ends_the_walk() {
        let tiles = Tiles::new(&vec![2.0_f32; 64 * 64], 64);
        let ray = down(2.0, 2.0, [60.0, 60.0, -0.5]);
        let calls = std::cell::Cell::new(0);
        let hit = tiles.walk(&ray, 0.0, 1.0, |from, _| {
            calls.set(calls.get() + 1);
            (calls.get() == 2).then_some(from)
        });
        assert!(hit.is_some());
        assert_eq!(calls.get(), 2);
    }
}
