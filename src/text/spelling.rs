//! Words that are meant by misspelt ones.

/// The word nearest to `word`, if it is near enough to be a slip of the pen.
pub(crate) fn nearest<'k>(word: &str, known: &[&'k str]) -> Option<&'k str> {
    let plain = |s: &str| s.to_lowercase().replace('-', "_");
    let word = plain(word);
    let (distance, near) = known.iter().map(|k| (edit_distance(&word, &plain(k)), *k)).min_by_key(|(d, _)| *d)?;
    let part_of = word.len() >= 3 && (near.starts_with(&word) || word.starts_with(near));
    (distance <= 1 + near.len() / 3 || part_of).then_some(near)
}

/// Levenshtein's distance: insertions, deletions and replacements that turn `a` into `b`.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edit_distances_are_levenshteins() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("abc", ""), 3);
        assert_eq!(edit_distance("same", "same"), 0);
    }

    #[test]
    fn the_nearest_key_is_offered_only_when_it_is_near() {
        let known = ["weather", "scene", "window", "sensors", "method", "quality"];
        assert_eq!(nearest("windows", &known), Some("window"));
        assert_eq!(nearest("Sensor", &known), Some("sensors"));
        assert_eq!(nearest("wether", &known), Some("weather"));
        assert_eq!(nearest("colour", &known), None);
        assert_eq!(nearest("x", &[]), None);
    }
}
