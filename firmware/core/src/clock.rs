//! The firmware's clock on the wire: 32 bits of microseconds that wrap after 71.6 minutes.

/// How far ahead a run may start.
pub const FARTHEST_START_US: u64 = 10_000_000;

/// The low 32 bits, as messages carry them.
pub fn low(now_us: u64) -> u32 {
    now_us as u32
}

/// The moment nearest to `now_us` whose low 32 bits are `low`; before boot counts as boot.
pub fn expand(now_us: u64, low: u32) -> u64 {
    let ahead = low.wrapping_sub(now_us as u32) as i32;
    now_us.saturating_add_signed(i64::from(ahead))
}

/// The start time of a run if it is neither past nor more than ten seconds ahead.
pub fn start_time(now_us: u64, low: u32) -> Option<u64> {
    let start = expand(now_us, low);
    let ahead = start.checked_sub(now_us)?;
    (ahead <= FARTHEST_START_US).then_some(start)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WRAP: u64 = 1 << 32;

    #[test]
    fn expands_to_the_nearest_moment_on_both_sides_of_the_wrap() {
        assert_eq!(expand(WRAP + 5, 7), WRAP + 7);
        assert_eq!(expand(WRAP + 5, u32::MAX), WRAP - 1);
        assert_eq!(expand(WRAP - 5, 3), WRAP + 3);
        assert_eq!(expand(5, u32::MAX - 9), 0, "nothing lies before boot");
    }

    #[test]
    fn a_start_is_refused_in_the_past_and_too_far_ahead() {
        let now = 3 * WRAP - 1_000;
        assert_eq!(start_time(now, low(now)), Some(now));
        assert_eq!(start_time(now, low(now + 5_000)), Some(now + 5_000));
        assert_eq!(start_time(now, low(now - 1)), None);
        assert_eq!(start_time(now, low(now + 10_000_001)), None);
    }
}
