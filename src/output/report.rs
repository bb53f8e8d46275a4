//! The report page of a run: one HTML file that holds everything it shows, for any browser, offline, on paper too.

use super::markup::escape;
use std::fmt::Write;

/// What a page shows, in the order of the page. All texts are plain; the page escapes them.
#[derive(Clone, Debug, Default)]
pub struct Report {
    /// Title of the run.
    pub title: String,
    /// One line under it: case, mesh, end time, date.
    pub subtitle: String,
    /// What the reader must know before believing the rest.
    pub alarms: Vec<String>,
    /// What the reader should know, but that puts no result in doubt.
    pub notes: Vec<String>,
    /// The numbers that matter.
    pub headline: Vec<Number>,
    /// The film.
    pub film: Option<Figure>,
    /// Pictures.
    pub pictures: Vec<Figure>,
    /// Charts.
    pub charts: Vec<Figure>,
    /// Tables and texts, such as the settings.
    pub sections: Vec<Section>,
    /// How to cite and to continue; blank lines separate paragraphs.
    pub footer: String,
}

/// A number of the headline.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Number {
    /// What it is.
    pub label: String,
    /// Its value, with the unit if there is one.
    pub value: String,
    /// Its error, or what it is compared with.
    pub note: String,
}

/// A figure with its words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Title.
    pub title: String,
    /// What is shown.
    pub content: Content,
    /// What it says; may be empty.
    pub caption: String,
}

/// What a figure shows.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Content {
    /// A drawing made by [`Chart::svg`](super::Chart::svg); it becomes part of the page as it is.
    Svg(String),
    /// The bytes of a PNG file.
    Png(Vec<u8>),
    /// The bytes of a GIF file.
    Gif(Vec<u8>),
    /// The bytes of an MP4 file.
    Mp4(Vec<u8>),
}

/// A part of the page below the figures.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Section {
    /// A title and lines of text, shown as they are; nothing if there are none.
    Text(String, String),
    /// A table.
    Table(Listing),
}

/// A table of texts.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Listing {
    /// Title.
    pub title: String,
    /// Names of the columns; may be empty.
    pub header: Vec<String>,
    /// Rows of cells.
    pub rows: Vec<Vec<String>>,
    /// What the table says; may be empty.
    pub caption: String,
}

impl Report {
    /// The page.
    pub fn html(&self) -> String {
        let mut page = Page(String::new());
        page.line("<!DOCTYPE html>");
        page.line("<html lang=\"en\"><head><meta charset=\"utf-8\"/>");
        page.line("<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"/>");
        page.element("title", &self.title);
        page.line(&format!("<style>\n{}</style></head><body>", include_str!("report.css")));
        page.line("<header>");
        page.element("h1", &self.title);
        page.element("p", &self.subtitle);
        page.line("</header><main>");
        self.alarms.iter().for_each(|a| page.line(&format!("<div class=\"alarm\" role=\"alert\">{}</div>", escape(a))));
        self.notes.iter().for_each(|n| page.line(&format!("<div class=\"remark\">{}</div>", escape(n))));
        self.numbers(&mut page);
        page.figures("Pictures", "pictures", self.film.iter().chain(&self.pictures));
        page.figures("Charts", "charts", &self.charts);
        self.sections.iter().for_each(|s| match s {
            Section::Text(_, text) if text.is_empty() => {}
            Section::Text(title, text) => {
                page.element("h2", title);
                page.element("pre", text);
            }
            Section::Table(table) => page.table(table),
        });
        page.line("</main><footer>");
        self.footer.split("\n\n").filter(|p| !p.trim().is_empty()).for_each(|p| page.element("p", p));
        page.line("</footer></body></html>");
        page.0
    }
    fn numbers(&self, page: &mut Page) {
        if self.headline.is_empty() {
            return;
        }
        page.line("<dl class=\"numbers\">");
        for n in &self.headline {
            page.line("<div>");
            page.element("dt", &n.label);
            page.element("dd", &n.value);
            if !n.note.is_empty() {
                page.line(&format!("<dd class=\"note\">{}</dd>", escape(&n.note)));
            }
            page.line("</div>");
        }
        page.line("</dl>");
    }
}

struct Page(String);

impl Page {
    fn line(&mut self, text: &str) {
        self.0.push_str(text);
        self.0.push('\n');
    }
    /// An element with plain text in it; nothing for an empty text.
    fn element(&mut self, tag: &str, text: &str) {
        if !text.is_empty() {
            self.line(&format!("<{tag}>{}</{tag}>", escape(text)));
        }
    }
    fn figures<'a>(&mut self, title: &str, class: &str, figures: impl IntoIterator<Item = &'a Figure>) {
        let mut figures = figures.into_iter().peekable();
        if figures.peek().is_none() {
            return;
        }
        self.element("h2", title);
        self.line(&format!("<div class=\"{class}\">"));
        figures.for_each(|f| self.figure(f));
        self.line("</div>");
    }
    fn figure(&mut self, figure: &Figure) {
        let name = escape(&figure.title);
        let image = |kind, bytes| format!("<img alt=\"{name}\" src=\"{}\"/>", data_uri(kind, bytes));
        let content = match &figure.content {
            Content::Svg(svg) => svg.clone(),
            Content::Png(bytes) => image("image/png", bytes),
            Content::Gif(bytes) => image("image/gif", bytes),
            Content::Mp4(bytes) => format!(
                "<video aria-label=\"{name}\" controls=\"\" loop=\"\" muted=\"\" autoplay=\"\" playsinline=\"\" src=\"{}\"></video>",
                data_uri("video/mp4", bytes)
            ),
        };
        let caption = escape(&figure.caption);
        self.line(&format!("<figure>{content}\n<figcaption><b>{name}</b> {caption}</figcaption></figure>"));
    }
    fn table(&mut self, table: &Listing) {
        self.element("h2", &table.title);
        self.element("p", &table.caption);
        let row = |cells: &[String], tag: &str| {
            // A number with an exponent must not be broken at its sign.
            let class = |c: &str| if c.parse::<f64>().is_ok() { " class=\"number\"" } else { "" };
            let cells = cells.iter().map(|c| format!("<{tag}{}>{}</{tag}>", class(c), escape(c))).collect::<String>();
            format!("<tr>{cells}</tr>")
        };
        self.line("<div class=\"scroll\"><table>");
        if !table.header.is_empty() {
            self.line(&format!("<thead>{}</thead>", row(&table.header, "th")));
        }
        self.line("<tbody>");
        table.rows.iter().for_each(|cells| self.line(&row(cells, "td")));
        self.line("</tbody></table></div>");
    }
}

/// Bytes as an address that holds them.
fn data_uri(kind: &str, bytes: &[u8]) -> String {
    let mut uri = String::with_capacity(bytes.len() / 3 * 4 + 40);
    // Writing to a String cannot fail.
    let _ = write!(uri, "data:{kind};base64,");
    let digits = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    for three in bytes.chunks(3) {
        let at = |i: usize| u32::from(three.get(i).copied().unwrap_or(0));
        let bits = at(0) << 16 | at(1) << 8 | at(2);
        for k in 0..4 {
            let digit = digits[(bits >> (18 - 6 * k) & 63) as usize];
            uri.push(if k <= three.len() { char::from(digit) } else { '=' });
        }
    }
    uri
}

#[cfg(test)]
mod tests {
    use super::super::markup::tests::assert_well_formed;
    use super::*;

    #[test]
    fn base64_is_that_of_rfc_4648() {
        for (text, code) in [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")] {
            assert_eq!(data_uri("a/b", text.as_bytes()), format!("data:a/b;base64,{code}"));
        }
        assert!(data_uri("a/b", &[0xfb, 0xff]).ends_with(",+/8="));
    }

    #[test]
    fn everything_is_escaped_and_nothing_is_fetched() {
        let evil = "<script>alert(\"x\")</script> & 'more' http://example.org";
        let text = || evil.to_string();
        let figure = |content| Figure { title: text(), content, caption: text() };
        let page = Report {
            title: text(),
            subtitle: text(),
            alarms: vec![text()],
            headline: vec![Number { label: text(), value: text(), note: text() }],
            film: Some(figure(Content::Gif(vec![1, 2, 3]))),
            pictures: vec![figure(Content::Png(vec![4])), figure(Content::Mp4(vec![5]))],
            charts: vec![figure(Content::Svg("<svg xmlns=\"http://www.w3.org/2000/svg\"></svg>".into()))],
            notes: vec![text()],
            sections: vec![
                Section::Text(text(), text()),
                Section::Table(Listing {
                    title: text(),
                    header: vec![text()],
                    rows: vec![vec![text(), text()]],
                    caption: text(),
                }),
            ],
            footer: format!("{evil}\n\n{evil}"),
        }
        .html();
        assert_well_formed(&page);
        assert!(!page.contains("<script") && !page.contains("src=\"http") && !page.contains("url("));
        assert_eq!(page.matches("&lt;script&gt;").count(), 28);
        for kind in ["image/gif;base64,AQID", "image/png;base64,BA==", "video/mp4;base64,BQ==", "<svg"] {
            assert!(page.contains(kind), "{kind} is missing");
        }
        assert!(page.find("alarm\"") < page.find("numbers\""), "alarms come first");
    }

    #[test]
    fn an_empty_report_is_a_page_without_empty_sections() {
        let page = Report { title: "Run".into(), ..Report::default() }.html();
        assert_well_formed(&page);
        assert!(!page.contains("<h2>") && !page.contains("<table>") && !page.contains("<figure>"));
    }
}
