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
        Ok(Dense(Lu::new(matrix)?))
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
        let errors = [4e-2, 1e-2, 2.5e-3].map(|tolerance| {
            let cover = covered(&surface, x, Vec::new(), tolerance, 1.0);
            let triangles = cover.triangles();
            let (area, angle) = measured(&cover, &triangles);
            assert!(
                edges(&triangles).values().all(|passed| *passed == (1, 1)),
                "an edge has not one triangle each way"
            );
            assert_eq!(euler(&cover, &triangles), characteristic);
            assert!(angle > 15.0, "{angle}");
            (exact - area) / exact
        });
        // The tolerance falls as the radius squared, and the error of the area with it.
        for pair in errors.windows(2) {
            let order = (pair[0] / pair[1]).log2();
            assert!(pair[1] > 0.0 && (1.7..2.4).contains(&order), "{errors:?}");
        }
    }
}

fn cube(low: f64, high: f64) -> Vec<Bound> {
    let faces =
        |coordinate| [Bound { coordinate, upper: false, value: low }, Bound { coordinate, upper: true, value: high }];
    (0..3).flat_map(faces).collect()
}

/// Every edge with one triangle lies on a bound, and the triangles are a disc.
fn is_a_disc(cover: &Cover<Implicit>, triangles: &[[usize; 3]]) {
    assert_eq!(euler(cover, triangles), 1);
    for ((i, j), passed) in edges(triangles) {
        let common = cover.charts[i].on.iter().any(|bound| cover.charts[j].on.contains(bound));
        assert!(passed == (1, 1) || (passed.0 + passed.1 == 1 && common), "{i} {j} {passed:?}");
    }
}

#[test]
fn a_plane_ends_at_the_box() {
    let plane = Implicit(Arc::new(|x| (x[0] + x[1] + x[2] - 1.5, [1.0; 3])));
    // Start inside, on a face, in a corner of the hexagon.
    for x in [[0.5, 0.5, 0.5], [0.7, 0.0, 0.8], [1.0, 0.5, 0.0]] {
        let cover = covered(&plane, x, cube(0.0, 1.0), 1e-3, 0.08);
        let triangles = cover.triangles();
        is_a_disc(&cover, &triangles);
        let (area, _) = measured(&cover, &triangles);
        assert!((area - 0.75 * 3.0_f64.sqrt()).abs() < 1e-12, "{area}");
        let corners = cover.charts.iter().filter(|chart| chart.on.len() == 2).count();
        assert_eq!(corners, 6);
        for chart in &cover.charts {
            assert!(chart.on.iter().all(|&k| chart.x[cover.bounds[k].coordinate] == cover.bounds[k].value));
            assert!(chart.x.iter().all(|x| (0.0..=1.0).contains(x)));
        }
    }
}

#[test]
fn a_cap_ends_at_a_circle() {
    let bound = Bound { coordinate: 2, upper: false, value: 0.3 };
    let errors = [1e-2, 2.5e-3].map(|tolerance| {
        let cover = covered(&sphere(), [0.6, 0.0, 0.8], vec![bound], tolerance, 1.0);
        let triangles = cover.triangles();
        is_a_disc(&cover, &triangles);
        let exact = 2.0 * PI * 0.7;
        (exact - measured(&cover, &triangles).0) / exact
    });
    assert!(errors[1] > 0.0 && errors[1] < 0.35 * errors[0], "{errors:?}");
}

#[test]
fn charts_are_small_where_the_surface_bends() {
    // A hill of height 0.3 and width 0.1 on a plain.
    let height = |x: f64, y: f64| 0.3 * (-(x * x + y * y) / 0.02).exp();
    let hill = Implicit(Arc::new(move |x| {
        let h = height(x[0], x[1]);
        (x[2] - h, [h * x[0] / 0.01, h * x[1] / 0.01, 1.0])
    }));
    let tolerance = 2e-3;
    let cover = covered(&hill, [0.7, 0.0, height(0.7, 0.0)], cube(-1.0, 1.0), tolerance, 0.15);
    let triangles = cover.triangles();
    is_a_disc(&cover, &triangles);
    let radius = |near: bool| {
        let there = cover.charts.iter().filter(move |c| (c.x[0].hypot(c.x[1]) < 0.15) == near);
        there.map(|c| c.radius).fold((f64::INFINITY, 0.0_f64), |(low, high), r| (low.min(r), high.max(r)))
    };
    assert!(radius(true).1 < 0.08 && radius(false).1 == 0.15, "{:?} {:?}", radius(true), radius(false));
    for t in &triangles {
        let mean = |k: usize| t.iter().map(|&i| cover.charts[i].x[k]).sum::<f64>() / 3.0;
        let off = (mean(2) - height(mean(0), mean(1))).abs();
        assert!(off < 3.0 * tolerance, "{off}");
    }
}

#[test]
fn threads_change_nothing() {
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let cover = pool.install(|| covered(&torus(), [1.4, 0.0, 0.0], Vec::new(), 1e-2, 1.0));
        let triangles = cover.triangles();
        (cover.charts.into_iter().map(|chart| chart.x).collect::<Vec<_>>(), triangles)
    };
    assert!(run(1) == run(3));
}
