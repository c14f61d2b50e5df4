//! Dead reckoning from the encoders, in integers: heading from the difference of the wheels' whole ways, so that it
//! never drifts by rounding, and position by the chord of every ten milliseconds.

use crate::fixed_point::{product, saturated};
use crate::trigonometry::{sine_cosine, ONE};

/// Ticks between two steps of the dead reckoning: at 2.5 rad/s the chord is 26 millionths shorter than the arc.
const STRIDE: u32 = 10;

/// Sizes that turn counts into ways.
#[derive(Clone, Copy, Debug, Default)]
pub struct WheelGeometry {
    /// pm per count.
    count_pm: [i64; 2],
    /// nm per count, 10 bits of fraction.
    count_nm: [i32; 2],
    track_um: i64,
}

impl WheelGeometry {
    pub fn new(count_pm: [i64; 2], track_um: i64) -> Self {
        Self {
            count_pm,
            count_nm: count_pm.map(|pm| saturated(((pm << 10) + 500) / 1000)),
            track_um,
        }
    }
}

/// Pose since boot.
#[derive(Clone, Debug, Default)]
pub struct Odometry {
    last_counts: Option<[i32; 2]>,
    /// Cumulative way of each wheel for control: nm, 10 bits of fraction.
    way_nm: [i64; 2],
    /// Counts that the dead reckoning has not taken yet, and for how many ticks.
    pending: [i64; 2],
    pending_ticks: u32,
    /// Cumulative counts, unwrapped.
    counts: [i64; 2],
    /// Cumulative way of each wheel in pm.
    way_pm: [i64; 2],
    x_pm: i64,
    y_pm: i64,
    heading_urad: i64,
}

impl Odometry {
    /// Take the encoders' counts (left, right; they wrap). Returns the counts since the last call.
    pub fn update(&mut self, counts: [i32; 2], geometry: &WheelGeometry) -> [i32; 2] {
        let [last_left, last_right] = self.last_counts.replace(counts).unwrap_or(counts);
        let [left, right] = counts;
        let steps = [left.wrapping_sub(last_left), right.wrapping_sub(last_right)];
        if steps != [0, 0] {
            let sums = self.pending.iter_mut().zip(&mut self.way_nm);
            for (((pending, way), step), count_nm) in sums.zip(steps).zip(geometry.count_nm) {
                *pending += i64::from(step);
                *way = way.wrapping_add(product(step, count_nm));
            }
        }
        self.pending_ticks += 1;
        if self.pending_ticks >= STRIDE {
            self.integrate(geometry);
        }
        steps
    }

    /// Bring the pose up to the last counts. `update` does it now and then; before the pose is told it must be done.
    pub fn integrate(&mut self, geometry: &WheelGeometry) {
        self.pending_ticks = 0;
        let steps = core::mem::take(&mut self.pending);
        if steps == [0, 0] {
            return;
        }
        let mut chord = 0;
        let sums = self.counts.iter_mut().zip(&mut self.way_pm);
        for (((count, sum), step), count_pm) in sums.zip(steps).zip(geometry.count_pm) {
            let way = step.saturating_mul(count_pm);
            *count = count.wrapping_add(step);
            *sum = sum.wrapping_add(way);
            chord += way / 2;
        }
        let before = self.heading_urad;
        // pm / um = urad.
        let [left_pm, right_pm] = self.way_pm;
        let difference = right_pm.wrapping_sub(left_pm);
        self.heading_urad = difference.checked_div(geometry.track_um).unwrap_or(0);
        let middle = before.wrapping_add(self.heading_urad) / 2;
        let (sine, cosine) = sine_cosine(middle);
        self.x_pm = self.x_pm.wrapping_add(scale(chord, cosine));
        self.y_pm = self.y_pm.wrapping_add(scale(chord, sine));
    }

    /// The next counts are where the wheels stand, however far from the last ones.
    pub fn rebase(&mut self) {
        self.last_counts = None;
    }

    /// Cumulative counts, left and right.
    pub fn counts(&self) -> [i64; 2] {
        self.counts
    }

    /// Way of each wheel in nm, wrapping, up to the last counts.
    pub fn way_nm(&self) -> [i32; 2] {
        self.way_nm.map(|way| (way >> 10) as i32)
    }

    /// x and y in units of 10 um.
    pub fn position_10um(&self) -> [i32; 2] {
        [self.x_pm, self.y_pm].map(|pm| saturated(pm / 10_000_000))
    }

    /// Low 32 bits: wraps every 683 turns, and the companion counts on.
    pub fn heading_urad(&self) -> i32 {
        self.heading_urad as i32
    }
}

/// `length` times a Q30 factor; a way of many metres in one tick (a faulty encoder) is cut off.
fn scale(length_pm: i64, factor: i64) -> i64 {
    let bound = i64::MAX / ONE / 2;
    (length_pm.clamp(-bound, bound) * factor) >> 30
}

#[cfg(test)]
mod tests {
    use super::*;

    fn geometry() -> WheelGeometry {
        WheelGeometry::new([130_899_694, 130_899_694], 200_000)
    }

    /// The same dead reckoning in floating point.
    fn reference(path: &[[i32; 2]]) -> (f64, f64, f64) {
        let (mut x, mut y, mut heading) = (0.0, 0.0, 0.0_f64);
        for pair in path.windows(2) {
            let metres = |i: usize| f64::from(pair[1][i] - pair[0][i]) * 130.899_694e-6;
            let turn = (metres(1) - metres(0)) / 0.2;
            let (chord, middle) = ((metres(0) + metres(1)) / 2.0, heading + turn / 2.0);
            x += chord * middle.cos();
            y += chord * middle.sin();
            heading += turn;
        }
        (x, y, heading)
    }

    #[test]
    fn agrees_with_floating_point_over_a_long_winding_way() {
        let (mut left, mut right) = (0_i32, 0_i32);
        let mut path = vec![[0, 0]];
        for tick in 0..600_000_i32 {
            let turn = (f64::from(tick) / 5_000.0).sin();
            left += i32::from((tick * 7) % 10 < 4) * 4 - i32::from(turn > 0.3);
            right += i32::from((tick * 7) % 10 < 4) * 4 - i32::from(turn < -0.35);
            path.push([left, right]);
        }
        let mut odometry = Odometry::default();
        for counts in &path {
            odometry.update(*counts, &geometry());
        }
        odometry.integrate(&geometry());
        let (x, y, heading) = reference(&path);
        let [x_int, y_int] = odometry.position_10um();
        assert!((f64::from(odometry.heading_urad()) / 1e6 - heading).abs() < 3e-6);
        // The reference takes a chord every millisecond, and the way is long.
        let way = path.len() as f64 * 0.2e-3;
        assert!(
            (f64::from(x_int) / 1e5 - x).abs() < way * 5e-6,
            "{x_int} {x}"
        );
        assert!(
            (f64::from(y_int) / 1e5 - y).abs() < way * 5e-6,
            "{y_int} {y}"
        );
    }

    #[test]
    fn counts_may_wrap() {
        let mut odometry = Odometry::default();
        odometry.update([i32::MAX - 5, i32::MIN + 5], &geometry());
        odometry.update([i32::MIN + 4, i32::MIN + 15], &geometry());
        assert_eq!(odometry.way_nm(), [1_308_996; 2]);
        odometry.integrate(&geometry());
        assert_eq!(odometry.counts(), [10, 10]);
        assert_eq!(odometry.heading_urad(), 0);
        assert_eq!(odometry.position_10um(), [130, 0]);
    }

    #[test]
    fn an_absurd_jump_does_not_panic() {
        let mut odometry = Odometry::default();
        for counts in [[0, 0], [i32::MAX, i32::MIN], [-1, 1], [i32::MIN, i32::MAX]] {
            odometry.update(counts, &geometry());
            odometry.integrate(&geometry());
        }
    }
}
