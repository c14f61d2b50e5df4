//! A pose in the plane: metres and radians, x forward, y left, heading counter-clockwise.

/// Of base_link on the map.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Metres.
    pub x: f64,
    /// Metres.
    pub y: f64,
    /// Radians, unwrapped.
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

#[cfg(test)]
mod tests {
    use std::f64::consts::{FRAC_PI_2, TAU};

    use super::*;

    const TRACK: f64 = 0.2;

    fn near(one: Pose, x: f64, y: f64, heading: f64) -> bool {
        (one.x - x).abs() < 1e-9 && (one.y - y).abs() < 1e-9 && (one.heading - heading).abs() < 1e-9
    }

    #[test]
    fn composition_turns_the_second_pose_into_the_frame_of_the_first() {
        let first = Pose {
            x: 1.0,
            y: 2.0,
            heading: FRAC_PI_2,
        };
        assert!(near(
            first.compose(0.5, 0.1, 0.2),
            0.9,
            2.5,
            FRAC_PI_2 + 0.2
        ));
    }

    #[test]
    fn wheels_that_roll_alike_go_straight_and_opposite_ones_turn_on_the_spot() {
        let start = Pose {
            x: 1.0,
            y: 1.0,
            heading: 0.0,
        };
        assert!(near(start.roll(0.3, 0.3, TRACK), 1.3, 1.0, 0.0));
        let quarter = FRAC_PI_2 * TRACK / 2.0;
        assert!(near(
            start.roll(-quarter, quarter, TRACK),
            1.0,
            1.0,
            FRAC_PI_2
        ));
    }

    #[test]
    fn a_whole_circle_in_any_number_of_pieces_comes_back_with_one_turn() {
        let circumference = TAU * 0.5;
        let (left, right) = (
            circumference - TAU * TRACK / 2.0,
            circumference + TAU * TRACK / 2.0,
        );
        for pieces in [3, 10, 1000] {
            let share = 1.0 / f64::from(pieces);
            let start = Pose {
                x: 0.0,
                y: 0.0,
                heading: 0.0,
            };
            let end = (0..pieces).fold(start, |pose, _| {
                pose.roll(left * share, right * share, TRACK)
            });
            assert!(near(end, 0.0, 0.0, TAU), "{pieces} pieces: {end:?}");
        }
    }
}
