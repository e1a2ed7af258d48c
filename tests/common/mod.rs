//! What several test files share: parameters, small systems, the way to a Hopf point.
#![allow(dead_code)]

pub mod brusselator;
pub mod lorenz;
pub mod text;

use faer::Mat;
use hopfline::bifurcation::{Coordinate, Equilibria, Hopf, HopfNormalForm};
use hopfline::continuation::{Border, Counts, Point, StepControl, Stop, System, Walk, correct};
use hopfline::linalg::c64;
use hopfline::models::{Law, Load, TwoDoublet};
use hopfline::orbit::{Collocation, Frame, Multipliers, Orbit, Points, from_hopf, half_period};
use hopfline::problem::{At, Automatic, Bounds, Default, Parameter, Problem, Reflection};
use hopfline::run::{RunOptions, run};
use hopfline::scene::Scene;
use std::path::Path;
use std::sync::Arc;

pub fn parameter(name: &'static str, value: f64) -> Parameter {
    Parameter { name, default: Default::Value(value), unit: "", meaning: "", bounds: Bounds::Any }
}

/// `|a - b| <= tolerance |b|`, said with the numbers when it fails.
#[track_caller]
pub fn close(what: &str, a: f64, b: f64, tolerance: f64) {
    let error = (a - b).abs() / b.abs();
    assert!(error <= tolerance, "{what}: {a:.15e} should be {b:.15e}; relative error {error:.1e} > {tolerance:.0e}");
}

/// `|a - b| <= tolerance`.
#[track_caller]
pub fn near(what: &str, a: f64, b: f64, tolerance: f64) {
    let error = (a - b).abs();
    assert!(error <= tolerance, "{what}: {a:.15e} should be {b:.15e}; error {error:.1e} > {tolerance:.0e}");
}

/// `close` for complex numbers.
#[track_caller]
pub fn close_complex(what: &str, a: c64, b: c64, tolerance: f64) {
    let error = (a - b).norm() / b.norm();
    assert!(error <= tolerance, "{what}: {a} should be {b}; relative error {error:.1e} > {tolerance:.0e}");
}

/// `G_u` and `G_v`.
pub fn matrices(problem: &dyn Problem, at: At) -> (Mat<f64>, Mat<f64>) {
    problem.linearised(at)
}

/// Eigenvalues and vectors at an equilibrium (not checked to be one).
pub fn spectrum(
    problem: &Arc<dyn Problem>,
    (u, p): (&[f64], &[f64]),
    shift: f64,
    vectors: usize,
) -> Vec<(c64, Vec<c64>)> {
    let coordinate = Coordinate { index: 0, logarithmic: false, width: 1.0 };
    let system =
        Equilibria { problem: problem.clone(), p: p.to_vec(), coordinate, scale_state: 1.0, all_eigenvalues: None };
    let pairs = system.spectrum(u, p[0], shift, vectors).expect("a spectrum");
    pairs.into_iter().map(|pair| (pair.value, pair.vector)).collect()
}

/// The Hopf point of the `rank`-th pair of eigenvalues (rightmost first) at (u, p), by Newton's method from there.
pub fn hopf_of_pair(
    problem: &Arc<dyn Problem>,
    (u, p): (&[f64], &[f64]),
    free: usize,
    shift: f64,
    rank: usize,
) -> Hopf {
    let pairs = spectrum(problem, (u, p), shift, problem.dim());
    let (value, vector) = pairs.iter().filter(|(value, _)| value.im > 0.0).nth(rank).expect("a complex pair").clone();
    Hopf::locate(&**problem, (u, p), free, value.im, &vector).expect("a Hopf point")
}

/// The two-doublet model and its parameters by name, ties of the defaults resolved by hand.
#[derive(Clone)]
pub struct Flagellum {
    pub problem: Arc<dyn Problem>,
    pub p: Vec<f64>,
}

impl Flagellum {
    pub fn new(functions: usize, load: Load, law: Law) -> Self {
        Self::of(Arc::new(Automatic(TwoDoublet::new(functions, load, law))))
    }

    /// Any form of the model.
    pub fn of(problem: Arc<dyn Problem>) -> Self {
        let value = |default: &Default| if let Default::Value(x) = default { *x } else { f64::NAN };
        let p = problem.parameters().iter().map(|parameter| value(&parameter.default)).collect();
        Self { problem, p }.tied()
    }

    pub fn index(&self, name: &str) -> usize {
        self.problem.parameters().iter().position(|p| p.name == name).expect("a parameter of the model")
    }

    pub fn get(&self, name: &str) -> f64 {
        self.p[self.index(name)]
    }

    /// Sets one value and what follows from it.
    pub fn with(mut self, name: &str, value: f64) -> Self {
        let i = self.index(name);
        self.p[i] = value;
        self.tied()
    }

    /// c_T = c_N/2, b_N = tau_c k_N, b_T = tau_c k_T, EI_2 = EI.
    fn tied(mut self) -> Self {
        let tau_c = self.get("tau_c");
        for (name, value) in [
            ("c_T", 0.5 * self.get("c_N")),
            ("b_N", tau_c * self.get("k_N")),
            ("b_T", tau_c * self.get("k_T")),
            ("tau", self.get("c_N") * self.get("L").powi(4) / self.get("EI")),
            ("EI_2", self.get("EI")),
        ] {
            let i = self.index(name);
            self.p[i] = value;
        }
        self
    }

    pub fn straight(&self) -> Vec<f64> {
        vec![0.0; self.problem.dim()]
    }

    /// The `rank`-th Hopf point of the straight state, from the eigenvalues at a load `p` near it.
    pub fn hopf(&self, p: f64, rank: usize) -> Hopf {
        let at = self.clone().with("p", p);
        hopf_of_pair(&at.problem, (&at.straight(), &at.p), at.index("p"), 1e4, rank)
    }

    pub fn observable(&self, name: &str) -> usize {
        self.problem.observables().iter().position(|o| o.name == name).expect("an observable of the model")
    }

    pub fn observe(&self, name: &str, u: &[f64], v: &[f64]) -> f64 {
        self.problem.observe(self.observable(name), At { u, v, p: &self.p })
    }

    /// The cycles from the first Hopf point (found from a load near it) at growing loads, by continuation on half a
    /// period with Radau points; the mesh is adapted once more at each.
    pub fn cycles(&self, onset: f64, loads: &[f64], (intervals, degree): (usize, usize)) -> Vec<Cycle> {
        let free = self.index("p");
        let hopf = self.hopf(onset, 0);
        let form = HopfNormalForm::new(&*self.problem, &hopf).expect("a normal form");
        let symmetry = half_period(&*self.problem, &hopf, 1.0).expect("an odd mode");
        // A first cycle slightly above the onset.
        let r = (0.002 * hopf.p[free] / form.p2).sqrt();
        assert!(r.is_finite(), "subcritical");
        let (orbit, lambda) = from_hopf((&hopf, &form), free, r, (&symmetry, 2), (intervals, degree, Points::Radau));
        assert!(lambda < loads[0], "{lambda}");
        let frame = Frame {
            problem: self.problem.clone(),
            p: self.p.clone(),
            free,
            symmetry: symmetry.clone(),
            parts: 2,
            scale_state: 0.1,
            scale_part: orbit.part,
            scale_lambda: 100.0,
        };
        let mut system = Collocation::new(frame, &orbit);
        let counts = &mut Counts::default();
        let fixed = |n: usize| Border { row: vec![0.0; n], lambda: 1.0 };
        let x = Collocation::unknowns(&orbit);
        let border = fixed(x.len());
        let mut point = correct(&system, (x, lambda), &border, counts).expect("a first cycle").point;
        let mut cycles = Vec::new();
        for &load in loads {
            let control = StepControl { step: 0.4, least: 1e-6, most: 1.0 };
            let mut walk = Walk::new(&mut system, point.clone(), control, (0.0, load));
            point = loop {
                let step = walk.step().unwrap_or_else(|stop| panic!("{stop}"));
                if step.stop == Some(Stop::RangeEnd) {
                    break step.to;
                }
            };
            system.prepare(&mut point);
            let border = fixed(point.x.len());
            let corrected = correct(&system, (point.x, load), &border, counts).expect("a cycle");
            let multipliers = corrected.factors.multipliers(None).expect("multipliers");
            point = corrected.point;
            let orbit = system.orbit(&point.x);
            let p = system.parameters(load);
            let deflection = orbit.extremes(&*self.problem, self.observable("tip_deflection"), &p, &symmetry).max;
            cycles.push(Cycle { orbit, multipliers, deflection });
        }
        cycles
    }
}

/// A computed cycle with its multipliers and the largest tip deflection of the mean line.
pub struct Cycle {
    pub orbit: Orbit,
    pub multipliers: Multipliers,
    pub deflection: f64,
}

/// Runs a scene of `problems` with nothing printed; it must be refused or fail with a message that has `wanted` in it.
#[track_caller]
pub fn refused(name: &str, sets: &[&str], wanted: &str) {
    let sets: Vec<String> = sets.iter().map(|s| (*s).to_owned()).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("problems").join(format!("{name}.toml"));
    let out = tempfile::tempdir().unwrap();
    let options = RunOptions { out: out.path().to_owned(), only: Vec::new(), resume: false, quiet: true };
    let message = match Scene::load(&path, &sets) {
        Err(error) => error.to_string(),
        Ok(scene) => match run(&scene, &options) {
            Err(error) => error.to_string(),
            Ok(summary) => summary.tasks.iter().map(|task| task.reason.clone() + "; ").collect(),
        },
    };
    assert!(message.contains(wanted), "{message:?} lacks {wanted:?}");
}

/// The first cycle from a Hopf point at radius r, over a whole period, corrected across the way in which cycles grow;
/// `scales` of state and parameter.
pub fn first_cycle(
    problem: Arc<dyn Problem>,
    hopf: &Hopf,
    r: f64,
    mesh: (usize, usize, Points),
    (scale_state, scale_lambda): (f64, f64),
) -> (Collocation, Point) {
    let form = HopfNormalForm::new(&*problem, hopf).expect("a normal form");
    let symmetry = Reflection::identity(problem.dim());
    let predict = |r: f64| from_hopf((hopf, &form), 0, r, (&symmetry, 1), mesh);
    let ((orbit, lambda), (ahead, further)) = (predict(r), predict(1.01 * r));
    let frame = Frame {
        problem,
        p: hopf.p.clone(),
        free: 0,
        symmetry: symmetry.clone(),
        parts: 1,
        scale_state,
        scale_part: orbit.part,
        scale_lambda,
    };
    let system = Collocation::new(frame, &orbit);
    let x = Collocation::unknowns(&orbit);
    let direction: Vec<f64> = Collocation::unknowns(&ahead).iter().zip(&x).map(|(a, b)| a - b).collect();
    let border = Border { row: system.dual(&direction), lambda: system.dual_lambda() * (further - lambda) };
    let first = correct(&system, (x, lambda), &border, &mut Counts::default()).expect("a cycle").point;
    (system, first)
}
