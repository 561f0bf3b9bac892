//! Keys of units: a hash of everything that determines them.

/// BLAKE3 of everything that determines a unit of work.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub struct Key([u8; 32]);

impl Key {
    /// Begins a key; `what` keeps apart the keys of different things.
    pub fn of(what: &str) -> KeyBuilder {
        KeyBuilder(blake3::Hasher::new()).text(what)
    }

    /// The bytes of the hash.
    pub const fn bytes(&self) -> &[u8; 32] {
        &self.0
    }

    /// The first eight bytes: enough to know that a store does *not* hold a key.
    pub(super) fn prefix(bytes: &[u8]) -> u64 {
        bytes
            .iter()
            .take(8)
            .fold(0, |prefix, byte| (prefix << 8) | u64::from(*byte))
    }
}

/// A key under way: what is added is told apart by place and length, so that `"ab", "c"` and `"a", "bc"` differ.
#[derive(Debug, Clone)]
pub struct KeyBuilder(blake3::Hasher);

impl KeyBuilder {
    /// Adds a text.
    #[must_use]
    pub fn text(self, text: &str) -> Self {
        self.bytes(text.as_bytes())
    }

    /// Adds bytes.
    #[must_use]
    pub fn bytes(mut self, bytes: &[u8]) -> Self {
        self.0.update(&(bytes.len() as u64).to_le_bytes());
        self.0.update(bytes);
        self
    }

    /// Adds a number, to the last bit.
    #[must_use]
    pub fn number(self, number: f64) -> Self {
        self.count(number.to_bits())
    }

    /// Adds numbers, to the last bit.
    #[must_use]
    pub fn numbers(self, numbers: &[f64]) -> Self {
        let length = self.count(numbers.len() as u64);
        numbers
            .iter()
            .fold(length, |key, number| key.number(*number))
    }

    /// Adds a count.
    #[must_use]
    pub fn count(mut self, count: u64) -> Self {
        self.0.update(&count.to_le_bytes());
        self
    }

    /// The key.
    pub fn key(&self) -> Key {
        Key(*self.0.finalize().as_bytes())
    }
}
