//! How many unseen cells a camera would see from a place and heading.

/// Cells of the camera's ground footprint for one heading, relative to the rover's cell.
struct Shape {
    /// Per row: offset of the row, first and last column offset.
    spans: Vec<(i32, i32, i32)>,
    /// The same with the ground between the rover and the footprint: what could hide it.
    hull: Vec<(i32, i32, i32)>,
    /// Cells of the hull by distance, each with its predecessor towards the rover and whether it is in the footprint.
    cells: Vec<Cell>,
}

struct Cell {
    dx: i32,
    dy: i32,
    before: u32,
    counted: bool,
}

pub struct Grid<'a> {
    pub unseen: &'a [u8],
    pub blocked: &'a [u8],
    pub columns: usize,
    pub rows: usize,
}

/// Row-wise prefix sums, one column wider than the grid.
fn prefix(cells: &[u8], columns: usize) -> Vec<u32> {
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

fn spans(polygon: &[(f64, f64)]) -> Vec<(i32, i32, i32)> {
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

/// Convex hull (Andrew's monotone chain) of the footprint and the rover itself.
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

impl Shape {
    /// `polygon`: convex footprint in cells, already turned to the heading.
    fn new(polygon: &[(f64, f64)]) -> Self {
        let spans_of_footprint = spans(polygon);
        let hull = spans(&hull_with_origin(polygon));
        let mut cells: Vec<Cell> = Vec::new();
        for &(dy, left, right) in &hull {
            let span = spans_of_footprint.iter().find(|span| span.0 == dy);
            for dx in left..=right {
                cells.push(Cell {
                    dx,
                    dy,
                    before: u32::MAX,
                    counted: span.is_some_and(|&(_, l, r)| (l..=r).contains(&dx)),
                });
            }
        }
        cells.sort_by_key(|cell| (cell.dx * cell.dx + cell.dy * cell.dy, cell.dy, cell.dx));
        let positions: std::collections::BTreeMap<(i32, i32), u32> = cells
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
                cell.before = positions.get(&back).copied().unwrap_or(u32::MAX);
            }
        }
        Self {
            spans: spans_of_footprint,
            hull,
            cells,
        }
    }

    fn sum(spans: &[(i32, i32, i32)], prefix: &[u32], grid: &Grid, x: i32, y: i32) -> u32 {
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
            sum += prefix[base + last] - prefix[base + first];
        }
        sum
    }

    /// Unseen cells of the footprint that no blocked cell hides.
    fn visible(&self, grid: &Grid, x: i32, y: i32, lit: &mut Vec<bool>) -> u32 {
        lit.clear();
        let mut sum = 0;
        for cell in &self.cells {
            let (column, row) = (x + cell.dx, y + cell.dy);
            let inside =
                column >= 0 && row >= 0 && column < grid.columns as i32 && row < grid.rows as i32;
            let reached =
                cell.before == u32::MAX || lit.get(cell.before as usize).copied().unwrap_or(true);
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

/// A camera's footprint at a set of headings, prepared once for many questions.
pub struct Views {
    shapes: Vec<Shape>,
}

impl Views {
    /// `polygon`: convex, in base_link, metres.
    pub fn new(polygon: &[(f64, f64)], headings: &[f64], resolution: f64) -> Self {
        let shapes = headings
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
                Shape::new(&turned)
            })
            .collect();
        Self { shapes }
    }

    pub fn count(&self) -> usize {
        self.shapes.len()
    }

    /// Unseen cells of the footprint for each position (column, row) and heading, nothing hidden: positions × headings.
    pub fn open_gains(&self, grid: &Grid, positions: &[(i32, i32)]) -> Vec<u32> {
        let unseen = prefix(grid.unseen, grid.columns);
        let mut gains = Vec::with_capacity(positions.len() * self.shapes.len());
        for &(x, y) in positions {
            for shape in &self.shapes {
                gains.push(Shape::sum(&shape.spans, &unseen, grid, x, y));
            }
        }
        gains
    }

    /// Unseen cells that no blocked cell hides, for each (column, row, heading's number).
    pub fn gains(&self, grid: &Grid, views: &[(i32, i32, usize)]) -> Vec<u32> {
        let unseen = prefix(grid.unseen, grid.columns);
        let blocked = prefix(grid.blocked, grid.columns);
        let mut lit = Vec::new();
        views
            .iter()
            .map(|&(x, y, heading)| {
                let Some(shape) = self.shapes.get(heading) else {
                    return 0;
                };
                let open = Shape::sum(&shape.spans, &unseen, grid, x, y);
                if open > 0 && Shape::sum(&shape.hull, &blocked, grid, x, y) > 0 {
                    shape.visible(grid, x, y, &mut lit)
                } else {
                    open
                }
            })
            .collect()
    }
}
