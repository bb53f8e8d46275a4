//! The numbers of a chart for the script of a page: it shows them under the pointer and draws a
//! part of the chart anew.

use super::layout::Frame;
use super::style::Style;
use super::{Chart, Curve, Piece};
use crate::base::rounded;
use serde_json::{Value, json};

/// Digits of the numbers: more than a reader takes in, and few bytes.
const DIGITS: usize = 7;

/// The chart in JSON: the place of the plot, the ranges of its axes, and the curves. Where a curve
/// has a gap its value is `null`; abscissas that are those of the curve before are left out.
pub fn json(
    chart: &Chart<'_>,
    frame: &Frame,
    curves: &[Curve<'_>],
    drawn: (&[Style], &[Vec<Piece>]),
) -> String {
    let mut before = Value::Null;
    let mut list = Vec::new();
    for ((curve, style), pieces) in curves.iter().zip(drawn.0).zip(drawn.1) {
        let [x, y] = columns(pieces);
        let (colour, dash, points) = style.words();
        let mut object =
            json!({ "name": curve.name, "colour": colour, "dash": dash, "points": points, "y": y });
        if x != before {
            object["x"] = x.clone();
            before = x;
        }
        list.push(object);
    }
    let [x, y] = frame.axes().map(|axis| axis.ends());
    json!({
        "frame": frame.ends(), "x": x, "y": y, "log": [chart.log_x, chart.log_y],
        "labels": [chart.x_label, chart.y_label], "curves": list,
    })
    .to_string()
}

/// Abscissas and ordinates, with `null` between the pieces.
fn columns(pieces: &[Piece]) -> [Value; 2] {
    let mut columns = [Vec::new(), Vec::new()];
    for piece in pieces {
        if let (false, Some(point)) = (columns[0].is_empty(), piece.first()) {
            columns[0].push(short(point[0]));
            columns[1].push(Value::Null);
        }
        for point in piece {
            columns.iter_mut().zip(point).for_each(|(column, v)| column.push(short(*v)));
        }
    }
    columns.map(Value::Array)
}

/// A number with few digits.
fn short(v: f64) -> Value {
    rounded(v, DIGITS).parse::<f64>().map_or(Value::Null, Value::from)
}
