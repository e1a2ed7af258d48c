//! `cargo bench --bench text`: models as text against the same models in Rust, per evaluation: the residual, its
//! linearisation and a third derivative, for Lorenz' equations (n = 3) and a Brusselator chain (n = 256).

#[path = "../common/mod.rs"]
mod common;

use common::brusselator::Brusselator;
use common::lorenz::Lorenz;
use common::text;
use hopfline::linalg::Matrix;
use hopfline::problem::{At, Direction, Problem};
use std::hint::black_box;
use std::time::Instant;

fn main() {
    println!("{:12} {:14} {:>12} {:>12} {:>7}", "model", "", "Rust", "text", "ratio");
    compare("lorenz", &*Lorenz::problem(), &*text::lorenz(), &[28.0, 10.0, 8.0 / 3.0]);
    compare("brusselator", &*Brusselator::chain(128, true), &*text::brusselator(128), &[0.52]);
}

fn compare(name: &str, native: &dyn Problem, text: &dyn Problem, p: &[f64]) {
    let n = native.dim();
    let (u, v): (Vec<f64>, Vec<f64>) = (0..n).map(|i| ((1.0 + i as f64).sin(), (2.0 + i as f64).cos())).unzip();
    let at = At { u: &u, v: &v, p };
    let mut out = vec![0.0; n];
    let direction = Direction { u: &v, v: &u, p: &[] };
    let row = |what: &str, run: &mut dyn FnMut(&dyn Problem)| {
        let (rust, taken) = (seconds(&mut || run(native)), seconds(&mut || run(text)));
        println!("{name:12} {what:14} {:>9.1} ns {:>9.1} ns {:>7.2}", 1e9 * rust, 1e9 * taken, taken / rust);
    };
    row("residual", &mut |problem| problem.residual(black_box(at), black_box(&mut out)));
    let zeros = || Matrix::zeros(text.structure(), n);
    let (mut gu, mut gv) = (zeros(), zeros());
    row("linearisation", &mut |problem| problem.linearise(black_box(at), black_box(&mut gu), &mut gv));
    row("third order", &mut |problem| problem.derivative(black_box(at), &[direction; 3], black_box(&mut vec![0.0; n])));
}

/// The least of several means.
fn seconds(run: &mut dyn FnMut()) -> f64 {
    let mut repeats = 1_u32;
    let mut best = f64::INFINITY;
    for _ in 0..40 {
        let start = Instant::now();
        (0..repeats).for_each(|_| run());
        let taken = start.elapsed().as_secs_f64();
        best = best.min(taken / f64::from(repeats));
        if taken < 2e-3 {
            repeats *= 2;
        }
    }
    best
}
