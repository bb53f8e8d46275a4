//! Checkpoints: lossless conversion of a state to bytes and back.

use super::balance::{Energies, EnergyBalance};
use super::clock::Clock;
use super::state::{Factored, State};
use crate::base::bytes::{Reader, Writer};
use crate::base::{Cause, Error, Result, fnv1a};
use crate::flow::FlowState;
use crate::linalg::SolveCost;
use crate::structure::Fields;

/// First bytes of a checkpoint; the last one is the version.
const MAGIC: &[u8; 8] = b"immersa\x09";

impl<const D: usize> State<D> {
    /// The state as bytes, marked with `tag`, which identifies the scene: numbers of 8 bytes, each
    /// list after its length.
    pub fn to_bytes(&self, tag: u64) -> Vec<u8> {
        let mut out = Writer(MAGIC.to_vec());
        out.integer(tag);
        out.integer(self.steps);
        out.numbers(&[self.time]);
        out.integer(u64::from(self.pace.is_some()));
        if let Some(c) = &self.pace {
            [c.interval, c.part, c.parts, c.rejected].into_iter().for_each(|v| out.integer(v));
            out.numbers(&[c.wanted, c.last, c.before, c.speed]);
        }
        out.vectors(&self.earliest_u);
        out.vectors(&self.flow.u);
        out.vectors(&self.earlier_u);
        out.numbers(&self.flow.p);
        self.fields.write(&mut out);
        out.integer(u64::from(self.factored.is_some()));
        if let Some(Factored { fields, backflow, wind, weight, dt, solve_cost: l }) = &self.factored
        {
            fields.write(&mut out);
            out.numbers(backflow);
            out.vectors(wind);
            out.numbers(&[*weight, *dt, l.solves, l.spent, l.last, l.hold, l.failures]);
        }
        let (e, b) = (self.energies, self.balance);
        out.numbers(&[e.kinetic, e.elastic, e.dissipation, e.grad_div, e.power, e.divergence]);
        out.numbers(&[e.elastic_power, e.elastic_traffic]);
        out.numbers(&[b.initial, b.dissipated, b.work, b.exchanged, b.transferred, b.least]);
        out.numbers(&[b.elastic_initial, b.elastic_work, b.elastic_traffic, b.start]);
        out.integer(b.settling);
        let check = fnv1a(&out.0);
        out.integer(check);
        out.0
    }

    /// The state from bytes that [`to_bytes`](Self::to_bytes) made with the same `tag`.
    ///
    /// # Errors
    /// Bytes that are cut off or damaged, or that belong to another scene.
    pub fn from_bytes(bytes: &[u8], tag: u64) -> Result<State<D>> {
        State::from_some(bytes, Some(tag))
    }

    /// The state from bytes that [`to_bytes`](Self::to_bytes) made, of whatever scene.
    ///
    /// # Errors
    /// Bytes that are cut off or damaged, or a state of another dimension.
    pub fn of_any_scene(bytes: &[u8]) -> Result<State<D>> {
        State::from_some(bytes, None)
    }

    fn from_some(bytes: &[u8], tag: Option<u64>) -> Result<State<D>> {
        let damaged = || {
            Error::input("the checkpoint is damaged or cut off")
                .value(format!("{} bytes", bytes.len()))
                .remedy("start a new run")
                .because(Cause::Checkpoint)
        };
        let body = bytes.len().checked_sub(8).filter(|n| *n >= MAGIC.len()).ok_or_else(damaged)?;
        let (content, check) = bytes.split_at(body);
        let (name, version) = MAGIC.split_at(MAGIC.len() - 1);
        if content.starts_with(name) && !content[name.len()..].starts_with(version) {
            return Err(Error::input("the checkpoint was written by another version of immersa")
                .value(format!(
                    "format {}, this program writes {}",
                    content[name.len()],
                    version[0]
                ))
                .remedy("continue with the version that began the run, or start a new run")
                .because(Cause::Checkpoint));
        }
        if !content.starts_with(MAGIC) || check != fnv1a(content).to_le_bytes() {
            return Err(damaged());
        }
        let mut reader = Reader(&content[MAGIC.len()..]);
        let marked = reader.integer().ok_or_else(damaged)?;
        if tag.is_some_and(|tag| tag != marked) {
            return Err(Error::input("the checkpoint belongs to another scene")
                .remedy(
                    "resume with the scene and the settings that the run was started with, or \
                     start a new run",
                )
                .because(Cause::Checkpoint));
        }
        State::read(&mut reader).filter(|_| reader.0.is_empty()).ok_or_else(damaged)
    }

    fn read(from: &mut Reader<'_>) -> Option<State<D>> {
        let steps = from.integer()?;
        let [time] = from.numbers()?.try_into().ok()?;
        let pace = match from.integer()? {
            0 => None,
            _ => {
                let [interval, part, parts, rejected] =
                    [from.integer()?, from.integer()?, from.integer()?, from.integer()?];
                let [wanted, last, before, speed] = from.numbers()?.try_into().ok()?;
                let clock = Clock { interval, part, parts, wanted, last, before, rejected, speed };
                Some(clock)
            }
        };
        let earliest_u = from.vectors()?;
        let (u, earlier_u, p) = (from.vectors()?, from.vectors()?, from.numbers()?);
        let fields = Fields::read(from)?;
        let factored = match from.integer()? {
            0 => None,
            _ => {
                let (fields, backflow, wind) =
                    (Fields::read(from)?, from.numbers()?, from.vectors()?);
                let [weight, dt, solves, spent, last, hold, failures] =
                    from.numbers()?.try_into().ok()?;
                let solve_cost = SolveCost { solves, spent, last, hold, failures };
                Some(Factored { fields, backflow, wind, weight, dt, solve_cost })
            }
        };
        let [kinetic, elastic, dissipation, grad_div, power, divergence] =
            from.numbers()?.try_into().ok()?;
        let [elastic_power, elastic_traffic] = from.numbers()?.try_into().ok()?;
        let energies = Energies {
            kinetic,
            elastic,
            dissipation,
            grad_div,
            power,
            divergence,
            elastic_power,
            elastic_traffic,
        };
        let [initial, dissipated, work, exchanged, transferred, least] =
            from.numbers()?.try_into().ok()?;
        let [elastic_initial, elastic_work, elastic_traffic, start] =
            from.numbers()?.try_into().ok()?;
        let settling = from.integer()?;
        let balance = EnergyBalance {
            initial,
            dissipated,
            work,
            exchanged,
            transferred,
            least,
            elastic_initial,
            elastic_work,
            elastic_traffic,
            start,
            settling,
        };
        let flow = FlowState { u, p };
        Some(State {
            steps,
            time,
            pace,
            flow,
            earlier_u,
            earliest_u,
            fields,
            factored,
            energies,
            balance,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::structure::{Carry, Data, Declaration, Rule};
    use nalgebra::SVector;

    fn fields(scale: f64) -> Fields<2> {
        let kept = Fields::default();
        let mut declared = Declaration::new(2, &kept);
        let rule = || Rule { carry: Carry::ByOwner, acts: true, written: false };
        declared.add("a.level_set", rule(), || Data::Scalar(vec![0.1 * scale, -0.0]));
        declared.add("a.labels", rule(), || Data::Labels(vec![3, 1]));
        declared.backward_map(true);
        declared.finish().unwrap().0
    }

    fn state() -> State<2> {
        State {
            steps: 7,
            time: 0.7,
            pace: Some(Clock { part: 1, parts: 4, last: 0.1, ..Clock::default() }),
            earliest_u: vec![SVector::<f64, 2>::new(0.1, 0.2)],
            flow: FlowState {
                u: vec![SVector::<f64, 2>::new(1.0, -0.0); 3],
                p: vec![f64::MIN_POSITIVE, 0.1],
            },
            earlier_u: vec![SVector::<f64, 2>::new(0.3, 2.0); 3],
            fields: fields(1.0),
            factored: Some(Factored {
                fields: fields(3.0),
                backflow: vec![0.0, 0.5],
                wind: vec![SVector::<f64, 2>::new(0.7, -0.2)],
                weight: 1.5,
                dt: 0.1,
                solve_cost: SolveCost { spent: 9.0, ..SolveCost::default() },
            }),
            energies: Energies { kinetic: 1.5, elastic_traffic: 2.5, ..Energies::default() },
            balance: EnergyBalance {
                work: 0.25,
                least: 1e-9,
                elastic_work: 0.5,
                start: -0.75,
                settling: 2,
                ..EnergyBalance::default()
            },
        }
    }

    #[test]
    fn a_state_comes_back_bit_by_bit_and_damage_is_noticed() {
        let bytes = state().to_bytes(42);
        assert_eq!(State::<2>::from_bytes(&bytes, 42).unwrap(), state());
        assert!(
            State::<2>::from_bytes(&bytes, 43).unwrap_err().to_string().contains("another scene")
        );
        for cut in 0..bytes.len() {
            assert!(State::<2>::from_bytes(&bytes[..cut], 42).is_err());
        }
        for k in 0..bytes.len() {
            let mut broken = bytes.clone();
            broken[k] ^= 1;
            assert!(State::<2>::from_bytes(&broken, 42).is_err());
        }
    }
}
