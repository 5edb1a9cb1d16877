//! A report as HTML: one file with its style and its figures inside, no script, nothing from the network.

use super::parts::{Figure, Part, Section, Table};
use crate::error::Result;
use std::fmt::Write;

/// Rows above which a table is folded.
const LONG: usize = 40;

/// The page.
pub(super) fn html(names: &[String], comparison: Option<&Section>, runs: &[Vec<Section>]) -> Result<String> {
    let title = format!("Daylight report: {}", names.join(", "));
    let mut page = format!(
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n<meta name=\"viewport\" content=\"width=device-width, \
         initial-scale=1\">\n<title>{0}</title>\n<style>\n{1}</style>\n</head>\n<body>\n<header><h1>{0}</h1></header>\n",
        escape(&title),
        include_str!("page.css")
    );
    let titles: Vec<&str> = comparison.into_iter().chain(&runs[0]).map(|s| s.title).collect();
    let links: Vec<String> = titles.iter().map(|t| format!("<a href=\"#{}\">{}</a>", anchor(t), escape(t))).collect();
    let _ = writeln!(page, "<nav>{}</nav>\n<main>", links.join(" "));
    if let Some(comparison) = comparison {
        open(&mut page, comparison.title);
        parts(&mut page, comparison)?;
        page.push_str("</section>\n");
    }
    for (i, first) in runs[0].iter().enumerate() {
        open(&mut page, first.title);
        if runs.len() == 1 {
            parts(&mut page, first)?;
        } else {
            page.push_str("<div class=\"runs\">\n");
            for (name, sections) in names.iter().zip(runs) {
                let _ = writeln!(page, "<div class=\"run\"><p class=\"name\">{}</p>", escape(name));
                parts(&mut page, &sections[i])?;
                page.push_str("</div>\n");
            }
            page.push_str("</div>\n");
        }
        page.push_str("</section>\n");
    }
    page.push_str("</main>\n</body>\n</html>\n");
    Ok(page)
}

fn open(page: &mut String, title: &str) {
    let _ = writeln!(page, "<section id=\"{}\">\n<h2>{}</h2>", anchor(title), escape(title));
}

fn parts(page: &mut String, section: &Section) -> Result<()> {
    for part in &section.parts {
        match part {
            Part::Text(text) => {
                let _ = writeln!(page, "<p>{}</p>", escape(text));
            }
            Part::Heading(text) => {
                let _ = writeln!(page, "<h3>{}</h3>", escape(text));
            }
            Part::Facts(facts) => {
                page.push_str("<dl>\n");
                for (name, value) in facts {
                    let _ = writeln!(page, "<dt>{}</dt><dd>{}</dd>", escape(name), escape(value));
                }
                page.push_str("</dl>\n");
            }
            Part::Notes(notes) => {
                let items: String = notes.iter().map(|n| format!("<li>{}</li>\n", escape(n))).collect();
                let _ = writeln!(page, "<ul class=\"notes\">\n{items}</ul>");
            }
            Part::Table(t) => table(page, t),
            Part::Figures(all) => {
                page.push_str("<div class=\"figures\">\n");
                for f in all {
                    figure(page, f)?;
                }
                page.push_str("</div>\n");
            }
        }
    }
    Ok(())
}

fn table(page: &mut String, table: &Table) {
    let folded = table.rows.len() > LONG;
    if folded {
        let _ = writeln!(page, "<details><summary>{} ({} rows)</summary>", escape(&table.caption), table.rows.len());
    }
    let caption = if folded || table.caption.is_empty() { String::new() } else { format!("<caption>{}</caption>", escape(&table.caption)) };
    let head: String = table.head.iter().map(|h| format!("<th>{}</th>", escape(h))).collect();
    let _ = writeln!(page, "<div class=\"table\"><table>{caption}\n<thead><tr>{head}</tr></thead>\n<tbody>");
    for row in &table.rows {
        // Numbers stand below each other on the right.
        let cell = |text: &String| {
            let is_number = text.starts_with(|c: char| c.is_ascii_digit() || matches!(c, '-' | '−' | '–'));
            format!("<td{}>{}</td>", if is_number { " class=\"n\"" } else { "" }, escape(text))
        };
        let _ = writeln!(page, "<tr>{}</tr>", row.iter().map(cell).collect::<String>());
    }
    page.push_str("</tbody></table></div>\n");
    if folded {
        page.push_str("</details>\n");
    }
}

fn figure(page: &mut String, figure: &Figure) -> Result<()> {
    let svg = figure.drawing.svg()?.replacen("<svg ", &format!("<svg role=\"img\" aria-label=\"{}\" ", escape(&figure.label)), 1);
    let caption = if figure.caption.is_empty() { String::new() } else { format!("<figcaption>{}</figcaption>", escape(&figure.caption)) };
    let _ = writeln!(page, "<figure style=\"width:{}px\">{svg}{caption}</figure>", figure.drawing.width());
    Ok(())
}

/// Text as HTML; all that comes from files goes through here.
fn escape(text: &str) -> String {
    let mut escaped = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => escaped.push_str("&amp;"),
            '<' => escaped.push_str("&lt;"),
            '>' => escaped.push_str("&gt;"),
            '"' => escaped.push_str("&quot;"),
            '\'' => escaped.push_str("&#39;"),
            c => escaped.push(c),
        }
    }
    escaped
}

fn anchor(title: &str) -> String {
    title.to_lowercase().replace(' ', "-")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::image::drawing::Drawing;

    #[test]
    fn names_from_files_cannot_leave_their_place() {
        let hostile = "</title><script>alert(1)</script>".to_string();
        let table = Table { name: "t".into(), caption: hostile.clone(), head: vec![hostile.clone()], rows: vec![vec![hostile.clone()]] };
        let drawing = {
            let mut d = Drawing::new(10.0, 10.0);
            d.label(hostile.clone(), [1.0, 1.0], 8.0, [0; 3], crate::image::drawing::Anchor::Start);
            d
        };
        let figure = Figure { name: "f".into(), label: format!("\" onload=\"{hostile}"), caption: hostile.clone(), drawing };
        let parts = vec![
            Part::Text(hostile.clone()),
            Part::Heading(hostile.clone()),
            Part::Facts(vec![("a", hostile.clone())]),
            Part::Notes(vec![hostile.clone()]),
            Part::Table(table),
            Part::Figures(vec![figure]),
        ];
        let page = html(std::slice::from_ref(&hostile), None, &[vec![Section { title: "One", parts }]]).unwrap();
        assert!(!page.contains("<script") && !page.contains("onload=\"<"), "{page}");
        // Title and heading of the page; text, heading, fact, note; caption, head and cell of the table; label and
        // caption of the figure and its own text.
        assert_eq!(page.matches("&lt;script").count(), 12, "{page}");
        // Nothing is fetched: the name of SVG's words is no address that anybody opens.
        assert_eq!(page.matches("http").count(), page.matches("xmlns=\"http://www.w3.org/2000/svg\"").count());
    }

    #[test]
    fn several_runs_stand_beside_each_other() {
        let section = |text: &str| vec![Section { title: "One", parts: vec![Part::Text(text.into())] }];
        let names = vec!["a".to_string(), "b".to_string()];
        let page = html(&names, None, &[section("the first"), section("the second")]).unwrap();
        assert!(page.find("the first").unwrap() < page.find("the second").unwrap() && page.matches("class=\"run\"").count() == 2, "{page}");
    }
}
