//! Sizes and colours that all figures share.

use super::stroke::Pattern;
use plotters::style::RGBColor;

pub const TITLE_SIZE: f64 = 13.5;
pub const LABEL_SIZE: f64 = 13.0;
pub const TICK_SIZE: f64 = 11.5;
pub const SMALL_SIZE: f64 = 11.0;

pub const CURVE_WIDTH: f64 = 1.6;
pub const THIN_WIDTH: f64 = 0.9;
pub const FRAME_WIDTH: f64 = 0.9;
pub const GRID_WIDTH: f64 = 0.6;

pub const INK: RGBColor = RGBColor(0x22, 0x22, 0x22);
pub const GRID: RGBColor = RGBColor(0xE9, 0xE9, 0xE9);
/// Samples of the legend that stand for a line of any colour.
pub const ANY: RGBColor = RGBColor(0x77, 0x77, 0x77);
/// The far sides of a box.
pub const PANE: RGBColor = RGBColor(0xF8, 0xF8, 0xF8);
pub const ZERO: RGBColor = RGBColor(0x99, 0x99, 0x99);
pub const WHITE: RGBColor = RGBColor(0xFF, 0xFF, 0xFF);
pub const EQUILIBRIA: RGBColor = RGBColor(0x00, 0x00, 0x00);

pub const DASHED: Pattern = Pattern { on: 6.0, off: 4.0 };
pub const DOTTED: Pattern = Pattern { on: 1.2, off: 2.8 };

/// Distinct with every common colour blindness (Okabe and Ito), the dark ones first.
const CYCLES: [RGBColor; 6] = [
    RGBColor(0x00, 0x72, 0xB2),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x9E, 0x73),
    RGBColor(0xCC, 0x79, 0xA7),
    RGBColor(0xE6, 0x9F, 0x00),
    RGBColor(0x56, 0xB4, 0xE9),
];

/// Okabe and Ito's, continued by dark ones of Tol's "muted" scheme.
const EIGENVALUES: [RGBColor; 12] = [
    RGBColor(0x00, 0x72, 0xB2),
    RGBColor(0xD5, 0x5E, 0x00),
    RGBColor(0x00, 0x9E, 0x73),
    RGBColor(0xCC, 0x79, 0xA7),
    RGBColor(0xE6, 0x9F, 0x00),
    RGBColor(0x56, 0xB4, 0xE9),
    RGBColor(0x33, 0x22, 0x88),
    RGBColor(0x88, 0x22, 0x55),
    RGBColor(0x99, 0x99, 0x33),
    RGBColor(0x00, 0x00, 0x00),
    RGBColor(0x80, 0x80, 0x80),
    RGBColor(0x80, 0x4A, 0x20),
];

/// From blue over purple to red in equal steps of CIELAB, with lightness growing from 34 to 58: never grey or pale, and
/// in order for the colour-blind and on a grey print.
const PHASES: [RGBColor; 9] = [
    RGBColor(0x00, 0x4C, 0xA9),
    RGBColor(0x50, 0x48, 0xAD),
    RGBColor(0x80, 0x42, 0xA6),
    RGBColor(0xA3, 0x3C, 0x99),
    RGBColor(0xBE, 0x38, 0x89),
    RGBColor(0xD3, 0x3A, 0x78),
    RGBColor(0xE3, 0x3F, 0x64),
    RGBColor(0xEF, 0x47, 0x50),
    RGBColor(0xF5, 0x53, 0x38),
];

/// Colour of the n-th branch of cycles.
pub fn cycles(n: usize) -> RGBColor {
    CYCLES.get(n % CYCLES.len()).copied().unwrap_or(INK)
}

/// Colour and dashes of the n-th eigenvalue branch: twelve colours, then the same dashed.
pub fn eigenvalue(n: usize) -> (RGBColor, Option<Pattern>) {
    let colour = EIGENVALUES.get(n % EIGENVALUES.len()).copied().unwrap_or(INK);
    (colour, (n >= EIGENVALUES.len()).then_some(DASHED))
}

/// Colour of a phase between 0 and 1, from blue to red.
pub fn phase(phase: f64) -> RGBColor {
    ramp(&PHASES, phase)
}

fn ramp(anchors: &[RGBColor], place: f64) -> RGBColor {
    let place = place.clamp(0.0, 1.0) * (anchors.len() - 1) as f64;
    let below = place.floor();
    let anchor = |i: usize| anchors.get(i).copied();
    let a = anchor(below as usize).unwrap_or(INK);
    let b = anchor(below as usize + 1).unwrap_or(a);
    mixed(a, b, place - below)
}

/// From pale to deep in equal steps of lightness; two hues that the colour-blind tell apart.
const SUPERCRITICAL: [RGBColor; 4] =
    [RGBColor(0xE3, 0xEE, 0xF9), RGBColor(0xA6, 0xCB, 0xE8), RGBColor(0x5C, 0xA0, 0xD0), RGBColor(0x1F, 0x6C, 0xAF)];
const SUBCRITICAL: [RGBColor; 4] =
    [RGBColor(0xFD, 0xEB, 0xD3), RGBColor(0xFB, 0xC5, 0x86), RGBColor(0xF0, 0x8F, 0x3C), RGBColor(0xC7, 0x58, 0x0A)];

pub fn ramp_supercritical(place: f64) -> RGBColor {
    ramp(&SUPERCRITICAL, place)
}

pub fn ramp_subcritical(place: f64) -> RGBColor {
    ramp(&SUBCRITICAL, place)
}

pub fn ramp_unknown(place: f64) -> RGBColor {
    ramp(&[GRID, ZERO], place)
}

/// A colour in the light of a lamp, 1 being full.
pub fn shaded(colour: RGBColor, light: f64) -> RGBColor {
    mixed(INK, colour, light)
}

/// Where stability is not known.
pub fn faded(colour: RGBColor) -> RGBColor {
    mixed(colour, RGBColor(0xA8, 0xA8, 0xA8), 0.6)
}

fn mixed(a: RGBColor, b: RGBColor, share: f64) -> RGBColor {
    let mix = |a: u8, b: u8| (f64::from(a) + share * (f64::from(b) - f64::from(a))).round() as u8;
    RGBColor(mix(a.0, b.0), mix(a.1, b.1), mix(a.2, b.2))
}
