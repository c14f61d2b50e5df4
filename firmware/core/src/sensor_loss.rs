//! What the loss of a sensor means: one table.
//!
//! A sensor is lost when it no longer answers. What sees nothing is not lost, and neither is what the rover never had:
//! `sonars_fitted` says which sonars there are. Encoders are not here, as their loss shows only while they turn; the
//! drive check cuts the motors then.

/// A sonar that a drive may depend on.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Sonar {
    Left,
    Centre,
    Right,
}

/// What the rover may still do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Allowed {
    pub arming: bool,
    /// Greatest forward speed, um/s; anything above stops the rover. Turning on the spot and backing are not looked at
    /// by any sonar.
    pub forward_um_s: i64,
}

const NOT_FORWARD: Allowed = Allowed {
    arming: false,
    forward_um_s: 0,
};

/// All three look at ground that the footprint sweeps going forward.
const TABLE: [(Sonar, Allowed); 3] = [
    (Sonar::Left, NOT_FORWARD),
    (Sonar::Centre, NOT_FORWARD),
    (Sonar::Right, NOT_FORWARD),
];

/// The number of the first lost sensor that forbids arming. `lost` has a bit for each, in the order of [`Sonar`].
pub fn forbids_arming(lost: u8) -> Option<u8> {
    first(lost, |allowed| !allowed.arming)
}

/// The number of the first lost sensor with which the rover may not go forward so fast.
pub fn forbids_speed(lost: u8, forward_um_s: i64) -> Option<u8> {
    if lost == 0 {
        return None;
    }
    first(lost, |allowed| forward_um_s > allowed.forward_um_s)
}

fn first(lost: u8, forbids: impl Fn(&Allowed) -> bool) -> Option<u8> {
    TABLE
        .iter()
        .find(|(sensor, allowed)| lost & 1 << *sensor as u8 != 0 && forbids(allowed))
        .map(|(sensor, _)| *sensor as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_sonar_has_one_row_in_the_order_of_its_number() {
        for (number, (sensor, _)) in TABLE.iter().enumerate() {
            assert_eq!(*sensor as usize, number);
        }
        assert_eq!(TABLE.len(), crate::sonar::SENSORS);
    }

    /// The default: no way forward without a sonar that looks there.
    #[test]
    fn any_lost_sonar_forbids_arming_and_going_forward_and_nothing_else() {
        for lost in 1..8_u8 {
            let named = lost.trailing_zeros() as u8;
            assert_eq!(forbids_arming(lost), Some(named));
            assert_eq!(forbids_speed(lost, 1), Some(named));
            assert_eq!(forbids_speed(lost, 0), None, "turning on the spot");
            assert_eq!(forbids_speed(lost, -100_000), None, "backing");
        }
        assert_eq!(forbids_arming(0), None);
        assert_eq!(forbids_speed(0, 500_000), None);
    }
}
