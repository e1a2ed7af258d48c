//! Points and rectangles on the page, in CSS pixels; y points down.

pub type Point = (f64, f64);

#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rect {
    pub left: f64,
    pub top: f64,
    pub right: f64,
    pub bottom: f64,
}

impl Rect {
    pub fn new(left: f64, top: f64, width: f64, height: f64) -> Rect {
        Rect { left, top, right: left + width, bottom: top + height }
    }

    pub fn centred((x, y): Point, width: f64, height: f64) -> Rect {
        Rect::new(x - width / 2.0, y - height / 2.0, width, height)
    }

    pub fn width(&self) -> f64 {
        self.right - self.left
    }

    pub fn height(&self) -> f64 {
        self.bottom - self.top
    }

    pub fn centre(&self) -> Point {
        ((self.left + self.right) / 2.0, (self.top + self.bottom) / 2.0)
    }

    pub fn grown(&self, by: f64) -> Rect {
        Rect { left: self.left - by, top: self.top - by, right: self.right + by, bottom: self.bottom + by }
    }

    /// The four corners and the first again.
    pub fn outline(&self) -> [Point; 5] {
        [
            (self.left, self.top),
            (self.right, self.top),
            (self.right, self.bottom),
            (self.left, self.bottom),
            (self.left, self.top),
        ]
    }

    pub fn contains(&self, (x, y): Point) -> bool {
        x >= self.left && x <= self.right && y >= self.top && y <= self.bottom
    }

    pub fn holds(&self, other: &Rect) -> bool {
        self.contains((other.left, other.top)) && self.contains((other.right, other.bottom))
    }

    pub fn overlaps(&self, other: &Rect) -> bool {
        self.left < other.right && other.left < self.right && self.top < other.bottom && other.top < self.bottom
    }

    /// Distance of a point from the nearest point of the rectangle.
    pub fn distance(&self, (x, y): Point) -> f64 {
        let nearest = (x.max(self.left).min(self.right), y.max(self.top).min(self.bottom));
        distance((x, y), nearest)
    }

    /// The part of a segment inside (Liang and Barsky).
    pub fn cut(&self, a: Point, b: Point) -> Option<(Point, Point)> {
        let (dx, dy) = (b.0 - a.0, b.1 - a.1);
        let (mut enter, mut leave) = (0.0_f64, 1.0_f64);
        let sides = [(-dx, a.0 - self.left), (dx, self.right - a.0), (-dy, a.1 - self.top), (dy, self.bottom - a.1)];
        for (slope, room) in sides {
            if slope == 0.0 {
                if room < 0.0 {
                    return None;
                }
            } else if slope < 0.0 {
                enter = enter.max(room / slope);
            } else {
                leave = leave.min(room / slope);
            }
        }
        let at = |t: f64| (a.0 + t * dx, a.1 + t * dy);
        (enter <= leave).then(|| (if enter > 0.0 { at(enter) } else { a }, if leave < 1.0 { at(leave) } else { b }))
    }

    /// Length of the parts of a curve inside.
    pub fn length_of(&self, curve: &[Point]) -> f64 {
        curve
            .windows(2)
            .filter_map(|pair| match *pair {
                [a, b] => self.cut(a, b),
                _ => None,
            })
            .map(|(a, b)| distance(a, b))
            .sum()
    }
}

pub fn distance(a: Point, b: Point) -> f64 {
    (b.0 - a.0).hypot(b.1 - a.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn segments_are_cut_at_the_edges() {
        let rect = Rect::new(0.0, 0.0, 10.0, 10.0);
        let cut = rect.cut((-10.0, 5.0), (20.0, 5.0));
        assert_eq!(cut, Some(((0.0, 5.0), (10.0, 5.0))));
        assert_eq!(rect.cut((-5.0, 0.0), (0.0, -5.0)), None);
        assert_eq!(rect.cut((3.0, 20.0), (3.0, 30.0)), None);
        let inside = ((1.0, 2.0), (3.0, 4.0));
        assert_eq!(rect.cut(inside.0, inside.1), Some(inside));
        assert_eq!(rect.length_of(&[(-10.0, 5.0), (20.0, 5.0), (20.0, 9.0), (5.0, 9.0)]), 15.0);
    }
}
