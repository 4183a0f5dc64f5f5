//! The report as Markdown.

use super::document::{Block, Table};

/// The whole text.
pub(super) fn render(title: &str, blocks: &[Block]) -> String {
    let mut text = format!("# {title}\n");
    for block in blocks {
        text.push('\n');
        match block {
            Block::Section(title) => text.push_str(&format!("## {title}\n")),
            Block::Part(title) => text.push_str(&format!("### {title}\n")),
            Block::Text(sentences) => text.push_str(&format!("{sentences}\n")),
            Block::Absent(sentence) => text.push_str(&format!("*Left out: {sentence}*\n")),
            Block::Table(table) => text.push_str(&rows(table)),
            Block::Figure(figure) => {
                let alt = figure.picture.title();
                text.push_str(&format!("![{alt}](figures/{}.png)\n\n{}\n", figure.name, figure.caption));
            }
            Block::Folded { title, text: folded } => {
                let folded = folded.trim_end();
                text.push_str(&format!(
                    "<details><summary>{title}</summary>\n\n```toml\n{folded}\n```\n\n</details>\n"
                ));
            }
        }
    }
    text
}

/// A table: its caption, then its rows.
pub(super) fn rows(table: &Table) -> String {
    let line = |cells: &[String]| {
        let cells: Vec<String> = cells.iter().map(|cell| cell.replace('|', "\\|")).collect();
        format!("| {} |\n", cells.join(" | "))
    };
    let rule: Vec<&str> =
        (0..table.header.len()).map(|column| if column == 0 { "---" } else { "---:" }).collect();
    let body: String = table.rows.iter().map(|row| line(row)).collect();
    format!("{}\n\n{}| {} |\n{body}", table.caption, line(&table.header), rule.join(" | "))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_of_a_table_has_as_many_cells() {
        let mut table = Table::new("What it is.", ["a", "b", "c"]);
        table.row(["x|y", "1", "2"].map(str::to_owned));
        let text = render("t", &[Block::Table(table)]);
        let lines: Vec<&str> = text.lines().filter(|line| line.starts_with('|')).collect();
        assert_eq!(lines, ["| a | b | c |", "| --- | ---: | ---: |", "| x\\|y | 1 | 2 |"]);
    }
}
