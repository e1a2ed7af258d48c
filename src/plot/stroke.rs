//! Curves on the page before they are drawn: thinned, clipped, broken into dashes.

use super::geometry::{Point, Rect, distance};

/// Deviations below this, in pixels, are not worth a point of the file.
const TOLERANCE: f64 = 0.02;
/// Dashes of one curve; a longer curve gets longer dashes.
const MOST_DASHES: f64 = 400.0;

/// Lengths along the curve of what is drawn and what is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pattern {
    pub on: f64,
    pub off: f64,
}

/// Leaves out points that the line between their neighbours passes closely enough (Douglas and Peucker). A curve
/// without extent is a single point.
pub fn thinned(curve: &[Point]) -> Vec<Point> {
    if let Some(&first) = curve.first()
        && curve.iter().all(|&p| distance(first, p) <= TOLERANCE)
    {
        return vec![first];
    }
    let mut near: Vec<Point> = Vec::with_capacity(curve.len());
    for (i, &point) in curve.iter().enumerate() {
        let last = i + 1 == curve.len();
        if last || near.last().is_none_or(|&p| distance(p, point) > TOLERANCE) {
            near.push(point);
        }
    }
    let mut keep = vec![false; near.len()];
    let mut spans = Vec::new();
    if let [first, .., last] = &mut keep[..] {
        (*first, *last) = (true, true);
        spans.push((0, near.len() - 1));
    }
    while let Some((begin, end)) = spans.pop() {
        let Some(&[a, .., b]) = near.get(begin..=end) else {
            continue;
        };
        let inner = (near.iter().enumerate()).take(end).skip(begin + 1);
        let far = inner.map(|(i, &p)| (i, from_segment(p, a, b))).max_by(|x, y| x.1.total_cmp(&y.1));
        if let Some((i, deviation)) = far
            && deviation > TOLERANCE
        {
            if let Some(flag) = keep.get_mut(i) {
                *flag = true;
            }
            spans.push((begin, i));
            spans.push((i, end));
        }
    }
    let kept = near.into_iter().zip(keep).filter(|(_, keep)| *keep);
    kept.map(|(p, _)| p).collect()
}

fn from_segment(p: Point, a: Point, b: Point) -> f64 {
    let (dx, dy) = (b.0 - a.0, b.1 - a.1);
    let square = dx * dx + dy * dy;
    if square == 0.0 {
        return distance(p, a);
    }
    let t = (((p.0 - a.0) * dx + (p.1 - a.1) * dy) / square).clamp(0.0, 1.0);
    distance(p, (a.0 + t * dx, a.1 + t * dy))
}

/// The pieces of a curve inside a rectangle.
pub fn clipped(curve: &[Point], area: &Rect) -> Vec<Vec<Point>> {
    let mut pieces: Vec<Vec<Point>> = Vec::new();
    for pair in curve.windows(2) {
        let &[a, b] = pair else { continue };
        let Some((from, to)) = area.cut(a, b) else {
            continue;
        };
        match pieces.last_mut() {
            Some(piece) if piece.last() == Some(&from) => piece.push(to),
            _ => pieces.push(vec![from, to]),
        }
    }
    pieces
}

/// The dashes of a curve, measured along it from its first point.
pub fn dashes(curve: &[Point], pattern: Pattern) -> Vec<Vec<Point>> {
    let total: f64 = segments(curve).map(|(a, b)| distance(a, b)).sum();
    let stretch = (total / (MOST_DASHES * (pattern.on + pattern.off))).max(1.0);
    let (on, off) = (pattern.on * stretch, pattern.off * stretch);
    let mut dashes = Vec::new();
    let mut dash: Vec<Point> = curve.first().copied().into_iter().collect();
    let (mut drawing, mut left) = (true, on);
    for (a, b) in segments(curve) {
        let length = distance(a, b);
        let mut done = 0.0;
        while length - done > left {
            done += left;
            let t = done / length;
            let point = (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1));
            if drawing {
                dash.push(point);
                dashes.push(std::mem::take(&mut dash));
            } else {
                dash.push(point);
            }
            drawing = !drawing;
            left = if drawing { on } else { off };
        }
        left -= length - done;
        if drawing {
            dash.push(b);
        }
    }
    if drawing && dash.len() > 1 {
        dashes.push(dash);
    }
    dashes
}

fn segments(curve: &[Point]) -> impl Iterator<Item = (Point, Point)> {
    curve.iter().copied().zip(curve.iter().copied().skip(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn thinning_keeps_ends_and_corners() {
        let straight: Vec<Point> = (0..=1000).map(|i| (f64::from(i) * 0.5, 3.0)).collect();
        assert_eq!(thinned(&straight), [(0.0, 3.0), (500.0, 3.0)]);
        let corner = [(0.0, 0.0), (1.0, 0.0), (2.0, 0.0), (2.0, 1.0), (2.0, 2.0)];
        assert_eq!(thinned(&corner), [(0.0, 0.0), (2.0, 0.0), (2.0, 2.0)]);
        assert_eq!(thinned(&[(1.0, 1.0)]), [(1.0, 1.0)]);
        assert_eq!(thinned(&[(1.0, 1.0); 5]), [(1.0, 1.0)]);
        assert!(thinned(&[]).is_empty());
    }

    #[test]
    fn thinning_stays_within_tolerance() {
        let curve: Vec<Point> = (0..2000).map(|i| f64::from(i) * 0.25).map(|x| (x, 100.0 * (x / 40.0).sin())).collect();
        let thin = thinned(&curve);
        assert!(thin.len() < curve.len() / 3, "{}", thin.len());
        for &p in &curve {
            let nearest = segments(&thin).map(|(a, b)| from_segment(p, a, b));
            assert!(nearest.fold(f64::INFINITY, f64::min) <= 2.0 * TOLERANCE);
        }
    }

    #[test]
    fn clipping_breaks_a_curve_where_it_leaves() {
        let area = Rect::new(0.0, 0.0, 10.0, 10.0);
        let curve = [(1.0, 5.0), (5.0, 5.0), (5.0, 20.0), (8.0, 20.0), (8.0, 5.0)];
        let pieces = clipped(&curve, &area);
        assert_eq!(pieces.len(), 2);
        assert_eq!(pieces[0], [(1.0, 5.0), (5.0, 5.0), (5.0, 10.0)]);
        assert_eq!(pieces[1], [(8.0, 10.0), (8.0, 5.0)]);
    }

    #[test]
    fn dashes_go_on_across_points() {
        let curve = [(0.0, 0.0), (1.0, 0.0), (4.0, 0.0), (4.0, 6.0)];
        let dashes = dashes(&curve, Pattern { on: 3.0, off: 2.0 });
        assert_eq!(dashes.len(), 2);
        assert_eq!(dashes[0], [(0.0, 0.0), (1.0, 0.0), (3.0, 0.0)]);
        assert_eq!(dashes[1], [(4.0, 1.0), (4.0, 4.0)]);
    }

    #[test]
    fn a_long_curve_has_a_bounded_number_of_dashes() {
        let zigzag: Vec<Point> = (0..5000).map(|i| (0.0, f64::from(i % 2) * 300.0)).collect();
        let count = dashes(&zigzag, Pattern { on: 6.0, off: 4.0 }).len();
        assert!(count <= MOST_DASHES as usize + 1, "{count}");
    }
}
