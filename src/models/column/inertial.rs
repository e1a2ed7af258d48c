//! What columns and pipes share: unknowns (psi, omega), equations psi_t = omega and the weak form with
//! (psi_t, psi_tt) = (omega, omega_t).

use crate::linalg::Matrix;
use crate::models::rod::{Basis, Forces, Motion, State, end, line, slopes, times, times_both, work};
use crate::problem::{At, Scalar};
use faer::reborrow::ReborrowMut;

pub fn residual<S: Scalar>(basis: &Basis, forces: &Forces<S>, (u, v): (&[S], &[S]), g: &mut [S]) {
    let k = basis.functions;
    let (kinematics, dynamics) = g.split_at_mut(k);
    kinematics.iter_mut().zip(v.iter().zip(&u[k..])).for_each(|(g, (&v, &omega))| *g = v - omega);
    work(basis, forces, &State { psi: &u[..k], rate: &u[k..], acceleration: Some(&v[k..]) }, dynamics);
}

pub fn linearise(basis: &Basis, forces: &Forces<f64>, at: At, gu: &mut Matrix, gv: &mut Matrix) {
    let k = basis.functions;
    let state = State { psi: &at.u[..k], rate: &at.u[k..], acceleration: Some(&at.v[k..]) };
    let slopes = slopes(basis, forces, &state);
    let (Matrix::Dense(gu), Matrix::Dense(gv)) = (gu, gv) else { return };
    let (mut gu, mut gv) = (gu.as_mut(), gv.as_mut());
    gu.fill(0.0);
    gv.fill(0.0);
    for i in 0..k {
        gu[(i, k + i)] = -1.0;
        gv[(i, i)] = 1.0;
    }
    gu.rb_mut().submatrix_mut(k, 0, k, k).copy_from(slopes.psi);
    gu.submatrix_mut(k, k, k, k).copy_from(slopes.rate);
    if let Some(mass) = slopes.acceleration {
        gv.submatrix_mut(k, k, k, k).copy_from(mass);
    }
}

/// In parts of the length: y and x of the tip, and its angle.
pub fn tip(basis: &Basis, psi: &[f64]) -> [f64; 3] {
    let angles = times(&basis.value, psi);
    let total = |part: fn(f64) -> f64| basis.total(angles.iter().map(|&a| part(a)));
    [total(f64::sin), total(f64::cos), end(basis, psi)]
}

/// The energy of a rod of unit rigidity and length: of bending, of motion with inertia I, of the tip's with m.
pub fn energy(basis: &Basis, forces: &Forces<f64>, u: &[f64]) -> f64 {
    let (psi, rate) = u.split_at(basis.functions);
    let bending: f64 = psi.iter().zip(&basis.stiffness).map(|(c, k)| 0.5 * k * c * c).sum();
    let [angles, rates] = times_both(&basis.value, [psi, rate]);
    let motion = Motion::new(basis, &angles, &rates);
    let squares = motion.v_x.iter().zip(&motion.v_y).map(|(x, y)| x * x + y * y);
    let v_x = basis.total(rates.iter().zip(&motion.sine).map(|(r, s)| -r * s));
    let v_y = basis.total(rates.iter().zip(&motion.cosine).map(|(r, c)| r * c));
    bending + 0.5 * forces.inertia * basis.total(squares) + 0.5 * forces.tip_inertia * (v_x * v_x + v_y * v_y)
}

pub fn picture(basis: &Basis, length: f64, u: &[f64]) -> Vec<[f64; 2]> {
    line(length, |x| {
        let (sine, cosine) = basis.psi(&u[..basis.functions], x).sin_cos();
        [cosine, sine]
    })
}
