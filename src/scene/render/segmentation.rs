//! Charts of a run that has segmented an image.

use super::folder::RunFolder;
use crate::scene::charts::Plot;

/// All charts of a segmentation.
pub(super) fn draw(run: &RunFolder) -> Vec<Plot> {
    if run.column("time").is_none() {
        return Vec::new();
    }
    let name = run.scene.interfaces().map(str::to_string).next().unwrap_or_default();
    let (area, perimeter) = (format!("{name}.area"), format!("{name}.perimeter"));
    let chart = |file: &str, words: [&str; 2], curves: &[(&str, &str)], caption: &str| {
        let mut sheet = run.columns().sheet();
        curves.iter().for_each(|(label, column)| sheet.line(*label, run.column(column)));
        sheet.draw(file, words, caption)
    };
    let charts = [
        chart(
            "energy",
            ["Energy", "energy"],
            &[("together", "energy"), ("misfit", "energy_fidelity"), ("length", "energy_length")],
            "The misfit of the image and its two levels, and the length of the contour, each with \
             its weight. Together they fall; where they no longer do the run could have ended.",
        ),
        chart(
            "levels",
            ["Mean grey levels", "grey level"],
            &[("inside", "c1"), ("outside", "c2")],
            "The means of the image on the two sides of the contour. They part as the contour \
             finds the objects.",
        ),
        chart(
            "components",
            ["Connected parts of the inside", "number"],
            &[("parts", "components")],
            "How many pieces the inside has. A single circle may fall apart into many, and pieces \
             may join.",
        ),
        chart("area", ["Area inside", "area"], &[("inside", &area)], "The area of the inside."),
        chart(
            "length",
            ["Length of the contour", "length"],
            &[("contour", &perimeter)],
            "The length of all contours.",
        ),
        chart(
            "misclassified",
            ["Pixels on the wrong side", "pixels"],
            &[("wrong", "misclassified")],
            "How many pixels differ from the mask that the scene names.",
        ),
    ];
    charts.into_iter().flatten().collect()
}

/// The largest rise of the energy from row to row, over its value at the start.
pub(super) fn largest_rise(run: &RunFolder) -> Option<f64> {
    let energy = run.column("energy").filter(|_| run.scene.image.is_some())?;
    let rises = energy.windows(2).map(|e| (e[1] - e[0]) / energy[0]);
    rises.reduce(f64::max)
}
