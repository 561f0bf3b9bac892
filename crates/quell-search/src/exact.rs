//! Results of starts as bytes, exact to the last bit.

use crate::{StartResult, StartStatus};

/// Changes with the layout below.
const LAYOUT: u8 = 1;

impl StartResult {
    /// The result as bytes, every number to its last bit: for whoever keeps finished starts and must go on with the very
    /// same numbers. The layout is little-endian: version, status, evaluations, objective, violation, certificate (after
    /// a byte that says whether there is one), then point and constraints, each after its length.
    pub fn to_bytes(&self) -> Vec<u8> {
        let numbers = self.point.len() + self.constraints.len();
        let mut bytes = Vec::with_capacity(51 + 8 * numbers);
        bytes.push(LAYOUT);
        bytes.push(match self.status {
            StartStatus::Certified => 0,
            StartStatus::Converged => 1,
            StartStatus::BudgetExhausted => 2,
            StartStatus::Infeasible => 3,
            StartStatus::Failed => 4,
        });
        bytes.extend((self.evaluations as u64).to_le_bytes());
        bytes.extend(self.objective.to_bits().to_le_bytes());
        bytes.extend(self.violation.to_bits().to_le_bytes());
        bytes.push(u8::from(self.certificate.is_some()));
        bytes.extend(self.certificate.unwrap_or_default().to_bits().to_le_bytes());
        for list in [&self.point, &self.constraints] {
            bytes.extend((list.len() as u64).to_le_bytes());
            for number in list {
                bytes.extend(number.to_bits().to_le_bytes());
            }
        }
        bytes
    }

    /// The result that [`to_bytes`](Self::to_bytes) wrote; none where the bytes are something else.
    pub fn from_bytes(bytes: &[u8]) -> Option<Self> {
        let mut reader = Reader(bytes);
        if reader.byte()? != LAYOUT {
            return None;
        }
        let status = match reader.byte()? {
            0 => StartStatus::Certified,
            1 => StartStatus::Converged,
            2 => StartStatus::BudgetExhausted,
            3 => StartStatus::Infeasible,
            4 => StartStatus::Failed,
            _ => return None,
        };
        let evaluations = usize::try_from(reader.count()?).ok()?;
        let objective = reader.number()?;
        let violation = reader.number()?;
        let certified = match reader.byte()? {
            0 => false,
            1 => true,
            _ => return None,
        };
        let certificate = reader.number()?;
        let point = reader.list()?;
        let constraints = reader.list()?;
        reader.0.is_empty().then_some(Self {
            point,
            objective,
            constraints,
            violation,
            evaluations,
            status,
            certificate: certified.then_some(certificate),
        })
    }
}

/// Bytes that are still to be read.
struct Reader<'a>(&'a [u8]);

impl Reader<'_> {
    fn byte(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    fn count(&mut self) -> Option<u64> {
        let (first, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(u64::from_le_bytes(*first))
    }

    fn number(&mut self) -> Option<f64> {
        self.count().map(f64::from_bits)
    }

    fn list(&mut self) -> Option<Vec<f64>> {
        let length = usize::try_from(self.count()?).ok()?;
        // A length that the bytes cannot hold is refused before memory is asked for.
        if length > self.0.len() / 8 {
            return None;
        }
        (0..length).map(|_| self.number()).collect()
    }
}
