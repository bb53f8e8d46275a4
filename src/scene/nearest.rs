//! Nearest known name to a misspelt one.

/// The candidate with the smallest edit distance to `name`, if the distance is small.
pub(crate) fn nearest<'a>(
    name: &str,
    candidates: impl IntoIterator<Item = &'a str>,
) -> Option<&'a str> {
    let lower = name.to_lowercase();
    candidates
        .into_iter()
        .map(|c| (edits(&lower, &c.to_lowercase()), c))
        .filter(|&(d, c)| {
            d < c.len().min(name.len()).max(1) && d <= 1 + c.len().min(name.len()) / 4
        })
        .min_by_key(|&(d, _)| d)
        .map(|(_, c)| c)
}

/// The advice for a name that is not among `known`: the nearest one, then the whole list.
pub(crate) fn advice<'a>(name: &str, known: impl IntoIterator<Item = &'a str> + Clone) -> String {
    let all: Vec<&str> = known.clone().into_iter().collect();
    let all = all.join(", ");
    match nearest(name, known) {
        Some(n) => format!("did you mean `{n}`? Known here: {all}"),
        None => format!("known here: {all}"),
    }
}

/// Levenshtein distance with transpositions of neighbours (optimal string alignment, Damerau 1964).
fn edits(a: &str, b: &str) -> usize {
    let (a, b): (Vec<char>, Vec<char>) = (a.chars().collect(), b.chars().collect());
    let mut before = vec![0; b.len() + 1];
    let mut last: Vec<usize> = (0..=b.len()).collect();
    for i in 1..=a.len() {
        let mut row = vec![i; b.len() + 1];
        for j in 1..=b.len() {
            let swap = i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1];
            let replaced = last[j - 1] + usize::from(a[i - 1] != b[j - 1]);
            row[j] = replaced.min(last[j] + 1).min(row[j - 1] + 1);
            if swap {
                row[j] = row[j].min(before[j - 2] + 1);
            }
        }
        before = std::mem::replace(&mut last, row);
    }
    last[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edits_counts_insertions_replacements_and_swaps() {
        assert_eq!(edits("", "abc"), 3);
        assert_eq!(edits("viscosity", "viscosty"), 1);
        assert_eq!(edits("centre", "center"), 1);
        assert_eq!(edits("kitten", "sitting"), 3);
    }

    #[test]
    fn the_nearest_name_is_found_and_a_far_one_is_not() {
        assert_eq!(nearest("viscosty", ["density", "viscosity"]), Some("viscosity"));
        assert_eq!(nearest("Sin", ["cos", "sin"]), Some("sin"));
        assert_eq!(nearest("colour", ["density", "viscosity"]), None);
        assert_eq!(nearest("q", ["x", "y"]), None, "one letter for another is no misprint");
        assert_eq!(nearest("X", ["x", "y"]), Some("x"));
    }
}
