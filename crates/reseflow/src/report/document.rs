//! A report as a list of blocks, before it becomes HTML or Markdown.

use crate::plot::Picture;

/// A part of the report.
pub(super) enum Block {
    /// The title of a section.
    Section(String),
    /// The title of a part of one.
    Part(String),
    /// A paragraph.
    Text(String),
    /// What is left out, and why.
    Absent(String),
    /// Figures in rows.
    Table(Table),
    /// A picture.
    Figure(Box<Figure>),
    /// A text that is shown when asked for.
    Folded { title: String, text: String },
}

/// A table: the first column is text, the others are figures.
pub(super) struct Table {
    pub(super) caption: String,
    pub(super) header: Vec<String>,
    pub(super) rows: Vec<Vec<String>>,
}

/// A picture with what it shows.
pub(super) struct Figure {
    /// The name of its files.
    pub(super) name: String,
    pub(super) caption: String,
    pub(super) picture: Picture,
}

impl Block {
    pub(super) fn text(text: impl Into<String>) -> Self {
        Self::Text(text.into())
    }

    pub(super) fn absent(text: impl Into<String>) -> Self {
        Self::Absent(text.into())
    }

    pub(super) fn figure(name: impl Into<String>, caption: impl Into<String>, picture: Picture) -> Self {
        Self::Figure(Box::new(Figure { name: name.into(), caption: caption.into(), picture }))
    }
}

impl Table {
    /// An empty table.
    pub(super) fn new<const C: usize>(caption: impl Into<String>, header: [&str; C]) -> Self {
        Self { caption: caption.into(), header: header.map(str::to_owned).to_vec(), rows: Vec::new() }
    }

    /// Appends a row.
    pub(super) fn row<const C: usize>(&mut self, cells: [String; C]) {
        self.rows.push(cells.to_vec());
    }

    /// The table, or a sentence where it has no row.
    pub(super) fn or_absent(self, sentence: &str) -> Block {
        if self.rows.is_empty() { Block::absent(sentence) } else { Block::Table(self) }
    }
}

/// What stands where there is no figure.
pub(super) fn dash() -> String {
    "–".to_owned()
}

/// A number in four decimals.
pub(super) fn decimals(value: f64) -> String {
    format!("{value:.4}")
}

/// A number in four decimals, or a dash.
pub(super) fn optional(value: Option<f64>) -> String {
    value.map_or_else(dash, decimals)
}

/// A share in per cent, with its sign.
pub(super) fn signed_percent(share: f64) -> String {
    format!("{}{}", if share >= 0.0 { "+" } else { "" }, percent(share))
}

/// A share in per cent.
pub(super) fn percent(share: f64) -> String {
    format!("{:.1} %", 100.0 * share)
}
