//! A rectangle with circular obstacles: every check is exact.

use crate::field::{wall_distance, Field, TOUCH};
use crate::geometry::{distance, point_segment_squared, Point};

pub struct Circles {
    pub width: f64,
    pub height: f64,
    pub obstacles: Vec<(Point, f64)>,
}

impl Field for Circles {
    fn bounds(&self) -> (Point, Point) {
        (Point::new(0.0, 0.0), Point::new(self.width, self.height))
    }

    fn clearance(&self, p: Point) -> f64 {
        let wall = wall_distance(self.bounds(), p);
        self.obstacles
            .iter()
            .fold(wall, |nearest, &(centre, radius)| {
                nearest.min(distance(p, centre) - radius)
            })
    }

    fn sweep_clear(&self, a: Point, b: Point, radius: f64) -> bool {
        self.obstacles.iter().all(|&(centre, obstacle)| {
            let reach = radius + obstacle - TOUCH;
            point_segment_squared(centre, a, b) >= reach * reach
        })
    }

    fn lattice_spacing(&self) -> f64 {
        self.width.max(self.height) / 96.0
    }
}
