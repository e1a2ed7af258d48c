mod common;
use common::Flagellum;
use hopfline::models::{Law, Load, Mesh, MixedTwoDoublet};
use hopfline::problem::{Automatic,At};
use hopfline::bifurcation::*; use hopfline::orbit::*; use hopfline::continuation::*;
use std::sync::Arc;
fn mixed(elements: usize, degree: usize, grading: f64) -> Flagellum {
    Flagellum::of(Arc::new(Automatic(MixedTwoDoublet::new(Mesh { elements, degree, grading }, Load::Uniform, Law::Printed))))
}
#[test]
fn timing() {
    let args: Vec<usize> = std::env::var("EK").unwrap().split(',').map(|x| x.parse().unwrap()).collect();
    let f = mixed(args[0],args[1],1.2);
    let t = std::time::Instant::now();
    let say = |s: &str| eprintln!("{:8.3} {s}", t.elapsed().as_secs_f64());
    let free = f.index("p");
    let hopf = f.hopf(339.0,0);
    say("hopf");
    let stride = 7*args[1]+5; let mut big=[0.0f64;7]; let mut sum=[0.0f64;7];
    for i in 0..hopf.q.len() { let pl=(i+2)%stride; let fl = if pl<7 {pl} else { [2,3,4,5,6,0,1][(pl-7)%7] }; big[fl]=big[fl].max(hopf.q[i].norm()); sum[fl]+=hopf.q[i].norm_sqr(); }
    eprintln!("{big:.5?} {:.5?}", sum.map(f64::sqrt));
    let form = HopfNormalForm::new(&*f.problem, &hopf).unwrap();
    say("form");
    let symmetry = half_period(&*f.problem, &hopf).unwrap();
    let r = (0.002*hopf.p[free]/form.p2).sqrt();
    let (orbit, lambda) = from_hopf((&hopf,&form),free,r,(&symmetry,2),(args[2],4,Points::Radau));
    let frame = Frame { problem: f.problem.clone(), p: f.p.clone(), free, symmetry: symmetry.clone(), parts:2, scale_state:0.1, scale_part: orbit.part, scale_lambda:100.0};
    let system = Collocation::new(frame,&orbit);
    let x = Collocation::unknowns(&orbit);
    let border = Border{row: vec![0.0;x.len()], lambda: 1.0};
    let mut rr = vec![0.0; x.len()];
    say("start");
    system.residual(&x, lambda, &mut rr);
    say("residual");
    let fac = system.factor(&x, lambda, &border).unwrap();
    say("factor");
    let big = fac.transitions().unwrap();
    say("transitions");
    let c = correct(&system,(x,lambda),&border,&mut Counts::default()).unwrap();
    say("corrected");
    let m = c.factors.multipliers(Some(4)).unwrap();
    say(&format!("multipliers {:?}", &m.values[..2]));
    let m = c.factors.multipliers(None).unwrap();
    say(&format!("multipliers {:?}", &m.values[..2]));
}
