//! The grid that a camera looks at, and sums over rows of its cells.

/// Offsets of one row of cells from the robot's: of the row, of its first and of its last column.
pub type Span = (i32, i32, i32);

/// Row-major cells; not 0 is unseen, or blocked.
pub struct Grid<'a> {
    /// Cells that no camera has seen yet.
    pub unseen: &'a [u8],
    /// Cells through which no camera sees; may be empty where occlusion does not matter.
    pub blocked: &'a [u8],
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
}

/// Row-wise prefix sums of the cells that are not 0, one column wider than the grid.
pub fn prefix_sums(cells: &[u8], columns: usize) -> Vec<u32> {
    let mut sums = Vec::with_capacity(cells.len() / columns.max(1) * (columns + 1));
    for row in cells.chunks_exact(columns) {
        let mut sum = 0u32;
        sums.push(0);
        for &cell in row {
            sum += u32::from(cell != 0);
            sums.push(sum);
        }
    }
    sums
}

/// Sum over the cells of `spans` around (x, y), from `prefix_sums`.
pub fn sum_over(spans: &[Span], sums: &[u32], grid: &Grid, x: i32, y: i32) -> u32 {
    let columns = grid.columns as i32;
    let mut sum = 0;
    for &(dy, left, right) in spans {
        let row = y + dy;
        if row < 0 || row >= grid.rows as i32 {
            continue;
        }
        let first = (x + left).clamp(0, columns) as usize;
        let last = (x + right + 1).clamp(0, columns) as usize;
        let base = row as usize * (grid.columns + 1);
        sum += sums[base + last] - sums[base + first];
    }
    sum
}
