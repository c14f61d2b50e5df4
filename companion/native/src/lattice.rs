//! The map as a lattice of points: what a sampling planner can't do by itself. It proves goals unreachable, and finds a
//! way through ground where random samples seldom fall.

use crate::field::Field;
use crate::geometry::{distance, Point};
use crate::search::{self, Stop};
use crate::wave::Marks;

pub struct Lattice {
    pub columns: usize,
    pub rows: usize,
    low: Point,
    pub spacing: f64,
    pub radius: f64,
    /// Per cell's centre: a lower bound of its clearance, once it has been looked up.
    room: Vec<f32>,
    /// Cells whose room has been looked up.
    known: Vec<u32>,
    /// Of searches that have ended, for the next ones.
    marks: Vec<Marks>,
    /// What searches that found no way have seen: no edge leads out of it.
    pub pieces: Vec<Marks>,
    /// Clearance of both ends from which on a straight and a slanting edge are clear without a look.
    open: [f32; 2],
}

/// In `room`: not looked up yet, and the robot does not fit.
const UNKNOWN: f32 = 0.0;
const SHUT: f32 = -1.0;

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

impl Lattice {
    pub fn new<F: Field>(field: &F, spacing: f64, radius: f64) -> Self {
        let (low, high) = field.bounds();
        let columns = ((high.x - low.x) / spacing).round().max(1.0) as usize;
        let rows = ((high.y - low.y) / spacing).round().max(1.0) as usize;
        // What is at least c away from both ends of an edge of length l is at least √(c² - l²/4) away from all of it.
        let open = |length: f64| {
            let room = (radius * radius + 0.25 * length * length).sqrt();
            (room + 1e-6 * (room + spacing)) as f32
        };
        Self {
            columns,
            rows,
            low,
            spacing,
            radius,
            room: vec![UNKNOWN; columns * rows],
            known: Vec::new(),
            marks: Vec::new(),
            pieces: Vec::new(),
            open: [open(spacing), open(std::f64::consts::SQRT_2 * spacing)],
        }
    }

    /// A lattice of half the finest spacing, with points on the borders of cells and in their middles: for passages into
    /// which the robot just fits.
    pub fn tightest<F: Field>(field: &F, radius: f64) -> Self {
        let half = 0.5 * field.lattice_spacing();
        let mut lattice = Self::new(field, half, radius);
        lattice.low = Point::new(lattice.low.x - 0.5 * half, lattice.low.y - 0.5 * half);
        lattice.columns += 1;
        lattice.rows += 1;
        lattice.room = vec![UNKNOWN; lattice.size()];
        lattice
    }

    /// True when a lattice of this `spacing` over `field` is as large as this one and lies where it lies.
    pub fn fits<F: Field>(&self, field: &F, spacing: f64, radius: f64) -> bool {
        let (low, high) = field.bounds();
        let columns = ((high.x - low.x) / spacing).round().max(1.0) as usize;
        let rows = ((high.y - low.y) / spacing).round().max(1.0) as usize;
        (columns, rows) == (self.columns, self.rows)
            && (low, spacing, radius) == (self.low, self.spacing, self.radius)
    }

    /// For another map: nothing is known of it, only the memory is kept.
    pub fn forget(&mut self) {
        for index in self.known.drain(..) {
            self.room[index as usize] = UNKNOWN;
        }
        for mut marks in std::mem::take(&mut self.pieces) {
            marks.wipe();
            self.give_marks(marks);
        }
    }

    /// True when an earlier search has shown that none of the cells `here` leads to one of those `there`.
    pub fn apart(&self, here: &[usize], there: &[usize]) -> bool {
        self.pieces.iter().any(|piece| {
            let all = |cells: &[usize], inside: bool| cells.iter().all(|&c| piece.has(c) == inside);
            (all(here, true) && all(there, false)) || (all(here, false) && all(there, true))
        })
    }

    /// Marks for a search, all clear.
    pub fn take_marks(&mut self) -> Marks {
        self.marks.pop().unwrap_or_else(|| Marks::new(self.size()))
    }

    pub fn give_marks(&mut self, marks: Marks) {
        self.marks.push(marks);
    }

    /// How much room there is at a cell's centre, negative where the robot does not fit; looked up once.
    pub fn room<F: Field>(&mut self, field: &F, index: usize) -> f32 {
        if self.room[index] == UNKNOWN {
            let room = field.room(self.point(index), self.radius);
            self.room[index] = room.map_or(SHUT, |room| (room as f32).max(f32::MIN_POSITIVE));
            self.known.push(index as u32);
        }
        self.room[index]
    }

    /// True when the robot can go straight from one cell's centre, where there is so much room, to a neighbour's.
    pub fn edge_clear<F: Field>(
        &mut self,
        field: &F,
        (from, room): (usize, f32),
        to: usize,
        slanting: bool,
    ) -> bool {
        let least = self.room(field, to).min(room);
        if least < 0.0 {
            return false;
        }
        least >= self.open[usize::from(slanting)]
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

    pub fn size(&self) -> usize {
        self.columns * self.rows
    }

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

    fn cell(&self, p: Point) -> (i64, i64) {
        let column = ((p.x - self.low.x) / self.spacing).floor() as i64;
        let row = ((p.y - self.low.y) / self.spacing).floor() as i64;
        (
            column.clamp(0, self.columns as i64 - 1),
            row.clamp(0, self.rows as i64 - 1),
        )
    }

    pub fn index(&self, column: i64, row: i64) -> Option<usize> {
        (column >= 0 && row >= 0 && column < self.columns as i64 && row < self.rows as i64)
            .then(|| row as usize * self.columns + column as usize)
    }

    /// The neighbours of a cell, in the order of `NEIGHBOURS`.
    fn around(&self, index: usize) -> impl Iterator<Item = usize> + use<'_> {
        let (column, row) = self.place(index);
        let beside = NEIGHBOURS.into_iter();
        beside.filter_map(move |(across, up)| self.index(column + across, row + up))
    }

    /// False when `goal` certainly can't be reached: of two floods, from there and from `start`, over every cell that
    /// could hold any position of the robot at all, one ends without meeting the other.
    pub fn possible<F: Field>(&self, field: &F, start: Point, goal: Point) -> bool {
        let ends = [start, goal].map(|p| {
            let (column, row) = self.cell(p);
            self.index(column, row)
        });
        let [Some(start), Some(goal)] = ends else {
            return false;
        };
        if start == goal {
            return true;
        }
        // Clearance is 1-Lipschitz: no point of a cell has more than its centre's plus the half diagonal.
        let least = self.radius - 0.7072 * self.spacing;
        let mut flooded = vec![0u8; self.size()];
        let mut pending = [vec![start], vec![goal]];
        (flooded[start], flooded[goal]) = (1, 2);
        loop {
            for side in [0, 1] {
                let Some(at) = pending[side].pop() else {
                    return false;
                };
                let (own, other) = (side as u8 + 1, 2 - side as u8);
                for next in self.around(at) {
                    if flooded[next] == other {
                        return true;
                    }
                    if flooded[next] == 0 && field.may_hold(self.point(next), least) {
                        flooded[next] = own;
                        pending[side].push(next);
                    }
                }
            }
        }
    }
}

/// What the lattices know about the way to a goal: `Err(true)` stands for none found though it may exist, and
/// `Err(false)` for proof that there is none. Coarse lattices first; only the finest one's flood proves anything.
pub fn way<F: Field>(
    field: &F,
    start: Point,
    goal: Point,
    radius: f64,
) -> Result<Vec<Point>, bool> {
    let spacings = field.lattice_spacings(radius);
    let ends = [start, goal].map(|p| Stop { p, next: 0 });
    let found = |mut lattice: Lattice| {
        let (behind, ahead) = ends.split_at(1);
        let (_, _, way) = search::joint(&mut lattice, field, behind, ahead)?;
        Some([vec![start], way, vec![goal]].concat())
    };
    let fine = Lattice::new(field, spacings[spacings.len() - 1], radius);
    (spacings.iter())
        .find_map(|&spacing| found(Lattice::new(field, spacing, radius)))
        .map(Ok)
        .unwrap_or_else(|| {
            if !fine.possible(field, start, goal) {
                return Err(false);
            }
            found(Lattice::tightest(field, radius)).ok_or(true)
        })
}
