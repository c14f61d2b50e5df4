//! Three ultrasonic sensors in turn, so that none hears another's ping.
//!
//! One slot of about 33 ms each: sound from 4 m is back after 23 ms, and what comes later has died away by the next
//! ping. An echo that is not from the sensor whose turn it is counts for nothing. A median of three removes single
//! echoes that other things cause.

/// Number of sensors: 0 left, 1 centre, 2 right.
pub const SENSORS: usize = 3;
/// Range that stands for "no echo".
pub const NO_ECHO_MM: u16 = u16::MAX;
/// Pings without any answer from the driver, not even a timeout, after which a sensor counts as dead.
const DEAD_AFTER: u8 = 3;
/// The sensor rings for this long after its own ping: 2 cm there and back.
const SHORTEST_ECHO_US: u32 = 116;
/// 4 m there and back and some reserve.
const LONGEST_ECHO_US: u32 = 25_000;
/// The first ping waits until everything has settled after power-on.
const FIRST_PING_US: u64 = 50_000;

/// What the board's driver reports: the length of the echo, 0 for a timeout.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SonarEcho {
    pub sensor: u8,
    pub echo_us: u32,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SonarStatus {
    Ok,
    NoEcho,
    Dead,
}

/// One finished ranging.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ranging {
    pub sensor: u8,
    pub status: SonarStatus,
    /// Median of the last three, `NO_ECHO_MM` when there was none.
    pub range_mm: u16,
    pub ping_us: u64,
}

#[derive(Clone, Copy, Debug)]
struct Sensor {
    last: [u16; 3],
    unanswered: u8,
}

impl Default for Sensor {
    fn default() -> Self {
        Self {
            last: [NO_ECHO_MM; 3],
            unanswered: 0,
        }
    }
}

impl Sensor {
    fn push(&mut self, range_mm: u16) {
        let [a, b, _] = self.last;
        self.last = [range_mm, a, b];
    }

    fn median_mm(&self) -> u16 {
        let [a, b, c] = self.last;
        a.max(b).min(c).max(a.min(b))
    }
}

/// The turn of the sensors and what they last said.
#[derive(Clone, Debug, Default)]
pub struct Sonar {
    sensors: [Sensor; SENSORS],
    current: u8,
    /// When the current sensor pinged; None before the very first ping.
    ping_us: Option<u64>,
    answered: bool,
}

impl Sonar {
    /// One tick. Returns the sensor to trigger now, and the ranging that was finished.
    pub fn tick(
        &mut self,
        now_us: u64,
        echo: Option<SonarEcho>,
        slot_us: u64,
        sound_mm_s: i64,
    ) -> (Option<u8>, Option<Ranging>) {
        let Some(ping_us) = self.ping_us else {
            if now_us < FIRST_PING_US {
                return (None, None);
            }
            return (Some(self.ping(0, now_us)), None);
        };
        let mut finished = None;
        if let Some(echo) = echo.filter(|echo| self.expects(echo)) {
            self.answered = true;
            finished = self.conclude(Some(range_mm(echo.echo_us, sound_mm_s)), ping_us);
        }
        if now_us.saturating_sub(ping_us) < slot_us {
            return (None, finished);
        }
        if !self.answered {
            finished = self.conclude(None, ping_us);
        }
        let next = if self.current >= 2 {
            0
        } else {
            self.current + 1
        };
        (Some(self.ping(next, now_us)), finished)
    }

    /// Median range of a sensor, `NO_ECHO_MM` when nothing is there.
    pub fn range_mm(&self, sensor: usize) -> u16 {
        self.sensors
            .get(sensor)
            .map_or(NO_ECHO_MM, Sensor::median_mm)
    }

    /// The nearest of all.
    pub fn nearest_mm(&self) -> u16 {
        self.sensors.iter().fold(NO_ECHO_MM, |nearest, sensor| {
            nearest.min(sensor.median_mm())
        })
    }

    /// A bit for each sensor that no longer answers.
    pub fn dead(&self) -> u8 {
        (0..).zip(&self.sensors).fold(0, |bits, (at, sensor)| {
            bits | u8::from(sensor.unanswered >= DEAD_AFTER) << at
        })
    }

    fn ping(&mut self, sensor: u8, now_us: u64) -> u8 {
        self.current = sensor;
        self.ping_us = Some(now_us);
        self.answered = false;
        sensor
    }

    /// Cross-talk guard: only the sensor whose turn it is, once, and not its own ringing.
    fn expects(&self, echo: &SonarEcho) -> bool {
        let ringing = echo.echo_us != 0 && echo.echo_us < SHORTEST_ECHO_US;
        !self.answered && echo.sensor == self.current && !ringing
    }

    /// File the result of the current slot; None as result means that the driver said nothing at all.
    fn conclude(&mut self, range_mm: Option<u16>, ping_us: u64) -> Option<Ranging> {
        let sensor = self.sensors.get_mut(usize::from(self.current))?;
        match range_mm {
            Some(range_mm) => {
                sensor.unanswered = 0;
                sensor.push(range_mm);
            }
            None => {
                sensor.unanswered = sensor.unanswered.saturating_add(1);
                sensor.push(NO_ECHO_MM);
            }
        }
        let median = sensor.median_mm();
        let status = match median {
            _ if sensor.unanswered >= DEAD_AFTER => SonarStatus::Dead,
            NO_ECHO_MM => SonarStatus::NoEcho,
            _ => SonarStatus::Ok,
        };
        Some(Ranging {
            sensor: self.current,
            status,
            range_mm: median,
            ping_us,
        })
    }
}

/// Half the way of the sound; `NO_ECHO_MM` for a timeout.
fn range_mm(echo_us: u32, sound_mm_s: i64) -> u16 {
    if echo_us == 0 || echo_us > LONGEST_ECHO_US {
        return NO_ECHO_MM;
    }
    let range = i64::from(echo_us) * sound_mm_s / 2_000_000;
    range.clamp(0, i64::from(NO_ECHO_MM) - 1) as u16
}

#[cfg(test)]
mod tests {
    use super::*;

    const SLOT_US: u64 = 33_000;
    const SOUND: i64 = 343_000;

    /// Run for some milliseconds; `world` answers each ping with an echo and a delay in ms.
    fn run(
        sonar: &mut Sonar,
        milliseconds: u64,
        world: impl Fn(u8, u64) -> Option<(u8, u32)>,
    ) -> (Vec<(u64, u8)>, Vec<Ranging>) {
        let (mut pings, mut results) = (vec![], vec![]);
        let mut pending: Option<(u64, SonarEcho)> = None;
        for ms in 0..milliseconds {
            let due = pending.filter(|(at, _)| *at == ms).map(|(_, echo)| echo);
            let (trigger, ranging) = sonar.tick(ms * 1000, due, SLOT_US, SOUND);
            if let Some(sensor) = trigger {
                pings.push((ms, sensor));
                pending = world(sensor, pings.len() as u64).map(|(sensor, echo_us)| {
                    (
                        ms + 5 + u64::from(echo_us) / 1000,
                        SonarEcho { sensor, echo_us },
                    )
                });
            }
            results.extend(ranging);
        }
        (pings, results)
    }

    #[test]
    fn the_sensors_ping_in_turn_thirty_three_milliseconds_apart() {
        let (pings, _) = run(&mut Sonar::default(), 300, |sensor, _| {
            Some((sensor, 5_831))
        });
        let sensors: Vec<u8> = pings.iter().map(|(_, sensor)| *sensor).collect();
        assert_eq!(&sensors[..6], &[0, 1, 2, 0, 1, 2]);
        assert!(pings.windows(2).all(|pair| pair[1].0 - pair[0].0 == 33));
    }

    #[test]
    fn an_echo_of_5831_microseconds_is_a_metre() {
        let mut sonar = Sonar::default();
        run(&mut sonar, 400, |sensor, _| Some((sensor, 5_831)));
        assert_eq!(sonar.range_mm(1), 1_000);
    }

    #[test]
    fn one_wrong_echo_is_removed_by_the_median_and_two_are_not() {
        let mut sonar = Sonar::default();
        let (_, results) = run(&mut sonar, 1_200, |sensor, count| {
            Some((sensor, if count == 16 { 600 } else { 5_831 }))
        });
        assert!(results[6..].iter().all(|r| r.range_mm == 1_000));
        let mut sonar = Sonar::default();
        run(&mut sonar, 1_200, |sensor, count| {
            Some((sensor, if count > 25 { 600 } else { 5_831 }))
        });
        assert_eq!(sonar.range_mm(0), 102);
    }

    #[test]
    fn an_echo_heard_by_another_sensor_counts_for_nothing() {
        let mut sonar = Sonar::default();
        run(&mut sonar, 300, |sensor, _| Some(((sensor + 1) % 3, 600)));
        assert!((0..3).all(|sensor| sonar.range_mm(sensor) == NO_ECHO_MM));
    }

    #[test]
    fn a_timeout_is_no_echo_and_a_driver_that_says_nothing_is_dead() {
        let mut sonar = Sonar::default();
        let (_, results) = run(&mut sonar, 500, |sensor, _| Some((sensor, 0)));
        assert!(results.iter().all(|r| r.status == SonarStatus::NoEcho));
        assert_eq!(sonar.dead(), 0);
        let (_, results) = run(&mut Sonar::default(), 1_200, |sensor, _| {
            (sensor != 2).then_some((sensor, 5_831))
        });
        let last = results.iter().rev().find(|r| r.sensor == 2).unwrap();
        assert_eq!(last.status, SonarStatus::Dead);
        assert_eq!(last.range_mm, NO_ECHO_MM);
    }
}
