//! The shape of a rod, for figures.

/// The curve with tangent `direction(x)` at x = s/L, at 101 points from the base on.
pub fn line(length: f64, direction: impl Fn(f64) -> [f64; 2]) -> Vec<[f64; 2]> {
    const CELLS: usize = 100;
    let mut line = vec![[0.0, 0.0]];
    let mut at = [0.0, 0.0];
    let step = 1.0 / CELLS as f64;
    for i in 0..CELLS {
        let x = i as f64 * step;
        // Simpson's rule on each cell: far below what a figure shows.
        let [left, middle, right] = [direction(x), direction(x + 0.5 * step), direction(x + step)];
        for d in 0..2 {
            at[d] += length * step / 6.0 * (left[d] + 4.0 * middle[d] + right[d]);
        }
        line.push(at);
    }
    line
}
