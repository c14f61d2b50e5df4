//! Things that the rover must not touch: upright discs, and the bounds of the area, which count as walls.

use crate::pose::Pose;

/// An upright disc, metres.
#[derive(Clone, Copy, Debug)]
pub struct Obstacle {
    /// Of its axis.
    pub x: f64,
    /// Of its axis.
    pub y: f64,
    /// Of the disc.
    pub radius: f64,
    /// Above the ground.
    pub height: f64,
}

/// Distance from a disc of `radius` at the pose to the nearest obstacle; infinite when there is none.
pub fn obstacle_clearance(pose: Pose, radius: f64, obstacles: &[Obstacle]) -> f64 {
    obstacles
        .iter()
        .map(|o| (pose.x - o.x).hypot(pose.y - o.y) - o.radius - radius)
        .fold(f64::INFINITY, f64::min)
}

/// Distance from a disc of `radius` at the pose to the nearest bound of the area.
pub fn wall_clearance(pose: Pose, radius: f64, width: f64, height: f64) -> f64 {
    pose.x.min(width - pose.x).min(pose.y).min(height - pose.y) - radius
}

/// Pushes a disc of `radius` out of what it has run into. Returns the corrected pose, and whether it was in contact.
pub fn block(
    pose: Pose,
    radius: f64,
    obstacles: &[Obstacle],
    width: f64,
    height: f64,
) -> (Pose, bool) {
    let mut free = pose;
    let mut contact = false;
    for o in obstacles {
        let (dx, dy) = (free.x - o.x, free.y - o.y);
        let distance = dx.hypot(dy);
        let reach = radius + o.radius;
        if distance < reach && distance > 0.0 {
            contact = true;
            free.x = o.x + dx / distance * reach;
            free.y = o.y + dy / distance * reach;
        }
    }
    let inside = |value: f64, size: f64| {
        value.clamp(radius.min(0.5 * size), (size - radius).max(0.5 * size))
    };
    let (x, y) = (inside(free.x, width), inside(free.y, height));
    contact |= x != free.x || y != free.y;
    free.x = x;
    free.y = y;
    (free, contact)
}

#[cfg(test)]
mod tests {
    use super::*;

    const POST: Obstacle = Obstacle {
        x: 1.0,
        y: 1.0,
        radius: 0.05,
        height: 0.3,
    };

    fn at(x: f64, y: f64) -> Pose {
        Pose { x, y, heading: 0.3 }
    }

    #[test]
    fn clearance_is_between_the_edges() {
        assert!((obstacle_clearance(at(1.0, 0.5), 0.15, &[POST]) - 0.3).abs() < 1e-12);
        assert_eq!(obstacle_clearance(at(1.0, 0.5), 0.15, &[]), f64::INFINITY);
        assert!((wall_clearance(at(0.4, 0.7), 0.15, 3.0, 4.0) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn a_disc_that_has_run_into_something_is_put_at_its_edge_with_its_heading() {
        let (pose, contact) = block(at(0.9, 1.0), 0.15, &[POST], 3.0, 4.0);
        assert!(contact);
        assert!((pose.x - 0.8).abs() < 1e-12);
        assert_eq!((pose.y, pose.heading), (1.0, 0.3));
        let (pose, contact) = block(at(2.95, 1.0), 0.15, &[], 3.0, 4.0);
        assert!(contact);
        assert!((pose.x - 2.85).abs() < 1e-12);
    }

    #[test]
    fn a_free_disc_stays_where_it_is() {
        let free = at(0.5, 1.0);
        assert_eq!(block(free, 0.15, &[POST], 3.0, 4.0), (free, false));
    }
}
