//! Tables of the page: quantities that should be zero, the columns of the series, the cost by
//! phase.

use super::folder::RunFolder;
use super::{segmentation, units};
use crate::base::{PHASES, Phase};
use crate::output::{Cell, Column, Table, rounded};

/// A fraction in per cent.
pub(super) fn per_cent(v: f64) -> String {
    crate::output::per_cent(v, 3)
}

/// A row of the balances: the quantity, its value at the end and the largest one, and the value
/// that it should have.
type Check = (String, [Option<f64>; 2], &'static str);

/// Quantities that should be zero or bounded.
pub(super) fn balances(run: &RunFolder) -> Table {
    let row = |cell: fn(Option<f64>, usize) -> Cell| {
        move |(what, values, bound): Check| {
            let [end, largest] = values.map(|v| cell(v, 3));
            vec![Cell::text(what), end, largest, Cell::text(bound)]
        }
    };
    let given = |check: &Check| check.1.iter().any(Option::is_some);
    let fractions =
        energies(run).into_iter().chain(areas(run)).filter(given).map(row(Cell::per_cent));
    let numbers = bounds(run).into_iter().chain(forces(run)).filter(given).map(row(Cell::optional));
    Table::new("", "Balances", ["", "at the end", "largest in the run", "should be"])
        .with_rows(fractions.chain(numbers))
        .with_caption("What the equations conserve or bound, and how well the computation kept it.")
}

fn energies(run: &RunFolder) -> Vec<Check> {
    vec![
        (
            "residual of the energy balance, over the energy in play".into(),
            [energy_balance(run), run.column("energy_balance").and_then(largest)],
            "0; negative when the scheme itself dissipates",
        ),
        (
            "energy that the start has taken at once, over the energy in play".into(),
            [run.summary.balance.start.filter(|v| *v < 0.0), None],
            "0 when the flow starts smoothly; not in the residual",
        ),
        (
            "rise of the energy in one step, over the first".into(),
            [None, run.summary.balance.largest_rise],
            "0 or less when nothing drives the flow",
        ),
        (
            "rise of the energy from row to row, over the first".into(),
            [None, segmentation::largest_rise(run)],
            "0 or less",
        ),
    ]
}

fn areas(run: &RunFolder) -> Vec<Check> {
    let enclosed = run.words().enclosed;
    let check = |name: &str| {
        let area = run.column_of(name, enclosed);
        let changes: Option<Vec<f64>> = area.map(|a| a.iter().map(|v| v / a[0] - 1.0).collect());
        let values = [area_change(run, name), changes.as_deref().and_then(largest)];
        (format!("change of the {enclosed} in {name}"), values, "0: no fluid crosses an interface")
    };
    run.scene.interfaces().filter(|_| run.scene.image.is_none()).map(check).collect()
}

fn bounds(run: &RunFolder) -> Vec<Check> {
    let columns = [
        (
            "divergence",
            "‖div u‖ in L2",
            "0; small against the gradient of u, and smaller on a finer mesh",
        ),
        ("cfl", "Courant number", "about 1 or less, for accuracy"),
        (
            "map_error",
            "rms(det grad Y - 1) of the backward map",
            "0; smaller with a smaller numerics.remap and on a finer mesh",
        ),
        (
            "step_over_limit",
            "step over the explicit limit (1.54)",
            "at most 1 when the coupling is explicit",
        ),
    ];
    let applies = |column: &str| column != "step_over_limit" || run.scene.acting().next().is_some();
    let check = |(column, what, bound): (&str, &str, &'static str)| {
        (what.to_string(), [run.last(column), run.column(column).and_then(largest)], bound)
    };
    columns.into_iter().filter(|c| applies(c.0)).map(check).collect()
}

fn forces(run: &RunFolder) -> Vec<Check> {
    let check = |name: &str, component: &str| {
        let [a, b] = ["", "_stress"].map(|by| format!("{name}{by}_{component}"));
        let difference = run.column(&a).zip(run.column(&b));
        let difference: Option<Vec<f64>> =
            difference.map(|(a, b)| a.iter().zip(b).map(|(a, b)| b - a).collect());
        let end = difference.as_ref().and_then(|d| d.last()).copied();
        (
            format!("force {name} in {component}: by stress less by residual"),
            [end, difference.as_deref().and_then(largest)],
            "0; smaller on a finer mesh",
        )
    };
    let of = |name: &str| ["x", "y", "z"].map(|component| check(name, component));
    run.scene.output.forces.iter().flat_map(|f| of(&f.name)).collect()
}

/// The residual of the energy balance at the end, relative.
pub(super) fn energy_balance(run: &RunFolder) -> Option<f64> {
    run.summary.balance.energy.or_else(|| run.last("energy_balance"))
}

/// The relative change of the area (in space: volume) in a membrane from start to end.
pub(super) fn area_change(run: &RunFolder, membrane: &str) -> Option<f64> {
    let said = run.summary.balance.area.get(membrane).copied().flatten();
    said.or_else(|| {
        run.column_of(membrane, run.words().enclosed)
            .and_then(|a| Some(a.last()? / a.first()? - 1.0))
    })
}

/// The value of the largest magnitude, with its sign.
fn largest(values: &[f64]) -> Option<f64> {
    values.iter().copied().filter(|v| v.is_finite()).max_by(|a, b| a.abs().total_cmp(&b.abs()))
}

/// The columns of the series: last, least and greatest value.
pub(super) fn columns(run: &RunFolder) -> Table {
    let with_units = run.series.names.iter().any(|name| !units::of_column(run, name).is_empty());
    let finite = |c: &[f64], pick: fn(f64, f64) -> f64| {
        c.iter().copied().filter(|v| v.is_finite()).reduce(pick)
    };
    let row = |(name, column): (&String, &Vec<f64>)| {
        let values = [run.last(name), finite(column, f64::min), finite(column, f64::max)];
        let [end, least, greatest] = values.map(|v| Cell::optional(v, 6));
        let unit = with_units.then(|| Cell::text(units::of_column(run, name)));
        [Cell::text(name)].into_iter().chain(unit).chain([end, least, greatest]).collect()
    };
    let unit = with_units.then_some("unit");
    let columns = ["column of series.csv"].into_iter().chain(unit);
    Table::new("", "Numbers", columns.chain(["at the end", "least", "greatest"]))
        .with_rows(run.series.names.iter().zip(&run.series.columns).skip(1).map(row))
}

/// Most rows of the series on the page.
const MOST_ROWS: usize = 1000;

/// The rows of the series, of a long one every so many and the last.
pub(super) fn rows(run: &RunFolder) -> Option<Table> {
    let (series, count) = (&run.series, run.series.rows());
    let every = count.div_ceil(MOST_ROWS).max(1);
    let names = series
        .names
        .iter()
        .map(|name| Column { heading: name.clone(), unit: units::of_column(run, name) });
    let shown = (0..count).filter(|k| k % every == 0 || k + 1 == count);
    let row = |k: usize| series.columns.iter().map(|c| Cell::number(c[k], 6)).collect();
    let caption = match every {
        1 => String::new(),
        n => format!("One of {n} rows, and the last."),
    };
    let table = Table::new("series", "Table of the series", names).with_caption(caption);
    (count > 0).then(|| table.with_rows(shown.map(row)))
}

/// Seconds by phase, the longest first.
pub(super) fn phases(run: &RunFolder) -> Table {
    let mut phases: Vec<(&String, f64)> =
        run.summary.seconds.iter().filter_map(|(k, v)| Some((k, (*v)?))).collect();
    phases.sort_by(|a, b| b.1.total_cmp(&a.1));
    let total: f64 = phases.iter().map(|p| p.1).sum();
    let share = |s: f64| Cell::per_cent((total > 0.0).then_some(s / total), 3);
    Table::new("", "Time by phase", ["phase", "elapsed", "share"])
        .with_unit("elapsed", "s")
        .with_rows(
            phases
                .into_iter()
                .map(|(name, s)| vec![Cell::text(name), Cell::number(s, 3), share(s)]),
        )
}

/// Solution of the linear systems; empty where there was none.
pub(super) fn solves(run: &RunFolder) -> Table {
    let s = &run.summary.solves;
    let rows = [
        ("factorisations", Cell::count(Some(s.factorisations))),
        ("solved by iterations with an older factor", Cell::count(Some(s.krylov))),
        ("iterations given up, then factored", Cell::count(Some(s.given_up))),
        ("iterations of a solve: mean", Cell::number(s.mean_iterations, 3)),
        ("iterations of a solve: most", Cell::count(Some(s.most_iterations))),
        ("largest relative residual", Cell::number(s.worst_residual, 2)),
    ];
    let keep =
        if s.krylov + s.given_up > 0 { rows.len() } else { usize::from(s.factorisations > 0) };
    Table::new("", "Linear systems", ["", "in the run"])
        .with_rows(rows.into_iter().take(keep).map(|(what, value)| vec![Cell::text(what), value]))
        .with_caption(
            "An older factor serves as preconditioner of GMRES as long as, by count, that costs \
             less than factoring.",
        )
}

/// Seconds of the processors by phase of the steps, in their order.
pub(super) fn steps(run: &RunFolder) -> Table {
    let spent = |name: &str| run.summary.step_seconds.get(name).copied().flatten().unwrap_or(0.0);
    let total: f64 = PHASES.iter().map(|(_, name)| spent(name)).sum();
    let count = run.summary.steps.unwrap_or(0).max(1) as f64;
    let row = |(_, name): &(Phase, &str)| {
        let s = spent(name);
        vec![
            Cell::text(*name),
            Cell::number(s, 3),
            Cell::number(s / count, 3),
            Cell::per_cent(Some(s / total), 3),
        ]
    };
    Table::new("", "Cost of the steps", ["phase of a step", "CPU time", "CPU time a step", "share"])
        .with_unit("CPU time", "s")
        .with_unit("CPU time a step", "s")
        .with_rows(PHASES.iter().filter(|(_, name)| total > 0.0 && spent(name) > 0.0).map(row))
        .with_caption(bandwidth(run))
}

/// Bandwidth of the substitutions; empty for short runs.
fn bandwidth(run: &RunFolder) -> String {
    let gigabytes = |v: f64| rounded(1e-9 * v, 3);
    run.summary.bandwidth.as_ref().map_or_else(String::new, |b| {
        format!(
            "The factor of {} MB was read twice in each of {} substitutions: over the time of the \
             solves {} GB/s. A copy of 64 MiB moved {} GB/s on the same machine.",
            rounded(1e-6 * b.factor_bytes, 3),
            b.substitutions,
            gigabytes(b.achieved),
            gigabytes(b.copy)
        )
    })
}
