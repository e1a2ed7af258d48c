//! The two-doublet model with its forces kept against the form in angles alone.

mod common;

use common::{Flagellum, close};
use hopfline::models::{Law, Load, Mesh, MixedTwoDoublet};
use hopfline::problem::{At, Automatic, check_derivatives};
use std::sync::Arc;

fn mixed(elements: usize, degree: usize, grading: f64) -> Flagellum {
    Flagellum::of(Arc::new(Automatic(MixedTwoDoublet::new(Mesh { elements, degree, grading }, Load::Uniform, Law::Printed))))
}

#[test]
fn explore() {
    for law in [Law::Printed, Law::Separation] {
        let f = Flagellum::of(Arc::new(Automatic(MixedTwoDoublet::new(Mesh { elements:3, degree:4, grading:1.5 }, Load::Distal, law))));
        let n = f.problem.dim();
        let u: Vec<f64> = (0..n).map(|i| 0.3*(i as f64).sin()).collect();
        let v: Vec<f64> = (0..n).map(|i| 3.0*(1.7*i as f64).cos()).collect();
        println!("{n} {:.1e}", check_derivatives(&*f.problem, At{u:&u,v:&v,p:&f.p}));
    }
    for k in 2..=8 {
      for e in [2,3,4,5,6,8,12,16] {
        let f = mixed(e,k,1.0);
        if f.problem.dim() > 300 { continue }
        let t = std::time::Instant::now();
        let h = f.hopf(338.0,0);
        let t1 = t.elapsed().as_secs_f64()*1e3;
        let p = h.p[f.index("p")];
        println!("k {k} E {e} n {} dof {}: p {p} {:.2e} omega {:.2e}  {t1:.1} ms", f.problem.dim(), e*k, p/338.889485397848-1.0, h.omega/202.675023170-1.0);
      }
    }
    for k in [12,16,20,24,28] {
        let f = Flagellum::new(k, Load::Uniform, Law::Printed);
        let t = std::time::Instant::now();
        let h = f.hopf(338.0,0);
        let t1 = t.elapsed().as_secs_f64()*1e3;
        let p = h.p[f.index("p")];
        println!("min K {k}: p {p} {:.2e} {t1:.1} ms", p/338.889485397848-1.0);
    }
}
