//! Tables on the terminal.

use comfy_table::{Cell, CellAlignment, ContentArrangement, presets};

/// A table with a header; the first column is text, the others are figures.
pub struct Table {
    table: comfy_table::Table,
}

impl Table {
    /// A table with these columns.
    pub fn new<const C: usize>(header: [&str; C]) -> Self {
        let mut table = comfy_table::Table::new();
        table.load_style(presets::UTF8_HORIZONTAL_ONLY);
        table.set_content_arrangement(ContentArrangement::Disabled);
        table.set_header(Self::cells(header.map(str::to_owned)));
        Self { table }
    }

    /// Appends a row.
    pub fn row<const C: usize>(&mut self, cells: [String; C]) {
        self.table.add_row(Self::cells(cells));
    }

    fn cells<const C: usize>(texts: [String; C]) -> Vec<Cell> {
        let align = |column| if column == 0 { CellAlignment::Left } else { CellAlignment::Right };
        texts.into_iter().enumerate().map(|(column, text)| Cell::new(text).set_alignment(align(column))).collect()
    }
}

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.table.fmt(f)
    }
}
