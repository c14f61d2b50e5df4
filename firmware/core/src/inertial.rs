//! The inertial sensor: how far the rover has turned, and which way is up.
//!
//! The gyroscope's bias is measured while the rover rests and follows the temperature in between. Turns about the vertical
//! add up to a heading. Up is a vector that the gyroscope turns and that what is felt draws slowly towards itself, less
//! the acceleration that the wheels are known to make. In the sensor's own steps and without trigonometry, 250 times a
//! second.
//!
//! The sensor is optional. One that falls silent or repeats itself is dropped and reported; nothing else depends on it.

use crate::fixed_point::{product, saturated, upper};
use rover_protocol::messages::gravity_status;

/// What the sensor has in its registers, along base_link's axes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct InertialSample {
    /// About x, y, z: 8.75 mdeg/s a step.
    pub gyro: [i16; 3],
    /// Along x, y, z: 0.061 mg a step.
    pub acceleration: [i16; 3],
    /// 1/256 K a step, from 25 degrees Celsius.
    pub temperature: i16,
}

/// Why it is not believed any more.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Loss {
    Silent = 1,
    Frozen = 2,
}

/// What the wheels do at a sample.
#[derive(Clone, Copy, Debug, Default)]
pub struct WheelMotion {
    /// Neither commanded to move nor turning.
    pub resting: bool,
    /// um/s and um/s^2, forwards.
    pub velocity: i32,
    pub acceleration: i32,
}

/// Bits of fraction of a rate's bias.
const BIAS_BITS: u32 = 8;
/// One step of rate with `BIAS_BITS` for a microsecond, in 2^-62 rad.
const ANGLE_PER_STEP: i64 = 2_751_092;
/// The same step in 2^-32 mrad/s and without fraction: 0.1527 mrad/s.
const MRAD_PER_STEP: i32 = 655_911_553;
/// Bits of fraction of the vector that points up.
const UP_BITS: u32 = 14;
/// 9.80665 m/s^2 in steps.
const GRAVITY: i32 = 16_393;
/// Steps to mm/s^2 by `upper`: 0.5982.
const MM_S2_PER_STEP: i32 = 2_569_274_000_u32 as i32;
/// um/s^2 to steps by `upper`: 1 / 598.2.
const STEPS_PER_UM_S2: i32 = 7_179_747;
/// um/s times steps of rate to steps of acceleration, Q32.
const TURNING: i64 = 1_096;
/// What is felt draws the vector by one part in this many at each sample: a second.
const DRAW_BITS: u32 = 8;
/// What is felt counts up to four times g.
const FELT_LIMIT: i32 = 65_535;
/// Something else than gravity is felt beyond this difference of the squares: a tenth of g.
const UNEVEN: i64 = (GRAVITY as i64 * GRAVITY as i64) / 5;
/// Samples apart by more than this leave turns out.
const LONGEST_GAP_US: u64 = 20_000;
/// No sample for so long: the sensor is silent.
const SILENT_US: u64 = 50_000;
/// Noise changes every sample. So many alike: the sensor repeats itself.
const FROZEN_SAMPLES: u16 = 25;
/// Samples of a rest that give a bias: half a second. None that come before the motors' last movement has died away.
const REST_SAMPLES: i32 = 125;
const SETTLE_SAMPLES: i32 = 50;
/// Rates of a rest differ by less than this, or somebody moves the rover: 1.2 deg/s.
const STILL_STEPS: i32 = 140;
/// A bias beyond this is a rotation and not a bias: 10 deg/s.
const BIAS_STEPS: i32 = 1_143;
/// Rests whose temperatures differ by so much tell how the bias follows it: 2 K.
const WARMER: i32 = 512;
/// The datasheet's 0.01 deg/s/K, five times.
const SLOPE_STEPS: i32 = 6 << BIAS_BITS;

#[derive(Clone, Debug, Default)]
struct Rest {
    samples: i32,
    sums: [i32; 3],
    least: [i16; 3],
    most: [i16; 3],
}

/// The rest at which the bias was last measured.
#[derive(Clone, Copy, Debug)]
struct Calibration {
    /// Steps with `BIAS_BITS`.
    bias: [i32; 3],
    temperature: i32,
}

#[derive(Clone, Debug, Default)]
pub struct Inertial {
    last: Option<(u64, InertialSample)>,
    alike: u16,
    rest: Rest,
    calibration: Option<Calibration>,
    /// Change of the bias over a kelvin, steps with `BIAS_BITS`.
    slope: [i32; 3],
    loss: Option<Loss>,
    /// Q32 radians.
    heading: i64,
    /// Rate about the vertical at the last sample, steps with `BIAS_BITS`.
    rate: i32,
    /// Steps with `UP_BITS`.
    up: Option<[i32; 3]>,
    /// Steps.
    shake: i32,
}

impl Inertial {
    /// One tick, with the sample that has come since the last.
    pub fn tick(&mut self, now_us: u64, sample: Option<InertialSample>, wheels: &WheelMotion) {
        let Some((then_us, before)) = self.last else {
            self.last = sample.map(|sample| (now_us, sample));
            return;
        };
        let Some(sample) = sample else {
            if now_us.saturating_sub(then_us) > SILENT_US {
                self.lose(Loss::Silent);
            }
            return;
        };
        self.last = Some((now_us, sample));
        self.alike = match sample == before {
            true => self.alike.saturating_add(1),
            false => 0,
        };
        if self.alike >= FROZEN_SAMPLES {
            self.lose(Loss::Frozen);
        }
        if self.alike > 0 {
            return;
        }
        self.loss = None;
        let elapsed_us = now_us.saturating_sub(then_us);
        if elapsed_us <= LONGEST_GAP_US {
            self.turn(&sample, elapsed_us as i64);
        }
        self.draw_up(&sample, wheels);
        self.rest(&sample, wheels.resting);
    }

    /// Why it is not believed; None while it is, and when there never was one.
    pub fn loss(&self) -> Option<Loss> {
        self.loss
    }

    /// As in the message; None when there never was a sensor.
    pub fn status(&self) -> Option<u8> {
        self.up?;
        Some(match (self.loss, self.calibration) {
            (Some(_), _) => gravity_status::LOST,
            (None, None) => gravity_status::SETTLING,
            (None, Some(_)) => gravity_status::GOOD,
        })
    }

    /// Whether its turns count: it speaks, and its bias is known.
    pub fn is_good(&self) -> bool {
        self.status() == Some(gravity_status::GOOD)
    }

    /// Turned since the start, urad, wrapping: as the last rate has it at `now_us`.
    pub fn heading_urad(&self, now_us: u64) -> i32 {
        let since_us = self.last.map_or(0, |(at, _)| now_us.saturating_sub(at));
        let ahead = angle(self.rate, since_us.min(LONGEST_GAP_US) as i64);
        let heading = self.heading.wrapping_add(i64::from(ahead));
        let (turns, rest) = (heading >> 32, heading & 0xffff_ffff);
        let urad = turns
            .wrapping_mul(1_000_000)
            .wrapping_add((rest * 1_000_000) >> 32);
        urad as i32
    }

    /// Rate about the vertical, mrad/s.
    pub fn rate_mrad_s(&self) -> i16 {
        let rate = upper(self.rate, MRAD_PER_STEP) >> BIAS_BITS;
        rate.clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16
    }

    /// Up on base_link, mm/s^2.
    pub fn up_mm_s2(&self) -> [i16; 3] {
        let up = self.up.unwrap_or_default();
        up.map(|steps| {
            mm_s2(steps >> UP_BITS).clamp(i32::from(i16::MIN), i32::from(i16::MAX)) as i16
        })
    }

    /// Greatest difference of what was felt from gravity since the last call, 0.1 m/s^2.
    pub fn take_shake(&mut self) -> u8 {
        let shake = mm_s2(core::mem::take(&mut self.shake)) / 100;
        shake.clamp(0, 255) as u8
    }

    fn lose(&mut self, loss: Loss) {
        self.loss = Some(loss);
        self.rest = Rest::default();
        self.rate = 0;
    }

    /// The bias at a temperature, steps with `BIAS_BITS`.
    fn bias(&self, temperature: i16) -> [i32; 3] {
        let Some(known) = self.calibration else {
            return [0; 3];
        };
        let warmer = i32::from(temperature) - known.temperature;
        let mut bias = known.bias;
        for (bias, slope) in bias.iter_mut().zip(self.slope) {
            // 256 steps are a kelvin.
            *bias = bias.saturating_add(slope.saturating_mul(warmer) >> 8);
        }
        bias
    }

    fn turn(&mut self, sample: &InertialSample, elapsed_us: i64) {
        let mut rates = [0; 3];
        let bias = self.bias(sample.temperature);
        for ((rate, raw), bias) in rates.iter_mut().zip(sample.gyro).zip(bias) {
            *rate = (i32::from(raw) << BIAS_BITS).saturating_sub(bias);
        }
        let [x, y, z] = rates.map(|rate| angle(rate, elapsed_us));
        let Some([ux, uy, uz]) = self.up else {
            return;
        };
        // The part of the turn about up, which is near z: on a slope the body's z does not tell the heading.
        let about_up = |x: i32, y: i32, z: i32| {
            let part = |turn: i32, up: i32| product(turn, up >> UP_BITS);
            let sum = part(x, ux) + part(y, uy) + part(z, uz);
            // By 2^28 / GRAVITY, so that no 64 bits are divided.
            saturated((sum >> 14).saturating_mul((1 << 28) / i64::from(GRAVITY)) >> 14)
        };
        self.heading = self.heading.wrapping_add(i64::from(about_up(x, y, z)));
        let [rate_x, rate_y, rate_z] = rates;
        self.rate = about_up(rate_x, rate_y, rate_z);
        // u' = u x turn: what stands still in the world turns back on the rover.
        let cross = |a: i32, b: i32, c: i32, d: i32| upper(a, b).saturating_sub(upper(c, d));
        self.up = Some([
            ux.saturating_add(cross(uy, z, uz, y)),
            uy.saturating_add(cross(uz, x, ux, z)),
            uz.saturating_add(cross(ux, y, uy, x)),
        ]);
    }

    fn draw_up(&mut self, sample: &InertialSample, wheels: &WheelMotion) {
        let [x, y, z] = sample.acceleration.map(i32::from);
        let turning = i64::from(wheels.velocity) * i64::from(self.rate >> BIAS_BITS);
        let sideways = saturated((turning * TURNING) >> 32);
        let ahead = upper(wheels.acceleration, STEPS_PER_UM_S2);
        // No acceleration that wheels can make is near this bound; it keeps the arithmetic within 32 bits.
        let felt = [x.saturating_sub(ahead), y.saturating_sub(sideways), z]
            .map(|steps| steps.clamp(-FELT_LIMIT, FELT_LIMIT));
        let Some(up) = self.up else {
            self.up = Some(felt.map(|steps| steps << UP_BITS));
            return;
        };
        let off = felt.iter().zip(up).fold(0, |most, (felt, up)| {
            (felt - (up >> UP_BITS)).abs().max(most)
        });
        self.shake = self.shake.max(off);
        let square: i64 = felt.iter().map(|steps| product(*steps, *steps)).sum();
        let gravity = i64::from(GRAVITY) * i64::from(GRAVITY);
        if (square - gravity).abs() > UNEVEN {
            return;
        }
        let mut drawn = up;
        for (up, felt) in drawn.iter_mut().zip(felt) {
            *up = up.saturating_add(((felt << UP_BITS).saturating_sub(*up)) >> DRAW_BITS);
        }
        self.up = Some(drawn);
    }

    /// Biases from a second of rest: its mean, when nothing has turned meanwhile.
    fn rest(&mut self, sample: &InertialSample, resting: bool) {
        if !resting {
            self.rest = Rest::default();
            return;
        }
        let rest = &mut self.rest;
        rest.samples += 1;
        if rest.samples <= SETTLE_SAMPLES {
            rest.least = sample.gyro;
            rest.most = sample.gyro;
            return;
        }
        let mut still = true;
        for (((sum, least), most), rate) in rest
            .sums
            .iter_mut()
            .zip(rest.least.iter_mut())
            .zip(rest.most.iter_mut())
            .zip(sample.gyro)
        {
            *sum += i32::from(rate);
            *least = rate.min(*least);
            *most = rate.max(*most);
            still &= i32::from(*most) - i32::from(*least) < STILL_STEPS;
        }
        if !still {
            *rest = Rest::default();
        } else if rest.samples >= SETTLE_SAMPLES + REST_SAMPLES {
            let bias = rest.sums.map(|sum| (sum << BIAS_BITS) / REST_SAMPLES);
            *rest = Rest::default();
            self.calibrate(bias, i32::from(sample.temperature));
        }
    }

    fn calibrate(&mut self, bias: [i32; 3], temperature: i32) {
        if bias.iter().any(|bias| bias.abs() > BIAS_STEPS << BIAS_BITS) {
            return;
        }
        if let Some(known) = self.calibration {
            let warmer = temperature - known.temperature;
            if warmer.abs() >= WARMER {
                for ((slope, new), old) in self.slope.iter_mut().zip(bias).zip(known.bias) {
                    let seen = ((new - old) << 8).checked_div(warmer).unwrap_or(0);
                    *slope = seen.clamp(-SLOPE_STEPS, SLOPE_STEPS);
                }
            }
        }
        self.calibration = Some(Calibration { bias, temperature });
    }
}

/// Of a rate (steps with `BIAS_BITS`) held for some time: Q32 radians.
fn angle(rate: i32, elapsed_us: i64) -> i32 {
    saturated(((i64::from(rate) * elapsed_us) * ANGLE_PER_STEP) >> 30)
}

fn mm_s2(steps: i32) -> i32 {
    // The factor is above a half, which 32 bits with sign do not hold.
    upper(steps, MM_S2_PER_STEP).saturating_add(steps)
}

#[cfg(test)]
#[path = "inertial_tests.rs"]
mod tests;
