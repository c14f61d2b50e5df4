//! Discs in which the robot's centre may not be, and how far it may follow their rims.

use std::f64::consts::TAU;

use crate::geometry::{distance, Point};

/// Radians by which an arc may reach into a blocked part of a rim: rounding where discs touch.
const SLACK_RAD: f64 = 1e-7;

/// A circle, widened by the robot's radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Disc {
    /// Its centre.
    pub centre: Point,
    /// Its radius in metres; 0 for the start and the goal.
    pub radius: f64,
}

/// In which sense a path follows a rim.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Turn {
    /// Anticlockwise, the centre on the left.
    Left,
    /// Clockwise, the centre on the right.
    Right,
}

impl Turn {
    /// Both of them.
    pub const BOTH: [Turn; 2] = [Turn::Left, Turn::Right];

    /// +1 for a turn to the left, −1 for one to the right.
    pub fn sign(self) -> f64 {
        match self {
            Turn::Left => 1.0,
            Turn::Right => -1.0,
        }
    }

    /// Radians from one angle to the other in this sense, 0 to 2π.
    pub fn arc(self, from: f64, to: f64) -> f64 {
        let arc = (self.sign() * (to - from)).rem_euclid(TAU);
        // An arc of nothing must not become a whole turn by rounding.
        if TAU - arc < SLACK_RAD {
            0.0
        } else {
            arc
        }
    }
}

impl Disc {
    /// The point of the rim at this angle.
    pub fn at(&self, angle: f64) -> Point {
        let (sin, cos) = angle.sin_cos();
        Point::new(
            self.centre.x + self.radius * cos,
            self.centre.y + self.radius * sin,
        )
    }

    /// The angle at which `p` lies from the centre.
    pub fn angle(&self, p: Point) -> f64 {
        (p.y - self.centre.y).atan2(p.x - self.centre.x)
    }
}

/// Ends of the tangent that leaves one disc's rim in one sense and meets another's in the other; none where one disc holds
/// the other.
pub fn tangent(from: (Disc, Turn), to: (Disc, Turn)) -> Option<(Point, Point)> {
    let (a, b) = (from.0, to.0);
    let apart = distance(a.centre, b.centre);
    let [s, t] = [(a, from.1), (b, to.1)].map(|(disc, turn)| turn.sign() * disc.radius);
    let cos = (t - s) / apart;
    if apart == 0.0 || cos.abs() >= 1.0 {
        return None;
    }
    let sin = (1.0 - cos * cos).sqrt();
    let (x, y) = (
        (b.centre.x - a.centre.x) / apart,
        (b.centre.y - a.centre.y) / apart,
    );
    // The normal to the left of the tangent; a centre on the left lies along it.
    let normal = Point::new(x * cos - y * sin, y * cos + x * sin);
    let end = |centre: Point, s: f64| Point::new(centre.x - s * normal.x, centre.y - s * normal.y);
    Some((end(a.centre, s), end(b.centre, t)))
}

/// The parts of a rim on which the robot's centre may not be, each by its middle and half its width in radians; none at
/// all when the whole rim is blocked.
pub fn blocked_parts(
    disc: &Disc,
    others: &[Disc],
    (low, high): (Point, Point),
) -> Option<Vec<(f64, f64)>> {
    let mut parts = Vec::new();
    for other in others {
        let apart = distance(disc.centre, other.centre);
        if other == disc || apart >= disc.radius + other.radius {
            continue;
        }
        if apart + disc.radius <= other.radius {
            return None;
        }
        if apart + other.radius <= disc.radius {
            continue;
        }
        let cos = (apart * apart + disc.radius * disc.radius - other.radius * other.radius)
            / (2.0 * apart * disc.radius);
        parts.push((disc.angle(other.centre), cos.clamp(-1.0, 1.0).acos()));
    }
    let c = disc.centre;
    let walls = [
        (high.x - c.x, 0.0),
        (high.y - c.y, 0.25),
        (c.x - low.x, 0.5),
        (c.y - low.y, 0.75),
    ];
    for (room, turns) in walls {
        if room <= -disc.radius {
            return None;
        }
        if room < disc.radius {
            parts.push((turns * TAU, (room / disc.radius).acos()));
        }
    }
    Some(parts)
}

/// Radians that the rim may be followed from `angle` on, at most a whole turn.
pub fn free_arc(parts: &[(f64, f64)], turn: Turn, angle: f64) -> f64 {
    (parts.iter())
        .map(|&(middle, half)| {
            let begin = middle - turn.sign() * (half - SLACK_RAD);
            if turn.arc(begin, angle) < 2.0 * (half - SLACK_RAD) {
                0.0
            } else {
                turn.arc(angle, begin)
            }
        })
        .fold(TAU, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::point_segment_squared;
    use std::f64::consts::PI;

    fn disc(x: f64, y: f64, radius: f64) -> Disc {
        Disc {
            centre: Point::new(x, y),
            radius,
        }
    }

    #[test]
    fn a_tangent_touches_both_discs_on_the_sides_that_were_asked_for() {
        let (a, b) = (disc(0.0, 0.0, 1.0), disc(4.0, 1.0, 0.5));
        for (first, second) in [
            (Turn::Left, Turn::Left),
            (Turn::Left, Turn::Right),
            (Turn::Right, Turn::Left),
            (Turn::Right, Turn::Right),
        ] {
            let (p, q) = tangent((a, first), (b, second)).unwrap();
            for (disc, turn) in [(a, first), (b, second)] {
                let near = point_segment_squared(disc.centre, p, q).sqrt();
                assert!((near - disc.radius).abs() < 1e-12);
                let (x, y) = (disc.centre.x - p.x, disc.centre.y - p.y);
                let left = (q.x - p.x) * y - (q.y - p.y) * x > 0.0;
                assert_eq!(left, turn == Turn::Left);
            }
        }
        assert_eq!(
            tangent((a, Turn::Left), (disc(0.2, 0.0, 0.1), Turn::Left)),
            None
        );
    }

    #[test]
    fn a_rim_ends_where_another_disc_or_a_wall_begins() {
        let bounds = (Point::new(-5.0, -0.5), Point::new(5.0, 5.0));
        let rim = disc(0.0, 0.0, 1.0);
        let parts = blocked_parts(&rim, &[rim, disc(1.0, 0.0, 1.0)], bounds).unwrap();
        // The other disc blocks ±60°, the wall below 210° to 330°.
        let left = free_arc(&parts, Turn::Left, PI / 2.0);
        let right = free_arc(&parts, Turn::Right, PI / 2.0);
        assert!((left - 2.0 * PI / 3.0).abs() < 1e-6, "{left}");
        assert!((right - PI / 6.0).abs() < 1e-6, "{right}");
        assert_eq!(free_arc(&parts, Turn::Left, 0.0), 0.0);
        assert_eq!(blocked_parts(&rim, &[disc(0.1, 0.0, 2.0)], bounds), None);
    }
}
