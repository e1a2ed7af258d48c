use super::cyclic::Cyclic;
use super::dense::Dense;
use super::*;
use faer::mat;
use proptest::prelude::*;
use std::f64::consts::PI;

/// Numbers between -1 and 1 that depend on the seed alone.
struct Numbers(u64);

impl Numbers {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        ((self.0 >> 11) as f64 / (1_u64 << 52) as f64) - 1.0
    }

    fn matrix(&mut self, n: usize, m: usize) -> Mat<f64> {
        Mat::from_fn(n, m, |_, _| self.next())
    }

    fn factors(&mut self, n: usize, count: usize) -> Vec<Mat<f64>> {
        (0..count).map(|_| self.matrix(n, n)).collect()
    }
}

/// `A_j = Q_{j+1} T_j Q_j^T` with random orthogonal Q and T of known diagonal blocks: eigenvalues `e^(ln ± i angle)`,
/// pairs where the angle is neither 0 nor pi, shared among the factors by given weights.
fn known(
    wanted: &[(f64, f64)],
    weights: &[f64],
    coupling: f64,
    random: &mut Numbers,
) -> (Vec<Mat<f64>>, Vec<Eigenvalue>) {
    let sizes: Vec<usize> = wanted.iter().map(|(_, angle)| if angle.sin().abs() > 1e-9 { 2 } else { 1 }).collect();
    let (n, count) = (sizes.iter().sum(), weights.len());
    let whole: f64 = weights.iter().sum();
    let mut t = vec![Mat::<f64>::zeros(n, n); count];
    let mut i = 0;
    for (&(ln, angle), &size) in wanted.iter().zip(&sizes) {
        for (t, weight) in t.iter_mut().zip(weights) {
            (i..i + size).for_each(|k| t[(k, k)] = (ln * weight / whole).exp());
            for c in i..i + size {
                for r in 0..i {
                    t[(r, c)] = coupling * random.next() * t[(c, c)].min(t[(r, r)]);
                }
            }
        }
        let (d, h) = (t[count - 1][(i, i)], &mut t[count - 1]);
        h[(i, i)] = d * angle.cos();
        if size == 2 {
            (h[(i + 1, i + 1)], h[(i, i + 1)], h[(i + 1, i)]) = (d * angle.cos(), -d * angle.sin(), d * angle.sin());
        }
        i += size;
    }
    let q: Vec<Mat<f64>> = (0..count).map(|_| random.matrix(n, n).qr().compute_Q()).collect();
    let factors = (0..count).map(|j| &q[(j + 1) % count] * &t[j] * q[j].transpose()).collect();
    let one = |ln: f64, angle: f64| Eigenvalue { ln, direction: c64::new(angle.cos(), angle.sin()) };
    let both = |(&(ln, angle), &size): (&(f64, f64), &usize)| {
        if size == 2 { vec![one(ln, angle.abs()), one(ln, -angle.abs())] } else { vec![one(ln, angle)] }
    };
    let mut values: Vec<Eigenvalue> = wanted.iter().zip(&sizes).flat_map(both).collect();
    sort(&mut values);
    (factors, values)
}

/// Largest difference in logarithm and direction when each value is matched to the nearest one left.
fn difference(found: &[Eigenvalue], values: &[Eigenvalue]) -> f64 {
    let mut left = values.to_vec();
    let mut worst = 0.0_f64;
    for x in found {
        let apart = |y: &Eigenvalue| {
            (if x.ln == y.ln { 0.0 } else { (x.ln - y.ln).abs() }) + (x.direction - y.direction).norm()
        };
        let nearest = (0..left.len()).min_by(|&i, &j| apart(&left[i]).total_cmp(&apart(&left[j]))).unwrap();
        worst = worst.max(apart(&left.swap_remove(nearest)));
    }
    worst
}

/// ln 1e10 down to ln 1e-300, real of both signs and pairs.
fn spread(blocks: usize) -> Vec<(f64, f64)> {
    let ln = |i: usize| 10_f64.ln() * (10.0 - 310.0 * i as f64 / (blocks - 1) as f64);
    (0..blocks).map(|i| (ln(i), [0.0, 1.1, PI, 2.5][i % 4])).collect()
}

#[test]
fn moduli_from_1e10_to_1e_minus_300_are_right() {
    let mut random = Numbers(1);
    for (blocks, count) in [(3, 60), (6, 60), (14, 100), (14, 250)] {
        let weights: Vec<f64> = (0..count).map(|_| 1.0 + 0.5 * random.next()).collect();
        let mut wanted = spread(blocks);
        let (factors, values) = known(&wanted, &weights, 0.1, &mut random);
        let off = difference(&all(&factors).unwrap(), &values);
        // One factor's smallest singular value is 1.5 · 310 / N decades below its norm, and known to eps of that norm.
        let limit = f64::EPSILON * 10_f64.powf(465.0 / count as f64) * (10 * count * blocks) as f64;
        assert!(off < limit && limit < 1e-3, "{blocks} {count}: {off:.1e} {limit:.1e}");
        // Small ones on top: the same eigenvalues, met in the wrong order.
        wanted.reverse();
        let (factors, values) = known(&wanted, &weights, 0.1, &mut random);
        let off = difference(&all(&factors).unwrap(), &values);
        assert!(off < limit, "{blocks} {count} reversed: {off:.1e} {limit:.1e}");
    }
}

#[test]
fn the_explicit_product_is_wrong_where_this_is_right() {
    let mut random = Numbers(2);
    let wanted = [(0.0, 0.0), (-100.0, 0.0), (-200.0, 0.0)];
    let (factors, values) = known(&wanted, &[1.0; 40], 0.5, &mut random);
    let product = factors.iter().fold(Mat::identity(3, 3), |product: Mat<f64>, a| a * product);
    let explicit = product.eigenvalues().unwrap();
    // e^-100 and e^-200 become rounding errors of 1.
    assert!(explicit.iter().filter(|mu| mu.norm().ln() > -60.0).count() > 1, "{explicit:?}");
    assert!(difference(&all(&factors).unwrap(), &values) < 1e-11);
}

#[test]
fn products_that_overflow_or_vanish_come_out() {
    let mut random = Numbers(3);
    let factors = random.factors(7, 12);
    let before = all(&factors).unwrap();
    for scale in [1e200, 1e-250] {
        let factors: Vec<Mat<f64>> = factors.iter().map(|a| Mat::from_fn(7, 7, |i, j| scale * a[(i, j)])).collect();
        let scaled: Vec<Eigenvalue> =
            before.iter().map(|value| Eigenvalue { ln: value.ln + 12.0 * scale.ln(), ..*value }).collect();
        assert!(difference(&all(&factors).unwrap(), &scaled) < 1e-11);
    }
    assert_eq!(Eigenvalue { ln: 800.0, direction: c64::new(-1.0, 0.0) }.value().re, f64::NEG_INFINITY);
    assert_eq!(Eigenvalue { ln: -800.0, direction: c64::new(0.0, 1.0) }.value(), c64::new(0.0, 0.0));
}

#[test]
fn units_of_very_different_size_do_no_harm() {
    let mut random = Numbers(9);
    let wanted: Vec<(f64, f64)> = (0..6).map(|i| (0.3 - f64::from(i), [0.0, 1.3, PI][i as usize % 3])).collect();
    for count in [1, 2, 7] {
        let (mut factors, values) = known(&wanted, &vec![1.0; count], 0.3, &mut random);
        let n = values.len();
        let units: Vec<f64> = (0..n).map(|i| 10_f64.powi([0, -9, 6, -3][i % 4])).collect();
        for a in &mut factors {
            *a = Mat::from_fn(n, n, |i, j| a[(i, j)] * units[i] / units[j]);
        }
        let off = difference(&all(&factors).unwrap(), &values);
        assert!(off < 1e-13, "{count}: {off:.1e}");
    }
}

#[test]
fn zero_columns_and_rows_are_exact_zeros() {
    let mut random = Numbers(4);
    // As many zeros in all factors: those of a differential-algebraic problem.
    let mut factors = random.factors(9, 5);
    for a in &mut factors {
        for j in [2, 5, 6] {
            a.col_as_slice_mut(j).fill(0.0);
        }
    }
    let found = all(&factors).unwrap();
    let kept = [0, 1, 3, 4, 7, 8];
    let small: Vec<Mat<f64>> = factors.iter().map(|a| Mat::from_fn(6, 6, |i, j| a[(kept[i], kept[j])])).collect();
    assert!(difference(&found[..6], &all(&small).unwrap()) < 1e-12);
    assert!(found[6..].iter().all(|value| *value == Eigenvalue::ZERO));
    // Different columns and rows here and there: the smallest section decides.
    let mut factors = random.factors(6, 4);
    factors[1].col_as_slice_mut(0).fill(0.0);
    factors[1].col_as_slice_mut(3).fill(0.0);
    factors[2].col_as_slice_mut(1).fill(0.0);
    (0..6).for_each(|j| factors[3][(4, j)] = 0.0);
    let found = all(&factors).unwrap();
    assert_eq!(found.iter().filter(|value| value.ln == f64::NEG_INFINITY).count(), 2);
    let product = factors.iter().fold(Mat::identity(6, 6), |product: Mat<f64>, a| a * product);
    let mut explicit: Vec<f64> = product.eigenvalues().unwrap().iter().map(|mu| mu.norm()).collect();
    explicit.sort_by(|x, y| y.total_cmp(x));
    assert!((0..4).all(|i| (found[i].ln - explicit[i].ln()).abs() < 1e-11), "{found:?} {explicit:?}");
    // Nothing but zeros.
    let mut factors = random.factors(3, 2);
    factors[0].fill(0.0);
    assert_eq!(all(&factors).unwrap(), [Eigenvalue::ZERO; 3]);
}

#[test]
fn a_zero_on_a_diagonal_splits_off_exactly() {
    let mut random = Numbers(5);
    for (at, factor) in [(0, 0), (2, 1), (4, 2), (5, 0)] {
        let mut factors: Vec<Mat<f64>> =
            (0..3).map(|_| Mat::from_fn(6, 6, |i, j| if i <= j { random.next() } else { 0.0 })).collect();
        factors.push(Mat::from_fn(6, 6, |i, j| if i <= j + 1 { random.next() } else { 0.0 }));
        factors[factor][(at, at)] = 0.0;
        let found = all(&factors).unwrap();
        assert_eq!(found.iter().filter(|value| value.ln == f64::NEG_INFINITY).count(), 1, "{at}: {found:?}");
        let product = factors.iter().fold(Mat::identity(6, 6), |product: Mat<f64>, a| a * product);
        let trace: f64 = (0..6).map(|i| product[(i, i)]).sum();
        let sum: c64 = found.iter().map(Eigenvalue::value).sum();
        assert!((sum.re - trace).abs() < 1e-13 && sum.im.abs() < 1e-13, "{at}: {sum} {trace}");
    }
}

#[test]
fn shifts_are_made_up_where_those_at_hand_do_not_converge() {
    // Roots of unity, on which the ordinary shifts, all zero, go round for ever.
    let n = 7;
    let turn = Mat::from_fn(n, n, |i, j| f64::from(u8::from(i == (j + 1) % n)));
    for count in [1, 2, 5] {
        let found = all(&vec![turn.clone(); count]).unwrap();
        for value in found {
            let power = value.direction.powi(n as i32);
            assert!(value.ln.abs() < 1e-14 && (power - 1.0).norm() < 1e-13, "{value:?}");
        }
    }
}

#[test]
fn bases_carry_the_factors_to_their_schur_form() {
    let mut random = Numbers(6);
    for (n, count) in [(1, 3), (2, 1), (7, 4), (12, 3)] {
        let factors = random.factors(n, count);
        let mut cyclic = Cyclic::new(factors.iter().map(|a| Dense::from(a.as_ref())).collect(), true);
        let blocks = cyclic.iterate().unwrap();
        let sorted = cyclic.sort(blocks);
        let q = cyclic.q.as_ref().unwrap();
        for j in 0..count {
            let (here, next) = (q[j].view(), q[(j + 1) % count].view());
            let scale = f64::from(cyclic.exponents[j]).exp2();
            let left = &factors[j] * here;
            let right = next * cyclic.t[j].view();
            let error = Mat::from_fn(n, n, |r, c| left[(r, c)] - scale * right[(r, c)]).norm_max();
            assert!(error < 3e-14, "{n} {count}: {error:.1e}");
            assert!((here.transpose() * here - Mat::<f64>::identity(n, n)).norm_max() < 1e-14);
            for c in 0..n {
                let block = sorted.iter().find(|(i, size)| c < i + size).unwrap();
                let below = if j + 1 == count { block.0 + block.1 } else { c + 1 };
                assert!((below..n).all(|r| cyclic.t[j].at(r, c) == 0.0), "{n} {count}: column {c} of factor {j}");
            }
        }
        let values: Vec<Eigenvalue> = sorted.iter().flat_map(|block| cyclic.values(*block)).collect();
        assert!(values.windows(2).all(|pair| pair[0].ln >= pair[1].ln - 1e-9), "{values:?}");
        assert!(difference(&values, &all(&factors).unwrap()) < 1e-11);
    }
}

#[test]
fn the_leading_ones_are_the_first_of_all() {
    let mut random = Numbers(7);
    let n = 60;
    let decaying = |i: usize| (0.2 - 0.4 * i as f64, [0.0, 2.0, PI][i % 3]);
    let mut products = vec![
        random.factors(n, 1),
        random.factors(n, 5),
        known(&(0..45).map(decaying).collect::<Vec<_>>(), &[1.0; 12], 0.1, &mut random).0,
        // A triple eigenvalue with three eigenvectors, of which one start sees one.
        known(
            &(0..n).map(|i| (if i < 3 { 0.0 } else { -0.3 * i as f64 }, 0.0)).collect::<Vec<_>>(),
            &[1.0; 6],
            0.0,
            &mut random,
        )
        .0,
    ];
    // Factors of rank 4, of zeros, of permutations, and one.
    products.push((0..3).map(|_| random.matrix(n, 4) * random.matrix(4, n)).collect());
    products.push(vec![Mat::zeros(n, n); 3]);
    products.push(vec![Mat::from_fn(n, n, |i, j| f64::from(u8::from(i == (j + 1) % n))); 4]);
    products.push(vec![Mat::identity(n, n); 4]);
    for (case, factors) in products.iter().enumerate() {
        let whole = all(factors).unwrap();
        for k in [1, 2, 3, 4, 6] {
            let found = leading(factors, k).unwrap();
            let cut = found.last().is_some_and(|value| value.direction.im > 0.0);
            assert!(!cut && (found.len() == k || found.len() == k + 1), "{case} {k}: {found:?}");
            for (x, y) in found.iter().zip(&whole) {
                // What is below 1e-30 of rank 4 is rounding error here and there.
                assert!(
                    (x.ln - y.ln).abs() < 1e-11 || x.ln.max(y.ln) < -70.0 || x.ln == y.ln,
                    "{case} {k}: {x:?} {y:?}"
                );
            }
            assert_eq!(leading(factors, k).unwrap(), found);
        }
    }
}

/// Factors that say what their product is, more or less.
struct Formed(Vec<Mat<f64>>, f64);

impl Product for Formed {
    fn dim(&self) -> usize {
        self.0.dim()
    }

    fn factors(&self) -> usize {
        self.0.factors()
    }

    fn apply(&self, j: usize, x: MatRef<'_, f64>, y: MatMut<'_, f64>) {
        self.0.apply(j, x, y);
    }

    fn formed(&self) -> Option<Mat<f64>> {
        let n = self.dim();
        let product = self.0.iter().fold(Mat::identity(n, n), |product: Mat<f64>, a| a * product);
        Some(product * faer::Scale(1.0 + self.1) + Mat::from_fn(n, n, |i, j| self.1 * ((i + 7 * j) as f64).sin()))
    }
}

#[test]
fn a_guess_of_the_product_changes_nothing_but_the_work() {
    let mut random = Numbers(9);
    let n = 60;
    let decaying = |i: usize| (0.2 - 0.4 * i as f64, [0.0, 2.0, PI][i % 3]);
    let products = [
        random.factors(n, 5),
        known(&(0..45).map(decaying).collect::<Vec<_>>(), &[1.0; 12], 0.1, &mut random).0,
        // Modulus 1e-30 at the tenth: out of a guess's reach.
        known(&(0..n).map(|i| (-7.0 * i as f64, 0.0)).collect::<Vec<_>>(), &[1.0; 8], 0.1, &mut random).0,
        vec![Mat::zeros(n, n); 3],
    ];
    for (case, factors) in products.iter().enumerate() {
        let whole = all(factors).unwrap();
        // Good, useless and wrong guesses.
        for wrong in [0.0, 1e-6, 1.0, f64::NAN] {
            for k in [1, 4, 6] {
                let found = leading(&Formed(factors.clone(), wrong), k).unwrap();
                for (x, y) in found.iter().zip(&whole) {
                    assert!((x.ln - y.ln).abs() < 1e-11 || x.ln == y.ln, "{case} {wrong} {k}: {x:?} {y:?}");
                }
            }
        }
    }
}

#[test]
fn entries_that_are_not_finite_are_refused() {
    let mut factors = Numbers(8).factors(50, 3);
    factors[1][(20, 30)] = f64::NAN;
    assert_eq!(all(&factors), Err(PeriodicError::NotFinite { factor: 1 }));
    assert_eq!(leading(&factors, 2), Err(PeriodicError::NotFinite { factor: 1 }));
    assert_eq!(all(&Vec::<Mat<f64>>::new()), Ok(Vec::new()));
    assert_eq!(leading(&factors[..1].to_vec(), 0), Ok(Vec::new()));
    let rotation = mat![[0.0, -1.0], [1.0, 0.0]];
    assert_eq!(all(&vec![rotation]).unwrap()[0].direction, c64::new(0.0, 1.0));
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn small_products_have_the_eigenvalues_of_their_explicit_form(n in 1_usize..7, count in 1_usize..5, seed: u64) {
        let factors = Numbers(seed).factors(n, count);
        let product = factors.iter().fold(Mat::identity(n, n), |product: Mat<f64>, a| a * product);
        let found = all(&factors).unwrap();
        // Symmetric functions of the eigenvalues, which no multiplicity makes ill-conditioned: traces of powers.
        let mut power = Mat::<f64>::identity(n, n);
        for k in 1..=n {
            power = &power * &product;
            let trace: f64 = (0..n).map(|i| power[(i, i)]).sum();
            let sum: c64 = found.iter().map(|value| value.value().powi(k as i32)).sum();
            let size = product.norm_l2().max(1.0).powi(k as i32) * 2_f64.powi(count as i32);
            prop_assert!((sum - trace).norm() < 1e-11 * size, "{k}: {sum} {trace}");
        }
    }

    #[test]
    fn the_first_factor_may_be_any_and_the_product_transposed(n in 1_usize..8, count in 2_usize..6, seed: u64) {
        let mut factors = Numbers(seed).factors(n, count);
        let sum = |values: &[Eigenvalue]| values.iter().map(|value| value.ln).sum::<f64>();
        let trace = |values: &[Eigenvalue]| values.iter().map(Eigenvalue::value).sum::<c64>();
        let before = all(&factors).unwrap();
        let norm: f64 = factors.iter().map(|a| a.norm_l2()).product();
        factors.rotate_left(1);
        let rotated = all(&factors).unwrap();
        factors.reverse();
        let transposed = all(&factors.iter().map(|a| a.transpose().to_owned()).collect::<Vec<_>>()).unwrap();
        let determinants: f64 = factors.iter().map(|a| a.determinant().abs().ln()).sum();
        for other in [&rotated, &transposed] {
            prop_assert!((trace(other) - trace(&before)).norm() < 1e-12 * norm);
            prop_assert!((sum(other) - determinants).abs() < 1e-6, "{} {determinants}", sum(other));
        }
        prop_assert!(before.iter().all(|value| (value.direction.norm() - 1.0).abs() < 1e-15));
        let im: f64 = before.iter().map(|value| value.direction.im).sum();
        prop_assert!(im.abs() < 1e-15);
    }
}
