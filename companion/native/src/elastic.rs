//! What a roadmap does before it gives up a node or an edge that something new stands on: it steps aside, or bends.

use crate::field::Field;
use crate::geometry::Point;

/// Shares of the spacing by which a node may step aside, and where.
const ASIDE: [f64; 3] = [0.25, 0.5, 0.75];
const DIRECTIONS: [(f64, f64); 8] = [
    (1.0, 0.0),
    (0.0, 1.0),
    (-1.0, 0.0),
    (0.0, -1.0),
    (0.7, 0.7),
    (-0.7, 0.7),
    (-0.7, -0.7),
    (0.7, -0.7),
];
/// Shares of the spacing by which an edge may bend to one side or the other, straight among them.
const BENDS: [f64; 7] = [0.0, 0.3, -0.3, 0.6, -0.6, 0.9, -0.9];

/// The first place at `p` or beside it where a disc of `radius` fits.
pub fn place<F: Field>(field: &F, p: Point, spacing: f64, radius: f64) -> Option<Point> {
    let aside = ASIDE.iter().flat_map(|share| {
        let off = share * spacing;
        (DIRECTIONS.iter()).map(move |(x, y)| Point::new(p.x + off * x, p.y + off * y))
    });
    [p].into_iter()
        .chain(aside)
        .find(|&p| field.edge_clear(p, p, radius))
}

/// A point through which a disc of `radius` gets from one place to the other in two straight lines.
pub fn bend<F: Field>(
    field: &F,
    (from, to): (Point, Point),
    spacing: f64,
    radius: f64,
) -> Option<Point> {
    let middle = from.towards(to, 0.5);
    let (x, y) = (to.x - from.x, to.y - from.y);
    let length = (x * x + y * y).sqrt();
    BENDS
        .iter()
        .map(|share| {
            let off = share * spacing / length;
            Point::new(middle.x - off * y, middle.y + off * x)
        })
        .find(|&p| field.edge_clear(from, p, radius) && field.edge_clear(p, to, radius))
}
