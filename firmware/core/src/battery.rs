//! Battery voltage: filtered, its lowest value, and whether it is too low to drive.

/// Hysteresis of the low-voltage condition.
const RECOVERY_MV: i32 = 300;
/// The filter starts at the first sample and has settled after this many.
const SETTLED_TICKS: u16 = 64;

#[derive(Clone, Debug, Default)]
pub struct Battery {
    /// Filtered voltage in mV / 64.
    filtered: u32,
    minimum_mv: u16,
    ticks: u16,
    below_since_us: Option<u64>,
    low: bool,
}

impl Battery {
    /// One tick; `limit_mv` must be undercut for `delay_us`, since motors starting pull the voltage down briefly.
    pub fn tick(&mut self, now_us: u64, sample_mv: u16, limit_mv: i32, delay_us: u64) {
        if self.ticks == 0 {
            self.filtered = u32::from(sample_mv) * 64;
            self.minimum_mv = sample_mv;
        }
        self.ticks = self.ticks.saturating_add(1);
        self.filtered = self.filtered - self.filtered / 64 + u32::from(sample_mv);
        if self.ticks > SETTLED_TICKS {
            self.minimum_mv = self.minimum_mv.min(self.voltage_mv());
        }
        let voltage = i32::from(self.voltage_mv());
        if voltage >= limit_mv {
            self.below_since_us = None;
            self.low &= voltage < limit_mv + RECOVERY_MV;
            return;
        }
        let since_us = *self.below_since_us.get_or_insert(now_us);
        self.low |= now_us.saturating_sub(since_us) >= delay_us;
    }

    pub fn voltage_mv(&self) -> u16 {
        (self.filtered / 64).min(u32::from(u16::MAX)) as u16
    }

    /// Lowest filtered voltage since boot.
    pub fn minimum_mv(&self) -> u16 {
        self.minimum_mv
    }

    /// Too low to drive.
    pub fn is_low(&self) -> bool {
        self.low
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(battery: &mut Battery, from_ms: u64, to_ms: u64, mv: u16) {
        for ms in from_ms..to_ms {
            battery.tick(ms * 1000, mv, 6_200, 500_000);
        }
    }

    #[test]
    fn a_short_dip_is_forgiven_and_a_long_one_is_not() {
        let mut battery = Battery::default();
        run(&mut battery, 0, 1_000, 7_400);
        run(&mut battery, 1_000, 1_400, 5_500);
        assert!(!battery.is_low());
        run(&mut battery, 1_400, 2_000, 7_400);
        run(&mut battery, 2_000, 2_700, 6_100);
        assert!(battery.is_low());
    }

    #[test]
    fn low_ends_only_well_above_the_limit() {
        let mut battery = Battery::default();
        run(&mut battery, 0, 1_000, 6_000);
        run(&mut battery, 1_000, 2_000, 6_300);
        assert!(battery.is_low());
        run(&mut battery, 2_000, 3_000, 6_600);
        assert!(!battery.is_low());
        assert_eq!(battery.minimum_mv(), 6_000);
    }
}
