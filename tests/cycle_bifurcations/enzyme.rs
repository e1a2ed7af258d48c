//! The enzyme model of Kernevez, as in peers' demos: two folds of cycles.

use super::Branch;
use super::common::{close, hopf_of_pair, parameter};
use hopfline::orbit::Points;
use hopfline::orbit::bifurcations::Event;
use hopfline::problem::{Automatic, Formula, Parameter, Problem, Scalar};
use std::sync::Arc;

/// `s' = s0 - s - rho R, a' = alpha (a0 - a) - rho R, R = s a / (1 + s + kappa s²)`.
struct Enzyme(Vec<Parameter>);

const ALPHA: f64 = 0.2_f32 as f64;
const KAPPA: f64 = 0.1_f32 as f64;

impl Formula for Enzyme {
    fn dim(&self) -> usize {
        2
    }

    fn parameters(&self) -> &[Parameter] {
        &self.0
    }

    fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
        let (s, a) = (u[0], u[1]);
        let rate = p[0] * s * a / (s + s * s * KAPPA + 1.0);
        g[0] = v[0] - (-s + 110.0 - rate);
        g[1] = v[1] - ((-a + 500.0) * ALPHA - rate);
    }
}

#[test]
fn both_folds_of_cycles_have_the_known_place_and_period() {
    let problem: Arc<dyn Problem> = Arc::new(Automatic(Enzyme(vec![parameter("rho", 3.5)])));
    // The equilibrium: 110 - s = 0.2 (500 - a) = rho R, by bisection in s.
    let rho = 3.5;
    let along = |s: f64| {
        let a = 500.0 - (110.0 - s) / ALPHA;
        110.0 - s - rho * s * a / (1.0 + s + KAPPA * s * s)
    };
    let roots: Vec<f64> =
        (0..11000).map(|i| 0.01 * f64::from(i)).filter(|&s| along(s) * along(s + 0.01) < 0.0).collect();
    let s = roots[0];
    let u = [s, 500.0 - (110.0 - s) / ALPHA];
    let hopf = hopf_of_pair(&problem, (&u, &[rho]), 0, 3.0, 0);
    close("Hopf point", hopf.p[0], 3.49995301145157, 1e-13);
    let followed = Branch::of_hopf(&problem, &hopf, 0.1, 3.0, (60, 4, Points::Gauss)).follow((2.0, 6.0), 2);
    let found = &followed.found;
    assert!(found.iter().all(|(_, located)| located.event == Event::Fold));
    for ((_, located), (rho, period)) in found.iter().zip([(2.75968722, 10.00639398), (5.00784040, 5.67657794)]) {
        close("rho", located.point.lambda, rho, 2e-9);
        close("T", *located.point.x.last().unwrap(), period, 1e-9);
    }
    assert_eq!(found.len(), 2);
}
