//! The tables of a convergence study.

use super::page::{DIGITS, Study, digits};
use super::sequence::Basis;
use super::{Limit, Meaning};
use crate::output::{Cell, Table};

impl Study<'_> {
    /// The runs, the checks last.
    pub(super) fn runs(&self) -> Table {
        let header = ["level", "cells", "edge", "steps", "unknowns", "CPU", "end"];
        let mut table = Table::new("levels", "Runs", header).with_unit("CPU", "s");
        for o in self.outcomes {
            table.rows.push(vec![
                Cell::text(&o.trial.label),
                Cell::count(o.summary.cells),
                Cell::optional(o.summary.edge, 4),
                Cell::count(o.summary.steps),
                Cell::count((o.unknowns() > 0).then(|| o.unknowns())),
                Cell::number(o.cpu_seconds(), 3),
                Cell::text(o.end.in_words()),
            ]);
        }
        table
    }

    /// Every quantity on every level.
    pub(super) fn convergence(&self) -> Table {
        let header = ["quantity", "time", self.size_name(), "value", "change", "error", "order"];
        let mut table = Table::new("convergence", "Level by level", header);
        for row in self.rows {
            let changes = row.sequence.changes();
            for (k, &size) in self.sizes.iter().enumerate() {
                let value = row.sequence.values[k];
                let (value, change, error) = match row.quantity.meaning {
                    Meaning::Value => {
                        (value, changes[k], row.limit.map_or(f64::NAN, |l| (value - l.value).abs()))
                    }
                    Meaning::Error => (f64::NAN, f64::NAN, value),
                    Meaning::Change => (f64::NAN, value, f64::NAN),
                };
                table.rows.push(vec![
                    Cell::text(&row.quantity.name),
                    Cell::number(row.time, 6),
                    Cell::number(size, 5),
                    Cell::number(value, DIGITS),
                    Cell::number(change, 3),
                    Cell::number(error, 3),
                    Cell::number(row.orders[k], 3),
                ]);
            }
        }
        table.caption = "Change: from the level before (of an interface: its distance from \
            there). Error: against the exact solution, or else against the limit below. Order: \
            from a level and those before it; - where none is seen."
            .into();
        table
    }

    /// The limits of all values; none if every quantity is an error or a distance.
    pub(super) fn limits(&self) -> Option<Table> {
        let zero = format!("{} -> 0", self.size_name());
        let mut header =
            vec!["quantity", "time", "finest", "order", zero.as_str(), "error bar", "taken"];
        header.extend(self.ladder.checks.iter().map(|c| c.0));
        let mut table = Table::new("limits", "What the values tend to", header);
        for row in self.rows.iter().filter(|r| r.quantity.meaning == Meaning::Value) {
            let digits = row.limit.map_or(DIGITS, |l| digits(&l));
            let mut cells = vec![
                Cell::text(&row.quantity.name),
                Cell::number(row.time, 6),
                Cell::number(row.finest(), DIGITS),
                Cell::number(row.order(), 3),
                Cell::optional(row.limit.map(|l| l.value), digits),
                Cell::optional(row.limit.map(|l| l.bar), 2),
                Cell::text(row.limit.map_or("no limit seen".into(), |l| basis(&l))),
            ];
            cells.extend(row.checks.iter().map(|&moved| Cell::number(moved, 2)));
            table.rows.push(cells);
        }
        table.caption = "Extrapolated from the two finest levels with a whole order, the bar is \
            the distance from the same extrapolation a level earlier, or with the order as seen; \
            with an observed order that is no whole one, it is all that the extrapolation adds; \
            where no order is seen but the values settle, the finest value stands, and the spread \
            of the last three."
            .into();
        if !self.ladder.checks.is_empty() {
            table.caption += " The last columns: by how much halving what is not refined moves \
                the coarsest level.";
        }
        (!table.rows.is_empty()).then_some(table)
    }

    /// Limits, bars, orders and finest values as numbers alone, a row a time.
    pub(super) fn by_time(&self) -> Table {
        let times = self.times();
        let mut table = Table::new("by_time", "Page by time", ["time"]);
        table.rows = times.iter().map(|t| vec![Cell::number(*t, DIGITS)]).collect();
        for row in self.rows {
            let limit = row.limit.map_or([f64::NAN; 2], |l| [l.value, l.bar]);
            let columns = [
                ("limit", limit[0]),
                ("bar", limit[1]),
                ("order", row.order()),
                ("finest", row.finest()),
            ];
            let skipped = if row.quantity.meaning == Meaning::Value { 0 } else { 2 };
            for (end, value) in columns.into_iter().skip(skipped) {
                let name = format!("{}.{end}", row.quantity.name);
                if table.position(&name).is_none() {
                    table.columns.push(name.into());
                }
                if let Some(k) = times.iter().position(|t| *t == row.time) {
                    table.rows[k].push(Cell::number(value, DIGITS));
                }
            }
        }
        table
    }
}

fn basis(limit: &Limit) -> String {
    match limit.basis {
        Basis::Whole(p) => format!("order {p}"),
        Basis::Observed(p) => format!("order {p:.2}, as seen"),
        Basis::Spread => "spread".into(),
    }
}
