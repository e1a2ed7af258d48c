//! What may be asked for: the kinds of tasks, with their keys.

use super::Place;
use std::collections::BTreeMap;

#[derive(Clone, Debug)]
pub struct Task {
    pub name: String,
    pub kind: TaskKind,
    pub at: Place,
}

#[derive(Clone, Debug)]
pub enum TaskKind {
    Equilibria(Equilibria),
    Diagram(Box<Diagram>),
    Cycles(Cycles),
    HopfCurve(Curve),
    FoldCurve(Curve),
    BranchPointCurve(Curve),
    CycleCurve(CycleKind, Curve),
    Calibration(Calibration),
    Map(Map),
    HopfSurface(Surface),
    Simulate(Simulate),
}

/// A closed range, `from < to`: reversed and empty ranges are refused, as are NaN and infinite ends.
#[derive(Clone, Debug, PartialEq)]
pub struct Range {
    pub from: f64,
    pub to: f64,
    pub at: Place,
}

impl TaskKind {
    /// As the scene names it: "equilibria", "cycles", "hopf-curve", ...
    pub fn name(&self) -> &'static str {
        match self {
            TaskKind::Equilibria(_) => "equilibria",
            TaskKind::Diagram(_) => "diagram",
            TaskKind::Cycles(_) => "cycles",
            TaskKind::HopfCurve(_) => "hopf-curve",
            TaskKind::FoldCurve(_) => "fold-curve",
            TaskKind::BranchPointCurve(_) => "branch-point-curve",
            TaskKind::CycleCurve(kind, _) => kind.task(),
            TaskKind::Calibration(_) => "calibration",
            TaskKind::Map(_) => "map",
            TaskKind::HopfSurface(_) => "hopf-surface",
            TaskKind::Simulate(_) => "simulate",
        }
    }

    pub fn along(&self) -> &Along {
        match self {
            TaskKind::Equilibria(task) => &task.along,
            TaskKind::Diagram(task) => &task.equilibria.along,
            TaskKind::Cycles(task) => &task.along,
            TaskKind::HopfCurve(task) | TaskKind::FoldCurve(task) | TaskKind::BranchPointCurve(task) => &task.along,
            TaskKind::CycleCurve(_, task) => &task.along,
            TaskKind::Calibration(task) => &task.along,
            TaskKind::Map(task) => &task.along,
            TaskKind::HopfSurface(task) => &task.along,
            TaskKind::Simulate(task) => &task.along,
        }
    }

    /// The point that the task starts from, "straight/HB1", and where the scene says so.
    pub fn from(&self) -> Option<(&str, &Place)> {
        match self {
            TaskKind::Equilibria(task) => task.from.as_ref().map(|(from, at)| (from.as_str(), at)),
            TaskKind::Simulate(task) => task.from.as_ref().map(|(from, at)| (from.as_str(), at)),
            TaskKind::Map(_) | TaskKind::Diagram(_) => None,
            TaskKind::Cycles(task) => Some((&task.from, &task.from_at)),
            TaskKind::HopfCurve(task) | TaskKind::FoldCurve(task) | TaskKind::BranchPointCurve(task) => {
                Some((&task.from, &task.from_at))
            }
            TaskKind::CycleCurve(_, task) => Some((&task.from, &task.from_at)),
            TaskKind::Calibration(task) => Some((&task.from, &task.from_at)),
            TaskKind::HopfSurface(task) => Some((&task.from, &task.from_at)),
        }
    }
}

/// A free parameter of several, and its bounds if it has any.
#[derive(Clone, Debug)]
pub struct Axis {
    pub name: String,
    pub range: Option<Range>,
}

/// What every task that varies parameters shares.
#[derive(Clone, Debug)]
pub struct Along {
    /// The free parameter; of several the last.
    pub free: String,
    pub free_at: Place,
    pub range: Range,
    /// The free parameters before it.
    pub others: Vec<Axis>,
    /// Those of them all that are followed by their logarithms.
    pub logarithmic: Vec<String>,
    /// Points wanted exactly: column or parameter, values. Labelled UZ1, UZ2, ... along the branch; of cycles that are followed
    /// both ways, first on the way to smaller values of the parameter.
    pub values: BTreeMap<String, Vec<f64>>,
    /// Largest step in the free parameter, in decades where it is logarithmic; default: a fiftieth of the range,
    /// of cycles a twentieth of it, or of what lies between their Hopf point and its end.
    pub max_step: Option<f64>,
    /// Most points of the branch. Default 1000.
    pub max_points: usize,
    /// Observables wanted as columns, besides those that figures and expectations use.
    pub observables: Vec<String>,
    /// Whether error estimates are computed. Default true.
    pub errors: bool,
    /// Places of the keys given in the task, for messages: "values", "observables", "max_step", ...
    pub places: BTreeMap<String, Place>,
}

/// `kind = "simulate"`.
#[derive(Clone, Debug)]
pub struct Simulate {
    /// The parameters that the task sets or varies; free is "" if there are none.
    pub along: Along,
    /// The point of another branch where the motion starts, and its place.
    pub from: Option<(String, Place)>,
    pub start: Option<Start>,
    /// Crossings that are stored, in the order of the scene.
    pub events: Vec<Happening>,
    /// Added to the start along its eigenmode: the largest entry.
    pub amplitude: Option<f64>,
    pub parameters: Vec<(String, f64)>,
    /// A parameter that goes from one value to another in the time given.
    pub ramp: Option<(String, [f64; 2])>,
    /// A parameter with one motion for each of its values.
    pub over: Option<(String, Vec<f64>)>,
    pub time: [f64; 2],
    /// Whether a diagonally implicit Runge-Kutta method is used, else backward differentiation.
    pub sdirk: bool,
    /// Local errors in parts of each unknown, and in parts of the largest.
    pub tolerance: f64,
    pub absolute: f64,
    /// Rows after the first.
    pub samples: usize,
}

/// Where a motion starts, if not at the model's own start.
#[derive(Clone, Debug)]
pub enum Start {
    /// All unknowns.
    List(Vec<f64>, Place),
    /// Some of them, by name; the others as in the model's start.
    Named(Guess),
}

/// `{ of = "x", value = 0, direction = "up", stop = true }`: an observable crosses a value.
#[derive(Clone, Debug)]
pub struct Happening {
    pub of: String,
    pub value: f64,
    /// "up", "down" or "any", the default.
    pub direction: &'static str,
    /// Whether the motion ends there. Default false.
    pub stop: bool,
    pub at: Place,
}

/// `kind = "equilibria"`.
#[derive(Clone, Debug)]
pub struct Equilibria {
    pub along: Along,
    /// The point of another branch that this one starts from, "straight/BP1", and its place.
    pub from: Option<(String, Place)>,
    /// Where in the range the branch is started without one, to be followed both ways; default: the lower end.
    pub start: Option<f64>,
    /// A state near which the first point is looked for; default: the model's start.
    pub guess: Option<Guess>,
    /// Observables with the ranges in which the branch is followed.
    pub bounds: Vec<(String, Range)>,
    /// Leading eigenvalues followed as continuous branches; 0: none.
    pub spectrum: usize,
    /// Whether all eigenvalues are computed, or the leading ones where the model has structure; default: all up to 256 unknowns.
    pub all_eigenvalues: Option<bool>,
    /// Kinds of special points looked for: "HB", "LP", "BP".
    pub detect: Vec<String>,
}

/// A state as a scene gives it: values of unknowns, and perhaps of the free parameter.
#[derive(Clone, Debug)]
pub struct Guess {
    pub values: Vec<(String, f64, Place)>,
    pub at: Place,
}

impl Guess {
    /// The free parameter's value, if it is given.
    pub fn free(&self, name: &str) -> Option<f64> {
        self.values.iter().find(|(known, ..)| known == name).map(|(_, value, _)| *value)
    }
}

/// `kind = "diagram"`: branches of equilibria and cycles, found by themselves.
#[derive(Clone, Debug)]
pub struct Diagram {
    /// What each branch of equilibria is computed with.
    pub equilibria: Equilibria,
    /// And each branch of cycles; None: none is computed.
    pub cycles: Option<Cycles>,
    /// States from which further branches start.
    pub states: Vec<Guess>,
    /// Values of the free parameter at which further solutions are looked for by deflation.
    pub deflate: Vec<f64>,
    /// Most switches between the first branch and the last. Default 3.
    pub depth: usize,
    pub max_branches: usize,
}

/// `kind = "cycles"`.
#[derive(Clone, Debug)]
pub struct Cycles {
    pub along: Along,
    /// "straight/HB1", or where other cycles bifurcate: "beat/PD1", "beat/BPC1".
    pub from: String,
    pub from_at: Place,
    /// Mesh intervals over the computed part of the period; None, the default: 20, or as many as the cycles have that
    /// they start from, twice as many for twice the period.
    pub intervals: Option<usize>,
    /// Wanted error of the orbit, relative to its size, which sets the number of intervals; default: `1e-6`, or none where
    /// `intervals` is given.
    pub tolerance: Option<f64>,
    /// Degree of the collocation polynomials, 2-7. Default 4.
    pub degree: usize,
    /// `points = "radau"` (default): right for stiff problems, order 2m - 1; `"gauss"`: order 2m.
    pub gauss: bool,
    /// Leading Floquet multipliers wanted as columns; 0 (default, or `false`): none. `true` asks for 6.
    pub multipliers: usize,
    /// `symmetry = "auto"` (default) uses half a period where the model allows; "none" the full one.
    pub symmetry: bool,
    /// Kinds of special points looked for: "LPC", "PD", "NS", "BPC".
    pub detect: Vec<String>,
    /// `relative = true`: orbits close up to the model's rotations, with columns `drift_1`, ...; starts are points of other
    /// cycles: NS of a rotating wave, UZ, EP. Default false.
    pub relative: bool,
}

impl Cycles {
    /// The error that the mesh is to have; None: the number of intervals is kept.
    pub fn error(&self) -> Option<f64> {
        self.tolerance.or(if self.intervals.is_none() { Some(1e-6) } else { None })
    }
}

/// Which bifurcations of cycles a curve follows: folds, period doublings, broken symmetries, tori.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CycleKind {
    Lpc,
    Pd,
    Bpc,
    Ns,
}

impl CycleKind {
    pub const ALL: [CycleKind; 4] = [CycleKind::Lpc, CycleKind::Pd, CycleKind::Bpc, CycleKind::Ns];

    /// The task's kind.
    pub fn task(self) -> &'static str {
        match self {
            CycleKind::Lpc => "lpc-curve",
            CycleKind::Pd => "pd-curve",
            CycleKind::Bpc => "bpc-curve",
            CycleKind::Ns => "ns-curve",
        }
    }

    /// The kind of its points, and what they are.
    pub fn point(self) -> (&'static str, &'static str) {
        match self {
            CycleKind::Lpc => ("LPC", "a fold of cycles"),
            CycleKind::Pd => ("PD", "a period doubling"),
            CycleKind::Bpc => ("BPC", "a branch point where cycles lose a symmetry"),
            CycleKind::Ns => ("NS", "a torus bifurcation"),
        }
    }

    /// Points of codimension two that may lie on the curve.
    pub fn found(self) -> &'static [&'static str] {
        match self {
            CycleKind::Lpc => &["CPC", "R1", "LPPD", "LPBP", "LPNS"],
            CycleKind::Pd => &["GPD", "R2", "LPPD", "PDNS"],
            CycleKind::Bpc => &["GBPC", "R2", "LPBP", "BPNS"],
            CycleKind::Ns => &["CH", "R1", "R2", "R3", "R4", "LPNS", "PDNS", "BPNS"],
        }
    }
}

/// `kind = "hopf-curve"`, `"fold-curve"`, `"branch-point-curve"`, or that of a [`CycleKind`].
#[derive(Clone, Debug)]
pub struct Curve {
    /// Two parameters; only the second must have a range.
    pub along: Along,
    /// "straight/HB1".
    pub from: String,
    pub from_at: Place,
}

/// `kind = "calibration"`.
#[derive(Clone, Debug)]
pub struct Calibration {
    /// The first of its parameters is solved for at the Hopf point and has no range; the others are the unknowns.
    pub along: Along,
    /// "straight/HB1", of a task of kind "equilibria".
    pub from: String,
    pub from_at: Place,
    /// At least as many as unknowns.
    pub targets: Vec<Wanted>,
    /// Points of the box from which solutions are looked for. Default 16.
    pub starts: usize,
}

/// A target of a calibration: all have a standard deviation, or none.
#[derive(Clone, Debug)]
pub struct Wanted {
    pub quantity: String,
    pub value: f64,
    pub sigma: Option<f64>,
    pub at: Place,
}

impl Calibration {
    /// The parameters to be found, with their ranges.
    pub fn unknowns(&self) -> Vec<(&str, &Range)> {
        let others = self.along.others.iter().filter_map(|axis| Some((axis.name.as_str(), axis.range.as_ref()?)));
        others.chain([(self.along.free.as_str(), &self.along.range)]).collect()
    }

    /// Names of the numbers that only this task has.
    pub fn columns(&self) -> Vec<String> {
        let mut names = vec!["chi2".to_owned(), "condition".to_owned()];
        names.extend(self.targets.iter().map(|target| format!("residual {}", target.quantity)));
        for (unknown, _) in self.unknowns() {
            names.push(format!("sigma {unknown}"));
            names.extend(self.targets.iter().map(|target| format!("d {unknown}/d {}", target.quantity)));
        }
        names
    }
}

/// `kind = "map"`.
#[derive(Clone, Debug)]
pub struct Map {
    /// Two parameters, both with a range.
    pub along: Along,
    /// Points in the direction of each, ends included. Default 50 and 50.
    pub grid: [usize; 2],
}

/// `kind = "hopf-surface"`.
#[derive(Clone, Debug)]
pub struct Surface {
    /// Three parameters, each with a range.
    pub along: Along,
    /// "straight/HB1".
    pub from: String,
    pub from_at: Place,
    /// How far the surface may leave its tangent planes between points, in parts of the ranges.
    pub tolerance: f64,
}
