//! Labels next to points: the first free place of several, or none.

use super::geometry::{Point, Rect};
use super::style::SMALL_SIZE;
use super::{marker, text};

/// A pixel of curve under a label counts as much as this many steps down the list of places.
const CROSSING: f64 = 0.5;
/// And so much counts a label that seems to belong to another symbol, because it is clearly nearer to that one.
const MISLEADING: f64 = 20.0;

/// What is already on a panel.
pub struct Placement<'a> {
    frame: Rect,
    curves: &'a [Vec<Point>],
    taken: Vec<Rect>,
    symbols: Vec<Point>,
}

impl<'a> Placement<'a> {
    pub fn new(frame: Rect, curves: &'a [Vec<Point>]) -> Placement<'a> {
        Placement { frame, curves, taken: Vec::new(), symbols: Vec::new() }
    }

    pub fn take(&mut self, rect: Rect) {
        self.taken.push(rect);
    }

    pub fn take_symbol(&mut self, at: Point) {
        self.taken.push(marker::extent(at));
        self.symbols.push(at);
    }

    /// The best of some places for the label of `owner`, given in order of preference: inside the frame, on nothing taken, on little of the
    /// curves. The place is taken then.
    pub fn place(&mut self, owner: Point, places: impl IntoIterator<Item = Rect>) -> Option<Rect> {
        let free = |place: &Rect| self.frame.holds(place) && !self.taken.iter().any(|t| t.overlaps(place));
        let cost = |(order, place): (usize, Rect)| {
            let crossed: f64 = self.curves.iter().map(|c| place.length_of(c)).sum();
            let away = 0.75 * place.distance(owner);
            let misleading = self.symbols.iter().any(|&s| place.distance(s) < away);
            let mislead = if misleading { MISLEADING } else { 0.0 };
            (order as f64 + CROSSING * crossed + mislead, place)
        };
        let best = (places.into_iter().enumerate())
            .filter(|(_, place)| free(place))
            .map(cost)
            .min_by(|a, b| a.0.total_cmp(&b.0));
        let (_, place) = best?;
        self.taken.push(place.grown(1.5));
        Some(place)
    }
}

/// Size of a label.
pub fn size(label: &str) -> (f64, f64) {
    (text::width(label, SMALL_SIZE), 1.05 * SMALL_SIZE)
}

/// Places for a label around a point, near ones first.
pub fn around(point: Point, label: &str) -> impl Iterator<Item = Rect> {
    let (width, height) = size(label);
    let directions: [Point; 8] =
        [(0.0, -1.0), (1.0, -1.0), (-1.0, -1.0), (1.0, 0.0), (-1.0, 0.0), (0.0, 1.0), (1.0, 1.0), (-1.0, 1.0)];
    [5.0, 9.0, 14.0].into_iter().flat_map(move |gap| {
        directions.into_iter().map(move |(dx, dy)| {
            // Letters beside a marker need more room than above or below it.
            let gap = match (dx == 0.0, dy == 0.0) {
                (_, true) => gap + 2.0,
                _ => gap,
            };
            let centre = (point.0 + dx * (width / 2.0 + gap), point.1 + dy * (height / 2.0 + gap));
            Rect::centred(centre, width, height)
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_keep_off_each_other_the_frame_and_the_curve() {
        let frame = Rect::new(0.0, 0.0, 200.0, 100.0);
        let curve = vec![vec![(0.0, 50.0), (200.0, 50.0)]];
        let mut placement = Placement::new(frame, &curve);
        let mut places: Vec<Rect> = Vec::new();
        for i in 0..300 {
            let point = (f64::from(i) * 0.7, 50.0);
            if let Some(place) = placement.place(point, around(point, "HB1")) {
                assert!(frame.holds(&place));
                assert!(places.iter().all(|p| !p.overlaps(&place)));
                places.push(place);
            }
        }
        // Two symbols too close for both labels between them.
        let (left, right) = ((60.0, 50.0), (66.0, 50.0));
        let mut placement = Placement::new(frame, &curve);
        placement.take_symbol(left);
        placement.take_symbol(right);
        for (own, other) in [(left, right), (right, left)] {
            let place = placement.place(own, around(own, "XP1")).unwrap();
            assert!(0.75 * place.distance(own) <= place.distance(other));
        }
        assert!(places.len() > 8 && places.len() < 60, "{}", places.len());
        assert_eq!(places[0].length_of(&curve[0]), 0.0);
    }
}
