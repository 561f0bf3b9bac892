//! Where a stream finds its registers.

#![expect(
    clippy::inline_always,
    reason = "only what is inlined is compiled for the vectors of the machine"
)]

/// Registers in a bank that needs no check of their numbers.
pub(super) const SMALL: usize = 256;

/// Registers of L points each.
pub(super) trait Bank<const L: usize> {
    /// The values of a register.
    fn at(&self, register: u32) -> &[f64; L];

    /// Writes a register.
    fn set(&mut self, register: u32, values: [f64; L]);
}

/// As many as there are; the compiler numbers registers below the length that the work space has been given.
impl<const L: usize> Bank<L> for [[f64; L]] {
    #[inline(always)]
    fn at(&self, register: u32) -> &[f64; L] {
        &self[register as usize]
    }

    #[inline(always)]
    fn set(&mut self, register: u32, values: [f64; L]) {
        self[register as usize] = values;
    }
}

/// For streams whose registers are all below [`SMALL`]: one byte cannot miss.
impl<const L: usize> Bank<L> for [[f64; L]; SMALL] {
    #[inline(always)]
    fn at(&self, register: u32) -> &[f64; L] {
        &self[usize::from(register as u8)]
    }

    #[inline(always)]
    fn set(&mut self, register: u32, values: [f64; L]) {
        self[usize::from(register as u8)] = values;
    }
}
