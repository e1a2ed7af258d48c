//! What a task leaves behind.

use crate::branch::{Branch, Kind};
use crate::continuation::Counts;
use serde::{Deserialize, Serialize};

#[derive(Clone, Copy, Debug, Serialize, Deserialize, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    Done,
    Interrupted,
    Failed,
}

/// A task's branch and how it went.
#[derive(Clone, Debug, Serialize, Deserialize, PartialEq)]
pub struct Outcome {
    pub branch: Branch,
    pub status: Status,
    /// Why the branch ended, in a sentence.
    pub reason: String,
    pub seconds: f64,
    pub counts: Counts,
}

impl Outcome {
    /// A task that got nowhere.
    pub fn failed(branch: Branch, reason: String) -> Self {
        Self { branch, status: Status::Failed, reason, seconds: 0.0, counts: Counts::default() }
    }
}

/// Why a curve that was followed both ways ended, and its status.
pub fn joined(ways: [(Status, &str); 2]) -> (Status, String) {
    let status = ways.into_iter().map(|(status, _)| status).find(|s| *s != Status::Done).unwrap_or(Status::Done);
    let [(_, down), (_, up)] = ways;
    let reason = if down == up { up.to_owned() } else { format!("one way: {down}; the other: {up}") };
    (status, reason)
}

/// The next label of a kind: "HB1" and "straight/HB1".
pub fn labels(branch: &Branch, kind: Kind) -> (String, String) {
    let count = branch.points.iter().filter(|p| p.kind == kind).count();
    let short = format!("{kind}{}", count + 1);
    let whole = format!("{}/{short}", branch.name);
    (short, whole)
}
