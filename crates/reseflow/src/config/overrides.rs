//! `--set train.batch_size=8`, `--camera points=64`: a key of a configuration, overridden on the command line.

use std::str::FromStr;

use toml::{Table, Value};

/// One `--set PATH=VALUE`, or another option of that form.
#[derive(Debug, Clone, PartialEq)]
pub struct Override {
    flag: &'static str,
    path: Vec<String>,
    value: Value,
}

impl Override {
    /// Reads `a.b=VALUE` as given to the option `flag`; `example` is quoted where it is not of that form.
    ///
    /// VALUE is TOML (`8`, `1e-3`, `true`, `[1, 2]`, `"text"`); what is not TOML is taken as text.
    ///
    /// # Errors
    /// A sentence that says what was expected.
    pub fn read(text: &str, flag: &'static str, example: &str) -> Result<Self, String> {
        let expected = || format!("expected KEY=VALUE, for example {example}, got `{text}`");
        let (key, value) = text.split_once('=').ok_or_else(expected)?;
        let path: Vec<String> = key.trim().split('.').map(|part| part.trim().to_owned()).collect();
        if path.iter().any(String::is_empty) {
            return Err(expected());
        }
        let value = value.trim();
        let parsed = toml::from_str::<Table>(&format!("value = {value}")).ok();
        let parsed = parsed.and_then(|mut table| table.remove("value"));
        Ok(Self { flag, path, value: parsed.unwrap_or_else(|| Value::String(value.to_owned())) })
    }

    /// What messages call it: the option and the dotted key.
    pub fn place(&self) -> String {
        format!("{} {}", self.flag, self.key())
    }

    /// The dotted key.
    pub fn key(&self) -> String {
        self.path.join(".")
    }

    /// Writes the value into `table`, making the tables on the way.
    ///
    /// # Errors
    /// A sentence, when a key on the way holds something that is not a table.
    pub fn apply(&self, table: &mut Table) -> Result<(), String> {
        let Some((last, parents)) = self.path.split_last() else { return Ok(()) };
        let mut table = table;
        for (depth, parent) in parents.iter().enumerate() {
            let entry = table.entry(parent.clone()).or_insert_with(|| Value::Table(Table::new()));
            table = entry.as_table_mut().ok_or_else(|| {
                let parent = self.path[..=depth].join(".");
                format!("{}: `{parent}` is a value, not a table with keys", self.place())
            })?;
        }
        table.insert(last.clone(), self.value.clone());
        Ok(())
    }
}

impl FromStr for Override {
    type Err = String;

    /// Reads what was given to `--set`, as [`Override::read`].
    fn from_str(text: &str) -> Result<Self, String> {
        Self::read(text, "--set", "train.batch_size=8")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_are_toml_and_else_text() {
        let mut table = Table::new();
        for text in ["a.b=8", "a.rate=1e-3", "a.list=[1, 2]", "task=door", "name=\"two words\""] {
            text.parse::<Override>().unwrap().apply(&mut table).unwrap();
        }
        let expected = "task = 'door'\nname = 'two words'\n[a]\nb = 8\nrate = 1e-3\nlist = [1, 2]";
        assert_eq!(table, toml::from_str::<Table>(expected).unwrap());
    }

    #[test]
    fn nonsense_is_refused() {
        for text in ["", "a", "=3", "a..b=3"] {
            assert!(text.parse::<Override>().is_err(), "{text}");
        }
        let mut table: Table = toml::from_str("a = 1").unwrap();
        let fault = "a.b=2".parse::<Override>().unwrap().apply(&mut table).unwrap_err();
        assert!(fault.contains("`a` is a value"), "{fault}");
    }
}
