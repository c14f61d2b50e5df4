//! What a roadmap tries before it gives up a node or an edge on which something new stands: it shifts the node, or bends
//! the edge.

use crate::geometry::Point;
use crate::map::field::Field;

/// Shares of the spacing by which a node may be shifted.
const SHIFTS: [f64; 3] = [0.25, 0.5, 0.75];
/// Directions in which it may be shifted.
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

/// The first point at `p` or beside it where a disc of `radius` fits.
pub fn shift<F: Field>(field: &F, p: Point, spacing: f64, radius: f64) -> Option<Point> {
    let shifted = SHIFTS.iter().flat_map(|share| {
        let off = share * spacing;
        (DIRECTIONS.iter()).map(move |(x, y)| Point::new(p.x + off * x, p.y + off * y))
    });
    [p].into_iter()
        .chain(shifted)
        .find(|&p| field.edge_clear(p, p, radius))
}

/// A point through which a disc of `radius` gets from one point to the other in two straight lines.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::map::circles::Circles;

    #[test]
    fn a_node_is_shifted_just_far_enough_to_fit() {
        let field = Circles::new(4.0, 4.0, vec![(Point::new(1.9, 2.0), 0.2)]);
        let p = Point::new(2.0, 2.0);
        let found = shift(&field, p, 1.0, 0.2).expect("there is room to the right");
        assert_eq!(found, Point::new(2.5, 2.0));
        assert_eq!(
            shift(&Circles::new(4.0, 4.0, Vec::new()), p, 1.0, 0.2),
            Some(p)
        );
    }

    #[test]
    fn an_edge_bends_around_a_small_obstacle_and_not_around_a_large_one() {
        let (from, to) = (Point::new(0.5, 2.0), Point::new(3.5, 2.0));
        let around = |size: f64| {
            let field = Circles::new(4.0, 4.0, vec![(Point::new(2.0, 2.0), size)]);
            bend(&field, (from, to), 1.0, 0.1)
        };
        assert!(around(0.3).is_some_and(|p| p.y != 2.0));
        assert_eq!(around(1.5), None);
    }
}
