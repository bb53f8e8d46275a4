use super::super::markup::tests::assert_well_formed;
use super::*;
use proptest::prelude::*;

fn curve<'a>(name: &'a str, x: &'a [f64], y: &'a [f64], stroke: Stroke) -> Curve<'a> {
    Curve { name, x, y, stroke, colour: None }
}

/// The value of an attribute in each element that has it.
fn values(svg: &str, attribute: &str) -> Vec<f64> {
    let from = format!(" {attribute}=\"");
    svg.split(&from).skip(1).filter_map(|r| r.split('"').next()?.parse().ok()).collect()
}

/// The texts of a drawing, without their tags.
fn texts(svg: &str) -> Vec<String> {
    let inside = |line: &str| {
        let mut out = String::new();
        line.split('<').for_each(|part| out += part.split_once('>').map_or("", |p| p.1));
        out
    };
    svg.lines().filter(|l| l.starts_with("<text")).map(inside).collect()
}

#[test]
fn a_chart_is_well_formed_and_names_everything() {
    let x: Vec<f64> = (0..50).map(|i| f64::from(i) * 0.02).collect();
    let y: Vec<f64> = x.iter().map(|x| (7.0 * x).sin()).collect();
    let svg = Chart {
        title: "Axes <a> & \"b\"",
        x_label: "time (s)",
        y_label: "length (m)",
        curves: vec![
            curve("axis_1 < axis_2", &x, &y, Stroke::Line),
            curve("FreeFEM", &x[..9], &y[..9], Stroke::Points),
        ],
        ..Chart::default()
    }
    .svg();
    assert_well_formed(&svg);
    let names = ["time (s)", "length (m)", "axis_1 &lt; axis_2", "FreeFEM", "Axes &lt;a&gt; &amp;"];
    for text in names {
        assert!(svg.contains(text), "{text} is missing");
    }
    assert_eq!(svg.matches("<circle").count(), 9 + 1, "a mark a point and one in the legend");
    assert!(svg.contains("viewBox") && !svg.contains(" width="), "it scales");
}

#[test]
fn values_that_cannot_be_drawn_leave_gaps() {
    let x = [1.0, 2.0, 3.0, 4.0, 5.0];
    let y = [1.0, f64::NAN, -2.0, 0.5, 0.25];
    let curves = vec![curve("a", &x, &y, Stroke::Line)];
    let chart = |log_y| Chart { log_y, curves: curves.clone(), ..Chart::default() };
    let pieces = |log| chart(log).pieces(&chart(log).curves[0]);
    assert_eq!(pieces(false), [vec![[1.0, 1.0]], vec![[3.0, -2.0], [4.0, 0.5], [5.0, 0.25]]]);
    assert_eq!(pieces(true), [vec![[1.0, 1.0]], vec![[4.0, 0.5], [5.0, 0.25]]]);
    assert!(
        Chart { curves: vec![curve("a", &x, &[f64::NAN; 5], Stroke::Line)], ..Chart::default() }
            .svg()
            .contains("no values that can be drawn")
    );
}

#[test]
fn numbers_at_the_ends_of_what_a_number_can_be_are_drawn() {
    let x = [1.0, 2.0, 3.0, 4.0, 5.0];
    let ends = [f64::MIN, 1.0, f64::MAX, 5e-324, 0.0];
    for y in [&[][..], &[f64::INFINITY; 5], &[0.0; 5], &[1e300; 5], &[5e-324; 5], &ends] {
        for (log_x, log_y) in [(false, false), (false, true), (true, false), (true, true)] {
            let curves = vec![curve("a", &x, y, Stroke::Line), curve("b", y, &x, Stroke::Marked)];
            let svg = Chart { log_x, log_y, curves, ..Chart::default() }.svg();
            assert_well_formed(&svg);
            assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        }
    }
}

#[test]
fn thinning_keeps_ends_and_peaks() {
    let mut points: Vec<_> = (0..100_000).map(|i| [f64::from(i), 0.0]).collect();
    points[54_321][1] = 1.0;
    let (first, last, peak) = (points[0], points[99_999], points[54_321]);
    let thin = thinned(points);
    assert!(thin.len() <= MOST_POINTS + 2);
    assert!(thin.contains(&first) && thin.contains(&last) && thin.contains(&peak));
}

/// A residual that is large while a motion is set in at once, and then a thousandth of that.
fn impulsive() -> ([f64; 40], [f64; 40]) {
    let x = std::array::from_fn(|i| 0.1 * i as f64);
    let mut y = std::array::from_fn(|i| 0.01 * (i as f64).sin());
    (y[0], y[1]) = (0.0, -83.0);
    (x, y)
}

#[test]
fn a_beginning_that_dwarfs_the_rest_is_cut_off_and_said() {
    let (x, mut y) = impulsive();
    let draw = |y: &[f64], cut_start| {
        let curves = vec![curve("a", &x, y, Stroke::Line)];
        Chart { cut_start, curves, title: "Balance", ..Chart::default() }.svg()
    };
    let (whole, cut) = (draw(&y, false), draw(&y, true));
    assert_well_formed(&cut);
    assert!(!whole.contains("Cut off"));
    let said: Vec<String> = texts(&cut).into_iter().filter(|t| t.contains("Cut off")).collect();
    assert_eq!(said, ["Cut off: the value −83 at 0.1"]);
    // The rest of the curve is as high as the plot, and nothing is drawn outside of it.
    let heights = |svg: &str| {
        let group = svg.split("class=\"curve\"").nth(1).unwrap().split("</g>").next().unwrap();
        let lines = group.split("<path d=\"M").skip(1).map(|d| d.split('"').next().unwrap());
        let y = lines.flat_map(|d| d.split('L')).map(|p| p.split(' ').nth(1).unwrap());
        y.map(|y| y.parse::<f64>().unwrap())
            .fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)))
    };
    let ((top, bottom), (high, low)) = (heights(&cut), heights(&whole));
    assert!(bottom - top > 0.8 * (low - high) && bottom <= HEIGHT, "{top} {bottom}");
    // A beginning that fades in steps is cut off as a whole.
    y[2] = -0.5;
    assert!(draw(&y, true).contains("Cut off: 2 values, the largest −83 at 0.1"));
    y[2] = 0.005;
    // Without such a beginning nothing is cut off, nor is what comes later.
    y[1] = 0.005;
    assert_eq!(draw(&y, true), draw(&y, false));
    y[20] = 50.0;
    assert_eq!(draw(&y, true), draw(&y, false));
}

#[test]
fn lines_end_at_the_range() {
    let line = [[0.0, 0.0], [1.0, -4.0], [2.0, 0.0], [3.0, 0.5]];
    let parts = cut::clipped(&line, [-1.0, 1.0]);
    assert_eq!(parts, [vec![[0.0, 0.0], [0.25, -1.0]], vec![[1.75, -1.0], [2.0, 0.0], [3.0, 0.5]]]);
    let across = cut::clipped(&[[0.0, -3.0], [1.0, 3.0]], [-1.5, 1.5]);
    assert_eq!(across, [vec![[0.25, -1.5], [0.75, 1.5]]]);
    assert!(cut::clipped(&[[0.0, 5.0], [1.0, 7.0]], [-1.0, 1.0]).is_empty());
}

#[test]
fn the_numbers_for_the_script_are_those_of_the_curves() {
    let (x, y) = ([0.0, 1.0, 2.0, 3.0], [0.123456789, f64::NAN, 2e-9, -1.0]);
    let curves = vec![curve("a \"b\"", &x, &y, Stroke::Line), curve("c", &x, &x, Stroke::Points)];
    let svg = Chart { x_label: "time (s)", curves, ..Chart::default() }.svg();
    let data = svg.split("data-chart=\"").nth(1).unwrap().split('"').next().unwrap();
    let data = super::super::markup::unescape(data);
    let data: serde_json::Value = serde_json::from_str(&data).unwrap();
    assert_eq!(data["curves"][0]["name"], "a \"b\"");
    assert_eq!(data["curves"][0]["x"], serde_json::json!([0.0, 2.0, 2.0, 3.0]));
    assert_eq!(data["curves"][0]["y"], serde_json::json!([0.1234568, null, 2e-9, -1.0]));
    assert_eq!(data["curves"][1]["points"], true);
    assert_eq!(
        (&data["labels"][0], &data["x"]),
        (&"time (s)".into(), &serde_json::json!([-0.12, 3.12]))
    );
    // Abscissas are there once.
    let twice = vec![curve("a", &x, &x, Stroke::Line), curve("b", &x, &[1.0; 4], Stroke::Line)];
    let svg = Chart { curves: twice, ..Chart::default() }.svg();
    assert_eq!(svg.matches("&quot;x&quot;:").count(), 1 + 1, "of the axis and of the first curve");
}

#[test]
fn slopes_are_triangles_with_their_order_beside_them() {
    let (x, y) = ([0.1, 0.2, 0.4], [1e-3, 4e-3, 1.6e-2]);
    let slope = Slope { x: [0.1, 0.2], y: 5e-4, order: 2.0, above: false };
    let curves = vec![curve("e", &x, &y, Stroke::Marked)];
    let chart = Chart { log_x: true, log_y: true, curves: curves.clone(), ..Chart::default() };
    let with = |slope| Chart { slopes: vec![slope], ..chart.clone() }.svg();
    assert_well_formed(&with(slope));
    assert_eq!(texts(&with(slope)).last().unwrap(), "2");
    assert_eq!(slope.corners(), [[0.1, 5e-4], [0.2, 2e-3], [0.2, 5e-4]]);
    let (nowhere, at_zero) = (Slope { y: 0.0, ..slope }, Slope { x: [0.0, 1.0], ..slope });
    for bad in [nowhere, at_zero, Slope { order: f64::NAN, ..slope }] {
        assert_eq!(with(bad), chart.svg(), "{bad:?}");
    }
    let linear = Chart { log_x: false, ..chart.clone() };
    assert_eq!(Chart { slopes: vec![slope], ..linear.clone() }.svg(), linear.svg());
}

/// The numbers on an axis with room for all.
fn ticks(low: f64, high: f64, log: bool) -> String {
    let axis = Axis::of([low, high].into_iter(), log, 0.0).unwrap();
    let label = |l: text::Label| l.exponent.map_or(l.text.clone(), |e| format!("{}^{e}", l.text));
    let all = axis.ticks(|_| true).into_iter();
    all.filter_map(|t| t.label).map(label).collect::<Vec<_>>().join(" ")
}

#[test]
fn numbers_on_linear_axes_are_round() {
    const SMALL: &str = "0 5·10^−8 10^−7 1.5·10^−7 2·10^−7 2.5·10^−7 3·10^−7";
    assert_eq!(ticks(0.0, 1.0, false), "0 0.2 0.4 0.6 0.8 1");
    assert_eq!(ticks(-0.31, 0.77, false), "−0.2 0 0.2 0.4 0.6");
    assert_eq!(ticks(0.0, 3e-7, false), SMALL);
    assert_eq!(ticks(0.3, 0.3, false), "0.285 0.29 0.295 0.3 0.305 0.31 0.315");
}

#[test]
fn numbers_on_logarithmic_axes_are_powers_or_round_within_a_decade() {
    assert_eq!(ticks(0.001, 200.0, true), "0.001 0.01 0.1 1 10 100");
    const SMALL: &str = "10^−15 2·10^−15 5·10^−15 10^−14 2·10^−14 5·10^−14";
    assert_eq!(ticks(1e-15, 6.4e-14, true), SMALL);
    assert_eq!(ticks(0.03, 1.2, true), "0.05 0.1 0.2 0.5 1");
    assert_eq!(ticks(2.1, 2.9, true), "2 2.2 2.4 2.6 2.8 3 3.2");
    assert_eq!(ticks(1e-30, 1e30, true), "10^−30 10^−20 10^−10 10^0 10^10 10^20 10^30");
}

#[test]
fn every_axis_has_numbers_that_do_not_touch() {
    for (low, high) in [(1.0, 1e60), (1e-15, 1e-3), (0.9, 1.1), (0.02, 0.7), (1e-200, 1e200)] {
        let (x, y) = ([low, high], [low, high]);
        for log in [false, true] {
            let curves = vec![curve("a", &x, &y, Stroke::Line)];
            let svg = Chart { log_x: log, log_y: log, curves, ..Chart::default() }.svg();
            let count = texts(&svg).len();
            assert!((4..=18).contains(&count), "{low} to {high}: {count} numbers");
        }
    }
}

#[test]
fn a_legend_with_many_or_long_names_is_below_the_plot() {
    let (x, y) = ([0.0, 1.0], [0.0, 1.0]);
    let height = |names: &[&str]| {
        let curves = names.iter().map(|n| curve(n, &x, &y, Stroke::Line)).collect();
        let svg = Chart { curves, ..Chart::default() }.svg();
        assert_well_formed(&svg);
        assert!(names.len() < 2 || svg.matches("stroke-width=\"1.8\"").count() == 2 * names.len());
        let (bottom, lowest) =
            (svg.split(&format!("viewBox=\"0 0 {WIDTH} ")).nth(1).unwrap(), values(&svg, "y"));
        let bottom: f64 = bottom.split('"').next().unwrap().parse().unwrap();
        assert!(lowest.iter().all(|y| *y < bottom));
        bottom
    };
    assert_eq!(height(&["a"]), HEIGHT);
    assert_eq!(height(&["a", "b"]), HEIGHT);
    assert!(height(&["a"; 30]) > HEIGHT);
    assert!(height(&["a", &"long name ".repeat(30)]) > HEIGHT);
    assert!(height(&["a", &"unbroken".repeat(30)]) > HEIGHT);
}

/// The sample of a style in a legend.
fn key(style: &Style) -> String {
    let mut canvas = Canvas::default();
    style.draw_key(&mut canvas, [0.0, 20.0], 0.0);
    canvas.document([1.0; 2], "", "")
}

#[test]
fn a_curve_without_a_point_is_not_in_the_legend() {
    let (x, y) = ([0.0, 1.0], [0.0, 1.0]);
    let lost = curve("lost", &x, &[f64::NAN; 2], Stroke::Line);
    let curves = vec![lost, curve("kept", &x, &y, Stroke::Line)];
    let svg = Chart { curves, ..Chart::default() }.svg();
    assert!(svg.contains("kept") && !svg.contains("lost"));
    assert!(svg.contains(style::COLOURS[1]) && !svg.contains(style::COLOURS[0]));
}

#[test]
fn curves_differ_without_colours() {
    let (x, y) = ([0.0, 1.0], [0.0, 1.0]);
    for stroke in [Stroke::Line, Stroke::Points, Stroke::Marked] {
        let names: Vec<String> = (0..8).map(|k| format!("c{k}")).collect();
        let curves: Vec<_> = names.iter().map(|n| curve(n, &x, &y, stroke)).collect();
        let without_colour = |key: String| style::COLOURS.iter().fold(key, |k, c| k.replace(c, ""));
        let styles = style::styles(&curves);
        let keys: Vec<String> = styles.iter().map(|s| without_colour(key(s))).collect();
        (1..8).for_each(|k| assert!(!keys[..k].contains(&keys[k]), "{stroke:?}: {k}"));
    }
}

#[test]
fn a_curve_without_a_name_looks_like_the_one_of_its_colour() {
    let (x, y) = ([0.0, 1.0], [0.0, 1.0]);
    let of = |name, colour| Curve { colour: Some(colour), ..curve(name, &x, &y, Stroke::Marked) };
    let curves = [of("a", 0), of("b", 1), of("", 0), of("", 1), of("c", 0), of("", 0)];
    let styles: Vec<String> = style::styles(&curves).iter().map(key).collect();
    assert_eq!(styles[2], styles[0]);
    assert_eq!(styles[3], styles[1]);
    assert_eq!(styles[5], styles[4]);
    assert_ne!(styles[4], styles[0]);
}

#[test]
fn lines_do_not_end_beside_an_equals_sign() {
    let lines = text::wrap("explicit coupling, viscosity = 0.001", 12.0, 200.0);
    assert_eq!(lines, ["explicit coupling,", "viscosity = 0.001"]);
}

proptest! {
    #[test]
    fn lines_of_text_keep_every_word_and_their_room(text in "[a-z_ ]{0,80}", room in 20.0..200.0) {
        let lines = text::wrap(&text, 12.0, room);
        prop_assert!(lines.iter().all(|l| !l.is_empty() && text::width(l, 12.0) <= room));
        let letters = |t: &str| t.replace(' ', "");
        prop_assert_eq!(letters(&lines.join("")), letters(&text));
    }

    #[test]
    fn no_text_is_clipped(
        title in "[ -~]{0,90}", x_label in "[ -~]{0,90}", y_label in "[ -~]{0,90}",
        low in -1e3..1e3, length in 1e-6..1e6,
        names in proptest::collection::vec("[a-z ]{1,60}", 1..12),
    ) {
        let (x, y) = ([low, low + length], [low, low + length]);
        let curves = names.iter().map(|n| curve(n, &x, &y, Stroke::Line)).collect();
        let (title, x_label, y_label) = (title.as_str(), x_label.as_str(), y_label.as_str());
        let chart = Chart { title, x_label, y_label, curves, ..Chart::default() };
        let svg = chart.svg();
        assert_well_formed(&svg);
        prop_assert_eq!(&svg, &chart.svg());
        for line in svg.lines().filter(|l| l.starts_with("<text")) {
            let [at, size] = ["x", "font-size"].map(|name| values(line, name)[0]);
            let wide = text::width(&super::super::markup::unescape(&texts(line)[0]), size);
            let (left, right) = match line {
                l if l.contains("rotate") => (at - size, at + 0.3 * size),
                l if l.contains("middle") => (at - 0.5 * wide, at + 0.5 * wide),
                l if l.contains("\"end\"") => (at - wide, at),
                _ => (at, at + wide),
            };
            prop_assert!(left >= 0.0 && right <= WIDTH, "{}", line);
        }
    }
}
