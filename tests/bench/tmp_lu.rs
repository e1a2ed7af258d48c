use faer::dyn_stack::{MemBuffer, MemStack};
use faer::linalg::lu::partial_pivoting::factor::{PartialPivLuParams, lu_in_place, lu_in_place_scratch};
use faer::{Mat, Par};
fn main() {
    for (r, c) in [(288, 216), (400, 320)] {
        let a = Mat::from_fn(r, c, |i, j| ((i * 37 + j * 91) as f64 * 0.7).sin() + if i == j { 2.0 } else { 0.0 });
        for (t, b) in [
            (16, 64),
            (16, 32),
            (16, 16),
            (16, 128),
            (8, 64),
            (8, 32),
            (8, 16),
            (4, 16),
            (4, 64),
            (32, 64),
            (32, 32),
            (2, 16),
        ] {
            let p = PartialPivLuParams { recursion_threshold: t, block_size: b, ..faer::Auto::<f64>::auto() };
            let mut order = vec![0usize; r];
            let mut inv = vec![0usize; r];
            let mut mem = MemBuffer::new(lu_in_place_scratch::<usize, f64>(r, c, Par::Seq, p.into()));
            let mut best = f64::INFINITY;
            for _ in 0..60 {
                let mut w = a.clone();
                let s = cpu_time::ProcessTime::now();
                lu_in_place(w.as_mut(), &mut order, &mut inv, Par::Seq, MemStack::new(&mut mem), p.into());
                best = best.min(s.elapsed().as_secs_f64());
            }
            let f = r as f64 * (c * c) as f64 - (c as f64).powi(3) / 3.0;
            println!("{r}x{c} thr {t} block {b}: {:.3} ms {:.1} GF/s", best * 1e3, f / best * 1e-9);
        }
    }
}
