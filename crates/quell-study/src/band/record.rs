//! A band as `results.json` has it.

use serde::Serialize;

/// A stable band, SI.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct BandResult {
    /// Lower end.
    pub lower: f64,
    /// Upper end.
    pub upper: f64,
    /// Value of the operating parameter at which the lower end is; none at an end of the range.
    pub lower_at: Option<f64>,
    /// Value of the operating parameter at which the upper end is; none at an end of the range.
    pub upper_at: Option<f64>,
    /// What ends it below and above.
    pub limited_by: [String; 2],
    /// What a small change of the design would bring about within the band, in words.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub near: Vec<String>,
    /// What was tested, in words.
    pub checks: Vec<String>,
}
