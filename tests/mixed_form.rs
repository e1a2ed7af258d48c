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

    for (e,k) in [(4,8),(5,8),(6,8),(8,8),(10,8),(12,6),(16,4),(40,4)] { for g in [1.0,1.15,1.3,1.5,2.0] {
        if e>12 && g>1.0 {continue}
        let f = mixed(e,k,g);
        let t = std::time::Instant::now();
        let q = f.clone().with("p",338.0);
        let (gu,gv)=q.problem.matrices(At{u:&q.straight(),v:&q.straight(),p:&q.p});
        let near = hopfline::linalg::nearest(&gu,&gv,hopfline::linalg::c64::new(0.0,200.0),4).unwrap();
        let t0 = t.elapsed().as_secs_f64()*1e3;
        let t = std::time::Instant::now();
        let h = hopfline::bifurcation::Hopf::locate(&*q.problem,(&q.straight(),&q.p),q.index("p"),near[0].value.im,&near[0].vector).unwrap();
        let t1 = t.elapsed().as_secs_f64()*1e3;
        let p = h.p[f.index("p")];
        println!("k {k} E {e} g {g} n {} dof {}: p {p} {:.2e} omega {:.2e}  {t0:.1} {t1:.1} ms", f.problem.dim(), e*k, p/338.889485397848-1.0, h.omega/202.675023170-1.0);
    }}
    for k in [12,16,20,24,28] {
        let f = Flagellum::new(k, Load::Uniform, Law::Printed);
        let t = std::time::Instant::now();
        let h = f.hopf(338.0,0);
        let t1 = t.elapsed().as_secs_f64()*1e3;
        let p = h.p[f.index("p")];
        println!("min K {k}: p {p} {:.2e} {t1:.1} ms", p/338.889485397848-1.0);
    }
}

#[test]
fn beats() {
    for (e,k,g,int) in [(4,8,1.2,8),(5,8,1.2,8)] {
        let t = std::time::Instant::now();
        let f = mixed(e,k,g);
        for c in f.cycles(338.0,&[340.0,360.0],(int,4)) {
            println!("{e} {k} {g} {int}: f {} y {} mult {:?}   {:.2} s", 1.0/c.orbit.period(), c.deflection, &c.multipliers.values[..2], t.elapsed().as_secs_f64());
        }
    }
    for (k,int) in [(28,8),(36,8)] {
        let t = std::time::Instant::now();
        let f = Flagellum::new(k,Load::Uniform,Law::Printed);
        for c in f.cycles(338.0,&[340.0,360.0],(int,4)) {
            println!("min {k} {int}: f {} y {} mult {:?}   {:.2} s", 1.0/c.orbit.period(), c.deflection, &c.multipliers.values[..2], t.elapsed().as_secs_f64());
        }
    }
}
