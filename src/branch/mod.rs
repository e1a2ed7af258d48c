//! What a study found, as plain data: branches (tables of numbers), special points, and how they are stored.
//!
//! A [`Branch`] knows nothing of the problem that it came from; it can be written, read back, plotted and resumed from.

mod archive;
mod csv;
mod mesh;
mod store;
mod table;

pub use archive::{Array, read_arrays, write_point};
pub use mesh::{read_triangles, write_mesh};
pub use store::{StoreError, is_temporary, write_atomically};
pub use table::{read_branch, write_branch};

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// What kind of solutions the rows of a branch are.
#[derive(Serialize, Deserialize, Clone, Copy, Debug, PartialEq, Eq)]
#[serde(rename_all = "kebab-case")]
pub enum BranchKind {
    Equilibria,
    Cycles,
    HopfCurve,
    FoldCurve,
    BranchPointCurve,
    /// Folds, period doublings and torus bifurcations of cycles.
    LpcCurve,
    PdCurve,
    /// Broken symmetries.
    BpcCurve,
    NsCurve,
    Calibration,
    Map,
    HopfSurface,
    /// A motion in time, or what motions settle on over a parameter.
    Simulation,
}

/// A named column of a branch, with its unit ("" for a pure number).
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Eq)]
pub struct Column {
    pub name: String,
    pub unit: String,
}

impl Column {
    /// The column of its error.
    pub fn error(&self) -> Self {
        Self { name: format!("error {}", self.name), unit: self.unit.clone() }
    }
}

/// One accepted point of a branch. `values` has one entry per column; `None` where a number does not exist.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq, Default)]
pub struct Row {
    /// The label without the branch's name, "HB1", if this is a special point.
    pub label: Option<String>,
    /// `None` where the scene did not ask for stability.
    pub stable: Option<bool>,
    pub values: Vec<Option<f64>>,
}

/// The field's names of special points (AUTO's names, never its integer codes).
#[derive(Serialize, Deserialize, Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum Kind {
    /// Hopf point.
    HB,
    /// Fold.
    LP,
    /// Branch point: two branches cross.
    BP,
    /// Exceptional point: two eigenvalues coalesce, a pair is born or dies on the real axis.
    XP,
    /// Krein collision, 1:1 resonance: two pairs meet on the imaginary axis, where undamped motions are, and leave it.
    KC,
    /// Generalised Hopf (Bautin) point: the first Lyapunov coefficient vanishes.
    GH,
    /// Bogdanov-Takens point: the frequency vanishes.
    BT,
    /// Zero-Hopf point: a real eigenvalue vanishes, too.
    ZH,
    /// Double Hopf point: another pair is on the axis, too.
    HH,
    /// Cusp: two folds meet.
    CP,
    /// Fold of cycles.
    LPC,
    /// Period doubling.
    PD,
    /// Torus (Neimark-Sacker) bifurcation.
    NS,
    /// Branch point of cycles: the breaking of a symmetry included.
    BPC,
    /// Cusp of cycles.
    CPC,
    /// Generalised period doubling: its cubic coefficient vanishes.
    GPD,
    /// Chenciner point: the torus bifurcation's cubic coefficient vanishes.
    CH,
    /// Strong resonances: critical multipliers are the first, second, third or fourth roots of unity.
    R1,
    R2,
    R3,
    R4,
    /// Fold-flip: multipliers +1 and -1.
    LPPD,
    /// Degenerate branch point of cycles on a curve of broken symmetries.
    GBPC,
    /// Fold and broken symmetry at once.
    LPBP,
    /// Broken symmetry and torus at once.
    BPNS,
    /// Fold and torus at once.
    LPNS,
    /// Period doubling and torus at once.
    PDNS,
    /// Cycle that a motion settled on.
    LC,
    /// Event of a motion.
    EV,
    /// User value.
    UZ,
    /// End of the branch.
    EP,
    /// No convergence.
    MX,
}

impl std::fmt::Display for Kind {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{self:?}")
    }
}

/// A point of a branch that has a name: "straight/HB1".
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct SpecialPoint {
    pub label: String,
    pub kind: Kind,
    /// Row of the branch that holds this point.
    pub row: usize,
    /// All parameters of the model at this point.
    pub parameters: BTreeMap<String, f64>,
    pub values: BTreeMap<String, f64>,
    /// Estimates of the total numerical error of entries of `parameters` and `values`.
    pub errors: BTreeMap<String, f64>,
    /// State, mesh, eigenvectors, shapes: what `points/LABEL.npz` holds.
    pub arrays: BTreeMap<String, Array>,
}

impl SpecialPoint {
    /// A point with its name and place, and nothing else yet.
    pub fn new(label: String, kind: Kind, row: usize) -> Self {
        let (parameters, values, errors, arrays) = Default::default();
        Self { label, kind, row, parameters, values, errors, arrays }
    }
}

/// A table of solutions along one curve, or on a surface.
#[derive(Serialize, Deserialize, Clone, Debug, PartialEq)]
pub struct Branch {
    pub name: String,
    pub kind: BranchKind,
    /// The free parameters.
    pub free: Vec<String>,
    pub columns: Vec<Column>,
    pub rows: Vec<Row>,
    pub points: Vec<SpecialPoint>,
    /// Of a surface: triples of rows, counterclockwise.
    #[serde(default)]
    pub triangles: Vec<[usize; 3]>,
}

impl Branch {
    /// A branch without rows.
    pub fn new(name: &str, kind: BranchKind, free: Vec<String>, columns: Vec<Column>) -> Self {
        let (name, rows, points, triangles) = (name.to_owned(), Vec::new(), Vec::new(), Vec::new());
        Self { name, kind, free, columns, rows, points, triangles }
    }

    /// Index of a column by name.
    pub fn column(&self, name: &str) -> Option<usize> {
        self.columns.iter().position(|c| c.name == name)
    }

    /// The columns in which each free parameter is followed: its own, or that of its logarithm if there is one.
    pub fn coordinates(&self) -> Vec<usize> {
        let place = |name: &String| self.column(&format!("log10 {name}")).or(self.column(name));
        self.free.iter().filter_map(place).collect()
    }

    /// The special point "NAME/LABEL" or "LABEL".
    pub fn point(&self, label: &str) -> Option<&SpecialPoint> {
        let short = |l: &str| l.rsplit('/').next().unwrap_or(l).to_owned();
        self.points.iter().find(|p| short(&p.label) == short(label))
    }
}
