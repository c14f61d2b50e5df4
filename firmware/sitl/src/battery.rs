//! The board's converter: the battery's voltage in steps of 12 bits, one conversion a tick, the mean of eight.
//!
//! As `firmware/pico/src/battery.rs` does it, because the wheels' duty follows the voltage: a desktop that knew it better
//! would drive otherwise.

const DIVIDER: f64 = 3.0;
const REFERENCE_MV: f64 = 3_300.0;
const FULL_SCALE: u32 = 4_096;
const VALUE_US: u64 = 8_000;

#[derive(Default)]
pub struct Converter {
    /// Begun at the last tick.
    conversion: Option<u32>,
    sum: u32,
    count: u32,
    millivolts: Option<u16>,
}

impl Converter {
    /// What the firmware reads at a tick when the battery has `battery_mv`.
    pub fn measure(&mut self, now_us: u64, battery_mv: u16) -> u16 {
        let steps = f64::from(battery_mv) / DIVIDER / REFERENCE_MV * f64::from(FULL_SCALE);
        let sample = (steps as u32).min(FULL_SCALE - 1);
        if let Some(last) = self.conversion.replace(sample) {
            self.sum += last;
            self.count += 1;
        }
        let mut value = self.millivolts.unwrap_or_else(|| millivolts(sample * 8, 8));
        if now_us.is_multiple_of(VALUE_US) && self.count > 0 {
            value = millivolts(self.sum, self.count);
            (self.sum, self.count) = (0, 0);
        }
        self.millivolts = Some(value);
        value
    }
}

fn millivolts(sum: u32, count: u32) -> u16 {
    (sum * REFERENCE_MV as u32 * DIVIDER as u32 / (FULL_SCALE * count)) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_value_is_the_mean_of_the_eight_conversions_before_it() {
        let mut converter = Converter::default();
        assert_eq!(converter.measure(1_000, 7_400), 7_398, "a step is 2.4 mV");
        let read: Vec<u16> = (2..=24)
            .map(|ms| converter.measure(ms * 1_000, if ms < 12 { 7_400 } else { 7_000 }))
            .collect();
        assert_eq!(read[5], 7_398);
        assert!((7_190..7_210).contains(&read[14]), "{read:?}");
        assert_eq!(read[22], 6_999);
    }
}
