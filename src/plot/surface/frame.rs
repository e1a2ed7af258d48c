//! The box about a surface: its three far sides with a grid, and axes along its near edges.

use super::Page;
use super::mesh::Mesh;
use super::view::{HEIGHT, Vector, View};
use crate::plot::PlotError;
use crate::plot::axis::{Axis, Direction};
use crate::plot::canvas::{Align, Font};
use crate::plot::geometry::{Point, Rect};
use crate::plot::style::{FRAME_WIDTH, GRID, GRID_WIDTH, INK, LABEL_SIZE, PANE, TICK_SIZE, ZERO};
use crate::plot::text;

const TICK: f64 = 5.0;
const GAP: f64 = 5.0;

pub struct Frame {
    /// Outlines of the far sides, and lines of their grids.
    panes: Vec<[Point; 4]>,
    grid: Vec<[Point; 2]>,
    edges: Vec<[Point; 2]>,
    ticks: Vec<[Point; 2]>,
    labels: Vec<Label>,
}

struct Label {
    text: String,
    place: Rect,
    font: Font,
}

impl Frame {
    pub fn new(mesh: &Mesh, view: &View) -> Frame {
        // On which side of the cube the eye is, in each direction.
        let near = view.toward.map(|t| if t >= 0.0 { 0.5 } else { -0.5 });
        let mut frame =
            Frame { panes: Vec::new(), grid: Vec::new(), edges: Vec::new(), ticks: Vec::new(), labels: Vec::new() };
        let at = |pairs: [(usize, f64); 3]| {
            let mut v: Vector = [0.0; 3];
            pairs.iter().for_each(|(k, x)| v[*k] = *x);
            view.at(v)
        };
        let ends = [-0.5, 0.5].map(|z| view.at([0.0, 0.0, z])).map(|p| p.1);
        let axes: Vec<Axis> = (0..3)
            .map(|k| {
                let (low, high) = mesh.axes[k].2;
                let mut from = [0.0; 3];
                let mut to = [0.0; 3];
                (from[k], to[k]) = (-0.5, 0.5);
                let (a, b) = (view.at(from), view.at(to));
                let direction = if k == 2 { Direction::Up } else { Direction::Across };
                let pixels = if k == 2 { (ends[0] - ends[1]).abs() } else { (b.0 - a.0).hypot(b.1 - a.1) };
                Axis::new(low, high, pixels.max(60.0), direction)
            })
            .collect();
        for (k, near) in near.iter().enumerate() {
            let (i, j) = ((k + 1) % 3, (k + 2) % 3);
            let far = if k == 2 { -0.5 } else { -near };
            frame.panes.push(
                [(-0.5, -0.5), (0.5, -0.5), (0.5, 0.5), (-0.5, 0.5)].map(|(x, y)| at([(k, far), (i, x), (j, y)])),
            );
            for (along, across) in [(i, j), (j, i)] {
                for tick in &axes[along].ticks {
                    let x = axes[along].place(tick.value) - 0.5;
                    frame.grid.push([-0.5, 0.5].map(|y| at([(k, far), (along, x), (across, y)])));
                }
            }
        }
        for (k, axis) in axes.iter().enumerate().take(2) {
            let other = 1 - k;
            let foot = |x: f64, out: f64| at([(k, x), (other, near[other] * (1.0 + out)), (2, -0.5)]);
            frame.edges.push([foot(-0.5, 0.0), foot(0.5, 0.0)]);
            let (edge, beyond) = (foot(0.0, 0.0), foot(0.0, 1.0));
            frame.axis(axis, &mesh.axes[k], &|x| foot(x, 0.0), unit(edge, beyond));
        }
        // The vertical axis stands at the left.
        let corners = [(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)];
        let left = corners.into_iter().min_by(|a, b| {
            let x = |(x, y): (f64, f64)| view.at([x, y, 0.0]).0;
            x(*a).total_cmp(&x(*b))
        });
        let (x, y) = left.unwrap_or((-0.5, -0.5));
        frame.edges.push([view.at([x, y, -0.5]), view.at([x, y, 0.5])]);
        if HEIGHT * view.up[2] > 0.05 {
            frame.axis(&axes[2], &mesh.axes[2], &|z| view.at([x, y, z]), (-1.0, 0.0));
        }
        frame
    }

    /// Ticks and texts of one axis; `out` is the way out of the box.
    fn axis(
        &mut self,
        axis: &Axis,
        (name, unit, _): &(String, String, (f64, f64)),
        at: &dyn Fn(f64) -> Point,
        out: Point,
    ) {
        let moved = |p: Point, by: f64| (p.0 + by * out.0, p.1 + by * out.1);
        let tall = TICK_SIZE * 0.75;
        let mut reach = 0.0_f64;
        for tick in &axis.ticks {
            let foot = at(axis.place(tick.value) - 0.5);
            self.ticks.push([foot, moved(foot, TICK)]);
            let width = text::width(&tick.text, TICK_SIZE);
            // As far out as the text needs to clear the tick in this direction.
            let half = (0.5 * width * out.0.abs()).hypot(0.5 * tall * out.1.abs());
            let centre = moved(foot, TICK + GAP + half);
            reach = reach.max(TICK + GAP + 2.0 * half);
            let place = Rect::centred(centre, width, tall);
            let font = Font::new(TICK_SIZE, Align::Centre, INK);
            self.labels.push(Label { text: tick.text.clone(), place, font });
        }
        let name = text::with_unit(&text::readable(name), unit, axis.power);
        let width = text::width(&name, LABEL_SIZE);
        let mut font = Font::new(LABEL_SIZE, Align::Centre, INK);
        let middle = at(0.0);
        let place = if out.1 == 0.0 {
            font.upright = true;
            Rect::centred(moved(middle, reach + GAP + 0.6 * LABEL_SIZE), LABEL_SIZE, width)
        } else {
            // Beside the middle of the edge, its nearest corner a little beyond the ticks' texts.
            let corner = moved(middle, reach + GAP + 0.5 * LABEL_SIZE);
            let centre = (corner.0 + 0.5 * width * out.0.clamp(-1.0, 1.0), corner.1 + 0.5 * LABEL_SIZE * out.1);
            Rect::centred(centre, width, LABEL_SIZE)
        };
        self.labels.push(Label { text: name, place, font });
    }

    /// The room that everything takes.
    pub fn extent(&self) -> Rect {
        let mut extent =
            Rect { left: f64::INFINITY, top: f64::INFINITY, right: f64::NEG_INFINITY, bottom: f64::NEG_INFINITY };
        let corners = self.panes.iter().flatten().copied();
        let labels = self.labels.iter().flat_map(|label| {
            let Rect { left, top, right, bottom } = label.place;
            [(left, top), (right, bottom)]
        });
        for (x, y) in corners.chain(labels) {
            extent.left = extent.left.min(x);
            extent.right = extent.right.max(x);
            extent.top = extent.top.min(y);
            extent.bottom = extent.bottom.max(y);
        }
        extent
    }

    pub(super) fn draw_back(&self, page: &mut Page) -> Result<(), PlotError> {
        for pane in &self.panes {
            page.fill(pane, PANE)?;
        }
        for line in &self.grid {
            page.curves(&[line.to_vec()], GRID_WIDTH, GRID)?;
        }
        for pane in &self.panes {
            let [a, b, c, d] = *pane;
            page.curves(&[vec![a, b, c, d, a]], GRID_WIDTH, ZERO)?;
        }
        Ok(())
    }

    pub(super) fn draw_labels(&self, page: &mut Page) -> Result<(), PlotError> {
        for line in self.edges.iter().chain(&self.ticks) {
            page.curves(&[line.to_vec()], FRAME_WIDTH, INK)?;
        }
        for label in &self.labels {
            let centre = page.moved(label.place.centre());
            page.canvas.text(&label.text, centre, label.font)?;
        }
        Ok(())
    }
}

fn unit(from: Point, to: Point) -> Point {
    let (dx, dy) = (to.0 - from.0, to.1 - from.1);
    let size = dx.hypot(dy).max(f64::MIN_POSITIVE);
    (dx / size, dy / size)
}
