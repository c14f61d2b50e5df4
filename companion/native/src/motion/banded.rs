//! Symmetric positive definite systems with two diagonals beside the main one, in time linear in their size.

/// Element (i, i + d) at `diagonals[d][i]`.
pub struct Pentadiagonal {
    /// The main diagonal and the two above it.
    pub diagonals: [Vec<f64>; 3],
}

impl Pentadiagonal {
    /// All zero.
    pub fn zeros(size: usize) -> Self {
        Self {
            diagonals: [vec![0.0; size], vec![0.0; size], vec![0.0; size]],
        }
    }

    /// Every element zero again.
    pub fn clear(&mut self) {
        for diagonal in &mut self.diagonals {
            diagonal.fill(0.0);
        }
    }

    /// L D Lᵀ in place: D on the main diagonal, L below its own ones.
    pub fn factor(&mut self) {
        let [main, first, second] = &mut self.diagonals;
        for i in 0..main.len() {
            let mut pivot = main[i];
            let mut next = first[i];
            if i >= 1 {
                pivot -= first[i - 1] * first[i - 1] * main[i - 1];
                next -= first[i - 1] * main[i - 1] * second[i - 1];
            }
            if i >= 2 {
                pivot -= second[i - 2] * second[i - 2] * main[i - 2];
            }
            // Rounding alone can make it less than nothing.
            let pivot = pivot.max(1e-14 * main[i].abs()).max(f64::MIN_POSITIVE);
            main[i] = pivot;
            first[i] = next / pivot;
            second[i] /= pivot;
        }
    }

    /// The solution for a right-hand side, in its place, once factored.
    pub fn solve(&self, values: &mut [f64]) {
        let [main, first, second] = &self.diagonals;
        let size = values.len();
        for i in 0..size {
            if i >= 1 {
                values[i] -= first[i - 1] * values[i - 1];
            }
            if i >= 2 {
                values[i] -= second[i - 2] * values[i - 2];
            }
        }
        for i in (0..size).rev() {
            values[i] /= main[i];
            if i + 1 < size {
                values[i] -= first[i] * values[i + 1];
            }
            if i + 2 < size {
                values[i] -= second[i] * values[i + 2];
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_solution_solves_the_system() {
        let size = 7;
        let mut matrix = Pentadiagonal::zeros(size);
        for i in 0..size {
            matrix.diagonals[0][i] = 6.0 + i as f64;
            matrix.diagonals[1][i] = if i + 1 < size { -2.0 } else { 0.0 };
            matrix.diagonals[2][i] = if i + 2 < size { 0.5 } else { 0.0 };
        }
        let wanted: Vec<f64> = (0..size).map(|i| (i as f64 * 1.3).sin()).collect();
        let element = |i: usize, j: usize| match i.abs_diff(j) {
            d @ 0..=2 => matrix.diagonals[d][i.min(j)],
            _ => 0.0,
        };
        let mut values: Vec<f64> = (0..size)
            .map(|i| (0..size).map(|j| element(i, j) * wanted[j]).sum())
            .collect();
        matrix.factor();
        matrix.solve(&mut values);
        for (found, right) in values.iter().zip(&wanted) {
            assert!((found - right).abs() < 1e-12);
        }
    }
}
