//! A task of kind `cycles`: a branch of periodic orbits from a Hopf point or a bifurcation of cycles, with multipliers,
//! bifurcations, user values and errors.

mod origin;
mod quantities;
mod refinement;
mod relative;
mod rows;
mod special;
mod values;

pub use quantities::{Average, columns, measure};
pub use refinement::Place;
pub use rows::empty;
pub use special::{VALUES, angle};

use super::outcome::{Outcome, Status, joined};
use super::resume::{Checkpoint, Keeper};
use super::study::Prepared;
use super::watch::Watch;
use crate::branch::{Branch, Kind, SpecialPoint};
use crate::continuation::{Counts, Failure, Point, Stop, Walk};
use crate::orbit::bifurcations::{Amplitude, Event, Homoclinic, KEPT, Passage, Segment, Signs, hopf_beside};
use crate::orbit::{Collocation, OrbitFactors};
use crate::problem::{Problem, Reflection};
use crate::scene;
pub use origin::INTERVALS;
use origin::Origin;
use refinement::Refinement;
use rows::{Maker, Pending};
use special::{Between, Special, endless};
use std::sync::Arc;
use std::time::Instant;
use thiserror::Error;

#[derive(Debug, Error)]
enum CyclesError {
    #[error(transparent)]
    Numerics(#[from] Failure),
    #[error("the start is not a Hopf point any more: {0}")]
    Start(#[from] crate::bifurcation::HopfError),
    #[error("{what} at {name} = {value} does not lie inside the range {from} to {to}")]
    Outside { what: String, name: String, value: f64, from: f64, to: f64 },
    #[error("the cycles leave the range at once: they go beyond its end {name} = {value}, where the Hopf point is")]
    Edge { name: String, value: f64 },
    #[error("{0} is not stored with all that a start needs")]
    Incomplete(String),
    #[error("{label} is a branch point for {name} alone: free = {name:?}")]
    OtherParameter { label: String, name: String },
    #[error(
        "{0} is no rotating wave with a complex pair of eigenvalues: relative = true starts at its NS point, or at any UZ or \
         EP of cycles that are no rotating waves"
    )]
    NoWave(String),
    #[error("the start {0} drifts along rotations, so that it closes in a frame only that turns: relative = true")]
    Drifts(String),
    #[error(
        "{0} obeys a symmetry over half a period that turns the rotations round: there is no drift; compute it with \
         symmetry = \"none\""
    )]
    Reflected(String),
    #[error(
        "a rotation leaves the cycle {0} as it is or only moves it along itself (a rotating wave): period and drift are \
         not determined apart; leave out relative, or start at an NS point of the wave"
    )]
    Unmoved(String),
    #[error("the branches at {0} touch: there is no other direction to second order")]
    Touching(String),
    #[error("the start {0} does not move: it is an equilibrium")]
    Still(String),
    #[error("the start {0} has a period of {1}, which is not a positive number")]
    Period(String, f64),
    #[error("the first Lyapunov coefficient vanishes: third order does not decide where the cycles go")]
    Degenerate,
}

/// A branch of cycles in the making.
struct Cycles<'a> {
    prepared: &'a Prepared,
    task: &'a scene::Cycles,
    branch: Branch,
    /// Accepted points that are not rows yet: they become so beside the walk's next step.
    pending: Vec<Pending>,
    maker: Maker<'a>,
    /// How the first of two ways ended, once it has.
    behind: Option<(Status, String)>,
    /// The stretch of the free parameter in which bifurcations could not be looked for.
    blind: Option<(f64, f64)>,
}

/// Why a branch ended.
enum End {
    Stop(Stop),
    /// At a homoclinic orbit or a Hopf point, in a sentence.
    Recognised(String),
}

/// What stands beside a running task: where its state is kept, who watches, since when and how long before that.
#[derive(Clone, Copy)]
struct Tools<'a> {
    keeper: &'a Keeper,
    watch: &'a Watch,
    start: Instant,
    before: f64,
}

/// Which way along the branch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Way {
    /// The only one there is.
    Away,
    /// Of a start amid a branch first to smaller values of the parameter, then to larger ones; of the other branch at a
    /// branch point first one side, then the other.
    Down,
    Up,
}

/// Runs the task from its start; goes on from a checkpoint if there is one.
pub fn run(
    prepared: &Prepared,
    name: &str,
    task: &scene::Cycles,
    from: &SpecialPoint,
    keeper: &Keeper,
    watch: &Watch,
) -> Outcome {
    let start = Instant::now();
    let kept = keeper.load(name);
    let before = kept.as_ref().map_or(0.0, |kept| kept.seconds);
    let mut counts = kept.as_ref().map_or_else(Counts::default, |kept| kept.counts);
    let branch = empty(prepared, name, task);
    let maker = Maker::new(prepared, task, branch.columns.clone());
    let mut cycles = Cycles { prepared, task, branch, pending: Vec::new(), maker, behind: None, blind: None };
    let (status, mut reason) = match cycles.both_ways(from, kept, Tools { keeper, watch, start, before }, &mut counts) {
        Ok(end) => end,
        Err(failure) => (Status::Failed, failure.to_string()),
    };
    if let Some((low, high)) = cycles.blind {
        let name = &task.along.free;
        reason += &format!(
            "; for {name} from {low} to {high} bifurcations were not looked for at all points, for there the multipliers are lost to \
             rounding (the trivial one is not 1)"
        );
    }
    Outcome { branch: cycles.branch, status, reason, seconds: before + start.elapsed().as_secs_f64(), counts }
}

impl End {
    fn describe(self) -> (Status, String) {
        match self {
            End::Stop(Stop::Interrupted) => (Status::Interrupted, Stop::Interrupted.to_string()),
            End::Stop(stop @ Stop::Stagnation { .. }) => (Status::Failed, stop.to_string()),
            End::Stop(stop) => (Status::Done, stop.to_string()),
            End::Recognised(reason) => (Status::Done, reason),
        }
    }
}

impl Cycles<'_> {
    /// The branch from its start, both ways where it goes on both sides; status and reason.
    fn both_ways(
        &mut self,
        from: &SpecialPoint,
        mut kept: Option<Checkpoint>,
        tools: Tools,
        counts: &mut Counts,
    ) -> Result<(Status, String), CyclesError> {
        let origin = self.origin(from)?;
        if !matches!(origin, Origin::Amid { .. } | Origin::Cycle { flip: false, .. }) {
            return Ok(self.follow(&origin, Way::Away, kept, tools, counts)?.describe());
        }
        let mut behind = kept.as_mut().and_then(|kept| kept.behind.take());
        if behind.is_none() {
            let end = self.follow(&origin, Way::Down, kept.take(), tools, counts)?.describe();
            // A closed branch has been followed all the way round.
            if end.0 == Status::Interrupted || end.1 == Stop::Closed.to_string() {
                return Ok(end);
            }
            self.turn();
            behind = Some(end);
        }
        let (before, reason) = behind.clone().unwrap_or((Status::Done, String::new()));
        self.behind = behind;
        let (status, last) = self.follow(&origin, Way::Up, kept, tools, counts)?.describe();
        Ok(joined([(before, &reason), (status, &last)]))
    }

    /// The rows so far in opposite order: the way back to the start.
    fn turn(&mut self) {
        let count = self.branch.rows.len();
        self.branch.rows.reverse();
        self.branch.points.iter_mut().for_each(|point| point.row = count - 1 - point.row);
        self.maker.refinement = Refinement::default();
    }

    fn follow(
        &mut self,
        origin: &Origin,
        way: Way,
        kept: Option<Checkpoint>,
        Tools { keeper, watch, start, before }: Tools,
        counts: &mut Counts,
    ) -> Result<End, CyclesError> {
        let along = &self.task.along;
        let (low, high) = (along.range.from, along.range.to);
        let onset = origin.onset(self.prepared.free);
        let (mut system, state, mut signs, mut passages) = match kept {
            Some(Checkpoint { branch, orbit, walk, refined, blind, signs, passages, .. }) => {
                (self.branch, self.blind) = (branch, blind);
                let frame = self.frame(origin)?;
                self.maker.refinement = Refinement::at(self.prepared, &frame, refined);
                (Collocation::new(frame, &orbit), walk, signs, passages)
            }
            None => {
                let (system, state) = self.start(origin, way, counts)?;
                (system, state, None, Vec::new())
            }
        };
        system.tolerance = self.task.error();
        // Of two ways each has half of the points.
        let room = if way == Way::Down { along.max_points.div_ceil(2) } else { along.max_points };
        let wanted = self.wanted(system.frame.parts);
        let width = system.frame.scale_lambda;
        let mut walk = Walk::resume(&mut system, state, (low, high));
        loop {
            let stopping = watch.stopped();
            let keeping = stopping || keeper.due();
            if keeping {
                self.make_rows(counts);
                keeper.keep(Checkpoint {
                    branch: self.branch.clone(),
                    orbit: walk.system.reference().clone(),
                    walk: walk.state.clone(),
                    refined: self.maker.refinement.place(),
                    counts: *counts,
                    seconds: before + start.elapsed().as_secs_f64(),
                    behind: self.behind.clone(),
                    blind: self.blind,
                    signs: signs.clone(),
                    passages: passages.clone(),
                });
            }
            if stopping {
                return Ok(End::Stop(Stop::Interrupted));
            }
            if self.branch.rows.len() + self.pending.len() >= room {
                self.make_rows(counts);
                return Ok(End::Stop(Stop::MaxPoints));
            }
            let before_step = walk.counts;
            // Taken before the step, which may move the mesh; its row may be made already.
            let here = self.pending(&*walk.system, &walk.state.point, None, Some(Kind::MX), Special::default());
            let mut pending = std::mem::take(&mut self.pending);
            let (step, (rows, made)) = rayon::join(|| walk.step(), || self.maker.rows(&mut pending));
            *counts += made;
            self.append(&pending, rows);
            let step = match step {
                Ok(step) => step,
                Err(stop) => {
                    if self.branch.rows.last().is_some_and(|row| row.label.is_none()) {
                        self.name_last_row(&here, Kind::MX);
                    }
                    return Ok(End::Stop(stop));
                }
            };
            let lambda = step.to.lambda;
            if let Some(reason) = self.vanished(origin, &*walk.system, &step.from, &step.to) {
                if self.branch.rows.last().is_some_and(|row| row.label.is_none()) {
                    self.name_last_row(&here, Kind::EP);
                }
                return Ok(End::Recognised(reason));
            }
            let mut between = self.user_values(&*walk.system, &step, (counts, watch));
            let next = self.signs(&step.to, &step.factors, &wanted, counts);
            // At the first point nothing has been looked at yet: its signs come from the factors of the first step.
            let before = self.signs_before(&signs, &*walk.system, &step.from, &wanted, counts);
            let next = match (&before, next) {
                (Some(a), Some(b)) => Some(b.after(a)),
                (_, next) => next,
            };
            if let (Some(a), Some(b)) = (&before, &next) {
                let signs = [a, b];
                let segment = Segment { system: &*walk.system, from: &step.from, to: &step.to, signs, width };
                between.extend(self.bifurcations(&segment, &wanted, counts));
            }
            if next.is_none() && !wanted.is_empty() {
                let (low, high) = self.blind.unwrap_or((lambda, lambda));
                self.blind = Some((low.min(lambda), high.max(lambda)));
            }
            signs = next;
            between.sort_by(|x, y| x.fraction.total_cmp(&y.fraction));
            for Between { point, factors, kind, special, .. } in between {
                let pending = self.pending(&*walk.system, &point, factors, Some(kind), special);
                self.pending.push(pending);
            }
            passages.push(Passage::new(&*walk.system, &step.to));
            passages.drain(..passages.len().saturating_sub(KEPT));
            let homoclinic = Homoclinic::recognise(&passages, (&*walk.system, &step.to), high - low);
            let ended = homoclinic.is_some() || step.stop == Some(Stop::RangeEnd);
            let special = match &homoclinic {
                Some(end) => self.end(&*walk.system, &step.to, end, counts),
                None => Special::default(),
            };
            let kind = ended.then_some(Kind::EP);
            let pending = self.pending(&*walk.system, &step.to, Some(step.factors), kind, special);
            self.pending.push(pending);
            counts.newton += walk.counts.newton - before_step.newton;
            counts.residuals += walk.counts.residuals - before_step.residuals;
            counts.factorisations += walk.counts.factorisations - before_step.factorisations;
            let goal = if lambda > onset { high } else { low };
            watch.at((lambda - onset) / (goal - onset), format!("{} = {lambda:.6}", along.free));
            if let Some(end) = homoclinic {
                self.make_rows(counts);
                return Ok(End::Recognised(endless(&along.free, &end)));
            }
            if let Some(stop) = step.stop {
                self.make_rows(counts);
                return Ok(End::Stop(stop));
            }
        }
    }

    /// Whether the cycles shrink, within a step, to an equilibrium or to cycles of the kind that they come from.
    fn vanished(&self, origin: &Origin, system: &Collocation, from: &Point, to: &Point) -> Option<String> {
        let name = &self.task.along.free;
        if let Some(value) = Amplitude::Swing.vanishes(system, from, to) {
            let gap = (value - from.lambda).abs();
            let located = hopf_beside(system, from).filter(|at| (at - value).abs() < gap);
            return Some(format!(
                "the cycles shrink to an equilibrium: a Hopf point near {name} = {:.6}",
                located.unwrap_or(value)
            ));
        }
        let Origin::Cycle { stored, flip: true } = origin else { return None };
        let identity = Reflection::identity(stored.orbit.dim);
        let (symmetry, what) = match stored.orbit.parts {
            2 => (self.prepared.problem.reflection()?, "symmetric cycles"),
            _ => (identity, "cycles of half the period"),
        };
        let value = Amplitude::Halves(&symmetry).vanishes(system, from, to)?;
        Some(format!("the cycles become {what} near {name} = {value:.6}"))
    }

    /// Test functions at the beginning of a step: those known from the end of the last one.
    fn signs_before(
        &self,
        known: &Option<Signs>,
        system: &Collocation,
        from: &Point,
        wanted: &[Event],
        counts: &mut Counts,
    ) -> Option<Signs> {
        use crate::continuation::{Border, System};
        if known.is_some() || wanted.is_empty() {
            return known.clone();
        }
        let border = Border { row: system.dual(&from.tangent), lambda: system.dual_lambda() * from.tangent_lambda };
        counts.factorisations += 1;
        let factors = system.factor(&from.x, from.lambda, &border).ok()?;
        self.signs(from, &factors, wanted, counts)
    }

    /// An accepted point; its row is made later.
    fn pending(
        &self,
        system: &Collocation,
        point: &Point,
        factors: Option<Arc<OrbitFactors>>,
        kind: Option<Kind>,
        special: Special,
    ) -> Pending {
        Pending::new(system, point, factors.filter(|_| self.task.multipliers > 0), kind, special)
    }

    /// Notes an accepted point.
    fn push(&mut self, system: &Collocation, point: &Point, factors: OrbitFactors, kind: Option<Kind>) {
        let pending = self.pending(system, point, Some(Arc::new(factors)), kind, Special::default());
        self.pending.push(pending);
    }
}
