//! Rows and special points of a Hopf curve.

use super::Curve;
use super::sample::{Here, Sample};
use crate::bifurcation::{Bautin, BogdanovTakens, DoubleHopf, HopfCurve, HopfSegment, Locus, Test, ZeroHopf};
use crate::branch::{Array, Branch, Column, Kind, Row, SpecialPoint};
use crate::continuation::{Counts, Point};
use crate::problem::Problem;
use crate::run::equilibria::{SCATTER, error};
use crate::run::outcome::labels;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::f64::consts::PI;

impl Curve<'_> {
    /// Rows and special points.
    pub(super) fn store(&self, branch: &mut Branch, samples: &[Sample]) {
        branch.rows = samples.iter().map(|sample| self.row(branch, sample)).collect();
        let marked: Vec<(usize, &Sample, Kind)> =
            samples.iter().enumerate().filter_map(|(row, sample)| Some((row, sample, sample.mark?.0))).collect();
        let points: Vec<SpecialPoint> =
            marked.par_iter().map(|(row, sample, kind)| self.special(branch, *row, sample, *kind)).collect();
        for ((row, _, kind), mut point) in marked.into_iter().zip(points) {
            let (short, label) = labels(branch, kind);
            point.label = label;
            if self.prepared.waves.contains(&point.label) {
                crate::run::wave::of_mode(self.prepared, &mut point);
            }
            branch.rows[row].label = Some(short);
            branch.points.push(point);
        }
    }

    /// A number of a sample by the name of its column.
    fn measure(&self, curve: &HopfCurve, point: &Point, here: Option<&Here>, name: &str) -> Option<f64> {
        let list = self.prepared.problem.parameters();
        for (coordinate, z) in [curve.first, curve.second].into_iter().zip(curve.coordinates(point)) {
            let own = list[coordinate.index].name;
            let value = || here.map_or(coordinate.value(z), |here| here.hopf.p[coordinate.index]);
            if name == own {
                return Some(value());
            }
            if name.strip_prefix("log10 ") == Some(own) {
                return Some(value().log10());
            }
        }
        let omega = here.map_or(curve.kappa(point).max(0.0).sqrt(), |here| here.hopf.omega);
        let slope = here.map(|here| here.hopf.slope);
        match name {
            "omega" => Some(omega),
            "frequency" => Some(omega / (2.0 * PI)),
            "lyapunov" => here?.form.as_ref().map(|form| form.l1),
            "dsigma_re" => slope.map(|s| s.re),
            "dsigma_im" => slope.map(|s| s.im),
            _ => None,
        }
        .filter(|value| value.is_finite())
    }

    /// What rounding leaves open of a number.
    fn rounding(&self, sample: &Sample, name: &str) -> f64 {
        let (p, omega) = sample.here.as_ref().map_or((0.0, 0.0), |here| here.hopf.rounding);
        let free = self.prepared.problem.parameters()[sample.free].name;
        SCATTER
            * match name {
                "omega" => omega,
                "frequency" => omega / (2.0 * PI),
                _ if name == free => p,
                _ => 0.0,
            }
    }

    fn row(&self, branch: &Branch, sample: &Sample) -> Row {
        let curve = &sample.segment.curve;
        let value = |here: Option<&Here>, name: &str| self.measure(curve, &sample.point, here, name);
        let held = [curve.first.index, curve.second.index].into_iter().find(|i| *i != sample.free);
        let held = held.map(|i| self.prepared.problem.parameters()[i].name);
        let number = |column: &Column| match column.name.strip_prefix("error ") {
            Some(name) => {
                let (here, fine) = (sample.here.as_ref()?, sample.fine.as_ref()?);
                if Some(name) == held {
                    return None;
                }
                let moved = error(value(Some(here), name)?, value(Some(fine), name)?)?;
                Some(moved.max(self.rounding(sample, name)))
            }
            None => value(sample.here.as_ref(), &column.name),
        };
        let degenerate = matches!(sample.mark, Some((Kind::GH, _)));
        let l1 = value(sample.here.as_ref(), "lyapunov").filter(|_| !degenerate);
        Row { label: None, stable: l1.map(|l1| l1 < 0.0), values: branch.columns.iter().map(number).collect() }
    }

    fn special(&self, branch: &Branch, row: usize, sample: &Sample, kind: Kind) -> SpecialPoint {
        let curve = &sample.segment.curve;
        let (mut values, mut errors) = (BTreeMap::new(), BTreeMap::new());
        for (column, value) in branch.columns.iter().zip(&branch.rows[row].values) {
            let Some(value) = *value else { continue };
            match column.name.strip_prefix("error ") {
                Some(name) => errors.insert(name.to_owned(), value),
                None if branch.free.contains(&column.name) => None,
                None => values.insert(column.name.clone(), value),
            };
        }
        if let Some((_, Some(test))) = sample.mark {
            let deciding = coefficients(&sample.segment, &sample.point, test);
            errors.extend(self.located_errors(sample, test, &deciding));
            values.extend(deciding);
        }
        let p = match &sample.here {
            Some(here) => here.hopf.p.clone(),
            None => curve.parameters(&sample.point),
        };
        let resolved = self.prepared.problem.resolve(&p);
        let list = self.prepared.problem.parameters();
        let n = self.prepared.problem.dim();
        let mut arrays = BTreeMap::from([
            ("state".to_owned(), Array::vector(sample.point.x[..n].to_vec())),
            ("parameters".to_owned(), Array::vector(resolved.clone())),
            ("tangent".to_owned(), Array::vector([&sample.point.tangent[..], &[sample.point.tangent_lambda]].concat())),
        ]);
        if let Some(Here { hopf, .. }) = &sample.here {
            for (name, z) in [("q", &hopf.q), ("w", &hopf.w)] {
                arrays.insert(format!("{name}_re"), Array::vector(z.iter().map(|z| z.re).collect()));
                arrays.insert(format!("{name}_im"), Array::vector(z.iter().map(|z| z.im).collect()));
            }
        }
        let parameters = list.iter().zip(&resolved).map(|(q, &x)| (q.name.to_owned(), x)).collect();
        SpecialPoint { label: String::new(), kind, row, parameters, values, errors, arrays }
    }

    /// Errors of a point that a test located: the same test between the same points of the refined curve.
    fn located_errors(&self, sample: &Sample, test: Test, deciding: &BTreeMap<String, f64>) -> BTreeMap<String, f64> {
        let mut errors = BTreeMap::new();
        let Some(refined) = &self.refined else { return errors };
        let Ok(segment) = sample.segment.refined(refined.problem.clone(), &refined.prolong) else { return errors };
        let Ok(Some(point)) = segment.locate(test, &mut Counts::default()) else { return errors };
        let list = self.prepared.problem.parameters();
        let curve = &sample.segment.curve;
        let free = [curve.first, curve.second].map(|c| list[c.index].name);
        for (k, name) in free.into_iter().chain(["omega", "frequency"]).enumerate() {
            let value = |curve: &HopfCurve, point: &Point| self.measure(curve, point, None, name);
            let (Some(here), Some(there)) = (value(curve, &sample.point), value(&segment.curve, &point)) else {
                continue;
            };
            if !matches!(test, Test::Value(held, _) if held == k) {
                let moved = error(here, there).map(|moved| moved.max(self.rounding(sample, name)));
                errors.extend(moved.map(|error| (name.to_owned(), error)));
            }
        }
        for (name, fine) in coefficients(&segment, &point, test) {
            if let Some(&value) = deciding.get(&name) {
                errors.extend(error(value, fine).map(|error| (name, error)));
            }
        }
        errors
    }
}

/// The normal-form coefficients that decide what unfolds at a point of codimension two, where they exist.
fn coefficients(segment: &HopfSegment, point: &Point, test: Test) -> BTreeMap<String, f64> {
    let curve = &segment.curve;
    let problem = &*curve.problem;
    let (u, p) = (&point.x[..problem.dim()], curve.parameters(point));
    let omega = curve.kappa(point).max(0.0).sqrt();
    let found: Option<Vec<(&str, f64)>> = match test {
        Test::Value(..) => None,
        Test::Criticality => {
            let bautin = curve.hopf(point, curve.solvable(point)).and_then(|hopf| Bautin::new(problem, &hopf));
            bautin.ok().map(|form| vec![("lyapunov_2", form.l2)])
        }
        Test::Frequency => {
            BogdanovTakens::new(problem, u, &p).ok().map(|form| vec![("bt_a", form.a), ("bt_b", form.b)])
        }
        Test::Steady => {
            let form = ZeroHopf::new(problem, u, &p, omega).ok();
            form.map(|form| vec![("zh_s", form.s), ("zh_theta", form.theta), ("zh_e", form.e)])
        }
        Test::Pair(from, to) => segment.pair(from, to, point).map(|pair| {
            let mut found = vec![("omega_2", pair.im)];
            if let Ok(form) = DoubleHopf::new(problem, u, &p, [omega, pair.im]) {
                let [p11, _, _, p22] = form.p;
                found.extend([("hh_p11", p11), ("hh_p22", p22), ("hh_theta", form.theta), ("hh_delta", form.delta)]);
            }
            found
        }),
    };
    let finite = found.into_iter().flatten().filter(|(_, value)| value.is_finite());
    finite.map(|(name, value)| (name.to_owned(), value)).collect()
}
