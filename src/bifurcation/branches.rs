//! Eigenvalues as continuous branches: which eigenvalue of one point is which of the next.
//!
//! Real eigenvalues and conjugate pairs are followed by extrapolation. Where two real ones meet and leave as a pair (or
//! a pair lands on the axis and splits) both branches go through: the pair's upper member continues the larger, the
//! lower one the smaller of the two. That happens at an exceptional point, where the eigenvalues go as a square root
//! of the distance but their mean and their discriminant `((a - b)/2)²` are smooth.

use crate::linalg::c64;

/// The present eigenvalues cannot be told apart at this distance: look in between.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Ambiguous;

/// Eigenvalues in the order of the branches.
#[derive(Clone, Debug)]
pub struct Followed {
    pub values: Vec<c64>,
    /// Branches that met or split since the last point.
    pub coalesced: Vec<(usize, usize)>,
}

/// A match must be this much closer than the next best.
const DISTINCT: f64 = 0.4;

#[derive(Clone, Copy)]
enum Entity {
    Real(f64),
    /// The member with im > 0.
    Pair(c64),
}

/// Real eigenvalues and pairs with their positions in the list (for a pair the upper member's, then the lower's). Pairs
/// closer to the axis than `blur` count as two real ones.
fn entities(values: &[c64], blur: f64) -> Vec<(Entity, usize, usize)> {
    let mut used = vec![false; values.len()];
    let mut found = Vec::new();
    for i in 0..values.len() {
        if used[i] {
            continue;
        }
        used[i] = true;
        let partner = (0..values.len()).filter(|&j| !used[j] && values[i].im.abs() > blur).min_by(|&j, &k| {
            let distance = |j: usize| (values[j] - values[i].conj()).norm();
            distance(j).total_cmp(&distance(k))
        });
        match partner.filter(|&j| (values[j] - values[i].conj()).norm() <= 1e-6 * values[i].norm()) {
            Some(j) => {
                used[j] = true;
                let (upper, lower) = if values[i].im > 0.0 { (i, j) } else { (j, i) };
                found.push((Entity::Pair(values[upper]), upper, lower));
            }
            None => found.push((Entity::Real(values[i].re), i, i)),
        }
    }
    found
}

/// Orders `next` (rightmost first) after the branches `last`, expected near `guess`. Only branches that are or come
/// among the `wanted` rightmost matter: what happens further left may stay open. Eigenvalues closer than `blur` need
/// not be told apart (near an accumulation point of the spectrum they cannot be). For doubts, see [`settle`].
pub fn follow(last: &[c64], guess: &[c64], next: &[c64], wanted: usize, blur: f64) -> Result<Followed, Ambiguous> {
    let mut sorted: Vec<f64> = last.iter().map(|z| z.re).collect();
    sorted.sort_by(|a, b| b.total_cmp(a));
    let edge = sorted.get(wanted.saturating_sub(1)).copied().unwrap_or(f64::NEG_INFINITY);
    let (old, new) = (entities(last, blur), entities(next, blur));
    let place = |(entity, upper, _): &(Entity, usize, usize)| match entity {
        // A guess of the wrong type (just after a coalescence) is not used.
        Entity::Real(_) if guess[*upper].im.abs() <= blur => Entity::Real(guess[*upper].re),
        Entity::Pair(_) if guess[*upper].im > blur => Entity::Pair(guess[*upper]),
        entity => *entity,
    };
    let expected: Vec<Entity> = old.iter().map(place).collect();
    let distance = |a: Entity, b: Entity| match (a, b) {
        (Entity::Real(x), Entity::Real(y)) => Some((x - y).abs()),
        (Entity::Pair(x), Entity::Pair(y)) => Some((x - y).norm()),
        _ => None,
    };
    let mut candidates: Vec<(f64, usize, usize)> = Vec::new();
    for (i, &a) in expected.iter().enumerate() {
        for (j, (b, ..)) in new.iter().enumerate() {
            if let Some(d) = distance(a, *b) {
                candidates.push((d, i, j));
            }
        }
    }
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut to, mut from) = (vec![None; old.len()], vec![None; new.len()]);
    for &(d, i, j) in &candidates {
        if to[i].is_some() || from[j].is_some() {
            continue;
        }
        // The nearest of the others is the first.
        let rival = candidates.iter().find(|c| (c.1 == i) != (c.2 == j)).map_or(f64::INFINITY, |c| c.0);
        let negligible = d <= blur.max(1e-7 * size(expected[i]));
        if d <= DISTINCT * rival || negligible {
            to[i] = Some(j);
            from[j] = Some(i);
        }
    }

    // What is left must be two real ones that became a pair, or a pair that became two real ones.
    let mut coalesced = Vec::new();
    let mut values = vec![None; last.len()];
    for (i, j) in to.iter().enumerate().filter_map(|(i, j)| j.map(|j| (i, j))) {
        values[old[i].1] = Some(next[new[j].1]);
        values[old[i].2] = Some(next[new[j].2]);
    }
    let open = |taken: &[Option<usize>], list: &[(Entity, usize, usize)], pair: bool| -> Vec<usize> {
        (0..list.len()).filter(|&i| taken[i].is_none() && matches!(list[i].0, Entity::Pair(_)) == pair).collect()
    };
    for j in open(&from, &new, true) {
        let Entity::Pair(z) = new[j].0 else { continue };
        let mut reals = open(&to, &old, false);
        reals.sort_by(|&a, &b| (last[old[a].1].re - z.re).abs().total_cmp(&(last[old[b].1].re - z.re).abs()));
        if let [a, b, ..] = reals[..] {
            let (larger, smaller) = if above(last[old[a].1], last[old[b].1]) { (a, b) } else { (b, a) };
            values[old[larger].1] = Some(next[new[j].1]);
            values[old[smaller].1] = Some(next[new[j].2]);
            (to[larger], to[smaller], from[j]) = (Some(j), Some(j), Some(larger));
            coalesced.push((old[larger].1, old[smaller].1));
        }
    }
    for i in open(&to, &old, true) {
        let Entity::Pair(z) = old[i].0 else { continue };
        let mut reals = open(&from, &new, false);
        reals.sort_by(|&a, &b| (next[new[a].1].re - z.re).abs().total_cmp(&(next[new[b].1].re - z.re).abs()));
        if let [a, b, ..] = reals[..] {
            let (larger, smaller) = if above(next[new[a].1], next[new[b].1]) { (a, b) } else { (b, a) };
            values[old[i].1] = Some(next[new[larger].1]);
            values[old[i].2] = Some(next[new[smaller].1]);
            (to[i], from[larger], from[smaller]) = (Some(larger), Some(i), Some(i));
            coalesced.push((old[i].1, old[i].2));
        }
    }
    // Branches beyond the wanted ones may get lost; they then stand still, to be found again or not.
    let lost = values.iter().zip(last).any(|(v, old)| v.is_none() && old.re >= edge);
    let unexplained = from.iter().zip(&new).any(|(taken, (_, upper, _))| taken.is_none() && *upper < wanted);
    if lost || unexplained {
        return Err(Ambiguous);
    }
    let values = values.iter().zip(last).map(|(v, old)| v.unwrap_or(*old)).collect();
    Ok(Followed { values, coalesced })
}

/// The same where doubts cannot be resolved by looking closer: nearest eigenvalues first, one by one.
pub fn settle(guess: &[c64], next: &[c64]) -> Vec<c64> {
    let all = (0..guess.len()).flat_map(|i| (0..next.len()).map(move |j| (i, j)));
    let mut candidates: Vec<(f64, usize, usize)> = all.map(|(i, j)| ((guess[i] - next[j]).norm(), i, j)).collect();
    candidates.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut values, mut taken) = (vec![None; guess.len()], vec![false; next.len()]);
    for (_, i, j) in candidates {
        if values[i].is_none() && !taken[j] {
            (values[i], taken[j]) = (Some(next[j]), true);
        }
    }
    values.iter().zip(guess).map(|(v, old)| v.unwrap_or(*old)).collect()
}

/// The larger of two real ones; a pair that counts as such keeps its upper member.
fn above(x: c64, y: c64) -> bool {
    x.re > y.re || x.re == y.re && x.im > y.im
}

fn size(entity: Entity) -> f64 {
    match entity {
        Entity::Real(x) => x.abs(),
        Entity::Pair(z) => z.norm(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn z(re: f64, im: f64) -> c64 {
        c64::new(re, im)
    }

    #[test]
    fn two_real_ones_meet_and_split() {
        let last = [z(-1.0, 0.0), z(-1.4, 0.0), z(-9.0, 0.0)];
        let next = [z(-1.25, 0.2), z(-1.25, -0.2), z(-9.1, 0.0)];
        let to = follow(&last, &last, &next, 3, 0.0).unwrap();
        assert_eq!(to.values, next);
        assert_eq!(to.coalesced, [(0, 1)]);
        let back = follow(&to.values, &to.values, &last, 3, 0.0).unwrap();
        assert_eq!(back.values, last);
    }

    #[test]
    fn crossing_branches_keep_their_direction() {
        let (last, guess) = ([z(-1.0, 0.0), z(-1.1, 0.0)], [z(-1.2, 0.0), z(-1.0, 0.0)]);
        let next = [z(-1.01, 0.0), z(-1.19, 0.0)];
        assert_eq!(follow(&last, &guess, &next, 2, 0.0).unwrap().values, [z(-1.19, 0.0), z(-1.01, 0.0)]);
    }

    #[test]
    fn doubt_is_said() {
        let (last, next) = ([z(-1.0, 0.0), z(-1.1, 0.0)], [z(-1.05, 0.0), z(-1.4, 0.0)]);
        assert_eq!(follow(&last, &last, &next, 2, 0.0).unwrap_err(), Ambiguous);
    }
}
