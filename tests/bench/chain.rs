//! The Brusselator chain of `common::brusselator`, banded, on 20 intervals of degree 4: at Gauss points, as AUTO has them, or
//! at Radau points, the program's own choice for stiff problems: fast decaying modes get no multipliers near the unit circle
//! there (see `Scheme`).

use super::Case;
use super::common::{brusselator::Brusselator, first_cycle};
use hopfline::continuation::StepControl;
use hopfline::orbit::Points;

pub fn case<const POINTS: usize>(points: Points) -> Case {
    let problem = Brusselator::chain(POINTS, true);
    let hopf = Brusselator::hopf(&problem);
    let size = f64::sqrt(2.0 * POINTS as f64);
    let (intervals, degree) = (20, 4);
    let mesh = (intervals, degree, points);
    let (system, start) = first_cycle(problem, &hopf, 0.1 * size, mesh, (size, 1.0));
    let (n, m, count) = (2.0 * POINTS as f64, degree as f64, intervals as f64);
    // Each interval: n + 2 columns through a band of 3 (2 m + m - 1) entries; each joint: one product of n by n matrices.
    let flops = count * m * n * (n + 2.0) * 2.0 * 3.0 * (3.0 * m - 1.0) + (count - 1.0) * 2.0 * n.powi(3);
    let auto = [(8, 0.008), (32, 0.30), (64, 1.1), (128, 5.5)].into_iter().find(|(points, _)| *points == POINTS);
    Case {
        name: format!("chain, n = {n}"),
        system,
        start,
        control: StepControl { step: 0.05, least: 1e-8, most: 0.1 },
        steps: if POINTS < 100 { 20 } else { 8 },
        multipliers: 10,
        flops,
        auto: auto.map(|(_, seconds)| seconds),
    }
}
