//! Exact Euclidean distance from every cell's centre to the nearest blocked cell's square.
//!
//! Two passes of lower envelopes of parabolas (Felzenszwalb and Huttenlocher 2012). The squares' half-width is
//! worked in by evaluating each envelope half a cell nearer on either side: the nearest point of a square
//! that lies d cells off along an axis is d - 1/2 away, and 0 away when d = 0.

/// Squared distances in cells along one line. `source` holds the squared distance across the line.
fn line(source: &[f64], out: &mut [f64], vertex: &mut [usize], border: &mut [f64]) {
    let n = source.len();
    let mut count = 0usize;
    for q in 0..n {
        if !source[q].is_finite() {
            continue;
        }
        let height = source[q] + (q * q) as f64;
        loop {
            if count == 0 {
                border[0] = f64::NEG_INFINITY;
                break;
            }
            let v = vertex[count - 1];
            let crossing = (height - source[v] - (v * v) as f64) / (2.0 * (q - v) as f64);
            if crossing > border[count - 1] {
                border[count] = crossing;
                break;
            }
            count -= 1;
        }
        vertex[count] = q;
        count += 1;
    }
    if count == 0 {
        out.copy_from_slice(source);
        return;
    }
    let mut near = 0usize;
    let mut far = 0usize;
    for (x, value) in out.iter_mut().enumerate() {
        let (before, after) = (x as f64 - 0.5, x as f64 + 0.5);
        while near + 1 < count && border[near + 1] < before {
            near += 1;
        }
        while far + 1 < count && border[far + 1] < after {
            far += 1;
        }
        let low = before - vertex[near] as f64;
        let high = after - vertex[far] as f64;
        *value = source[x]
            .min(low * low + source[vertex[near]])
            .min(high * high + source[vertex[far]]);
    }
}

/// Clearance in cells, row-major; infinite where nothing is blocked.
pub fn clearance(blocked: &[u8], width: usize, height: usize) -> Vec<f32> {
    let longest = width.max(height);
    let mut vertex = vec![0usize; longest];
    let mut border = vec![0.0f64; longest + 1];
    let mut columns = vec![0.0f32; width * height];
    let mut source = vec![0.0f64; longest];
    let mut out = vec![0.0f64; longest];
    for x in 0..width {
        for y in 0..height {
            source[y] = if blocked[y * width + x] != 0 {
                0.0
            } else {
                f64::INFINITY
            };
        }
        line(
            &source[..height],
            &mut out[..height],
            &mut vertex,
            &mut border,
        );
        for y in 0..height {
            columns[y * width + x] = out[y] as f32;
        }
    }
    let mut result = columns;
    for row in result.chunks_exact_mut(width) {
        for (value, cell) in source.iter_mut().zip(row.iter()) {
            *value = f64::from(*cell);
        }
        line(
            &source[..width],
            &mut out[..width],
            &mut vertex,
            &mut border,
        );
        for (cell, value) in row.iter_mut().zip(out.iter()) {
            *cell = value.sqrt() as f32;
        }
    }
    result
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn clearance_is_the_distance_to_the_nearest_blocked_square() {
        let (width, height) = (23, 17);
        let mut random = Random::new(8);
        let blocked: Vec<u8> = (0..width * height)
            .map(|_| u8::from(random.uniform() < 0.05))
            .collect();
        let found = clearance(&blocked, width, height);
        for (cell, &found) in found.iter().enumerate() {
            let (x, y) = ((cell % width) as f64, (cell / width) as f64);
            let expected = (0..blocked.len())
                .filter(|&other| blocked[other] != 0)
                .map(|other| {
                    let gap =
                        |here: f64, there: usize| ((here - there as f64).abs() - 0.5).max(0.0);
                    gap(x, other % width).hypot(gap(y, other / width))
                })
                .fold(f64::INFINITY, f64::min);
            assert!((f64::from(found) - expected).abs() < 1e-5);
        }
    }

    #[test]
    fn a_map_with_nothing_in_it_has_no_end_of_clearance() {
        assert!(clearance(&[0; 12], 4, 3)
            .iter()
            .all(|value| value.is_infinite()));
    }
}
