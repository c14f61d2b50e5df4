//! The bumper: what it takes for a touch to end a drive, and how the rover comes to rest after one.
//!
//! A touch is an edge while the motors are on, or a switch that is pressed while the rover goes forward. Backing away from
//! what was touched is the one motion that a pressed switch allows besides turning: the way out. Switches that chatter
//! while they open are no touch then.

/// After a touch both bridges short the motors for so long, or until the wheels stand: they brake, where bridges that are
/// off would let the rover roll on.
const ARREST_US: u64 = 300_000;

#[derive(Clone, Debug, Default)]
pub struct Bumper {
    pressed: bool,
    touched: bool,
    arrested_until_us: Option<u64>,
}

impl Bumper {
    /// One tick's level; `travel` is the commanded forward speed, of any unit, negative backwards.
    pub fn sense(&mut self, pressed: bool, travel: i64) {
        let edge = pressed && !self.pressed;
        self.pressed = pressed;
        self.touched = travel >= 0 && (edge || (pressed && travel > 0));
    }

    /// Whether this tick's level ends a drive.
    pub fn is_touch(&self) -> bool {
        self.touched
    }

    pub fn is_pressed(&self) -> bool {
        self.pressed
    }

    /// The motors were cut because of a touch.
    pub fn arrest(&mut self, now_us: u64) {
        self.arrested_until_us = Some(now_us.saturating_add(ARREST_US));
    }

    /// Arming ends it: the wheels are held then.
    pub fn release(&mut self) {
        self.arrested_until_us = None;
    }

    /// Whether the bridges are on, without duty, to bring the wheels to rest.
    pub fn holds(&mut self, now_us: u64, standing: bool) -> bool {
        if standing
            || self
                .arrested_until_us
                .is_some_and(|until_us| now_us >= until_us)
        {
            self.arrested_until_us = None;
        }
        self.arrested_until_us.is_some()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_edge_is_a_touch_unless_the_rover_backs() {
        for (travel, touch) in [(0, true), (100, true), (-100, false)] {
            let mut bumper = Bumper::default();
            bumper.sense(true, travel);
            assert_eq!(bumper.is_touch(), touch, "{travel}");
        }
    }

    #[test]
    fn a_switch_that_stays_pressed_allows_turning_and_backing_and_not_going_forward() {
        let mut bumper = Bumper::default();
        bumper.sense(true, 0);
        for (travel, touch) in [(0, false), (-100, false), (1, true), (0, false)] {
            bumper.sense(true, travel);
            assert_eq!(bumper.is_touch(), touch, "{travel}");
        }
    }

    #[test]
    fn the_wheels_are_braked_until_they_stand_and_no_longer_than_the_limit() {
        let mut bumper = Bumper::default();
        assert!(!bumper.holds(0, false));
        bumper.arrest(1_000);
        assert!(bumper.holds(2_000, false));
        assert!(!bumper.holds(3_000, true));
        assert!(!bumper.holds(4_000, false), "it does not begin anew");
        bumper.arrest(5_000);
        assert!(!bumper.holds(5_000 + ARREST_US, false));
    }
}
