//! Tables on the terminal.

use comfy_table::{Cell, CellAlignment, ContentArrangement, LineStyle, TableStyle};

/// A rule above, below and under the header; nothing between the rows.
const STYLE: TableStyle = TableStyle::new()
    .top_border(LineStyle::none().fill('─').junction('─'))
    .header_separator(LineStyle::none().fill('─').junction('─'))
    .bottom_border(LineStyle::none().fill('─').junction('─'));

/// A table with a header.
pub struct Table {
    table: comfy_table::Table,
    others: CellAlignment,
}

impl Table {
    /// A table whose first column is text and whose others are figures.
    pub fn figures<const C: usize>(header: [&str; C]) -> Self {
        Self::with_alignment(header, CellAlignment::Right)
    }

    /// A table of names and what there is to say about each, as wide as the terminal; `subject` is what it is all about.
    pub fn facts(kind: &str, subject: &str) -> Self {
        let mut table = Self::with_alignment([kind, subject], CellAlignment::Left);
        // Where there is no terminal this wraps nothing, and every fact keeps to its line.
        table.table.set_content_arrangement(ContentArrangement::Dynamic);
        table
    }

    fn with_alignment<const C: usize>(header: [&str; C], others: CellAlignment) -> Self {
        let mut table = comfy_table::Table::new();
        table.load_style(STYLE);
        table.set_content_arrangement(ContentArrangement::Disabled);
        let mut table = Self { table, others };
        let header = table.cells(header.map(str::to_owned));
        table.table.set_header(header);
        table
    }

    /// Appends a row.
    pub fn row<const C: usize>(&mut self, cells: [String; C]) {
        let cells = self.cells(cells);
        self.table.add_row(cells);
    }

    /// Appends a row of a table of facts.
    pub fn fact(&mut self, name: &str, value: impl std::fmt::Display) {
        self.row([name.to_owned(), value.to_string()]);
    }

    fn cells<const C: usize>(&self, texts: [String; C]) -> Vec<Cell> {
        let alignment = |column| if column == 0 { CellAlignment::Left } else { self.others };
        let cell = |(column, text)| Cell::new::<String>(text).set_alignment(alignment(column));
        texts.into_iter().enumerate().map(cell).collect()
    }
}

impl std::fmt::Display for Table {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.table.trim_fmt())
    }
}
