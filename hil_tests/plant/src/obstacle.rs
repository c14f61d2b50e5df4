//! Things that the rover must not touch: upright discs, and the bounds of the area, which count as walls.

use crate::pose::Pose;

#[derive(Clone, Copy, Debug)]
pub struct Obstacle {
    pub x: f64,
    pub y: f64,
    pub radius: f64,
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
