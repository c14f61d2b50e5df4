//! Curves from node to node of a bend: the cubic spline of heading over arc length, and points along it.

/// Curvature at both ends of each curve of one run, and its slope at both.
#[derive(Default)]
pub struct Spline {
    /// Curvature at the beginning, 1/m.
    pub k0: Vec<f64>,
    /// At the end.
    pub k1: Vec<f64>,
    /// Slope of curvature at the beginning, 1/m².
    pub r0: Vec<f64>,
    /// At the end.
    pub r1: Vec<f64>,
}

/// Adds the spline of one run of curves, which begins and ends without curvature and without a slope of it.
pub fn add_run(spline: &mut Spline, length: &[f64], angle: &[f64]) {
    let count = length.len();
    let mean: Vec<f64> = length.iter().zip(angle).map(|(h, a)| a / h).collect();
    // Continuity of the second derivative: k[i-1] / h[i-1] + 2 k[i] (1 / h[i-1] + 1 / h[i]) + k[i+1] / h[i] = …
    let (mut upper, mut curvature) = (vec![0.0; count], vec![0.0; count + 1]);
    for i in 1..count {
        let (before, behind) = (length[i - 1], length[i]);
        let pivot = 2.0 / before + 2.0 / behind - upper[i - 1] / before;
        upper[i] = 1.0 / (behind * pivot);
        let right = 3.0 * (mean[i - 1] / before + mean[i] / behind);
        curvature[i] = (right - curvature[i - 1] / before) / pivot;
    }
    for i in (1..count).rev() {
        curvature[i] -= upper[i] * curvature[i + 1];
    }
    let slope =
        |i: usize| (6.0 * mean[i] - 4.0 * curvature[i] - 2.0 * curvature[i + 1]) / length[i];
    let slopes = (0..count).map(|i| if i == 0 { 0.0 } else { slope(i) });
    let begin = spline.r0.len();
    spline.r0.extend(slopes);
    spline.r1.extend_from_slice(&spline.r0[begin + 1..]);
    spline.r1.push(0.0);
    spline.k0.extend_from_slice(&curvature[..count]);
    spline.k1.extend_from_slice(&curvature[1..]);
}

/// One curve: pose at its beginning, length, curvature and its slope there, third derivatives of three equal parts.
pub struct Curve {
    /// Where it begins, metres.
    pub at: [f64; 2],
    /// Radians.
    pub heading: f64,
    /// Metres.
    pub length: f64,
    /// 1/m.
    pub curvature: f64,
    /// 1/m².
    pub slope: f64,
    /// 1/m³.
    pub thirds: [f64; 3],
}

/// Points of four-point Gauss quadrature on [-1, 1] that are positive, and their weights.
const NODES: [(f64, f64); 2] = [
    (0.339_981_043_584_856_3, 0.652_145_154_862_546_1),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_9),
];

impl Curve {
    /// The ends of `chords` equal parts of it.
    pub fn points(&self, chords: usize) -> impl Iterator<Item = [f64; 2]> + '_ {
        let h = self.length / 3.0;
        let mut states = [[0.0, self.curvature, self.slope]; 3];
        for part in 1..3 {
            let ([turned, first, second], third) = (states[part - 1], self.thirds[part - 1]);
            states[part] = [
                turned + h * (first + h * (second / 2.0 + h * third / 6.0)),
                first + h * (second + h * third / 2.0),
                second + h * third,
            ];
        }
        let half = self.length / (2.0 * chords as f64);
        let mut here = self.at;
        std::iter::once(self.at).chain((0..chords).map(move |chord| {
            let middle = (2 * chord + 1) as f64 * half;
            for (node, weight) in NODES {
                for s in [middle - node * half, middle + node * half] {
                    let part = ((s / h) as usize).min(2);
                    let ([turned, first, second], third) = (states[part], self.thirds[part]);
                    let r = s - part as f64 * h;
                    let turned = turned + r * (first + r * (second / 2.0 + r * third / 6.0));
                    let (sine, cosine) = (self.heading + turned).sin_cos();
                    here[0] += half * weight * cosine;
                    here[1] += half * weight * sine;
                }
            }
            here
        }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_spline_takes_the_angles_and_is_smooth_between() {
        let (length, angle) = ([0.1, 0.07, 0.12, 0.1, 0.09], [0.02, 0.1, -0.05, 0.03, 0.0]);
        let mut found = Spline::default();
        add_run(&mut found, &length, &angle);
        assert_eq!(
            (found.k0[0], found.k1[4], found.r0[0], found.r1[4]),
            (0.0, 0.0, 0.0, 0.0)
        );
        for i in 1..5 {
            assert_eq!(
                (found.k0[i], found.r0[i]),
                (found.k1[i - 1], found.r1[i - 1])
            );
        }
        // Between inner nodes the heading is one cubic: the third derivative from both ends is the same.
        for i in 1..4 {
            let h = length[i];
            let third = (found.r1[i] - found.r0[i]) / h;
            let turned = h * (found.k0[i] + h * (found.r0[i] / 2.0 + h * third / 6.0));
            assert!((turned - angle[i]).abs() < 1e-12, "{i}");
        }
    }

    #[test]
    fn points_along_an_arc_lie_on_its_circle() {
        let curve = Curve {
            at: [1.0, 2.0],
            heading: 0.3,
            length: 0.8,
            curvature: 2.0,
            slope: 0.0,
            thirds: [0.0; 3],
        };
        let centre = [1.0 - 0.5 * 0.3_f64.sin(), 2.0 + 0.5 * 0.3_f64.cos()];
        let points: Vec<[f64; 2]> = curve.points(4).collect();
        assert_eq!(points.len(), 5);
        for [x, y] in points {
            assert!(((x - centre[0]).hypot(y - centre[1]) - 0.5).abs() < 1e-9);
        }
    }
}
