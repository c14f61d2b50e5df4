//! Brown–Conrady lens distortion on the plane one ahead of the lens: k1, k2, p1, p2, k3.

/// Coefficients in OpenCV's order.
pub type Lens = [f64; 5];

/// Enough for a hundredth of a pixel at the corners of a lens with 20 % of barrel distortion.
const ITERATIONS: usize = 30;

/// Radial factor and tangential shift at an undistorted point.
fn bend(lens: &Lens, a: f64, b: f64) -> (f64, f64, f64) {
    let [k1, k2, p1, p2, k3] = *lens;
    let square = a * a + b * b;
    let radial = 1.0 + square * (k1 + square * (k2 + square * k3));
    (
        radial,
        2.0 * p1 * a * b + p2 * (square + 2.0 * a * a),
        p1 * (square + 2.0 * b * b) + 2.0 * p2 * a * b,
    )
}

/// Where the lens shows an undistorted point.
pub fn distort(lens: &Lens, a: f64, b: f64) -> (f64, f64) {
    if lens.iter().all(|k| *k == 0.0) {
        return (a, b);
    }
    let (radial, along_a, along_b) = bend(lens, a, b);
    (a * radial + along_a, b * radial + along_b)
}

/// What the lens shows at a point, by fixed-point iteration.
pub fn undistort(lens: &Lens, a: f64, b: f64) -> (f64, f64) {
    if lens.iter().all(|k| *k == 0.0) {
        return (a, b);
    }
    (0..ITERATIONS).fold((a, b), |(x, y), _| {
        let (radial, along_a, along_b) = bend(lens, x, y);
        ((a - along_a) / radial, (b - along_b) / radial)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_a_lens_bends_it_bends_back() {
        let lens = [-0.2, 0.03, 0.002, -0.001, 0.0];
        for (a, b) in [(0.0, 0.0), (0.5, 0.4), (-0.5, 0.2), (0.1, -0.4)] {
            let (x, y) = undistort(&lens, a, b);
            let (back_a, back_b) = distort(&lens, x, y);
            assert!((back_a - a).abs() < 1e-5 && (back_b - b).abs() < 1e-5);
        }
        assert!(distort(&lens, 0.5, 0.4).0 < 0.5, "a barrel draws inwards");
        assert_eq!(undistort(&[0.0; 5], 0.3, 0.2), (0.3, 0.2));
    }
}
