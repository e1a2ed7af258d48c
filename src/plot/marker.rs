//! The symbols of special points.

use super::PlotError;
use super::canvas::Canvas;
use super::geometry::{Point, Rect};
use super::style::{INK, WHITE};
use crate::branch::{Branch, Kind};
use std::collections::BTreeMap;

/// A special point as the rows of a branch know it.
pub struct Mark {
    pub row: usize,
    pub kind: Kind,
    /// Without the branch's name.
    pub label: String,
}

/// The special points of a branch in the order of its rows: from its points, and from the labels of rows where there
/// are no points (a branch read from a table has none).
pub fn marks(branch: &Branch) -> Vec<Mark> {
    let mut marks: BTreeMap<(usize, String), Kind> = BTreeMap::new();
    for (row, label) in
        (branch.rows.iter().enumerate()).filter_map(|(i, row)| row.label.as_ref().map(|label| (i, label)))
    {
        if let Some(kind) = kind_of(label) {
            marks.insert((row, label.clone()), kind);
        }
    }
    for point in branch.points.iter().filter(|p| p.row < branch.rows.len()) {
        let label = point.label.rsplit('/').next().unwrap_or_default();
        marks.insert((point.row, label.to_owned()), point.kind);
    }
    let mark = |((row, label), kind)| Mark { row, kind, label };
    marks.into_iter().map(mark).collect()
}

/// The kind that a label begins with: "HB12" is a Hopf point.
fn kind_of(label: &str) -> Option<Kind> {
    const ALL: [Kind; 32] = [
        Kind::HB,
        Kind::LP,
        Kind::BP,
        Kind::XP,
        Kind::KC,
        Kind::GH,
        Kind::BT,
        Kind::ZH,
        Kind::HH,
        Kind::CP,
        Kind::LPC,
        Kind::PD,
        Kind::NS,
        Kind::BPC,
        Kind::CPC,
        Kind::GPD,
        Kind::CH,
        Kind::R1,
        Kind::R2,
        Kind::R3,
        Kind::R4,
        Kind::LPPD,
        Kind::LPNS,
        Kind::PDNS,
        Kind::GBPC,
        Kind::LPBP,
        Kind::BPNS,
        Kind::LC,
        Kind::EV,
        Kind::UZ,
        Kind::EP,
        Kind::MX,
    ];
    ALL.into_iter().find(|kind| {
        let number = label.strip_prefix(&kind.to_string());
        number.is_some_and(|number| !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit()))
    })
}

/// What the legend says; the end of a branch explains itself.
pub fn meaning(kind: Kind) -> Option<&'static str> {
    match kind {
        Kind::HB => Some("Hopf point (HB)"),
        Kind::LP => Some("fold (LP)"),
        Kind::BP => Some("branch point (BP)"),
        Kind::XP => Some("exceptional point (XP)"),
        Kind::KC => Some("two pairs meet on the axis (KC)"),
        Kind::GH => Some("generalised Hopf point (GH)"),
        Kind::BT => Some("Bogdanov-Takens point (BT)"),
        Kind::ZH => Some("zero-Hopf point (ZH)"),
        Kind::HH => Some("double Hopf point (HH)"),
        Kind::CP => Some("cusp (CP)"),
        Kind::LPC => Some("fold of cycles (LPC)"),
        Kind::PD => Some("period doubling (PD)"),
        Kind::NS => Some("torus bifurcation (NS)"),
        Kind::BPC => Some("branch point of cycles (BPC)"),
        Kind::CPC => Some("cusp of cycles (CPC)"),
        Kind::GPD => Some("generalised period doubling (GPD)"),
        Kind::CH => Some("Chenciner point (CH)"),
        Kind::R1 => Some("resonance 1:1 (R1)"),
        Kind::R2 => Some("resonance 1:2 (R2)"),
        Kind::R3 => Some("resonance 1:3 (R3)"),
        Kind::R4 => Some("resonance 1:4 (R4)"),
        Kind::LPPD => Some("fold-flip (LPPD)"),
        Kind::LPNS => Some("fold and torus (LPNS)"),
        Kind::PDNS => Some("period doubling and torus (PDNS)"),
        Kind::GBPC => Some("degenerate branch point of cycles (GBPC)"),
        Kind::LPBP => Some("fold and branch point of cycles (LPBP)"),
        Kind::BPNS => Some("branch point of cycles and torus (BPNS)"),
        Kind::LC => Some("cycle that a motion settled on (LC)"),
        Kind::EV => Some("event (EV)"),
        Kind::UZ => Some("user value (UZ)"),
        Kind::MX => Some("no convergence (MX)"),
        Kind::EP => None,
    }
}

/// Who gets a label first where there is not room for all. Ends of branches get none.
pub fn priority(kind: Kind) -> Option<u8> {
    match kind {
        Kind::HB | Kind::KC => Some(0),
        Kind::MX => Some(2),
        Kind::UZ => Some(3),
        Kind::XP => Some(4),
        Kind::EP => None,
        _ => Some(1),
    }
}

/// The room that a symbol takes.
pub fn extent(point: Point) -> Rect {
    Rect::centred(point, 9.0, 9.0)
}

/// Draws a symbol; `along` is the direction of the curve there, of any length.
pub fn draw(canvas: &mut Canvas, kind: Kind, at: Point, along: Point) -> Result<(), PlotError> {
    let shape = |points: &[Point]| -> Vec<Point> { points.iter().map(|p| (at.0 + p.0, at.1 + p.1)).collect() };
    match kind {
        Kind::HB => {
            canvas.disc(at, 4.6, WHITE)?;
            canvas.disc(at, 3.7, INK)
        }
        Kind::LP | Kind::LPC => solid(canvas, &shape(&SQUARE)),
        Kind::BP | Kind::BPC => solid(canvas, &shape(&CROSSING)),
        Kind::PD => solid(canvas, &shape(&HANGING)),
        Kind::NS => {
            canvas.disc(at, 4.6, INK)?;
            canvas.disc(at, 3.4, WHITE)?;
            canvas.line(&shape(&[(-2.4, 0.0), (2.4, 0.0)]), 1.1, INK)
        }
        Kind::BT | Kind::R1 | Kind::R2 | Kind::R3 | Kind::R4 => solid(canvas, &shape(&STANDING)),
        Kind::GH | Kind::GPD | Kind::GBPC | Kind::CH => {
            canvas.disc(at, 4.6, INK)?;
            canvas.disc(at, 3.4, WHITE)?;
            canvas.disc(at, 1.5, INK)
        }
        Kind::ZH | Kind::LPPD | Kind::LPNS | Kind::PDNS | Kind::LPBP | Kind::BPNS => {
            canvas.fill(&shape(&SQUARE), WHITE)?;
            canvas.line(&shape(&SQUARE), 1.1, INK)
        }
        Kind::UZ | Kind::EV => solid(canvas, &shape(&TRIANGLE)),
        Kind::HH | Kind::LC => {
            canvas.disc(at, 4.6, INK)?;
            canvas.disc(at, 3.4, WHITE)
        }
        Kind::CP | Kind::CPC => {
            let hanging: Vec<Point> = shape(&HANGING);
            canvas.fill(&hanging, WHITE)?;
            canvas.line(&hanging, 1.1, INK)
        }
        Kind::XP => {
            let diamond = shape(&DIAMOND);
            canvas.fill(&diamond, WHITE)?;
            canvas.line(&diamond, 1.1, INK)
        }
        Kind::KC => {
            let diamond = shape(&DIAMOND);
            canvas.line(&diamond, 1.8, WHITE)?;
            canvas.fill(&diamond, INK)
        }
        Kind::MX => {
            canvas.line(&shape(&[(-3.4, -3.4), (3.4, 3.4)]), 1.6, INK)?;
            canvas.line(&shape(&[(-3.4, 3.4), (3.4, -3.4)]), 1.6, INK)
        }
        Kind::EP => {
            let length = along.0.hypot(along.1);
            let across = if length > 0.0 { (-along.1 / length * 3.5, along.0 / length * 3.5) } else { (0.0, 3.5) };
            canvas.line(&shape(&[across, (-across.0, -across.1)]), 1.1, INK)
        }
    }
}

const SQUARE: [Point; 5] = [(-3.3, -3.3), (3.3, -3.3), (3.3, 3.3), (-3.3, 3.3), (-3.3, -3.3)];
/// Two bars that cross.
const CROSSING: [Point; 13] = [
    (-4.4, -1.3),
    (-1.3, -1.3),
    (-1.3, -4.4),
    (1.3, -4.4),
    (1.3, -1.3),
    (4.4, -1.3),
    (4.4, 1.3),
    (1.3, 1.3),
    (1.3, 4.4),
    (-1.3, 4.4),
    (-1.3, 1.3),
    (-4.4, 1.3),
    (-4.4, -1.3),
];
const TRIANGLE: [Point; 4] = [(0.0, -4.2), (3.9, 3.0), (-3.9, 3.0), (0.0, -4.2)];
const HANGING: [Point; 4] = [(0.0, 4.2), (3.9, -3.0), (-3.9, -3.0), (0.0, 4.2)];
const STANDING: [Point; 5] = [(0.0, -4.6), (4.6, 0.0), (0.0, 4.6), (-4.6, 0.0), (0.0, -4.6)];
const DIAMOND: [Point; 5] = [(0.0, -4.2), (4.2, 0.0), (0.0, 4.2), (-4.2, 0.0), (0.0, -4.2)];

/// A filled shape with a white rim, which sets it off from the curve.
fn solid(canvas: &mut Canvas, outline: &[Point]) -> Result<(), PlotError> {
    canvas.line(outline, 1.8, WHITE)?;
    canvas.fill(outline, INK)
}
