//! Figures of a page: charts, pictures and films with their words.

use super::markup::{address, escape, prose};
use std::fmt::Write;

/// A figure with its words.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Figure {
    /// Name of its file, without ending; empty if it has none of its own. Charts are beside the
    /// page, in `charts`.
    pub name: String,
    /// Title.
    pub title: String,
    /// The drawing.
    pub content: Content,
    /// Explanation; may be empty.
    pub caption: String,
}

/// The drawing of a figure.
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

impl Figure {
    /// A chart, `svg` being made by [`Chart::svg`](super::Chart::svg).
    pub fn chart(
        name: impl Into<String>,
        title: impl Into<String>,
        svg: String,
        caption: impl Into<String>,
    ) -> Figure {
        let content = Content::Svg(svg);
        Figure { name: name.into(), title: title.into(), content, caption: caption.into() }
    }

    /// Name and bytes of the file of a chart.
    pub fn file(&self) -> Option<(String, &[u8])> {
        match &self.content {
            Content::Svg(svg) => Some((format!("{}.svg", self.name), svg.as_bytes())),
            _ => None,
        }
    }

    /// The element `figure` of HTML.
    pub(super) fn html(&self) -> String {
        let name = escape(&self.title);
        let image =
            |kind, bytes| format!("<img alt=\"{name}\" src=\"{}\"/>", data_uri(kind, bytes));
        let content = match &self.content {
            Content::Svg(svg) => svg.clone(),
            Content::Png(bytes) => image("image/png", bytes),
            Content::Gif(bytes) => image("image/gif", bytes),
            Content::Mp4(bytes) => format!(
                "<video aria-label=\"{name}\" controls=\"\" loop=\"\" muted=\"\" autoplay=\"\" \
                 playsinline=\"\" src=\"{}\"></video>",
                data_uri("video/mp4", bytes)
            ),
        };
        let stop = if self.title.is_empty() || self.title.ends_with('.') { "" } else { "." };
        let caption = prose(&self.caption);
        let file = match self.file() {
            Some((file, _)) if !self.name.is_empty() => {
                format!(" <a href=\"charts/{}\">SVG</a>", address(&file))
            }
            _ => String::new(),
        };
        format!(
            "<figure>{content}\n<figcaption><b>{name}{stop}</b> {caption}{file}</figcaption></figure>"
        )
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
    use super::*;

    #[test]
    fn base64_is_that_of_rfc_4648() {
        for (text, code) in
            [("", ""), ("f", "Zg=="), ("fo", "Zm8="), ("foo", "Zm9v"), ("foobar", "Zm9vYmFy")]
        {
            assert_eq!(data_uri("a/b", text.as_bytes()), format!("data:a/b;base64,{code}"));
        }
        assert!(data_uri("a/b", &[0xfb, 0xff]).ends_with(",+/8="));
    }
}
