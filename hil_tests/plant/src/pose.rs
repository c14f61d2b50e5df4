//! A pose in the plane: metres and radians, x forward, y left, heading counter-clockwise.

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    pub x: f64,
    pub y: f64,
    pub heading: f64,
}

impl Pose {
    /// A pose given on this one, in the frame that this one is given in.
    pub fn compose(self, x: f64, y: f64, heading: f64) -> Self {
        let (sine, cosine) = self.heading.sin_cos();
        Self {
            x: self.x + cosine * x - sine * y,
            y: self.y + sine * x + cosine * y,
            heading: self.heading + heading,
        }
    }

    /// Moves along the arc that two wheels `track` apart roll, `left` and `right` metres long.
    pub fn roll(self, left: f64, right: f64, track: f64) -> Self {
        let travel = 0.5 * (left + right);
        let turn = (right - left) / track;
        // The chord of an arc lies at half the turn; its length differs from the arc by sinc(turn / 2).
        let half = 0.5 * turn;
        let chord = if half.abs() < 1e-6 {
            travel
        } else {
            travel * half.sin() / half
        };
        let (sine, cosine) = (self.heading + half).sin_cos();
        Self {
            x: self.x + chord * cosine,
            y: self.y + chord * sine,
            heading: self.heading + turn,
        }
    }
}
