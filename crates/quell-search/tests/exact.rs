//! Results of starts as bytes and back.
#![allow(missing_docs, reason = "a test binary")]

use proptest::collection::vec;
use proptest::prelude::*;
use quell_search::{StartResult, StartStatus};

fn bits(numbers: &[f64]) -> Vec<u64> {
    numbers.iter().map(|number| number.to_bits()).collect()
}

fn status() -> impl Strategy<Value = StartStatus> {
    prop_oneof![
        Just(StartStatus::Certified),
        Just(StartStatus::Converged),
        Just(StartStatus::BudgetExhausted),
        Just(StartStatus::Infeasible),
        Just(StartStatus::Failed),
    ]
}

proptest! {
    /// Every bit of every number comes back, those of NaN, of negative zero and of subnormal numbers included; and what
    /// was cut off anywhere, or has something after it, is no result.
    #[test]
    fn round_trips(
        point in vec(any::<u64>(), 0..6),
        constraints in vec(any::<u64>(), 0..4),
        objective: u64,
        violation: u64,
        certificate: Option<u64>,
        evaluations in 0..usize::MAX,
        status in status(),
    ) {
        let numbers = |bits: &[u64]| bits.iter().map(|bits| f64::from_bits(*bits)).collect::<Vec<_>>();
        let result = StartResult {
            point: numbers(&point),
            objective: f64::from_bits(objective),
            constraints: numbers(&constraints),
            violation: f64::from_bits(violation),
            evaluations,
            status,
            certificate: certificate.map(f64::from_bits),
        };
        let bytes = result.to_bytes();
        let back = StartResult::from_bytes(&bytes).unwrap();
        prop_assert_eq!(bits(&back.point), point);
        prop_assert_eq!(bits(&back.constraints), constraints);
        prop_assert_eq!(back.objective.to_bits(), objective);
        prop_assert_eq!(back.violation.to_bits(), violation);
        prop_assert_eq!(back.certificate.map(f64::to_bits), certificate);
        prop_assert_eq!((back.evaluations, back.status), (evaluations, status));
        for length in 0..bytes.len() {
            prop_assert!(StartResult::from_bytes(&bytes[..length]).is_none());
        }
        let longer = [bytes, vec![0]].concat();
        prop_assert!(StartResult::from_bytes(&longer).is_none());
    }

    /// Bytes from anywhere are refused or read, and never ask for more memory than they are long.
    #[test]
    fn any_bytes(bytes in vec(any::<u8>(), 0..120)) {
        if let Some(result) = StartResult::from_bytes(&bytes) {
            prop_assert_eq!(result.to_bytes().len(), bytes.len());
        }
    }
}
