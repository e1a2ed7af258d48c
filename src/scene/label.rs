//! Labels of special points, "straight/HB1": what they name, and whether it can exist.

use super::{Fault, Task, TaskKind};

/// Kinds of points that a scene can refer to.
pub(super) const POINT_KINDS: [&str; 31] = [
    "HB", "LP", "BP", "KC", "XP", "UZ", "EP", "LC", "EV", "GH", "BT", "ZH", "HH", "CP", "LPC", "PD", "NS", "BPC",
    "CPC", "GPD", "CH", "R1", "R2", "R3", "R4", "LPPD", "LPNS", "PDNS", "GBPC", "LPBP", "BPNS",
];

/// "straight/HB1": the first Hopf point of the task "straight".
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Label<'a> {
    pub task: &'a str,
    pub kind: &'a str,
    /// Counts from 1.
    pub number: usize,
}

impl<'a> Label<'a> {
    pub fn parse(text: &'a str) -> Option<Label<'a>> {
        let (task, point) = text.rsplit_once('/')?;
        // The number begins where digits alone are left: "LPC1" is no LP, "R11" the first R1.
        let (kind, digits) = POINT_KINDS.iter().find_map(|kind| {
            let digits = point.strip_prefix(kind)?;
            let number = !digits.starts_with('0') && digits.bytes().all(|byte| byte.is_ascii_digit());
            number.then_some((*kind, digits))
        })?;
        let number = digits.parse().ok()?;
        is_name(task).then_some(Label { task, kind, number })
    }
}

/// Whether the text can name a task or figure: names go into labels and file names.
pub(super) fn is_name(text: &str) -> bool {
    let allowed = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    !text.is_empty() && text.chars().all(allowed)
}

/// A task that is known by name before it is read: its line, to say where it comes too late.
pub(super) struct Announced {
    pub name: String,
    pub line: Option<usize>,
}

/// The task that a branch, or a point of it, belongs to: its own, or the diagram that found it, whose branches are named
/// "all-1", "all-2", ...
pub fn owner<'a>(tasks: &'a [Task], name: &str) -> Option<&'a Task> {
    let branch = name.split('/').next()?;
    tasks
        .iter()
        .find(|task| task.name == branch && !matches!(task.kind, TaskKind::Diagram(_)))
        .or_else(|| tasks.iter().find(|task| matches!(task.kind, TaskKind::Diagram(_)) && owned(&task.name, branch)))
}

/// Whether a name is that of a branch of a diagram.
pub(super) fn owned(diagram: &str, branch: &str) -> bool {
    let number = branch.strip_prefix(diagram).and_then(|rest| rest.strip_prefix('-'));
    number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
}

/// Refuses a label whose task is not among those read so far, or finds no such points.
pub(super) fn check(text: &str, read: &[Task], announced: &[Announced]) -> Result<(), Fault> {
    let first = announced.first().map_or("straight", |task| &task.name);
    let Some(label) = Label::parse(text) else {
        return Err(Fault::Label { found: text.to_owned(), example: format!("{first}/HB1") });
    };
    if let Some(diagram) = read.iter().find(|task| task.name == label.task && matches!(task.kind, TaskKind::Diagram(_)))
    {
        let (name, rest) = (&diagram.name, text.rsplit('/').next().unwrap_or_default());
        let message = format!(
            "{name:?} is a diagram of several branches, {name}-1, {name}-2, ...; write for example {name}-1/{rest}"
        );
        return Err(Fault::Other(message));
    }
    let Some(task) = owner(read, label.task) else {
        return Err(match announced.iter().find(|later| later.name == label.task) {
            Some(later) => Fault::Later { name: later.name.clone(), at: later.line },
            None => Fault::unknown("task", label.task, announced.iter().map(|task| task.name.as_str())),
        });
    };
    match obstacle(task, label.kind) {
        None => Ok(()),
        Some(advice) => Err(Fault::NotProduced { task: task.name.clone(), kind: label.kind.to_owned(), advice }),
    }
}

/// Why the task finds no points of this kind, as advice; None if it may find some.
fn obstacle(task: &Task, kind: &str) -> Option<String> {
    let along = task.kind.along();
    match (kind, &task.kind) {
        ("UZ", TaskKind::Calibration(_)) => None,
        (_, TaskKind::Calibration(_)) => Some(" (its solutions are UZ1, UZ2, ...)".to_owned()),
        (_, TaskKind::Map(_)) => Some(" (it is a map, without points)".to_owned()),
        (_, TaskKind::HopfSurface(_)) => {
            Some(" (a surface has no points with names; start from where it starts)".to_owned())
        }
        ("EP", _) => None,
        ("LC", TaskKind::Simulate(_)) => None,
        ("EV", TaskKind::Simulate(task)) if !task.events.is_empty() => None,
        ("EV", TaskKind::Simulate(_)) => Some("; give it events = [{ of = \"x\", value = 0 }]".to_owned()),
        (_, TaskKind::Simulate(_)) => Some(
            " (a simulation leaves EP1, LC1 where it settles on a cycle, and EV1, EV2, ... at its events)".to_owned(),
        ),
        ("HB" | "LP" | "BP" | "KC" | "XP" | "UZ", TaskKind::Diagram(_)) => None,
        (_, TaskKind::Diagram(_)) => Some(" (it finds HB, LP, BP, KC, XP, UZ and EP)".to_owned()),
        ("UZ", _) if along.values.is_empty() => Some(format!("; give it values = {{ {} = [...] }}", along.free)),
        ("UZ", _) => None,
        ("KC" | "XP", TaskKind::Equilibria(task)) => {
            let looks = task.spectrum > 0 || task.detect.iter().any(|known| known == "HB");
            (!looks).then(|| "; give it spectrum = 4".to_owned())
        }
        ("EV", _) => Some(" (events of motions: kind = \"simulate\")".to_owned()),
        ("LC", _) => Some(" (cycles that a simulation settles on: kind = \"simulate\")".to_owned()),
        ("LPC" | "PD" | "NS" | "BPC", TaskKind::Equilibria(_)) => {
            Some(" (these are points of cycles: kind = \"cycles\")".to_owned())
        }
        (_, TaskKind::Equilibria(_)) if !["HB", "LP", "BP"].contains(&kind) => {
            Some(" (points of codimension two are on curves: kind = \"hopf-curve\" or \"fold-curve\")".to_owned())
        }
        (_, TaskKind::Equilibria(task)) => missing(&task.detect, kind),
        ("GH" | "BT" | "ZH" | "HH", TaskKind::HopfCurve(_)) => None,
        (_, TaskKind::HopfCurve(_)) => Some(" (it follows Hopf points: only GH, BT, ZH, HH, UZ and EP)".to_owned()),
        ("CP" | "BT" | "ZH", TaskKind::FoldCurve(_)) => None,
        (_, TaskKind::FoldCurve(_)) => Some(" (it follows folds: only CP, BT, ZH, UZ and EP)".to_owned()),
        (_, TaskKind::BranchPointCurve(_)) => Some(" (it follows branch points: only UZ and EP)".to_owned()),
        (_, TaskKind::CycleCurve(curve, _)) => {
            let found = curve.found();
            (!found.contains(&kind)).then(|| format!(" (it finds only {}, UZ and EP)", found.join(", ")))
        }
        ("LPC" | "PD" | "NS" | "BPC", TaskKind::Cycles(cycles)) => missing(&cycles.detect, kind),
        (_, TaskKind::Cycles(_)) => Some(" (it follows cycles: only LPC, PD, NS, BPC, UZ and EP)".to_owned()),
    }
}

/// What to add to a list of kinds to be detected.
fn missing(detect: &[String], kind: &str) -> Option<String> {
    if detect.iter().any(|known| known == kind) {
        return None;
    }
    let all: Vec<String> = detect.iter().map(|k| format!("{k:?}")).chain([format!("{kind:?}")]).collect();
    Some(format!("; give it detect = [{}]", all.join(", ")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_task_kind_number() {
        let label = Label::parse("two-doublet_1/HB12");
        let expected = Label { task: "two-doublet_1", kind: "HB", number: 12 };
        assert_eq!(label, Some(expected));
        for (text, kind, number) in [("a/LPC2", "LPC", 2), ("a/R11", "R1", 1), ("a/PDNS10", "PDNS", 10)] {
            assert_eq!(Label::parse(text), Some(Label { task: "a", kind, number }));
        }
        for bad in [
            "",
            "/",
            "straight",
            "straight/",
            "/HB1",
            "straight/HB",
            "straight/HB0",
            "straight/HB01",
            "straight/HB+1",
            "straight/PC1",
            "straight/R1",
            "straight/hb1",
            "straight/µ1",
            "a b/HB1",
            "a/b/HB1",
            "straight/HB99999999999999999999999",
        ] {
            assert_eq!(Label::parse(bad), None, "{bad}");
        }
    }
}
