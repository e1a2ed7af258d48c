//! Lorenz' equations, sigma = 10, beta = 8/3: the cycles from the Hopf point at rho = 470/19, 35 intervals of degree 4.

use super::Case;
use super::common::{first_cycle, lorenz::Lorenz};
use hopfline::continuation::StepControl;
use hopfline::orbit::Points;

pub fn case() -> Case {
    let problem = Lorenz::problem();
    let hopf = Lorenz::hopf(&problem);
    let (system, start) = first_cycle(problem, &hopf, 0.5, (35, 4, Points::Gauss), (10.0, 10.0));
    Case {
        name: "Lorenz, n = 3".to_owned(),
        system,
        start,
        control: StepControl { step: 0.02, least: 1e-8, most: 0.05 },
        steps: 30,
        multipliers: 3,
        // 57 n³ an interval of degree 4, 7.7 n³ a joint.
        flops: (35.0 * 57.0 + 34.0 * 7.7) * 27.0,
        auto: Some(0.0009),
    }
}
