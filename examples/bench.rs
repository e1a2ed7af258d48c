#[global_allocator] static A: mimalloc::MiMalloc = mimalloc::MiMalloc;
use hopfline::models::*; use hopfline::problem::*; use hopfline::orbit::*; use faer::Mat; use std::time::Instant;
fn main(){
  for k in [40usize,44] { let m = if k==40 {4} else {5};
    let prob = Automatic(TwoDoublet::new(k,Load::Uniform,Law::Printed));
    let p: Vec<f64> = vec![12.0,400.0,0.2,0.003,0.0015,1e4,7.776,1e3,0.7776,1e5,2500.0,335.0,7.776e-4,0.15552];
    let n=2*k;
    let u: Vec<f64>=(0..n).map(|i|0.3/(1.0+i as f64)).collect(); let v: Vec<f64>=(0..n).map(|i|20.0/(2.0+i as f64*i as f64)).collect();
    let at=At{u:&u,v:&v,p:&p};
    let (mut gu, mut gv)=(Mat::zeros(n,n),Mat::zeros(n,n)); let mut g=vec![0.0;n]; let mut e=vec![0.0;p.len()]; e[11]=1.0;
    let t=Instant::now(); for _ in 0..500 {prob.linearise(at, gu.as_mut(), gv.as_mut());} println!("linearise {:?}", t.elapsed()/500);
    let t=Instant::now(); for _ in 0..500 {prob.residual(at, &mut g);} println!("residual {:?}", t.elapsed()/500);
    let t=Instant::now(); for _ in 0..500 {prob.derivative(at, &[Direction{u:&[],v:&[],p:&e}], &mut g);} println!("derivative {:?}", t.elapsed()/500);
    let inside=Mat::from_fn(m*n,(m-1)*n,|i,j| ((i*7+j*13)%101) as f64 + if i==j {1000.0} else {0.0});
    let right=Mat::from_fn(m*n,2*n+2,|i,j| ((i*17+j*11)%101) as f64);
    let t=Instant::now(); for _ in 0..20 { std::hint::black_box(Elimination::new(inside.clone(),right.clone(),n).unwrap()); } println!("elimination {:?}", t.elapsed()/20);
    let j2=Mat::from_fn(2*n,n,|i,j| ((i*7+j*13)%101) as f64 + if i==j {1000.0} else {0.0});
    let r2=Mat::from_fn(2*n,2*n+2,|i,j| ((i*17+j*11)%101) as f64);
    let t=Instant::now(); for _ in 0..20 { std::hint::black_box(Elimination::new(j2.clone(),r2.clone(),n).unwrap()); } println!("join {:?}", t.elapsed()/20);
    let t=Instant::now(); for _ in 0..20 { std::hint::black_box(gu.eigenvalues().unwrap()); } println!("eigenvalues {:?}", t.elapsed()/20);
    let t=Instant::now(); for _ in 0..20 { std::hint::black_box(gu.eigen().unwrap()); } println!("eigen {:?}", t.elapsed()/20);
    let t=Instant::now(); for _ in 0..20 { std::hint::black_box(gu.partial_piv_lu()); } println!("lu {:?}", t.elapsed()/20);
  }
}
