//! The report as one HTML file that needs nothing else: style and figures lie in it.

use super::document::{Block, Table};
use crate::plot::PlotError;

const STYLE: &str = include_str!("style.css");

/// The whole file.
///
/// # Errors
/// When a figure cannot be drawn.
pub(super) fn render(title: &str, blocks: &[Block]) -> Result<String, PlotError> {
    let mut body = String::new();
    let mut contents = String::new();
    let mut sections = 0;
    for block in blocks {
        match block {
            Block::Section(title) => {
                if sections > 0 {
                    body.push_str("</section>\n");
                }
                sections += 1;
                let title = escaped(title);
                contents.push_str(&format!("<li><a href=\"#s{sections}\">{title}</a></li>\n"));
                body.push_str(&format!("<section id=\"s{sections}\">\n<h2>{title}</h2>\n"));
            }
            Block::Part(title) => body.push_str(&format!("<h3>{}</h3>\n", escaped(title))),
            Block::Text(sentences) => body.push_str(&format!("<p>{}</p>\n", escaped(sentences))),
            Block::Absent(sentence) => {
                body.push_str(&format!("<p class=\"absent\">Left out: {}</p>\n", escaped(sentence)));
            }
            Block::Table(table) => body.push_str(&rows(table)),
            Block::Figure(figure) => {
                let svg = inline(&figure.picture.svg()?, figure.picture.title());
                let caption = escaped(&figure.caption);
                body.push_str(&format!("<figure>\n{svg}<figcaption>{caption}</figcaption>\n</figure>\n"));
            }
            Block::Folded { title, text } => body.push_str(&format!(
                "<details><summary>{}</summary><pre>{}</pre></details>\n",
                escaped(title),
                escaped(text.trim_end())
            )),
        }
    }
    if sections > 0 {
        body.push_str("</section>\n");
    }
    let title = escaped(title);
    Ok(format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\" />\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\" />\n\
         <meta name=\"color-scheme\" content=\"light dark\" />\n<title>{title}</title>\n<style>\n{STYLE}</style>\n</head>\n\
         <body>\n<main>\n<h1>{title}</h1>\n<nav><ul>\n{contents}</ul></nav>\n{body}</main>\n</body>\n</html>\n"
    ))
}

fn rows(table: &Table) -> String {
    let line = |cells: &[String], tag: &str| {
        let cells: String = cells.iter().map(|cell| format!("<{tag}>{}</{tag}>", escaped(cell))).collect();
        format!("<tr>{cells}</tr>\n")
    };
    let body: String = table.rows.iter().map(|row| line(row, "td")).collect();
    format!(
        "<div class=\"table\"><table>\n<caption>{}</caption>\n<thead>\n{}</thead>\n<tbody>\n{body}</tbody>\n</table></div>\n",
        escaped(&table.caption),
        line(&table.header, "th")
    )
}

/// An SVG file as a part of the page: it takes the page's width and, by the style sheet, its colours.
fn inline(svg: &str, title: &str) -> String {
    let title = escaped(title);
    let part = svg.replacen(" xmlns=\"http://www.w3.org/2000/svg\"", "", 1);
    part.replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{title}\" "), 1)
}

/// The text with the characters that HTML reserves written out.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::{Lettering, Picture};

    #[test]
    fn texts_are_escaped_and_nothing_is_fetched() {
        let mut picture = Picture::new("a \"<figure>\"", 40.0, 20.0);
        picture.text((20.0, 10.0), "x < 1", Lettering::sized(9.0));
        let folded = Block::Folded { title: "config & co".to_owned(), text: "a = \"<b>\"".to_owned() };
        let html =
            render("R & D", &[Block::text("1 < 2"), folded, Block::figure("f", "c", picture)]).unwrap();
        for part in [
            "R &amp; D",
            "1 &lt; 2",
            "a = &quot;&lt;b&gt;&quot;",
            "aria-label=\"a &quot;&lt;figure&gt;&quot;\"",
        ] {
            assert!(html.contains(part), "no {part} in {html}");
        }
        assert!(!html.contains("http:") && !html.contains("https:") && !html.contains("url("));
    }
}
