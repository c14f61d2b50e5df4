//! Measurements that come over the link instead of from the pins.

use crate::sonar::{SonarEcho, SENSORS};

/// An echo of this length: the sensor says nothing at all, as a broken one.
const SILENT: u32 = 0xff_ffff;
/// When the driver of a sensor without an echo gives up.
const TIMEOUT_US: u64 = 25_000;

/// The measurements that replace the board's.
#[derive(Clone, Debug)]
pub struct Injection {
    /// None until the first ones have come.
    pub counts: Option<[i32; 2]>,
    pub battery_mv: u16,
    pub emergency_stop: bool,
    pub bumper: bool,
    pub echoes_us: [u32; SENSORS],
    /// Sensor that was pinged and has not answered, and when.
    pub pinged: Option<(u8, u64)>,
    /// When something was injected last.
    pub heard_us: u64,
}

impl Injection {
    pub fn new(battery_mv: u16, now_us: u64) -> Self {
        Self {
            counts: None,
            battery_mv,
            emergency_stop: false,
            bumper: false,
            echoes_us: [0; SENSORS],
            pinged: None,
            heard_us: now_us,
        }
    }

    /// The answer of the sensor that was pinged, once its echo has had the time to come back.
    pub fn answer(&mut self, now_us: u64) -> Option<SonarEcho> {
        let (sensor, ping_us) = self.pinged?;
        let echo_us = self.echoes_us.get(usize::from(sensor)).copied()?;
        let after_us = match echo_us {
            SILENT => return None,
            0 => TIMEOUT_US,
            echo_us => u64::from(echo_us),
        };
        if now_us.saturating_sub(ping_us) < after_us {
            return None;
        }
        self.pinged = None;
        Some(SonarEcho { sensor, echo_us })
    }
}
