//! Names defined by a scene.

use super::item::Item;
use crate::base::Result;

/// The entries of a table whose keys are their names; a name becomes part of column and file names.
pub(in crate::scene) fn named<T>(
    item: &Item,
    read: impl Fn(String, &Item) -> Result<T>,
) -> Result<Vec<T>> {
    let entries = item.open_table()?;
    let one = |(name, item): (&str, Item)| match is_identifier(name) {
        true => read(name.to_string(), &item),
        false => Err(item.key_error(format!("`{name}` cannot be a name here")).remedy(IDENTIFIER)),
    };
    entries.items().map(one).collect()
}

/// The tables of a list, each with a name distinct from all others and from those in `taken`.
pub(in crate::scene) fn distinct<T>(
    item: Option<Item>,
    taken: &[&str],
    read: impl Fn(&Item) -> Result<T>,
    name: impl Fn(&T) -> &str,
) -> Result<Vec<T>> {
    let Some(item) = item else { return Ok(Vec::new()) };
    let mut all: Vec<T> = Vec::new();
    for item in item.list()? {
        let one = read(&item)?;
        if all.iter().map(&name).chain(taken.iter().copied()).any(|n| n == name(&one)) {
            let named = item.open_table()?.get("name").unwrap_or(item);
            return Err(named
                .error(format!("two interfaces are named `{}`", name(&one)))
                .remedy("give each of them a name of its own"));
        }
        all.push(one);
    }
    Ok(all)
}

const IDENTIFIER: &str = "use letters, digits, `_` and `-`, and begin with a letter";

/// A name that becomes part of column and file names.
pub(in crate::scene) fn identifier(item: &Item) -> Result<String> {
    let name = item.text()?;
    if is_identifier(name) {
        return Ok(name.to_string());
    }
    Err(item.error(format!("\"{name}\" cannot be a name here")).remedy(IDENTIFIER))
}

fn is_identifier(name: &str) -> bool {
    let allowed = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
    name.starts_with(|c: char| c.is_ascii_alphabetic()) && name.chars().all(allowed)
}
