//! What quantised segments really do, integrated from the integers that are sent: states, extremes, points on the way.

/// Parts that a segment which turns is cut into; two-point Gauss quadrature in each leaves less than 0.1 µm.
pub const PARTS: usize = 8;

/// Of one segment (SI): duration, jerks of both axes, whether it ends at rest.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Seconds.
    pub time: f64,
    /// Jerk of travel and of heading.
    pub jerk: [f64; 2],
    /// Speeds and accelerations are exactly zero at its end.
    pub rest: bool,
}

impl Segment {
    /// From µs, millionths of the SI unit twice, and 1 where it ends at rest.
    pub fn of(row: [i64; 4]) -> Self {
        Self {
            time: row[0] as f64 * 1e-6,
            jerk: [row[1] as f64 * 1e-6, row[2] as f64 * 1e-6],
            rest: row[3] != 0,
        }
    }
}

/// Speed and acceleration of one axis at the beginning of a segment.
#[derive(Clone, Copy, Debug, Default)]
struct Axis {
    speed: f64,
    acceleration: f64,
}

impl Axis {
    fn way(&self, t: f64, jerk: f64) -> f64 {
        t * (self.speed + t * (self.acceleration / 2.0 + t * jerk / 6.0))
    }

    fn after(&self, t: f64, jerk: f64) -> Self {
        Self {
            speed: self.speed + t * (self.acceleration + t * jerk / 2.0),
            acceleration: self.acceleration + t * jerk,
        }
    }

    /// Largest magnitudes of speed, acceleration and jerk: at the ends, or where the speed has its peak.
    fn most(&self, t: f64, jerk: f64) -> [f64; 3] {
        let end = self.after(t, jerk);
        let mut speed = self.speed.abs().max(end.speed.abs());
        if jerk != 0.0 {
            let peak = (-self.acceleration / jerk).clamp(0.0, t);
            speed = speed.max(self.after(peak, jerk).speed.abs());
        }
        let acceleration = self.acceleration.abs().max(end.acceleration.abs());
        [speed, acceleration, jerk.abs()]
    }
}

/// Both axes from rest, segment by segment.
#[derive(Default)]
struct Motion {
    axes: [Axis; 2],
}

impl Motion {
    fn step(&mut self, segment: &Segment) {
        for (axis, jerk) in self.axes.iter_mut().zip(segment.jerk) {
            *axis = if segment.rest {
                Axis::default()
            } else {
                axis.after(segment.time, jerk)
            };
        }
    }

    /// Speed, acceleration and jerk of travel, the same of heading, lateral acceleration.
    fn most(&self, segment: &Segment) -> [f64; 7] {
        let [travel, heading] =
            [0, 1].map(|axis| self.axes[axis].most(segment.time, segment.jerk[axis]));
        // Both at their largest in the same segment: never less than the product at any time.
        let lateral = travel[0] * heading[0];
        let [[a, b, c], [d, e, f]] = [travel, heading];
        [a, b, c, d, e, f, lateral]
    }
}

/// Which of the magnitudes are speeds; the others are accelerations and jerks.
const SPEEDS: [bool; 7] = [true, false, false, true, false, false, true];

/// Of each segment, from speed and acceleration of both axes: the largest share of what is allowed of a speed, and of an
/// acceleration or jerk. `allowed`: in the order of `Way::most`.
pub fn shares(
    state: [[f64; 2]; 2],
    segments: impl Iterator<Item = Segment>,
    allowed: [f64; 7],
) -> Vec<[f64; 2]> {
    let mut motion = Motion {
        axes: state.map(|[speed, acceleration]| Axis {
            speed,
            acceleration,
        }),
    };
    let each = |segment: Segment| {
        let mut found = [0.0, 0.0_f64];
        let most = motion.most(&segment);
        for ((most, allowed), speed) in most.iter().zip(allowed).zip(SPEEDS) {
            let kind = usize::from(!speed);
            found[kind] = f64::max(found[kind], most / allowed);
        }
        motion.step(&segment);
        found
    };
    segments.map(each).collect()
}

/// Where the rover goes.
#[derive(Default)]
pub struct Way {
    /// Pose at the beginning of each segment and at the end of the last.
    pub poses: Vec<[f64; 3]>,
    /// Where it passes.
    pub points: Vec<[f64; 2]>,
    /// The segment that each point is in.
    pub segments: Vec<i64>,
    /// By how much the way leaves the chord behind each point but the last at most, metres.
    pub bulges: Vec<f64>,
    /// Largest magnitudes over all segments: speed, acceleration, jerk, turn rate, turn acceleration, turn jerk, lateral
    /// acceleration.
    pub most: [f64; 7],
}

/// The way of segments from rest at a pose.
pub fn way(segments: &[Segment], pose: [f64; 3]) -> Way {
    let mut found = Way::default();
    let mut motion = Motion::default();
    let [mut x, mut y, mut heading] = pose;
    for (number, segment) in segments.iter().enumerate() {
        let (t, [jerk, turn_jerk]) = (segment.time, segment.jerk);
        let [travel, turning] = motion.axes;
        let most = motion.most(segment);
        for (all, here) in found.most.iter_mut().zip(most) {
            *all = all.max(here);
        }
        let (distance, turned) = (travel.way(t, jerk), turning.way(t, turn_jerk));
        found.poses.push([x, y, heading]);
        let mut add = |x: f64, y: f64, bulge: f64| {
            found.points.push([x, y]);
            found.segments.push(number as i64);
            found.bulges.push(bulge);
        };
        if distance != 0.0 && turned != 0.0 {
            // A chord is left by at most an eighth of its time squared times the acceleration across it.
            let across = most[6] + most[1] * turned.abs().min(1.0);
            let part = t / PARTS as f64;
            let bulge = across * part * part / 8.0;
            let off = (1.0_f64 / 3.0).sqrt() / 2.0;
            for number in 0..PARTS {
                add(x, y, bulge);
                for node in [0.5 - off, 0.5 + off] {
                    let r = (number as f64 + node) * part;
                    let way = 0.5 * part * travel.after(r, jerk).speed;
                    let (sine, cosine) = (heading + turning.way(r, turn_jerk)).sin_cos();
                    x += way * cosine;
                    y += way * sine;
                }
            }
        } else {
            add(x, y, 0.0);
            x += distance * heading.cos();
            y += distance * heading.sin();
        }
        heading += turned;
        motion.step(segment);
    }
    found.poses.push([x, y, heading]);
    found.points.push([x, y]);
    found.segments.push(segments.len() as i64);
    found
}

/// A polyline, how far each of its legs may be off what it stands for, and the legs that each piece runs along.
pub struct Legs<'a> {
    /// The polyline.
    pub points: &'a [[f64; 2]],
    /// Metres, of each leg.
    pub error: &'a [f64],
    /// Number of the first segment of each piece.
    pub starts: &'a [i64],
    /// First leg of each piece, and the one behind its last.
    pub range: &'a [[i64; 2]],
}

/// Metres, no less than the distance to its legs of the way behind each point of the way but the last.
///
/// To a single leg the distance is convex along a chord: at most what it is at the ends.
pub fn beside(legs: &Legs, points: &[[f64; 2]], segments: &[i64], bulges: &[f64]) -> Vec<f64> {
    let mut piece = 0;
    let mut each = |number: usize| {
        while piece + 1 < legs.starts.len() && legs.starts[piece + 1] <= segments[number] {
            piece += 1;
        }
        let [first, last] = legs.range[piece].map(|leg| leg as usize);
        let near = (first..last).map(|leg| {
            let ends = [legs.points[leg], legs.points[leg + 1]];
            let far = |point| distance(point, ends);
            legs.error[leg] + far(points[number]).max(far(points[number + 1]))
        });
        near.fold(f64::INFINITY, f64::min) + bulges[number]
    };
    (0..bulges.len()).map(&mut each).collect()
}

fn distance(point: [f64; 2], [a, b]: [[f64; 2]; 2]) -> f64 {
    let (along, off) = (
        [b[0] - a[0], b[1] - a[1]],
        [point[0] - a[0], point[1] - a[1]],
    );
    let share = (off[0] * along[0] + off[1] * along[1]) / (along[0].powi(2) + along[1].powi(2));
    let share = share.clamp(0.0, 1.0);
    (off[0] - share * along[0]).hypot(off[1] - share * along[1])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_turn_of_constant_rate_at_constant_speed_is_an_arc() {
        let rows = [[1_000_000, 200_000, 400_000, 0], [3_000_000, 0, 0, 0]];
        let mut segments: Vec<Segment> = rows.map(Segment::of).to_vec();
        // The accelerations that the first has left are taken to nothing.
        segments.insert(1, Segment::of([1_000_000, -200_000, -400_000, 0]));
        let found = way(&segments, [0.0; 3]);
        let [x, y, heading] = found.poses[2];
        let radius = 0.2 / 0.4;
        let centre = [x - radius * heading.sin(), y + radius * heading.cos()];
        for (point, segment) in found.points.iter().zip(&found.segments) {
            if *segment >= 2 {
                let far = (point[0] - centre[0]).hypot(point[1] - centre[1]);
                assert!((far - radius).abs() < 1e-7, "{far}");
            }
        }
        assert!((found.most[0] - 0.2).abs() < 1e-12 && (found.most[6] - 0.08).abs() < 1e-12);
        let share = shares([[0.0; 2]; 2], segments.iter().copied(), [0.4; 7]);
        assert!((share[2][0] - 1.0).abs() < 1e-12 && share[2][1] < 1e-12);
    }

    #[test]
    fn beside_a_leg_is_as_far_as_the_farther_end() {
        let legs = Legs {
            points: &[[0.0, 0.0], [1.0, 0.0]],
            error: &[0.01],
            starts: &[0],
            range: &[[0, 1]],
        };
        let found = beside(&legs, &[[0.2, 0.1], [0.8, -0.3]], &[0, 1], &[0.002]);
        assert!((found[0] - 0.312).abs() < 1e-12);
    }
}
