//! `cargo bench --bench orbits`: time, counts and work of steps along branches of cycles, and the share of the machine's
//! matrix-multiply peak that they reach, measured in the same run. Arguments name cases: `lorenz`, `chain`, `large`.
//!
//! Times are of the processor (all threads), and include Floquet multipliers at each step.

mod chain;
#[path = "../common/mod.rs"]
mod common;
mod lorenz;

use cpu_time::ProcessTime;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use hopfline::continuation::{Counts, StepControl, Walk};
use hopfline::orbit::Collocation;
use std::time::Instant;

/// What a case measures: a system at a first point, and how to step.
pub struct Case {
    pub name: String,
    pub system: Collocation,
    pub start: hopfline::continuation::Point,
    pub control: StepControl,
    pub steps: usize,
    /// Leading multipliers at each step.
    pub multipliers: usize,
    /// Multiplications and additions of one factorisation.
    pub flops: f64,
    /// AUTO-07p's seconds per step for the same problem and mesh, from the project's table; it was measured on another day.
    pub auto: Option<f64>,
}

fn main() {
    // cargo passes --bench.
    let wanted: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let want = |name: &str| wanted.is_empty() && name != "large" || wanted.iter().any(|w| w == name);
    let peak = peak();
    println!("matrix-multiply peak, one thread: {:.1} Gflop/s", peak * 1e-9);
    println!(
        "{:18} {:>6} {:>11} {:>11} {:>7} {:>7} {:>10} {:>6} {:>9} {:>6}",
        "case", "steps", "CPU s/step", "wall s/step", "factors", "solves", "Mflop/step", "peak", "AUTO s", "ratio"
    );
    let mut cases: Vec<fn() -> Case> = Vec::new();
    if want("lorenz") {
        cases.push(lorenz::case);
    }
    if want("chain") {
        cases.extend([chain::case::<8> as fn() -> Case, chain::case::<32>, chain::case::<64>, chain::case::<128>]);
    }
    if want("large") {
        cases.push(chain::case::<500>);
    }
    for case in cases {
        report(case(), peak);
    }
}

fn report(mut case: Case, peak: f64) {
    let mut walk = Walk::new(&mut case.system, case.start.clone(), case.control, (f64::MIN, f64::MAX));
    // The first step makes factors that later ones start from.
    walk.step().unwrap_or_else(|stop| panic!("{}: {stop}", case.name));
    let before = walk.counts;
    let (cpu, wall) = (ProcessTime::now(), Instant::now());
    let mut found = 0;
    for _ in 0..case.steps {
        let step = walk.step().unwrap_or_else(|stop| panic!("{}: {stop}", case.name));
        found += step.factors.multipliers(Some(case.multipliers)).map_or(0, |m| m.values.len().min(case.multipliers));
    }
    let (cpu, wall) = (cpu.elapsed().as_secs_f64(), wall.elapsed().as_secs_f64());
    assert!(found > 0, "{}: no multipliers", case.name);
    let Counts { factorisations, newton, .. } = walk.counts;
    let steps = case.steps as f64;
    let per = |count: usize, before: usize| (count - before) as f64 / steps;
    let factors = per(factorisations, before.factorisations);
    let flops = factors * case.flops;
    let compared = case.auto.map_or(String::new(), |auto| format!("{auto:9} {:6.1}", auto * steps / cpu));
    println!(
        "{:18} {:>6} {:11.6} {:11.6} {factors:7.2} {:7.2} {:10.1} {:5.0}% {compared}",
        case.name,
        case.steps,
        cpu / steps,
        wall / steps,
        per(newton, before.newton),
        flops * 1e-6,
        100.0 * flops * steps / cpu / peak,
    );
}

/// Additions and multiplications a second of faer's matrix product on one thread: the best of several.
fn peak() -> f64 {
    let n = 768;
    let a = Mat::from_fn(n, n, |i, j| ((i * 7 + j * 3) % 11) as f64 - 5.0);
    let mut c = Mat::zeros(n, n);
    let best = (0..8).map(|_| {
        let start = Instant::now();
        matmul(c.as_mut(), Accum::Replace, a.as_ref(), a.as_ref(), 1.0, Par::Seq);
        start.elapsed().as_secs_f64()
    });
    2.0 * (n as f64).powi(3) / best.fold(f64::INFINITY, f64::min)
}
