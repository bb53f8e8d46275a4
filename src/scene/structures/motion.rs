//! How a vesicle moves in a shear flow, from the series.

use super::{Finding, FindingValue};

/// Change of the angle of a steady vesicle in the second half of a run, in degrees.
const STEADY: f64 = 1.0;

/// The motion in the second half of a run, whose times, angles of the long axis and directions of a
/// point of the membrane (degrees, counted on over turns) these are: tank-treading (steady while the
/// membrane turns), vacillating-breathing (the axis swings), tumbling (it turns over), at rest, or
/// unsettled; with its angle, swing or times.
pub(super) fn findings([time, turned, treaded]: [&[f64]; 3]) -> Vec<Finding> {
    let Some((&end, &start)) = time.last().zip(time.first()) else { return Vec::new() };
    let first = time.partition_point(|t| *t < start + 0.5 * (end - start));
    let late = |values: &[f64]| values.get(first..).unwrap_or_default().to_vec();
    let [time, turned, treaded] = [time, turned, treaded].map(late);
    if time.len() < 3 || turned.iter().chain(&treaded).any(|v| v.is_nan()) {
        return Vec::new();
    }
    let span = time[time.len() - 1] - time[0];
    let gone = |values: &[f64]| values[values.len() - 1] - values[0];
    let least = turned.iter().copied().fold(f64::INFINITY, f64::min);
    let most = turned.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    let finding = |names, value, note: &str| Finding { names, value, note: note.into() };
    let of = |word, note| finding(["motion", "Motion"], FindingValue::Word(word), note);
    let number = |names, value, note| finding(names, FindingValue::Number(value), note);
    if gone(&turned).abs() > 180.0 {
        let time = 180.0 / gone(&turned).abs() * span;
        return vec![
            of("tumbling", "the long axis turns over"),
            number(["half_turn", "Time of half a turn"], time, "mean over the second half"),
        ];
    }
    let frequency = half_turns(&time, &treaded).map(|turns| {
        let note = "by whole half turns in the second half";
        number(["treading_frequency", "Turns of the membrane a unit of time"], turns, note)
    });
    if most - least < STEADY {
        // Degrees; less is an error of the mesh.
        let treads = gone(&treaded).abs() > 10.0;
        let angle =
            number(["angle", "Angle of the long axis"], turned[turned.len() - 1], "degrees");
        let what = match treads {
            true => of("tank-treading", "the axis is steady, the membrane turns"),
            false => of("at rest", "neither axis nor membrane turn"),
        };
        return [what, angle].into_iter().chain(frequency.filter(|_| treads)).collect();
    }
    let up: Vec<bool> = turned.windows(2).map(|w| w[1] > w[0]).collect();
    let reversals = up.windows(2).filter(|w| w[0] != w[1]).count();
    if reversals >= 2 {
        let found = [
            of("vacillating-breathing", "the long axis swings about"),
            number(["swing", "Swing of the long axis"], most - least, "degrees"),
        ];
        return found.into_iter().chain(frequency).collect();
    }
    vec![of("unsettled", "run it for longer")]
}

/// Turns a unit of time by the largest number of half turns that fit, after which a membrane of a
/// symmetric form is where it was; `None` without half a turn.
fn half_turns(time: &[f64], treaded: &[f64]) -> Option<f64> {
    let start = treaded[0];
    let gone = treaded[treaded.len() - 1] - start;
    let half = 180.0 * (gone.abs() / 180.0).floor();
    let k = treaded.iter().position(|v| (v - start).abs() >= half).filter(|_| half > 0.0)?;
    let [before, after] = [treaded[k - 1], treaded[k]].map(|v| (v - start).abs());
    let when = time[k - 1] + (time[k] - time[k - 1]) * (half - before) / (after - before);
    Some(half / 360.0 / (when - time[0]) * gone.signum())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::PI;

    fn motion(turned: impl Fn(f64) -> f64, treaded: impl Fn(f64) -> f64) -> (String, f64) {
        let time: Vec<f64> = (0..=200).map(|k| f64::from(k) * 0.1).collect();
        let at = |f: &dyn Fn(f64) -> f64| time.iter().map(|&t| f(t)).collect::<Vec<f64>>();
        let found = findings([&time, &at(&turned), &at(&treaded)]);
        let FindingValue::Word(word) = found[0].value else { panic!("{found:?}") };
        let number = match found.get(1).map(|f| &f.value) {
            Some(FindingValue::Number(v)) => *v,
            _ => f64::NAN,
        };
        (word.to_string(), number)
    }

    #[test]
    fn each_motion_is_recognised() {
        let (word, angle) = motion(|t| 25.0 + 20.0 * (-t).exp(), |t| -30.0 * t);
        assert!(word == "tank-treading" && (angle - 25.0).abs() < 1e-3, "{word} {angle}");
        // A membrane that turns unevenly: twice the frequency in the form.
        let time: Vec<f64> = (0..=200).map(|k| f64::from(k) * 0.1).collect();
        let of: Vec<f64> = time.iter().map(|t| -36.0 * t + 20.0 * (0.4 * PI * t).sin()).collect();
        assert!((half_turns(&time, &of).unwrap() + 0.1).abs() < 1e-9);
        assert!(half_turns(&time, &time).is_none());
        let (word, time) = motion(|t| -45.0 * t, |t| -60.0 * t);
        assert!(word == "tumbling" && (time - 4.0).abs() < 1e-9, "{word} {time}");
        let (word, swing) = motion(|t| 15.0 * (2.0 * t).sin(), |t| -30.0 * t);
        assert!(word == "vacillating-breathing" && (swing - 30.0).abs() < 0.2, "{word} {swing}");
        assert_eq!(motion(|t| 40.0 - t, |t| -30.0 * t).0, "unsettled");
        assert_eq!(motion(|_| 20.0, |_| 3.0).0, "at rest");
        assert!(findings([&[0.0], &[1.0], &[1.0]]).is_empty());
    }
}
