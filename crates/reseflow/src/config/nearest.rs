//! The known name that a mistyped one most likely meant.

/// Below this similarity a suggestion would puzzle more than it helps.
const MIN_SIMILARITY: f64 = 0.6;

/// The candidate most similar to `name`, if one is similar enough.
pub fn nearest<'a>(name: &str, candidates: impl Iterator<Item = &'a str>) -> Option<&'a str> {
    let similarity =
        |candidate: &str| strsim::normalized_damerau_levenshtein(&name.to_lowercase(), candidate);
    candidates
        .map(|candidate| (similarity(candidate), candidate))
        .filter(|(score, _)| *score >= MIN_SIMILARITY)
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, candidate)| candidate)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suggests_what_is_near_and_nothing_else() {
        let tasks = ["triangle", "door", "painting"];
        assert_eq!(nearest("traingle", tasks.into_iter()), Some("triangle"));
        assert_eq!(nearest("Doors", tasks.into_iter()), Some("door"));
        assert_eq!(nearest("cube", tasks.into_iter()), None);
    }
}
