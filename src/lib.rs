//! Continuation and bifurcation of `M(u, p) u' = F(u, p)`: equilibria, their eigenvalues, Hopf points, limit cycles,
//! with an estimate of the error on every number.
//!
//! # The map
//!
//! Everything that is solved for comes from one residual, `G(u, v, p) = M(u, p) v - F(u, p)`, and its exact derivatives
//! in (u, v, p): equilibria are `G(u, 0, p) = 0`, eigenvalues `(G_u + sigma G_v) q = 0`, orbits `G(u, u', p) = 0`.
//! Every curve that is followed is a [`continuation::System`], n equations in n unknowns and a parameter; one loop,
//! [`continuation::Walk`], follows them all.
//!
//! | module | what it holds | look at first |
//! |---|---|---|
//! | [`problem`] | what is followed: [`problem::Problem`], and [`problem::Formula`] from which the rest is derived by dual numbers | `problem::Formula` |
//! | [`linalg`] | LU, bordered systems, eigenvalues of pencils and of products | `linalg::pencil` |
//! | [`continuation`] | predictor, corrector, step control, points between points; surfaces by charts | `continuation::Walk` |
//! | [`bifurcation`] | equilibria as curves and over grids, eigenvalue branches, Hopf points and folds, their curves and surfaces, normal forms, calibration | `bifurcation::Hopf` |
//! | [`orbit`] | collocation, condensation, mesh, multipliers, start from a Hopf point; bifurcations of cycles and their curves | `orbit::Collocation`, `orbit::bifurcations` |
//! | `simulate` | time integration, and what motions settle on (feature `simulation`) | `simulate::settle` |
//! | [`expression`] | arithmetic as text: grammar, tree, statements of models | `expression::Node` |
//! | [`import`] | models of other programs, rewritten as scenes | `import::read` |
//! | [`models`] | the models that scenes can name | `models::TwoDoublet` |
//! | [`scene`] | TOML to typed scene, units, errors with file and line | `scene::Scene` |
//! | [`branch`] | what was found, as plain data; CSV and NPZ | `branch::Branch` |
//! | [`plot`] | branches to SVG | `plot::draw` |
//! | [`run`] | the conductor: scene, problem, continuation, branch, files | `run::run` |
//! | [`cli`] | the command line's words | |
//!
//! # In a program of your own
//!
//! ```
//! use hopfline::problem::{Automatic, Bounds, Default, Formula, Parameter, Scalar};
//! use hopfline::bifurcation::{Hopf, HopfNormalForm};
//! use hopfline::linalg::c64;
//!
//! /// x' = mu x - y - x (x² + y²), y' = x + mu y - y (x² + y²).
//! struct Circle([Parameter; 1]);
//!
//! impl Formula for Circle {
//!     fn dim(&self) -> usize {
//!         2
//!     }
//!     fn parameters(&self) -> &[Parameter] {
//!         &self.0
//!     }
//!     fn residual<S: Scalar>(&self, u: &[S], v: &[S], p: &[S], g: &mut [S]) {
//!         let r2 = u[0] * u[0] + u[1] * u[1];
//!         g[0] = v[0] - (p[0] * u[0] - u[1] - u[0] * r2);
//!         g[1] = v[1] - (u[0] + p[0] * u[1] - u[1] * r2);
//!     }
//! }
//!
//! let mu = Parameter { name: "mu", default: Default::Value(0.1), unit: "", meaning: "growth", bounds: Bounds::Any };
//! let problem = Automatic(Circle([mu]));
//! let (q, near) = ([c64::new(1.0, 0.0), c64::new(0.0, -1.0)], [0.1]);
//! let hopf = Hopf::locate(&problem, (&[0.0, 0.0], &near), 0, 1.1, &q)?;
//! assert!(hopf.p[0].abs() < 1e-14 && (hopf.omega - 1.0).abs() < 1e-14);
//! assert!(HopfNormalForm::new(&problem, &hopf)?.l1 < 0.0);
//! # Ok::<(), hopfline::bifurcation::HopfError>(())
//! ```

pub mod bifurcation;
pub mod branch;
#[cfg(feature = "program")]
pub mod cli;
pub mod continuation;
#[cfg(feature = "program")]
pub mod expression;
#[cfg(feature = "program")]
pub mod import;
pub mod linalg;
pub mod models;
pub mod orbit;
#[cfg(feature = "program")]
pub mod plot;
pub mod problem;
#[cfg(feature = "program")]
pub mod run;
#[cfg(feature = "program")]
pub mod scene;
#[cfg(feature = "simulation")]
pub mod simulate;
