//! The covering of surfaces by charts: closed surfaces, boxes, curvature.

use faer::Mat;
use hopfline::continuation::{Bound, Cover, CoverControl, Factored, Surface};
use hopfline::linalg::{Lu, Singular};
use std::collections::BTreeMap;
use std::f64::consts::PI;
use std::sync::Arc;

type Equation = dyn Fn(&[f64]) -> (f64, [f64; 3]) + Send + Sync;

/// f(x) = 0 in three dimensions, with the gradient of f.
#[derive(Clone)]
struct Implicit(Arc<Equation>);

struct Dense(Lu<f64>);

impl Factored for Dense {
    fn solve(&self, right: &mut [f64]) {
        self.0.solve(right);
    }
}

impl Surface for Implicit {
    type Factors = Dense;

    fn residual(&self, x: &[f64], r: &mut [f64]) {
        r[0] = (self.0)(x).0;
    }

    fn factor(&self, x: &[f64], rows: [&[f64]; 2]) -> Result<Dense, Singular> {
        let (_, gradient) = (self.0)(x);
        let matrix = Mat::from_fn(3, 3, |i, j| if i == 0 { gradient[j] } else { rows[i - 1][j] });
        Ok(Dense(Lu::new(matrix.as_ref())?))
    }

    fn weights(&self) -> &[f64] {
        &[1.0; 3]
    }
}

fn sphere() -> Implicit {
    Implicit(Arc::new(|x| (x[0] * x[0] + x[1] * x[1] + x[2] * x[2] - 1.0, [2.0 * x[0], 2.0 * x[1], 2.0 * x[2]])))
}

/// Large radius 1, small radius 0.4.
fn torus() -> Implicit {
    Implicit(Arc::new(|x| {
        let rho = x[0].hypot(x[1]);
        let away = rho - 1.0;
        (away * away + x[2] * x[2] - 0.16, [2.0 * away * x[0] / rho, 2.0 * away * x[1] / rho, 2.0 * x[2]])
    }))
}

fn covered(surface: &Implicit, x: [f64; 3], bounds: Vec<Bound>, tolerance: f64, largest: f64) -> Cover<Implicit> {
    let control = CoverControl { tolerance, largest };
    let mut cover = Cover::start(surface, &x, &[0, 1, 2], bounds, control).unwrap();
    while cover.step() {
        assert!(cover.charts.len() < 20_000, "the covering does not end");
    }
    assert!(cover.failures.is_empty(), "{:?}", cover.failures);
    for chart in &cover.charts {
        // The corrector stops at steps of 1e-11.
        assert!((surface.0)(&chart.x).0.abs() < 1e-10);
    }
    cover
}

/// All edges with the triangles on both sides, as often as they are passed each way.
fn edges(triangles: &[[usize; 3]]) -> BTreeMap<(usize, usize), (usize, usize)> {
    let mut edges = BTreeMap::new();
    for &[a, b, c] in triangles {
        for (i, j) in [(a, b), (b, c), (c, a)] {
            let passed: &mut (usize, usize) = edges.entry((i.min(j), i.max(j))).or_default();
            if i < j { passed.0 += 1 } else { passed.1 += 1 }
        }
    }
    edges
}

fn cross(a: [f64; 3], b: [f64; 3]) -> [f64; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Area and least angle (degrees) of the triangles.
fn measured(cover: &Cover<Implicit>, triangles: &[[usize; 3]]) -> (f64, f64) {
    let (mut area, mut least) = (0.0, 180.0_f64);
    for t in triangles {
        let p = t.map(|i| [cover.charts[i].x[0], cover.charts[i].x[1], cover.charts[i].x[2]]);
        let side = |a: usize, b: usize| [0, 1, 2].map(|k| p[b][k] - p[a][k]);
        let size = |v: [f64; 3]| (v[0] * v[0] + v[1] * v[1] + v[2] * v[2]).sqrt();
        area += 0.5 * size(cross(side(0, 1), side(0, 2)));
        for k in 0..3 {
            let (u, v) = (side(k, (k + 1) % 3), side(k, (k + 2) % 3));
            let dot: f64 = (0..3).map(|k| u[k] * v[k]).sum();
            least = least.min((dot / size(u) / size(v)).acos().to_degrees());
        }
    }
    (area, least)
}

/// V - E + F.
fn euler(cover: &Cover<Implicit>, triangles: &[[usize; 3]]) -> i64 {
    cover.charts.len() as i64 - edges(triangles).len() as i64 + triangles.len() as i64
}

#[test]
fn closed_surfaces_are_closed_and_areas_converge_at_second_order() {
    let exact = [4.0 * PI, 4.0 * PI * PI * 0.4];
    for (surface, x, characteristic, exact) in
        [(sphere(), [0.6, 0.0, 0.8], 2, exact[0]), (torus(), [1.4, 0.0, 0.0], 0, exact[1])]
    {
        let mut errors = Vec::new();
        for tolerance in [2e-2, 5e-3, 1.25e-3] {
            let cover = covered(&surface, x, Vec::new(), tolerance, 1.0);
            let triangles = cover.triangles();
            let (area, angle) = measured(&cover, &triangles);
            println!(
                "{tolerance}: {} charts, {} triangles, area {area}, least angle {angle}, {:?}",
                cover.charts.len(),
                triangles.len(),
                cover.counts
            );
            assert!(
                edges(&triangles).values().all(|passed| *passed == (1, 1)),
                "an edge has not one triangle each way"
            );
            assert_eq!(euler(&cover, &triangles), characteristic);
            assert!(angle > 15.0, "{angle}");
            errors.push((exact - area) / exact);
        }
        // The tolerance falls as the radius squared.
        println!("{errors:?}");
    }
}
