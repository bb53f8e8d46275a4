//! Pages: the results of a run or a study as one HTML file for any browser, offline and on paper,
//! and as text for a terminal.

use super::figure::Figure;
use super::markup::{escape, prose};
use super::table::{Cell, Table};

/// Content of a page. All texts are plain; the page escapes them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Page {
    /// Title.
    pub title: String,
    /// One line under it: mesh, steps, order.
    pub subtitle: String,
    /// How and when it was made: names and what they stand for.
    pub origin: Vec<(String, String)>,
    /// Doubts about the results: to be read before the rest.
    pub alarms: Vec<String>,
    /// The most important numbers.
    pub key_numbers: Vec<KeyNumber>,
    /// Remarks that put no result in doubt: runs that failed, assumptions, what was left out.
    pub notes: Vec<String>,
    /// The results in sentences.
    pub statements: Vec<String>,
    /// Films and pictures.
    pub pictures: Vec<Figure>,
    /// Charts.
    pub charts: Vec<Figure>,
    /// The tables.
    pub tables: Vec<Table>,
    /// Texts with their titles, such as the settings; they are shown as they are, line by line.
    pub texts: Vec<(String, String)>,
    /// A table of many rows of numbers, which a page shows where it may run its script.
    pub sheet: Option<Table>,
    /// Long tables, folded at the end of the page and left out on a terminal.
    pub details: Vec<Table>,
    /// Origin and references; blank lines separate paragraphs.
    pub footer: String,
}

/// A number at the top of a page.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct KeyNumber {
    /// Its name.
    pub label: String,
    /// Its value, with the unit if there is one.
    pub value: String,
    /// Its error, or a value to compare it with; may be empty.
    pub note: String,
}

/// Lines of a text from which on it is folded.
const LONG: usize = 24;

impl Page {
    /// All tables, those of the details last.
    pub fn all_tables(&self) -> impl Iterator<Item = &Table> {
        self.tables.iter().chain(&self.details)
    }
    /// The table of this name.
    pub fn table(&self, name: &str) -> Option<&Table> {
        self.all_tables().find(|t| t.name == name)
    }

    /// The page for a terminal: tables, notes and statements.
    pub fn text(&self) -> String {
        let mut parts: Vec<String> = self.tables.iter().map(Table::text).collect();
        parts.push(self.notes.iter().map(|n| format!("note: {n}\n")).collect());
        parts.push(self.statements.iter().map(|s| format!("{s}\n")).collect());
        parts.retain(|p| !p.is_empty());
        parts.join("\n")
    }

    /// The page as an HTML document.
    pub fn html(&self) -> String {
        let mut out = Html(String::new());
        out.line("<!DOCTYPE html>");
        out.line("<html lang=\"en\"><head><meta charset=\"utf-8\"/>");
        out.line("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>");
        out.element("title", &self.title);
        out.line(&format!("<style>\n{}</style></head><body>", include_str!("page.css")));
        out.line("<header>");
        out.element("h1", &self.title);
        out.element("p", &self.subtitle);
        out.origin(&self.origin);
        out.line("</header><main>");
        self.alarms.iter().for_each(|a| {
            out.line(&format!("<div class=\"alarm\" role=\"alert\">{}</div>", escape(a)))
        });
        out.key_numbers(&self.key_numbers);
        out.list("", "remarks", &self.notes);
        out.list("Results", "statements", &self.statements);
        out.figures("Pictures", "pictures", &self.pictures);
        out.figures("Charts", "charts", &self.charts);
        self.tables.iter().for_each(|t| out.table(t));
        self.sheet.iter().for_each(|t| out.sheet(t));
        self.texts.iter().for_each(|(title, text)| out.text(title, text));
        self.details.iter().for_each(|t| out.details(t));
        out.line("</main><footer>");
        self.footer
            .split("\n\n")
            .filter(|p| !p.trim().is_empty())
            .for_each(|p| out.element("p", p));
        out.line("</footer>");
        if !self.pictures.is_empty() || !self.charts.is_empty() || self.sheet.is_some() {
            out.line(&format!("<script>\n{}</script>", include_str!("page.js")));
        }
        out.line("</body></html>");
        out.0
    }
}

/// An HTML document in the making.
struct Html(String);

impl Html {
    fn line(&mut self, text: &str) {
        self.0.push_str(text);
        self.0.push('\n');
    }
    /// An element with plain text in it; nothing for an empty text.
    fn element(&mut self, tag: &str, text: &str) {
        if !text.is_empty() {
            self.line(&format!("<{tag}>{}</{tag}>", prose(text)));
        }
    }
    fn key_numbers(&mut self, numbers: &[KeyNumber]) {
        if numbers.is_empty() {
            return;
        }
        self.line("<dl class=\"numbers\">");
        for n in numbers {
            self.line("<div>");
            self.element("dt", &n.label);
            self.element("dd", &n.value);
            if !n.note.is_empty() {
                self.line(&format!("<dd class=\"note\">{}</dd>", prose(&n.note)));
            }
            self.line("</div>");
        }
        self.line("</dl>");
    }
    fn origin(&mut self, entries: &[(String, String)]) {
        if entries.is_empty() {
            return;
        }
        self.line("<dl class=\"origin\">");
        for (name, what) in entries {
            self.line(&format!("<dt>{}</dt><dd>{}</dd>", escape(name), escape(what)));
        }
        self.line("</dl>");
    }
    /// The numbers of a table as data for the script, and where they are without it.
    fn sheet(&mut self, table: &Table) {
        self.line("<details class=\"sheet\">");
        self.line(&format!("<summary>{}</summary>", escape(&table.title)));
        self.element("p", &table.caption);
        let file = Cell::file(format!("{}.csv", table.name)).html();
        self.line(&format!("<p>All rows and digits: {file}</p>"));
        // `<` ends no text in JSON, but would begin a tag here.
        let data = table.numbers().to_string().replace('<', "\\u003c");
        self.line(&format!("<script type=\"application/json\">{data}</script>"));
        self.line("</details>");
    }
    fn list(&mut self, title: &str, class: &str, items: &[String]) {
        if items.is_empty() {
            return;
        }
        self.element("h2", title);
        self.line(&format!("<ul class=\"{class}\">"));
        items.iter().for_each(|i| self.element("li", i));
        self.line("</ul>");
    }
    fn figures(&mut self, title: &str, class: &str, figures: &[Figure]) {
        if figures.is_empty() {
            return;
        }
        self.element("h2", title);
        self.line(&format!("<div class=\"{class}\">"));
        figures.iter().for_each(|f| self.line(&f.html()));
        self.line("</div>");
    }
    fn table(&mut self, table: &Table) {
        self.element("h2", &table.title);
        self.element("p", &table.caption);
        self.line(&table.html());
    }
    /// A text, folded if it is long; nothing for an empty one.
    fn text(&mut self, title: &str, text: &str) {
        match text.lines().count() {
            0 => {}
            n => self
                .folded(title, n < LONG, |out| out.line(&format!("<pre>{}</pre>", escape(text)))),
        }
    }
    fn details(&mut self, table: &Table) {
        self.folded(&table.title, table.rows.len() < LONG, |out| {
            out.element("p", &table.caption);
            out.line(&table.html());
        });
    }
    /// A part of the page that the reader opens and closes.
    fn folded(&mut self, title: &str, open: bool, content: impl FnOnce(&mut Html)) {
        let open = if open { " open=\"\"" } else { "" };
        self.line(&format!("<details{open}><summary>{}</summary>", escape(title)));
        content(self);
        self.line("</details>");
    }
}

#[cfg(test)]
mod tests {
    use super::super::figure::Content;
    use super::super::markup::tests::assert_well_formed;
    use super::*;

    #[test]
    fn everything_is_escaped_and_nothing_is_fetched() {
        let evil = "<script>alert(\"x\")</script> & 'more' http://example.org";
        let text = || evil.to_string();
        let figure = |content| Figure { name: text(), title: text(), content, caption: text() };
        let table = || {
            Table::new(evil, evil, [evil]).with_rows([vec![Cell::text(evil)]]).with_caption(evil)
        };
        let page = Page {
            title: text(),
            subtitle: text(),
            origin: vec![(text(), text())],
            alarms: vec![text()],
            key_numbers: vec![KeyNumber { label: text(), value: text(), note: text() }],
            notes: vec![text()],
            statements: vec![text()],
            pictures: [Content::Gif(vec![1, 2, 3]), Content::Png(vec![4]), Content::Mp4(vec![5])]
                .map(figure)
                .to_vec(),
            charts: vec![figure(Content::Svg(
                "<svg xmlns=\"http://www.w3.org/2000/svg\"></svg>".into(),
            ))],
            tables: vec![table()],
            texts: vec![(text(), text())],
            sheet: Some(table()),
            details: vec![table()],
            footer: format!("{evil}\n\n{evil}"),
        }
        .html();
        assert_well_formed(&page);
        assert!(
            !page.contains("<script>alert")
                && !page.contains("src=\"http")
                && !page.contains("url(h")
        );
        assert_eq!(
            page.matches("&lt;script&gt;").count(),
            3 + 2 + 1 + 3 + 2 + 3 * 3 + 2 + 4 + 3 + 2 + 4 + 2
        );
        for kind in
            ["image/gif;base64,AQID", "image/png;base64,BA==", "video/mp4;base64,BQ==", "<svg"]
        {
            assert!(page.contains(kind), "{kind} is missing");
        }
        assert!(page.find("alarm\"") < page.find("numbers\""), "alarms come first");
    }

    #[test]
    fn a_sheet_is_data_for_the_script_and_a_file() {
        let columns = ["time", "</script> & speed"].map(super::super::table::Column::from);
        let sheet = Table::new("series", "Series", columns)
            .with_unit("time", "ms")
            .with_rows([vec![Cell::number(0.5, 3), Cell::number(f64::NAN, 3)]]);
        let page = Page { sheet: Some(sheet), ..Page::default() }.html();
        assert_well_formed(&page);
        let data = page.split("application/json\">").nth(1).unwrap();
        let data: serde_json::Value =
            serde_json::from_str(data.split("</script>").next().unwrap()).unwrap();
        assert_eq!(data["columns"], serde_json::json!(["time (ms)", "</script> & speed"]));
        assert_eq!(data["rows"], serde_json::json!([[0.5, null]]));
        assert!(page.contains("<a href=\"series.csv\">series.csv</a>"));
    }

    #[test]
    fn an_empty_page_has_no_empty_parts() {
        let page = Page { title: "Run".into(), ..Page::default() }.html();
        assert_well_formed(&page);
        for part in ["<h2>", "<table>", "<figure>", "<ul", "<details", "<dl", "<script"] {
            assert!(!page.contains(part), "{part}");
        }
    }

    #[test]
    fn long_texts_are_folded_and_numbers_are_kept_whole() {
        let page = Page {
            statements: vec!["changed by 2e-5, at most".into()],
            texts: vec![("short".into(), "a\nb".into()), ("long".into(), "line\n".repeat(LONG))],
            ..Page::default()
        };
        let html = page.html();
        assert_eq!(html.matches("<details>").count(), 1);
        assert!(html.contains("by <span class=\"whole\">2e-5,</span> at most"), "{html}");
        assert_eq!(page.text(), "changed by 2e-5, at most\n");
    }
}
