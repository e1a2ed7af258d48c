//! `hopfline check`: what would be computed, what is left out, and why.

use super::{RunError, ready};
use crate::linalg::Structure;
use crate::scene::{CycleKind, Scene, TaskKind};
use std::fmt::Write;

/// The plan of a scene, for people.
pub fn plan(scene: &Scene) -> Result<String, RunError> {
    let ready = ready(scene, &[])?;
    let mut out = String::new();
    let _ = writeln!(out, "{}: {}", ready.scene.path.display(), ready.scene.title);
    let name = if scene.model.text.is_some() { "written in the scene," } else { &scene.model.name };
    let bands = match ready.study.structure() {
        Structure::Dense => String::new(),
        Structure::Banded { lower, upper } => format!(", each coupled to {lower} before and {upper} after it"),
        Structure::Sparse(pattern) => format!(", coupled by {} entries", pattern.entries()),
    };
    let _ = writeln!(out, "model {name} with {} unknowns{bands}", ready.study.dim());
    let parameters = ready.study.parameters();
    for (name, value, unit, tie) in &parameters {
        let tie = tie.as_ref().map_or(String::new(), |tie| format!("  = {tie}"));
        let free = ready.tasks.iter().any(|(task, _)| {
            let along = task.kind.along();
            &along.free == name || along.others.iter().any(|axis| &axis.name == name)
        });
        let note = if free { "  (free)" } else { "" };
        let _ = writeln!(out, "  {name:6} {value:12} {unit}{tie}{note}");
    }
    let optional = crate::models::find(&scene.model.name).map_or(&[] as &[&str], |model| model.optional);
    let zero: Vec<&str> = parameters.iter().filter(|(_, x, ..)| *x == 0.0).map(|(name, ..)| name.as_str()).collect();
    let zero: Vec<&str> = zero.into_iter().filter(|name| optional.contains(name)).collect();
    if !zero.is_empty() {
        let _ = writeln!(out, "  terms left out, their coefficient being zero: {}", zero.join(", "));
    }
    for (task, prepared) in &ready.tasks {
        let along = task.kind.along();
        let others = along.others.iter().map(|axis| (&axis.name, axis.range.as_ref()));
        let free: Vec<String> = others
            .chain([(&along.free, Some(&along.range))])
            .map(|(name, range)| match range {
                Some(range) => format!("{name} from {} to {}", range.from, range.to),
                None => name.clone(),
            })
            .collect();
        let free = if along.free.is_empty() { String::new() } else { format!(" in {}", free.join(" and ")) };
        let _ = writeln!(out, "task {}: {}{free}", task.name, task.kind.name());
        let yes_no = |flag: bool, what: String, why: &str| {
            if flag { format!("  computed: {what}\n") } else { format!("  left out: {what} ({why})\n") }
        };
        match &task.kind {
            TaskKind::Equilibria(e) => {
                if let Some((from, _)) = &e.from {
                    let _ = writeln!(out, "  computed: the branch from {from}, both ways");
                }
                let detect = e.detect.iter().any(|kind| kind == "HB");
                let count = if detect { e.spectrum.max(4) } else { e.spectrum };
                out +=
                    &yes_no(count > 0, format!("{count} leading eigenvalues at every point"), "no spectrum, no detect");
                out += &yes_no(detect, "Hopf points with their normal form".into(), "detect has no HB");
                let detects = |kind: &str| e.detect.iter().any(|known| known == kind);
                out += &yes_no(detects("LP"), "folds with their normal form".into(), "detect has no LP");
                let points = "branch points with their normal form, from a determinant's sign at every point";
                out += &yes_no(detects("BP"), points.into(), "detect has no BP");
            }
            TaskKind::Diagram(d) => {
                let more = if d.deflate.is_empty() { "" } else { " and those that deflation finds" };
                let _ = writeln!(
                    out,
                    "  computed: branches from the model's start and {} states{more}, and all that branch off within {} switches, \
                     at most {}",
                    d.states.len(),
                    d.depth,
                    d.max_branches
                );
                let count = d.equilibria.spectrum.max(4);
                let _ = writeln!(
                    out,
                    "  computed: {count} leading eigenvalues at every point; Hopf points, folds and branch points with their normal form"
                );
                out += &yes_no(d.cycles.is_some(), "cycles from every Hopf point".into(), "cycles = false");
            }
            TaskKind::FoldCurve(curve) => {
                let _ = writeln!(out, "  computed: folds from {}, both ways along the curve", curve.from);
                out += "  computed: points of codimension two (CP, BT, ZH)\n";
            }
            TaskKind::BranchPointCurve(curve) => {
                let _ = writeln!(out, "  computed: branch points from {}, both ways along the curve", curve.from);
                out += "  computed: imperfection, which is zero where branches do cross\n";
            }
            TaskKind::CycleCurve(kind, curve) => {
                let what = match kind {
                    CycleKind::Lpc => "folds of cycles",
                    CycleKind::Pd => "period doublings",
                    CycleKind::Bpc => "broken symmetries of cycles",
                    CycleKind::Ns => "torus bifurcations",
                };
                let points = kind.found().join(", ");
                let _ = writeln!(
                    out,
                    "  computed: {what} from {}, both ways along the curve, with their normal form",
                    curve.from
                );
                let _ = writeln!(out, "  computed: points of codimension two ({points})");
            }
            TaskKind::Map(map) => {
                let [m, n] = map.grid;
                let _ = writeln!(out, "  computed: the rightmost eigenvalue at {m} x {n} points");
            }
            TaskKind::HopfCurve(curve) => {
                let _ = writeln!(
                    out,
                    "  computed: Hopf points from {}, both ways along the curve, with their normal form",
                    curve.from
                );
                out += "  computed: points of codimension two (GH, BT, ZH, HH)\n";
            }
            TaskKind::Calibration(c) => {
                let targets: Vec<String> = c.targets.iter().map(|t| format!("{} = {}", t.quantity, t.value)).collect();
                let (from, starts) = (&c.from, c.starts);
                let _ = writeln!(
                    out,
                    "  computed: where {from} has {}, from {starts} starts in the box",
                    targets.join(", ")
                );
            }
            TaskKind::Simulate(motion) => {
                let method = if motion.sdirk { "ESDIRK3(4)" } else { "BDF" };
                let [from, to] = motion.time;
                let count = motion.over.as_ref().map_or(1, |(_, values)| values.len());
                let _ = writeln!(
                    out,
                    "  computed: {count} motion(s) from t = {from} to {to} by {method}, local errors of {:e} of each unknown and \
                     {:e} of the largest",
                    motion.tolerance, motion.absolute
                );
                for event in &motion.events {
                    let _ = writeln!(
                        out,
                        "  computed: where {} = {} (EV), direction {}",
                        event.of, event.value, event.direction
                    );
                }
                let why = "a parameter changes all the time";
                out += &yes_no(motion.ramp.is_none(), "steady states, cycles and closed curves of returns".into(), why);
            }
            TaskKind::HopfSurface(surface) => {
                let _ = writeln!(
                    out,
                    "  computed: the surface of Hopf points from {}, to {} of the ranges, with their normal form",
                    surface.from, surface.tolerance
                );
            }
            TaskKind::Cycles(c) => {
                let points = if c.gauss { "Gauss" } else { "Radau" };
                let _ = writeln!(
                    out,
                    "  computed: cycles from {}, {} of degree {} ({points} points)",
                    c.from,
                    c.intervals.map_or("as many intervals as the start needs".to_owned(), |n| format!("{n} intervals")),
                    c.degree
                );
                let half = c.symmetry && crate::problem::Problem::reflection(&*prepared.problem).is_some();
                out += &yes_no(!half, "the second half of each period".into(), "symmetry gives it");
                let multipliers = c.multipliers > 0;
                out +=
                    &yes_no(multipliers, "Floquet multipliers and stability".into(), "multipliers are not asked for");
                for (kind, what) in [
                    ("LPC", "folds of cycles"),
                    ("PD", "period doublings"),
                    ("NS", "torus bifurcations"),
                    ("BPC", "branch points of cycles"),
                ] {
                    let asked = c.detect.iter().any(|known| known == kind);
                    out += &yes_no(asked, format!("{what} ({kind})"), &format!("detect has no {kind}"));
                }
            }
        }
        let of_cycles = matches!(task.kind, TaskKind::CycleCurve(..));
        let of_states = matches!(
            task.kind,
            TaskKind::Equilibria(_) | TaskKind::Diagram(_) | TaskKind::FoldCurve(_) | TaskKind::BranchPointCurve(_)
        );
        if of_cycles || of_states || matches!(task.kind, TaskKind::Cycles(_) | TaskKind::Simulate(_)) {
            let list = ready.study.observables();
            let wanted: Vec<&str> = prepared.observables.iter().map(|&i| list[i].name).collect();
            let others: Vec<&str> = list.iter().map(|o| o.name).filter(|name| !wanted.contains(name)).collect();
            for (names, taken, why) in
                [(wanted, true, ""), (others, false, "no column, figure or expectation uses them")]
            {
                if !names.is_empty() {
                    out += &yes_no(taken, format!("observables {}", names.join(", ")), why);
                }
            }
        }
        let refined = crate::problem::Problem::refined(&*prepared.problem).is_some();
        let estimates = "error estimates on a refined discretisation".to_owned();
        out += &match (along.errors, &task.kind) {
            (false, _) => yes_no(false, estimates, "errors = false"),
            // Cycles always have a degree more in time.
            (true, TaskKind::CycleCurve(..) | TaskKind::Cycles(_)) => yes_no(true, estimates, ""),
            (true, TaskKind::Simulate(_)) => {
                yes_no(true, "errors of cycles by a second run with ten times the tolerance".into(), "")
            }
            (true, TaskKind::FoldCurve(_)) => yes_no(false, estimates, "folds have none"),
            (true, TaskKind::BranchPointCurve(_)) => yes_no(false, estimates, "curves of branch points have none"),
            (true, _) => yes_no(refined, estimates, "the model has no finer discretisation"),
        };
    }
    for figure in &scene.figures {
        let _ = writeln!(out, "figure {}: {}", figure.name, figure.kind);
    }
    if let Some(study) = &scene.bench {
        let settings: usize = study.families.iter().map(|family| family.variants.len()).sum();
        let (numbers, families) = (study.quantities.len(), study.families.len());
        let _ = writeln!(
            out,
            "study: {numbers} numbers, {families} families with {settings} settings (computed by hopfline bench alone)"
        );
    }
    Ok(out)
}
