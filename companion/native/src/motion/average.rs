//! Sums over the vertices in a window that slides along a polyline: what average.py in Python defines.

/// Values, their first four derivatives, and the values less the polyline, at one place, x and y each.
pub type Averaged = [[f64; 2]; 6];

/// Polylines one after the other on one axis of arc length.
pub struct Axis<'a> {
    /// Of all points, ascending.
    pub u: &'a [f64],
    /// The points.
    pub points: &'a [[f64; 2]],
    /// The leg that leads on from each point.
    pub legs: &'a [i64],
    /// Where the direction changes, ascending.
    pub at: &'a [f64],
    /// By how much.
    pub change: &'a [[f64; 2]],
}

/// The average at one place, with a window whose size changes by `slope` along the path.
pub fn averaged(axis: &Axis, u: f64, window: f64, slope: f64) -> Averaged {
    let count = axis.u.len();
    let here = axis
        .u
        .partition_point(|each| *each <= u)
        .clamp(1, count)
        .saturating_sub(1);
    let leg = axis.legs[here] as usize;
    let span = axis.u[leg + 1] - axis.u[leg];
    let way = (u - axis.u[leg]).clamp(0.0, span);
    let (a, b) = (axis.points[leg], axis.points[leg + 1]);
    let direction = [(b[0] - a[0]) / span, (b[1] - a[1]) / span];
    let mut found = [[0.0; 2]; 6];
    found[0] = [a[0] + way * direction[0], a[1] + way * direction[1]];
    found[1] = direction;
    let first = axis.at.partition_point(|each| *each <= u - window);
    let change = axis.at[first..].iter().zip(&axis.change[first..]);
    for (at, change) in change.take_while(|(at, _)| **at < u + window) {
        let z = (u - at) / window;
        let [half, value, rate, bend] = kernel(z);
        let q = 1.0 - z * slope;
        let step = if z >= 0.0 { 1.0 } else { 0.0 };
        let off = offset(z);
        let weights = [
            window * off,
            half - step + slope * (off + z * step - z * half),
            value * q * q / window,
            (rate * q * q * q - 3.0 * slope * value * q * q) / (window * window),
            bend / (window * window * window),
            window * off,
        ];
        for (sum, weight) in found.iter_mut().zip(weights) {
            sum[0] += change[0] * weight;
            sum[1] += change[1] * weight;
        }
    }
    found
}

/// How far it is from the polyline, and the magnitudes of its curvature and of the first two derivatives of that.
pub fn bending([_, d1, d2, d3, d4, off]: &Averaged) -> [f64; 4] {
    let cross = |a: &[f64; 2], b: &[f64; 2]| a[0] * b[1] - a[1] * b[0];
    let square = (d1[0] * d1[0] + d1[1] * d1[1]).max(1e-6);
    let speed = square.sqrt();
    let curvature = cross(d1, d2) / (square * speed);
    let along = (d1[0] * d2[0] + d1[1] * d2[1]) / square;
    let change = cross(d1, d3) / (square * speed) - 3.0 * curvature * along;
    let third = cross(d1, d4).abs() / (square * square * speed);
    [
        off[0].hypot(off[1]),
        curvature.abs(),
        (change / speed).abs(),
        third,
    ]
}

/// d(z): zero from |z| = 1 on.
fn offset(z: f64) -> f64 {
    let t = z.abs().min(1.0);
    if t <= 0.5 {
        0.875 / 6.0 - t * (0.5 - t * (0.5 - t * t / 6.0))
    } else {
        (1.0 - t).powi(4) / 6.0
    }
}

/// The integral of K up to z, K and its first two derivatives.
fn kernel(z: f64) -> [f64; 4] {
    let t = z.abs().min(1.0);
    let sign = if z == 0.0 { 0.0 } else { z.signum() };
    if t <= 0.5 {
        let half = t * (1.0 - t * t / 1.5);
        return [0.5 + sign * half, 1.0 - 2.0 * t * t, -4.0 * sign * t, -4.0];
    }
    let left = 1.0 - t;
    let half = 0.5 - left.powi(3) / 1.5;
    [
        0.5 + sign * half,
        2.0 * left * left,
        -4.0 * sign * left,
        4.0,
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_derivatives_of_the_average_are_those_of_its_values() {
        let points = [[0.0, 0.0], [1.0, 0.0], [1.5, 0.4], [2.5, 0.1]];
        let mut u = vec![0.0];
        let mut legs: Vec<[f64; 2]> = vec![];
        for pair in points.windows(2) {
            let (dx, dy): (f64, f64) = (pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]);
            let way = dx.hypot(dy);
            legs.push([dx / way, dy / way]);
            u.push(u[u.len() - 1] + way);
        }
        let change: Vec<[f64; 2]> = legs
            .windows(2)
            .map(|pair| [pair[1][0] - pair[0][0], pair[1][1] - pair[0][1]])
            .collect();
        let axis = Axis {
            u: &u,
            points: &points,
            legs: &[0, 1, 2, 2],
            at: &u[1..3],
            change: &change,
        };
        // Between kinks of the kernel the fourth derivative is constant, the window's slope zero.
        for place in [0.83, 1.21, 1.43] {
            let h = 1e-3;
            let [before, here, behind] =
                [place - h, place, place + h].map(|each| averaged(&axis, each, 0.45, 0.0));
            for order in 0..4 {
                for side in 0..2 {
                    let slope = (behind[order][side] - before[order][side]) / (2.0 * h);
                    assert!(
                        (slope - here[order + 1][side]).abs() < 1e-3,
                        "{place} {order}"
                    );
                }
            }
        }
        assert_eq!(averaged(&axis, 0.2, 0.45, 0.0)[0], [0.2, 0.0]);
    }
}
