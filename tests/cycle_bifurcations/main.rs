//! Bifurcations of cycles against published values, exact cycles, and each other.

#[path = "../common/mod.rs"]
mod common;
mod curves;
mod enzyme;
mod exact;
mod lorenz;

use hopfline::bifurcation::{Coordinate, Hopf, HopfNormalForm};
use hopfline::continuation::{Border, Corrected, Counts, StepControl, Stop, Walk, correct};
use hopfline::orbit::bifurcations::{Event, Homoclinic, Located, Passage, Segment, Signs};
use hopfline::orbit::{Collocation, Frame, Orbit, OrbitFactors, Points, from_hopf};
use hopfline::problem::{Problem, Reflection};
use std::sync::Arc;

pub fn coordinate(index: usize, width: f64) -> Coordinate {
    Coordinate { index, logarithmic: false, width }
}

/// A branch of cycles under way.
pub struct Branch {
    pub system: Collocation,
    pub start: Corrected<OrbitFactors>,
    pub control: StepControl,
}

/// What came of it.
pub struct Followed {
    /// With the system on the mesh that was in force.
    pub found: Vec<(Collocation, Located)>,
    pub stop: Option<Stop>,
    pub homoclinic: Option<Homoclinic>,
    pub counts: Counts,
}

impl Branch {
    pub fn new(system: Collocation, start: Corrected<OrbitFactors>) -> Self {
        Self { system, start, control: StepControl { step: 0.02, least: 1e-8, most: 0.1 } }
    }

    /// The first cycle near a Hopf point, over the whole period; r in units of the state.
    pub fn of_hopf(problem: &Arc<dyn Problem>, hopf: &Hopf, r: f64, extent: f64, mesh: (usize, usize, Points)) -> Self {
        let form = HopfNormalForm::new(&**problem, hopf).expect("a normal form");
        let symmetry = Reflection::identity(hopf.u.len());
        let predict = |r: f64| from_hopf((hopf, &form), 0, r, (&symmetry, 1), mesh);
        let ((orbit, lambda), (ahead, lambda_ahead)) = (predict(r), predict(1.01 * r));
        let frame = Frame {
            problem: problem.clone(),
            p: hopf.p.clone(),
            free: 0,
            symmetry: symmetry.clone(),
            parts: 1,
            scale_state: (extent / form.p2.abs()).sqrt(),
            scale_part: orbit.part,
            scale_lambda: extent,
        };
        let system = Collocation::new(frame, &orbit);
        let x = Collocation::unknowns(&orbit);
        let t: Vec<f64> = Collocation::unknowns(&ahead).iter().zip(&x).map(|(a, b)| a - b).collect();
        let border = border_along(&system, &t, lambda_ahead - lambda);
        let start = correct(&system, (x, lambda), &border, &mut Counts::default()).expect("a first cycle");
        Self::new(system, start)
    }

    /// Goes on until as many bifurcations are found, a homoclinic ends the branch, or it leaves the range.
    pub fn follow(mut self, (low, high): (f64, f64), wanted: usize) -> Followed {
        let mut signs = Signs::new(&self.start.point, &self.start.factors, &Event::ALL).expect("signs");
        let width = self.system.frame.scale_lambda;
        let mut walk = Walk::new(&mut self.system, self.start.point, self.control, (low, high));
        let mut followed = Followed { found: Vec::new(), stop: None, homoclinic: None, counts: Counts::default() };
        let mut passages: Vec<Passage> = Vec::new();
        for _ in 0..1000 {
            let step = match walk.step() {
                Ok(step) => step,
                Err(stop) => {
                    followed.stop = Some(stop);
                    break;
                }
            };
            let next = Signs::new(&step.to, &step.factors, &Event::ALL).expect("signs");
            for event in signs.events(&next, &Event::ALL) {
                let segment =
                    Segment { system: &*walk.system, from: &step.from, to: &step.to, signs: [&signs, &next], width };
                let located = segment.locate(event, &mut followed.counts).expect("a search");
                match located {
                    Some(located) => {
                        println!("{event:?} {:.12} {:.10}", located.point.lambda, located.point.x.last().unwrap());
                        followed.found.push((walk.system.clone(), located));
                    }
                    None => println!("{event:?}: nothing between {} and {}", step.from.lambda, step.to.lambda),
                }
            }
            passages.push(Passage::new(&*walk.system, &step.to));
            followed.homoclinic = Homoclinic::recognise(&passages, (&*walk.system, &step.to), high - low);
            signs = next;
            if followed.found.len() >= wanted || followed.homoclinic.is_some() || step.stop.is_some() {
                followed.stop = step.stop;
                break;
            }
        }
        followed
    }
}

fn border_along(system: &Collocation, t: &[f64], t_lambda: f64) -> Border {
    use hopfline::continuation::{System, inner};
    let size = inner(system, (t, t_lambda), (t, t_lambda)).sqrt();
    Border { row: system.dual(t).iter().map(|t| t / size).collect(), lambda: system.dual_lambda() * t_lambda / size }
}

/// Newton's method with lambda fixed.
pub fn fixed(frame: &Frame, orbit: &Orbit, lambda: f64) -> (Collocation, Corrected<OrbitFactors>) {
    let system = Collocation::new(frame.clone(), orbit);
    let x = Collocation::unknowns(orbit);
    let border = Border { row: vec![0.0; x.len()], lambda: -1.0 };
    let corrected = correct(&system, (x, lambda), &border, &mut Counts::default()).expect("an orbit");
    (system, corrected)
}
