//! Strict TOML: every fault of a configuration file is one sentence with the file, the line, the key and what was expected.

use std::path::Path;

use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_path_to_error::Segment;
use toml::Table;
use toml::de::{DeTable, DeValue};

use super::nearest::nearest;
use super::overrides::Override;
use crate::error::bad_input;

/// Reads the TOML file at `path` with `overrides` applied.
///
/// # Errors
/// Bad input: the file cannot be read, is not TOML, holds an unknown key or a value of the wrong type.
pub fn load<T>(path: &Path, overrides: &[Override]) -> anyhow::Result<T>
where
    T: DeserializeOwned + Serialize + Default,
{
    let place = path.display().to_string();
    let text = std::fs::read_to_string(path).map_err(|reason| bad_input(format!("{place}: {reason}")))?;
    parse(&text, &place, overrides)
}

/// Reads TOML `text`; `place` is what messages call it.
///
/// # Errors
/// As [`load`].
pub fn parse<T>(text: &str, place: &str, overrides: &[Override]) -> anyhow::Result<T>
where
    T: DeserializeOwned + Serialize + Default,
{
    let mut table: Table = toml::from_str(text).map_err(|error| {
        let line = error.span().map(|span| format!(":{}", line_of(text, span.start))).unwrap_or_default();
        bad_input(format!("{place}{line}: not valid TOML: {}", error.message()))
    })?;
    for item in overrides {
        item.apply(&mut table).map_err(bad_input)?;
    }
    serde_path_to_error::deserialize(table).map_err(|error| {
        let path = segments(error.path());
        bad_input(describe::<T>(&path, error.inner().message(), text, place, overrides))
    })
}

fn segments(path: &serde_path_to_error::Path) -> Vec<String> {
    path.iter()
        .filter_map(|segment| match segment {
            Segment::Map { key } => Some(key.clone()),
            Segment::Seq { index } => Some(index.to_string()),
            Segment::Enum { .. } | Segment::Unknown => None,
        })
        .collect()
}

/// Turns serde's message about the value at `path` into a sentence that says where, what and what was expected.
fn describe<T: Serialize + Default>(
    path: &[String],
    message: &str,
    text: &str,
    place: &str,
    overrides: &[Override],
) -> String {
    let mut quoted = message.split('`').skip(1).step_by(2);
    if message.starts_with("unknown field") {
        let key = quoted.next().unwrap_or_default().to_owned();
        let siblings: Vec<String> = quoted.map(str::to_owned).collect();
        let mut full = path.to_vec();
        if full.last() != Some(&key) {
            full.push(key.clone());
        }
        let place = locate(&full, text, place, overrides);
        let parent = &full[..full.len() - 1];
        let hint = match nearest_key::<T>(&key, parent, &siblings) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!("known keys here: {}", siblings.join(", ")),
        };
        return format!("{place}: unknown key `{}`; {hint}", full.join("."));
    }
    let key = path.join(".");
    let place = locate(path, text, place, overrides);
    if message.starts_with("unknown variant") {
        let value = quoted.next().unwrap_or_default().to_owned();
        let known: Vec<&str> = quoted.collect();
        let hint = nearest(&value, known.iter().copied()).map(|near| format!("; did you mean `{near}`?"));
        let known = known.join(", ");
        return format!("{place}: `{key}` is `{value}`, expected one of {known}{}", hint.unwrap_or_default());
    }
    if let Some((got, expected)) = message.split_once(", expected ") {
        let got = got.trim_start_matches("invalid type: ").trim_start_matches("invalid value: ");
        return format!("{place}: `{key}` is {got}, expected {}", plain_type(expected));
    }
    if key.is_empty() { format!("{place}: {message}") } else { format!("{place}: `{key}`: {message}") }
}

/// The name of a Rust type in words that a user of a configuration file knows.
fn plain_type(expected: &str) -> &str {
    match expected {
        "usize" | "u64" | "u32" | "u16" | "u8" => "a whole number, 0 or more",
        "isize" | "i64" | "i32" => "a whole number",
        "f64" | "f32" => "a number",
        other => other,
    }
}

/// `file:line` of the key at `path`, or the override that set it.
fn locate(path: &[String], text: &str, place: &str, overrides: &[Override]) -> String {
    let key = path.join(".");
    if let Some(item) =
        overrides.iter().rev().find(|item| key == item.key() || item.key().starts_with(&format!("{key}.")))
    {
        return item.place();
    }
    match line_of_key(path, text) {
        Some(line) => format!("{place}:{line}"),
        None => place.to_owned(),
    }
}

fn line_of_key(path: &[String], text: &str) -> Option<usize> {
    let document = DeTable::parse(text).ok()?;
    let mut table = document.get_ref();
    let mut line = None;
    for (depth, name) in path.iter().enumerate() {
        let (key, value) = table.iter().find(|(key, _)| key.get_ref().as_ref() == name.as_str())?;
        line = Some(line_of(text, key.span().start));
        match value.get_ref() {
            DeValue::Table(inner) => table = inner,
            _ if depth + 1 < path.len() => break,
            _ => {}
        }
    }
    line
}

fn line_of(text: &str, offset: usize) -> usize {
    text.bytes().take(offset).filter(|&byte| byte == b'\n').count() + 1
}

/// The known key nearest to `key`: first among its siblings, then anywhere in the configuration.
fn nearest_key<T: Serialize + Default>(key: &str, parent: &[String], siblings: &[String]) -> Option<String> {
    let qualified =
        |name: &str| parent.iter().map(String::as_str).chain([name]).collect::<Vec<_>>().join(".");
    if let Some(sibling) = nearest(key, siblings.iter().map(String::as_str)) {
        return Some(qualified(sibling));
    }
    let mut all = Vec::new();
    if let Ok(default) = serde_json::to_value(T::default()) {
        collect_keys(&default, String::new(), &mut all);
    }
    let leaf = |path: &str| path.rsplit('.').next().unwrap_or_default().to_owned();
    let leaves: Vec<String> = all.iter().map(|path| leaf(path)).collect();
    let near = nearest(key, leaves.iter().map(String::as_str))?;
    all.iter().find(|path| leaf(path) == near).cloned()
}

fn collect_keys(value: &serde_json::Value, prefix: String, keys: &mut Vec<String>) {
    let serde_json::Value::Object(map) = value else { return };
    for (name, inner) in map {
        let path = if prefix.is_empty() { name.clone() } else { format!("{prefix}.{name}") };
        keys.push(path.clone());
        collect_keys(inner, path, keys);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde::Deserialize;

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    struct Inner {
        batch_size: usize,
        learning_rate: f64,
        path: Shape,
    }

    #[derive(Debug, PartialEq, Serialize, Deserialize)]
    #[serde(rename_all = "snake_case")]
    enum Shape {
        Screw,
        Product,
    }

    impl Default for Inner {
        fn default() -> Self {
            Self { batch_size: 16, learning_rate: 1e-3, path: Shape::Screw }
        }
    }

    #[derive(Debug, Default, PartialEq, Serialize, Deserialize)]
    #[serde(default, deny_unknown_fields)]
    struct Outer {
        name: String,
        train: Inner,
    }

    fn fault(text: &str, sets: &[&str]) -> String {
        let sets: Vec<Override> = sets.iter().map(|set| set.parse().unwrap()).collect();
        parse::<Outer>(text, "a.toml", &sets).unwrap_err().to_string()
    }

    #[test]
    fn overrides_win_over_the_file() {
        let sets = ["train.batch_size=8".parse().unwrap()];
        let config: Outer = parse("name = 'x'\n[train]\nbatch_size = 4", "a.toml", &sets).unwrap();
        assert_eq!(config.train.batch_size, 8);
        assert_eq!(config.name, "x");
    }

    #[test]
    fn every_fault_names_place_key_and_expectation() {
        let cases = [
            (
                "name = 'x'\n\n[train]\nbath_size = 8",
                "a.toml:4: unknown key `train.bath_size`; did you mean `train.batch_size`?",
            ),
            ("batch_size = 8", "a.toml:1: unknown key `batch_size`; did you mean `train.batch_size`?"),
            ("zzz = 8", "a.toml:1: unknown key `zzz`; known keys here: name, train"),
            (
                "[train]\nbatch_size = 'eight'",
                "a.toml:2: `train.batch_size` is string \"eight\", expected a whole number, 0 or more",
            ),
            (
                "[train]\nbatch_size = -1",
                "a.toml:2: `train.batch_size` is integer `-1`, expected a whole number, 0 or more",
            ),
            (
                "[train]\nlearning_rate = true",
                "a.toml:2: `train.learning_rate` is boolean `true`, expected a number",
            ),
            (
                "[train]\npath = 'screws'",
                "a.toml:2: `train.path` is `screws`, expected one of screw, product; did you mean `screw`?",
            ),
            ("train = 3", "a.toml:1: `train` is integer `3`, expected struct Inner"),
        ];
        for (text, expected) in cases {
            assert_eq!(fault(text, &[]), expected);
        }
        assert!(fault("name = ", &[]).starts_with("a.toml:1: not valid TOML: "));
    }

    #[test]
    fn a_fault_in_an_override_names_the_override() {
        let expected =
            "--set train.bath_size: unknown key `train.bath_size`; did you mean `train.batch_size`?";
        assert_eq!(fault("", &["train.bath_size=8"]), expected);
        assert!(
            fault("", &["train.batch_size=x"])
                .starts_with("--set train.batch_size: `train.batch_size` is string")
        );
    }
}
