//! `cargo bench --bench orbits`: time, counts and work of steps along branches of cycles, and the share of the machine's
//! matrix-multiply peak that they reach, measured in the same run. Arguments name cases: `lorenz`, `chain`, `256`, `large`.
//!
//! Times are of the processor (all threads), and include Floquet multipliers at each step; of these, separately. Memory is the
//! most that the whole process held.

mod chain;
#[path = "../common/mod.rs"]
mod common;
mod lorenz;
mod memory;

use cpu_time::ProcessTime;
use faer::linalg::matmul::matmul;
use faer::{Accum, Mat, Par};
use hopfline::continuation::{Counts, StepControl, Walk};
use hopfline::orbit::{Collocation, Points};
use std::time::Instant;

/// Leading multipliers that a scene's tables give unless told otherwise: timed, but no part of a step here.
const USUAL: usize = 6;

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
    let peak = peak();
    println!("matrix-multiply peak, one thread: {:.1} Gflop/s", peak * 1e-9);
    println!(
        "{:16} {:>5} {:>10} {:>10} {:>9} {:>10} {:>7} {:>6} {:>10} {:>5} {:>6} {:>7} {:>5}",
        "case",
        "steps",
        "CPU s/step",
        "multipl. s",
        "(6 only)",
        "wall s",
        "factors",
        "solves",
        "Mflop/step",
        "peak",
        "MB",
        "AUTO s",
        "ratio"
    );
    type Make = fn() -> Case;
    let cases: [(&str, Make); 8] = [
        ("lorenz", lorenz::case),
        ("chain 16", || chain::case::<8>(Points::Gauss)),
        ("chain 64", || chain::case::<32>(Points::Gauss)),
        ("chain 128", || chain::case::<64>(Points::Gauss)),
        ("chain 256", || chain::case::<128>(Points::Gauss)),
        ("large 500", || chain::case::<250>(Points::Radau)),
        ("large 1000", || chain::case::<500>(Points::Radau)),
        ("gauss", || chain::case::<500>(Points::Gauss)),
    ];
    let chosen = |name: &str| match &wanted[..] {
        [] => name.starts_with("lorenz") || name.starts_with("chain"),
        wanted => wanted.iter().any(|word| name.split(' ').any(|part| part == word)),
    };
    for (_, case) in cases.iter().filter(|(name, _)| chosen(name)) {
        report(case(), peak);
    }
}

fn report(mut case: Case, peak: f64) {
    let mut walk = Walk::new(&mut case.system, case.start.clone(), case.control, (f64::MIN, f64::MAX));
    memory::forget();
    // The first step makes factors that later ones start from.
    walk.step().unwrap_or_else(|stop| panic!("{}: {stop}", case.name));
    let before = walk.counts;
    let (cpu, wall) = (ProcessTime::now(), Instant::now());
    let (mut found, mut spectra, mut fewer, mut aside) = (0, 0.0, 0.0, 0.0);
    for _ in 0..case.steps {
        let step = walk.step().unwrap_or_else(|stop| panic!("{}: {stop}", case.name));
        let start = ProcessTime::now();
        found += step.factors.multipliers(Some(case.multipliers)).map_or(0, |m| m.values.len().min(case.multipliers));
        spectra += start.elapsed().as_secs_f64();
        let (start, now) = (ProcessTime::now(), Instant::now());
        step.factors.multipliers(Some(USUAL)).unwrap_or_else(|error| panic!("{}: {error}", case.name));
        fewer += start.elapsed().as_secs_f64();
        aside += now.elapsed().as_secs_f64();
    }
    let (cpu, wall) = (cpu.elapsed().as_secs_f64() - fewer, wall.elapsed().as_secs_f64() - aside);
    assert!(found > 0, "{}: no multipliers", case.name);
    let Counts { factorisations, newton, .. } = walk.counts;
    let steps = case.steps as f64;
    let per = |count: usize, before: usize| (count - before) as f64 / steps;
    let factors = per(factorisations, before.factorisations);
    let flops = factors * case.flops;
    let compared = case.auto.map_or(String::new(), |auto| format!("{auto:7} {:5.1}", auto * steps / cpu));
    println!(
        "{:16} {:>5} {:10.6} {:10.6} {:9.6} {:10.6} {factors:7.2} {:6.2} {:10.1} {:4.0}% {:6.1} {compared}",
        case.name,
        case.steps,
        cpu / steps,
        spectra / steps,
        fewer / steps,
        wall / steps,
        per(newton, before.newton),
        flops * 1e-6,
        100.0 * flops * steps / cpu / peak,
        memory::most().map_or(f64::NAN, |most| most / 1e6),
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
