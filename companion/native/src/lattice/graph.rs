//! The map as an 8-connected lattice: its points are nodes, its edges are checked exactly, both when they are asked for.

use crate::geometry::{distance, Point};
use crate::lattice::labels::Labels;
use crate::map::field::Field;

/// Square cells over a map; each cell's centre is a node.
pub struct Lattice {
    /// Cells along x.
    pub columns: usize,
    /// Cells along y.
    pub rows: usize,
    low: Point,
    /// Side of a cell in metres.
    pub spacing: f64,
    /// Radius of the robot in metres.
    pub radius: f64,
    /// Per cell's centre: a lower bound of its clearance, once it has been looked up.
    clearance: Vec<f32>,
    /// Per cell: directions of clear edges, `KNOWN` and perhaps `ALL_AROUND`; 0 until they have been checked.
    edges: Vec<u16>,
    /// Cells whose clearance has been looked up.
    known: Vec<u32>,
    /// Of searches that have ended, for the next ones.
    labels: Vec<Labels>,
    /// Connected components that searches have exhausted: no edge leads out of them.
    pub components: Vec<Labels>,
    /// Clearance of both ends from which on a straight and a diagonal edge are clear without a check.
    ample: [f32; 2],
}

/// In `edges`: they have been checked.
const KNOWN: u16 = 1 << 8;
/// In `edges`: every edge between two of the nine cells around this one is clear.
const ALL_AROUND: u16 = 1 << 9;

/// The clear edges of a cell.
pub struct Edges {
    /// Directions of `NEIGHBOURS`, as bits.
    pub directions: u8,
    /// Every edge between two of the nine cells around this one is clear.
    pub all_around: bool,
}

/// In `clearance`: not looked up yet.
const UNKNOWN: f32 = 0.0;
/// In `clearance`: the robot does not fit.
const BLOCKED: f32 = -1.0;
/// Share of a clearance that covers the rounding to f32.
const ROUNDING: f64 = 1e-6;
/// Spacing of the tightest lattice, in spacings of the finest.
const TIGHTEST: f64 = 0.5;

/// Columns and rows to each neighbour of a cell, straight ones first.
pub const NEIGHBOURS: [(i64, i64); 8] = [
    (1, 0),
    (0, 1),
    (-1, 0),
    (0, -1),
    (1, 1),
    (-1, 1),
    (-1, -1),
    (1, -1),
];
/// The first diagonal one among `NEIGHBOURS`.
pub const FIRST_DIAGONAL: usize = 4;

impl Lattice {
    /// A lattice over all of `field` for a disc of `radius`; nothing is looked up yet.
    pub fn new<F: Field>(field: &F, spacing: f64, radius: f64) -> Self {
        let (low, high) = field.bounds();
        let columns = ((high.x - low.x) / spacing).round().max(1.0) as usize;
        let rows = ((high.y - low.y) / spacing).round().max(1.0) as usize;
        // What is at least c away from both ends of an edge of length l is at least √(c² - l²/4) away from all of it.
        let ample = |length: f64| {
            let clearance = (radius * radius + 0.25 * length * length).sqrt();
            (clearance + ROUNDING * (clearance + spacing)) as f32
        };
        Self {
            columns,
            rows,
            low,
            spacing,
            radius,
            clearance: vec![UNKNOWN; columns * rows],
            edges: vec![0; columns * rows],
            known: Vec::new(),
            labels: Vec::new(),
            components: Vec::new(),
            ample: [ample(spacing), ample(std::f64::consts::SQRT_2 * spacing)],
        }
    }

    /// A lattice of half the finest spacing, with points on the borders of cells and in their middles: for passages into
    /// which the robot just fits.
    pub fn tightest<F: Field>(field: &F, radius: f64) -> Self {
        let half = TIGHTEST * field.lattice_spacing();
        let mut lattice = Self::new(field, half, radius);
        lattice.low = Point::new(lattice.low.x - 0.5 * half, lattice.low.y - 0.5 * half);
        lattice.columns += 1;
        lattice.rows += 1;
        lattice.clearance = vec![UNKNOWN; lattice.size()];
        lattice.edges = vec![0; lattice.size()];
        lattice
    }

    /// True when a lattice of this `spacing` over `field` has the same cells as this one.
    pub fn matches<F: Field>(&self, field: &F, spacing: f64, radius: f64) -> bool {
        let (low, high) = field.bounds();
        let columns = ((high.x - low.x) / spacing).round().max(1.0) as usize;
        let rows = ((high.y - low.y) / spacing).round().max(1.0) as usize;
        (columns, rows) == (self.columns, self.rows)
            && (low, spacing, radius) == (self.low, self.spacing, self.radius)
    }

    /// Makes ready for another map: nothing is known of it, only the memory is reused.
    pub fn reset(&mut self) {
        for index in self.known.drain(..) {
            self.clearance[index as usize] = UNKNOWN;
            self.edges[index as usize] = 0;
        }
        for mut labels in std::mem::take(&mut self.components) {
            labels.wipe();
            self.give_labels(labels);
        }
    }

    /// True when an earlier search has shown that none of the cells `here` is connected to one of those `there`.
    pub fn known_disconnected(&self, here: &[usize], there: &[usize]) -> bool {
        self.components.iter().any(|component| {
            let all = |cells: &[usize], inside: bool| {
                cells.iter().all(|&c| component.reached(c) == inside)
            };
            (all(here, true) && all(there, false)) || (all(here, false) && all(there, true))
        })
    }

    /// Blank labels for a search.
    pub fn take_labels(&mut self) -> Labels {
        self.labels
            .pop()
            .unwrap_or_else(|| Labels::new(self.size()))
    }

    /// Takes wiped labels back for the next search.
    pub fn give_labels(&mut self, labels: Labels) {
        self.labels.push(labels);
    }

    /// A lower bound of the clearance at a cell's centre, negative where the robot does not fit; looked up once.
    pub fn clearance<F: Field>(&mut self, field: &F, index: usize) -> f32 {
        if self.clearance[index] == UNKNOWN {
            let free = field.free_clearance(self.point(index), self.radius);
            self.clearance[index] =
                free.map_or(BLOCKED, |free| (free as f32).max(f32::MIN_POSITIVE));
            self.known.push(index as u32);
        }
        self.clearance[index]
    }

    /// The clear edges that lead from a cell; checked once.
    pub fn edges<F: Field>(&mut self, field: &F, index: usize) -> Edges {
        if self.edges[index] == 0 {
            self.edges[index] = KNOWN | self.checked_edges(field, index);
        }
        let found = self.edges[index];
        Edges {
            directions: found as u8,
            all_around: found & ALL_AROUND != 0,
        }
    }

    fn checked_edges<F: Field>(&mut self, field: &F, index: usize) -> u16 {
        let clearance = self.clearance(field, index);
        if clearance < 0.0 {
            return 0;
        }
        let (column, row) = self.place(index);
        let mut directions = 0;
        for (direction, (across, up)) in NEIGHBOURS.into_iter().enumerate() {
            if let Some(next) = self.index(column + across, row + up) {
                let diagonal = direction >= FIRST_DIAGONAL;
                if self.edge_clear(field, (index, clearance), next, diagonal) {
                    directions |= 1 << direction;
                }
            }
        }
        // Clearance is 1-Lipschitz: then every edge between two of the nine cells is clear as well.
        let ample = self.ample[1] + (std::f64::consts::SQRT_2 * self.spacing) as f32;
        if directions == 0xff && clearance >= ample {
            directions |= ALL_AROUND;
        }
        directions
    }

    /// True when the edge from one cell, which has this clearance, to a neighbour is clear.
    pub fn edge_clear<F: Field>(
        &mut self,
        field: &F,
        (from, clearance): (usize, f32),
        to: usize,
        diagonal: bool,
    ) -> bool {
        let least = self.clearance(field, to).min(clearance);
        if least < 0.0 {
            return false;
        }
        least >= self.ample[usize::from(diagonal)]
            || field.hop_clear(self.point(from), self.point(to), self.radius)
    }

    /// Cells up to `reach` columns and rows from the one that holds `p` whose centres a straight edge reaches, with its
    /// length.
    pub fn links<F: Field>(&self, field: &F, p: Point, reach: i64) -> Vec<(usize, f64)> {
        let mut links = Vec::new();
        for index in self.cells_around(p, reach) {
            let centre = self.point(index);
            if field.short_clear(p, centre, self.radius) {
                links.push((index, distance(p, centre)));
            }
        }
        links
    }

    /// The cells up to `reach` columns and rows from the one that holds `p`.
    pub fn cells_around(&self, p: Point, reach: i64) -> Vec<usize> {
        let (column, row) = self.cell(p);
        let offsets =
            (-reach..=reach).flat_map(|up| (-reach..=reach).map(move |across| (across, up)));
        offsets
            .filter_map(|(across, up)| self.index(column + across, row + up))
            .collect()
    }

    /// How many cells have been looked up.
    pub fn known_cells(&self) -> u64 {
        self.known.len() as u64
    }

    /// Number of cells.
    pub fn size(&self) -> usize {
        self.columns * self.rows
    }

    /// The centre of a cell.
    pub fn point(&self, index: usize) -> Point {
        let (column, row) = self.place(index);
        self.at(column, row)
    }

    /// The centre of the cell in this column and row.
    pub fn at(&self, column: i64, row: i64) -> Point {
        Point::new(
            self.low.x + (column as f64 + 0.5) * self.spacing,
            self.low.y + (row as f64 + 0.5) * self.spacing,
        )
    }

    /// Column and row of a cell.
    pub fn place(&self, index: usize) -> (i64, i64) {
        let (index, columns) = (index as u32, self.columns as u32);
        (i64::from(index % columns), i64::from(index / columns))
    }

    /// Column and row of the cell that holds `p`, or of the one nearest to it.
    pub(super) fn cell(&self, p: Point) -> (i64, i64) {
        let column = ((p.x - self.low.x) / self.spacing).floor() as i64;
        let row = ((p.y - self.low.y) / self.spacing).floor() as i64;
        (
            column.clamp(0, self.columns as i64 - 1),
            row.clamp(0, self.rows as i64 - 1),
        )
    }

    /// The cell in this column and row; none outside the lattice.
    pub fn index(&self, column: i64, row: i64) -> Option<usize> {
        (column >= 0 && row >= 0 && column < self.columns as i64 && row < self.rows as i64)
            .then(|| row as usize * self.columns + column as usize)
    }

    /// The neighbours of a cell, in the order of `NEIGHBOURS`.
    pub(super) fn neighbours(&self, index: usize) -> impl Iterator<Item = usize> + use<'_> {
        let (column, row) = self.place(index);
        let beside = NEIGHBOURS.into_iter();
        beside.filter_map(move |(across, up)| self.index(column + across, row + up))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::circles::Circles;

    fn lattice(radius: f64) -> (Circles, Lattice) {
        let field = Circles::new(4.0, 3.0, vec![(Point::new(2.0, 1.5), 0.5)]);
        let lattice = Lattice::new(&field, 0.5, radius);
        (field, lattice)
    }

    #[test]
    fn cells_and_points_belong_together() {
        let (_, lattice) = lattice(0.1);
        assert_eq!((lattice.columns, lattice.rows), (8, 6));
        for index in 0..lattice.size() {
            let (column, row) = lattice.cell(lattice.point(index));
            assert_eq!(lattice.index(column, row), Some(index));
        }
        assert_eq!(lattice.index(8, 0), None);
        assert_eq!(lattice.cell(Point::new(99.0, -99.0)), (7, 0));
    }

    #[test]
    fn an_edge_is_clear_exactly_when_the_map_says_so() {
        let (field, mut lattice) = lattice(0.2);
        let (mut clear, mut blocked) = (0, 0);
        for from in 0..lattice.size() {
            let (column, row) = lattice.place(from);
            for (direction, (across, up)) in NEIGHBOURS.into_iter().enumerate() {
                let Some(to) = lattice.index(column + across, row + up) else {
                    continue;
                };
                let bound = lattice.clearance(&field, from);
                if bound < 0.0 {
                    continue;
                }
                let found =
                    lattice.edge_clear(&field, (from, bound), to, direction >= FIRST_DIAGONAL);
                assert_eq!(
                    found,
                    field.segment_clear(lattice.point(from), lattice.point(to), 0.2)
                );
                *(if found { &mut clear } else { &mut blocked }) += 1;
            }
        }
        assert!(clear > 50 && blocked > 10);
    }

    #[test]
    fn a_reset_lattice_knows_nothing_of_the_map_before() {
        let (field, mut lattice) = lattice(0.2);
        let middle = lattice.index(3, 2).unwrap();
        assert!(lattice.clearance(&field, middle) < 0.0);
        lattice.reset();
        assert!(lattice.clearance(&Circles::new(4.0, 3.0, Vec::new()), middle) > 0.0);
    }
}
