use faer::Mat;
use hopfline::bifurcation::*;
use hopfline::linalg::*;
use hopfline::models::*;
use hopfline::problem::*;
use std::time::Instant;
fn main() {
    for (k, load, law) in [
        (28, Load::Uniform, Law::Printed),
        (32, Load::Uniform, Law::Printed),
        (40, Load::Uniform, Law::Printed),
        (28, Load::Uniform, Law::Separation),
        (28, Load::Distal, Law::Printed),
        (40, Load::Distal, Law::Printed),
    ] {
        let prob = Automatic(TwoDoublet::new(k, load, law));
        let mut p: Vec<f64> =
            vec![12.0, 400.0, 0.2, 0.003, 0.0015, 1e4, 7.776, 1e3, 0.7776, 1e5, 2500.0, 335.0, 7.776e-4, 0.15552];
        if load == Load::Distal {
            p.push(4.0);
            p[11] = 422.0;
        }
        let n = 2 * k;
        let z = vec![0.0; n];
        let u: Vec<f64> = (0..n).map(|i| 0.3 / (1.0 + i as f64)).collect();
        let v: Vec<f64> = (0..n).map(|i| 20.0 / (2.0 + i as f64 * i as f64)).collect();
        println!("deriv check {:e}", check_derivatives(&prob, At { u: &u, v: &v, p: &p }));
        let (mut gu, mut gv) = (Mat::zeros(n, n), Mat::zeros(n, n));
        let t = Instant::now();
        for _ in 0..1000 {
            prob.linearise(At { u: &u, v: &v, p: &p }, gu.as_mut(), gv.as_mut());
        }
        println!("linearise {:?}", t.elapsed() / 1000);
        let mut g = vec![0.0; n];
        let t = Instant::now();
        for _ in 0..1000 {
            prob.residual(At { u: &u, v: &v, p: &p }, &mut g);
        }
        println!("residual {:?}", t.elapsed() / 1000);
        prob.linearise(At { u: &z, v: &z, p: &p }, gu.as_mut(), gv.as_mut());
        let t = Instant::now();
        let e = pencil(gu.as_ref(), gv.as_ref(), 500.0, 8).unwrap();
        println!("pencil {:?}", t.elapsed());
        for x in e.iter().take(5) {
            println!("{}", x.value);
        }
        let t = Instant::now();
        let h = Hopf::locate(&prob, (&z, &p), 11, e[0].value.im, &e[0].vector).unwrap();
        println!(
            "hopf {:?}  p {:.12} om {:.10} slope {}",
            t.elapsed(),
            h.p[11],
            h.omega,
            h.slope * (0.15552 / (1728.0 / 400.0))
        );
        let t = Instant::now();
        let nf = HopfNormalForm::new(&prob, &h).unwrap();
        println!("nf {:?} l1 {:.8} c1 {} p2 {} ", t.elapsed(), nf.l1, nf.c1, nf.p2);
        let mut p0 = h.p.clone();
        p0[9] = 0.0;
        p0[10] = 0.0;
        let mut h0 = h.clone();
        h0.p = p0;
        println!("l1 without k3 {}", HopfNormalForm::new(&prob, &h0).unwrap().l1);
        let lin = |k3: f64| {
            let mut h0 = h.clone();
            h0.p[9] = k3;
            HopfNormalForm::new(&prob, &h0).unwrap().l1
        };
        let (a, b) = (lin(0.0), lin(1e5));
        println!("l1=0 at {}", 1e5 * a / (a - b));
    }
}
