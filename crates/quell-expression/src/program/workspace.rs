//! Where programs compute.

use super::bank::SMALL;

/// Registers of a program for L points at a time; made by `default`, sized by the program, so only the first call
/// allocates.
#[derive(Debug, Clone, Default)]
pub struct Workspace<const L: usize = 1> {
    registers: Vec<[f64; L]>,
    scratch: Vec<[f64; L]>,
}

/// Registers of a program for a batch of points.
pub type BatchWorkspace = Workspace<{ super::LANES }>;

impl<const L: usize> Workspace<L> {
    /// At least so many registers and scratch registers; what was never written is not-a-number.
    #[inline]
    pub(super) fn sized(
        &mut self,
        registers: usize,
        scratch: usize,
    ) -> (&mut [[f64; L]], &mut [[f64; L]]) {
        // What is written in a small bank needs a whole one.
        if self.registers.len() < registers.max(SMALL) {
            self.registers.resize(registers.max(SMALL), [f64::NAN; L]);
        }
        if self.scratch.len() < scratch {
            self.scratch.resize(scratch, [f64::NAN; L]);
        }
        (&mut self.registers, &mut self.scratch)
    }
}
