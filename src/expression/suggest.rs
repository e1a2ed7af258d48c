//! Near misses.

/// The known word that `word` is most likely a slip of the pen for.
pub fn suggest<'a>(word: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let lower = word.to_lowercase();
    known
        .into_iter()
        .map(|candidate| {
            let distance = strsim::damerau_levenshtein(&lower, &candidate.to_lowercase());
            (distance, candidate)
        })
        .filter(|(distance, candidate)| *distance <= (candidate.chars().count().max(lower.chars().count()) / 3).min(4))
        .min_by_key(|(distance, _)| *distance)
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggestions_bridge_slips_but_not_gulfs() {
        let known = ["range", "free", "max_step", "p", "L"];
        assert_eq!(suggest("rnage", known), Some("range"));
        assert_eq!(suggest("max-step", known), Some("max_step"));
        assert_eq!(suggest("FREE", known), Some("free"));
        assert_eq!(suggest("P", known), Some("p"));
        assert_eq!(suggest("l", known), Some("L"));
        assert_eq!(suggest("q", known), None);
        assert_eq!(suggest("tolerance", known), None);
        assert_eq!(suggest("", known), None);
    }
}
