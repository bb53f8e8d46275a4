//! Tables of the page: balances, columns of the series, computing time.

use super::folder::RunFolder;
use super::segmentation;
use crate::base::{PHASES, Phase};
use crate::output::{Listing, rounded};

/// A fraction in per cent.
pub(super) fn per_cent(v: f64) -> String {
    format!("{} %", rounded(100.0 * v, 3))
}

/// Table of balances, exactly zero in theory, and of other indicators of accuracy.
pub(super) fn balances(run: &RunFolder) -> Listing {
    let mut rows = Vec::new();
    let mut row = |what: String, end: Option<String>, largest: Option<String>, says: &str| {
        if end.is_some() || largest.is_some() {
            rows.push(vec![what, end.unwrap_or_default(), largest.unwrap_or_default(), says.to_string()]);
        }
    };
    let relative = |c: &[f64]| largest(c).map(per_cent);
    row(
        "spurious energy over the energy in play".into(),
        energy_balance(run).map(per_cent),
        run.column("energy_balance").and_then(relative),
        "0; negative when the scheme itself dissipates",
    );
    row(
        "rise of the energy in one step, over the first".into(),
        None,
        run.summary.balance.largest_rise.map(per_cent),
        "0 or less when nothing drives the flow",
    );
    row(
        "rise of the energy from row to row, over the first".into(),
        None,
        segmentation::largest_rise(run).map(per_cent),
        "0 or less",
    );
    for name in run.scene.interfaces().filter(|_| run.scene.image.is_none()) {
        let enclosed = run.words().enclosed;
        let area = run.column_of(name, enclosed);
        let changes: Option<Vec<f64>> = area.map(|a| a.iter().map(|v| v / a[0] - 1.0).collect());
        row(
            format!("change of the {enclosed} in {name}"),
            area_change(run, name).map(per_cent),
            changes.as_deref().and_then(relative),
            "0: no fluid crosses an interface",
        );
    }
    let end = |name: &str| run.last(name).map(|v| rounded(v, 3));
    let most = |name: &str| run.column(name).and_then(largest).map(|v| rounded(v, 3));
    for (column, what, says) in [
        ("divergence", "‖div u‖ in L2", "0; small against the gradient of u, and smaller on a finer mesh"),
        ("cfl", "Courant number", "about 1 or less, for accuracy"),
        (
            "map_error",
            "rms(det grad Y - 1) of the backward map",
            "0; smaller with a smaller numerics.remap and on a finer mesh",
        ),
        ("step_over_limit", "step over the explicit limit (1.54)", "at most 1 when the coupling is explicit"),
    ] {
        if column != "step_over_limit" || run.scene.acting().next().is_some() {
            row(what.into(), end(column), most(column), says);
        }
    }
    for force in &run.scene.output.forces {
        for component in ["x", "y", "z"] {
            let [a, b] = ["", "_stress"].map(|method| format!("{}{method}_{component}", force.name));
            let difference = run.column(&a).zip(run.column(&b));
            let difference: Option<Vec<f64>> = difference.map(|(a, b)| a.iter().zip(b).map(|(a, b)| b - a).collect());
            row(
                format!("force {} in {component}: by stress less by residual", force.name),
                difference.as_ref().and_then(|d| d.last()).map(|v| rounded(*v, 3)),
                difference.as_deref().and_then(largest).map(|v| rounded(v, 3)),
                "0; smaller on a finer mesh",
            );
        }
    }
    Listing {
        title: "Balances".into(),
        header: ["", "at the end", "largest in the run", "should be"].map(String::from).to_vec(),
        rows,
        caption: "What the equations conserve or bound, and how well the computation kept it.".into(),
    }
}

/// The spurious energy at the end, relative.
pub(super) fn energy_balance(run: &RunFolder) -> Option<f64> {
    run.summary.balance.energy.or_else(|| run.last("energy_balance"))
}

/// The relative change of the area (in space: volume) in a membrane from start to end.
pub(super) fn area_change(run: &RunFolder, membrane: &str) -> Option<f64> {
    let said = run.summary.balance.area.get(membrane).copied().flatten();
    said.or_else(|| run.column_of(membrane, run.words().enclosed).and_then(|a| Some(a.last()? / a.first()? - 1.0)))
}

/// The value of the largest magnitude, with its sign.
fn largest(values: &[f64]) -> Option<f64> {
    values.iter().copied().filter(|v| v.is_finite()).max_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// The columns of the series: last, least and greatest value.
pub(super) fn columns(run: &RunFolder) -> Listing {
    let finite = |c: &[f64], pick: fn(f64, f64) -> f64| c.iter().copied().filter(|v| v.is_finite()).reduce(pick);
    let row = |(name, column): (&String, &Vec<f64>)| {
        let text = |v: Option<f64>| v.map_or_else(|| "-".to_string(), |v| rounded(v, 6));
        vec![name.clone(), text(run.last(name)), text(finite(column, f64::min)), text(finite(column, f64::max))]
    };
    Listing {
        title: "Numbers".into(),
        header: ["column of series.csv", "at the end", "least", "greatest"].map(String::from).to_vec(),
        rows: run.series.names.iter().zip(&run.series.columns).skip(1).map(row).collect(),
        caption: String::new(),
    }
}

/// Seconds by phase, the longest first.
pub(super) fn phases(run: &RunFolder) -> Listing {
    let mut phases: Vec<(&String, f64)> = run.summary.seconds.iter().filter_map(|(k, v)| Some((k, (*v)?))).collect();
    phases.sort_by(|a, b| b.1.total_cmp(&a.1));
    let total: f64 = phases.iter().map(|p| p.1).sum();
    let share = |s: f64| if total > 0.0 { per_cent(s / total) } else { String::new() };
    Listing {
        title: "Where the time went".into(),
        header: ["phase", "seconds", "share"].map(String::from).to_vec(),
        rows: phases.into_iter().map(|(name, s)| vec![name.clone(), rounded(s, 3), share(s)]).collect(),
        caption: String::new(),
    }
}

/// Table of the solves of linear systems; empty if there are none.
pub(super) fn solves(run: &RunFolder) -> Listing {
    let s = &run.summary.solves;
    let rows = [
        ("factorisations", s.factorisations.to_string()),
        ("solved by iterations with an older factor", s.krylov.to_string()),
        ("iterations given up, then factored", s.given_up.to_string()),
        ("iterations of a solve: mean", rounded(s.mean_iterations, 3)),
        ("iterations of a solve: most", s.most_iterations.to_string()),
        ("largest relative residual", rounded(s.worst_residual, 2)),
    ];
    let keep = if s.krylov + s.given_up > 0 { rows.len() } else { usize::from(s.factorisations > 0) };
    let rows = rows.into_iter().take(keep).map(|(what, value)| vec![what.to_string(), value]).collect();
    Listing {
        title: "Linear systems".into(),
        header: ["", "in the run"].map(String::from).to_vec(),
        rows,
        caption:
            "An older factor serves as preconditioner of GMRES as long as, by count, that costs less than factoring."
                .into(),
    }
}

/// CPU seconds by phase of the steps, in their order.
pub(super) fn steps(run: &RunFolder) -> Listing {
    let spent = |name: &str| run.summary.step_seconds.get(name).copied().flatten().unwrap_or(0.0);
    let total: f64 = PHASES.iter().map(|(_, name)| spent(name)).sum();
    let count = run.summary.steps.unwrap_or(0).max(1) as f64;
    let row = |(_, name): &(Phase, &str)| {
        let s = spent(name);
        vec![name.to_string(), rounded(s, 3), rounded(s / count, 3), per_cent(s / total)]
    };
    let rows = PHASES.iter().filter(|(_, name)| total > 0.0 && spent(name) > 0.0).map(row).collect();
    let gigabytes = |v: f64| rounded(1e-9 * v, 3);
    let caption = run.summary.bandwidth.as_ref().map_or_else(String::new, |b| {
        format!(
            "The factor of {} MB was read twice in each of {} substitutions: over the time of the solves {} GB/s. A copy of 64 MiB \
             moved {} GB/s on the same machine.",
            rounded(1e-6 * b.factor_bytes, 3),
            b.substitutions,
            gigabytes(b.achieved),
            gigabytes(b.copy)
        )
    });
    Listing {
        title: "What the steps took".into(),
        header: ["phase of a step", "CPU seconds", "a step", "share"].map(String::from).to_vec(),
        rows,
        caption,
    }
}
