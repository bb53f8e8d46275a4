//! A state as bytes, and back, bit by bit.

use super::budget::{Budget, Energies};
use super::setup::State;
use crate::base::{Error, Result, fnv1a};
use crate::flow::FlowState;
use nalgebra::SVector;

/// First bytes of a checkpoint; the last one is the version.
const MAGIC: &[u8; 8] = b"immersa\x01";

impl<const D: usize> State<D> {
    /// The state as bytes, marked with `tag`, which tells the scene apart.
    pub fn to_bytes(&self, tag: u64) -> Vec<u8> {
        let mut out = MAGIC.to_vec();
        let mut integer = |v: u64| out.extend(v.to_le_bytes());
        integer(tag);
        integer(self.steps);
        for n in [self.flow.u.len(), self.flow.p.len(), self.phi.len()] {
            integer(n as u64);
        }
        let vectors = self.flow.u.iter().chain(&self.earlier_u).flat_map(|v| v.iter());
        let numbers = vectors.chain(&self.flow.p).chain(self.phi.iter().flatten());
        for v in numbers {
            out.extend(v.to_le_bytes());
        }
        let (e, b) = (self.energies, self.budget);
        for v in [e.kinetic, e.elastic, e.dissipation, e.grad_div, e.power, e.divergence] {
            out.extend(v.to_le_bytes());
        }
        for v in [b.initial, b.dissipated, b.work, b.exchanged] {
            out.extend(v.to_le_bytes());
        }
        let check = fnv1a(&out);
        out.extend(check.to_le_bytes());
        out
    }

    /// The state from bytes that [`to_bytes`](Self::to_bytes) made with the same `tag`.
    ///
    /// # Errors
    /// Bytes that are cut off or damaged, or that belong to another scene.
    pub fn from_bytes(bytes: &[u8], tag: u64) -> Result<State<D>> {
        let damaged = || {
            Error::input("the checkpoint is damaged or cut off")
                .value(format!("{} bytes", bytes.len()))
                .remedy("start afresh in another folder with --out")
        };
        let body = bytes.len().checked_sub(8).filter(|n| *n >= MAGIC.len()).ok_or_else(damaged)?;
        let (content, check) = bytes.split_at(body);
        if !content.starts_with(MAGIC) || check != fnv1a(content).to_le_bytes() {
            return Err(damaged());
        }
        let mut words = content[MAGIC.len()..].as_chunks::<8>().0.iter();
        let mut integer = || words.next().map(|w| u64::from_le_bytes(*w)).ok_or_else(damaged);
        if integer()? != tag {
            return Err(Error::input("the checkpoint belongs to another scene")
                .remedy("resume with the scene and the settings that the run was started with, or start afresh in another folder with --out"));
        }
        let steps = integer()?;
        let (nodes, pressures, structures) = (integer()? as usize, integer()? as usize, integer()? as usize);
        let wanted = 2 * D as u128 * nodes as u128 + pressures as u128 + structures as u128 * nodes as u128 + 10;
        if words.len() as u128 != wanted {
            return Err(damaged());
        }
        let mut numbers = words.map(|w| f64::from_le_bytes(*w));
        let mut next = || numbers.next().unwrap_or(f64::NAN);
        let mut vectors = || (0..nodes).map(|_| SVector::<f64, D>::from_fn(|_, _| next())).collect::<Vec<_>>();
        let (u, earlier_u) = (vectors(), vectors());
        let p = (0..pressures).map(|_| next()).collect();
        let phi = (0..structures).map(|_| (0..nodes).map(|_| next()).collect()).collect();
        let energies = Energies {
            kinetic: next(),
            elastic: next(),
            dissipation: next(),
            grad_div: next(),
            power: next(),
            divergence: next(),
        };
        let budget = Budget { initial: next(), dissipated: next(), work: next(), exchanged: next() };
        Ok(State { steps, flow: FlowState { u, p }, phi, earlier_u, energies, budget })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn state() -> State<2> {
        State {
            steps: 7,
            flow: FlowState { u: vec![SVector::<f64, 2>::new(1.0, -0.0); 3], p: vec![f64::MIN_POSITIVE, 0.1] },
            phi: vec![vec![0.1, 0.2, 0.3]],
            earlier_u: vec![SVector::<f64, 2>::new(0.3, 2.0); 3],
            energies: Energies { kinetic: 1.5, ..Energies::default() },
            budget: Budget { work: 0.25, ..Budget::default() },
        }
    }

    #[test]
    fn a_state_comes_back_bit_by_bit_and_damage_is_noticed() {
        let bytes = state().to_bytes(42);
        assert_eq!(State::<2>::from_bytes(&bytes, 42).unwrap(), state());
        assert!(State::<2>::from_bytes(&bytes, 43).unwrap_err().to_string().contains("another scene"));
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
