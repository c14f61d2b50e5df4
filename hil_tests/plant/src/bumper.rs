//! The bumper: a strip around the front half of the hull, whose switches close when it touches anything.

use crate::obstacle::Obstacle;
use crate::pose::Pose;

/// How far to either side of straight ahead the strip reaches, radians.
const HALF_ANGLE: f64 = std::f64::consts::FRAC_PI_2;
/// What closes a switch: less room than this. The plant keeps a hull and what it presses against exactly apart.
const TOUCH: f64 = 1e-4;

/// Whether a hull of `radius` at the pose touches an obstacle, or a bound of the area, with its front half.
pub fn pressed(pose: Pose, radius: f64, obstacles: &[Obstacle], width: f64, height: f64) -> bool {
    let ahead = |dx: f64, dy: f64| {
        let (sine, cosine) = pose.heading.sin_cos();
        let (along, across) = (cosine * dx + sine * dy, cosine * dy - sine * dx);
        across.atan2(along).abs() <= HALF_ANGLE
    };
    let touched = |o: &Obstacle| {
        let (dx, dy) = (o.x - pose.x, o.y - pose.y);
        dx.hypot(dy) <= radius + o.radius + TOUCH && ahead(dx, dy)
    };
    let walls = [
        (pose.x, -1.0, 0.0),
        (width - pose.x, 1.0, 0.0),
        (pose.y, 0.0, -1.0),
        (height - pose.y, 0.0, 1.0),
    ];
    let at_wall = |(room, dx, dy): (f64, f64, f64)| room <= radius + TOUCH && ahead(dx, dy);
    obstacles.iter().any(touched) || walls.into_iter().any(at_wall)
}

/// How fast a hull that was at `before` and would have rolled to `rolled` in `dt` seconds came up against what has pushed
/// it to `held`: the part of its speed along that push, m/s.
pub fn closing_speed(before: Pose, rolled: Pose, held: Pose, dt: f64) -> f64 {
    let (px, py) = (held.x - rolled.x, held.y - rolled.y);
    let length = px.hypot(py);
    if length < 1e-12 {
        return 0.0;
    }
    let (vx, vy) = ((rolled.x - before.x) / dt, (rolled.y - before.y) / dt);
    (-(vx * px + vy * py) / length).max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    const POST: Obstacle = Obstacle {
        x: 1.0,
        y: 1.0,
        radius: 0.05,
        height: 0.05,
    };

    fn at(x: f64, y: f64, heading: f64) -> Pose {
        Pose { x, y, heading }
    }

    #[test]
    fn the_front_half_feels_what_it_touches_however_low_and_the_back_does_not() {
        let touches = |heading| pressed(at(0.8, 1.0, heading), 0.15, &[POST], 3.0, 4.0);
        assert!(touches(0.0) && touches(1.5) && touches(-1.5));
        assert!(!touches(1.7) && !touches(3.1));
        assert!(!pressed(at(0.799, 1.0, 0.0), 0.15, &[POST], 3.0, 4.0));
    }

    #[test]
    fn walls_are_felt_like_obstacles() {
        assert!(pressed(at(2.85, 2.0, 0.0), 0.15, &[], 3.0, 4.0));
        assert!(!pressed(at(2.85, 2.0, 3.0), 0.15, &[], 3.0, 4.0));
    }

    #[test]
    fn the_closing_speed_is_the_part_towards_what_is_touched() {
        let (before, rolled) = (at(0.0, 0.0, 0.0), at(0.3e-3, 0.4e-3, 0.0));
        let speed = closing_speed(before, rolled, at(0.2e-3, 0.4e-3, 0.0), 1e-3);
        assert!((speed - 0.3).abs() < 1e-9, "{speed}");
        assert_eq!(closing_speed(before, rolled, rolled, 1e-3), 0.0);
    }
}
