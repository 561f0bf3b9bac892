//! Adaptive Gauss-Kronrod quadrature on several intervals at once.

/// Positive nodes of the 15-point Kronrod rule; every second one belongs to the 7-point Gauss rule (R. Piessens et al., QUADPACK, 1983).
const NODES: [f64; 8] = [
    0.991_455_371_120_812_6,
    0.949_107_912_342_758_5,
    0.864_864_423_359_769_1,
    0.741_531_185_599_394_4,
    0.586_087_235_467_691_1,
    0.405_845_151_377_397_2,
    0.207_784_955_007_898_47,
    0.0,
];
const KRONROD: [f64; 8] = [
    0.022_935_322_010_529_224,
    0.063_092_092_629_978_55,
    0.104_790_010_322_250_18,
    0.140_653_259_715_525_92,
    0.169_004_726_639_267_9,
    0.190_350_578_064_785_4,
    0.204_432_940_075_298_9,
    0.209_482_141_084_727_82,
];
const GAUSS: [f64; 4] = [
    0.129_484_966_168_869_7,
    0.279_705_391_489_276_7,
    0.381_830_050_505_118_9,
    0.417_959_183_673_469_4,
];

/// An integral and the estimate of its error.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Integral {
    pub(crate) value: f64,
    pub(crate) error: f64,
}

fn rule<E>(from: f64, to: f64, f: &mut impl FnMut(f64) -> Result<f64, E>) -> Result<Integral, E> {
    let (middle, half) = (0.5 * (from + to), 0.5 * (to - from));
    let mut samples = [0.0; 15];
    let (mut kronrod, mut gauss, mut size) = (0.0, 0.0, 0.0);
    for (i, (&node, &weight)) in NODES.iter().zip(&KRONROD).enumerate() {
        let pair = if node == 0.0 {
            vec![middle]
        } else {
            vec![middle - half * node, middle + half * node]
        };
        for (side, x) in pair.into_iter().enumerate() {
            let value = f(x)?;
            samples[2 * i + side] = value;
            kronrod += weight * value;
            size += weight * value.abs();
            if i % 2 == 1 {
                gauss += GAUSS[i / 2] * value;
            }
        }
    }
    let mean = 0.5 * kronrod;
    let mut spread = 0.0;
    for (i, &weight) in KRONROD.iter().enumerate() {
        for side in 0..if i == 7 { 1 } else { 2 } {
            spread += weight * (samples[2 * i + side] - mean).abs();
        }
    }
    let difference = (kronrod - gauss).abs();
    let estimate = if spread > 0.0 {
        spread * (200.0 * difference / spread).powf(1.5).min(1.0)
    } else {
        difference
    };
    Ok(Integral {
        value: half * kronrod,
        error: half * estimate.max(50.0 * f64::EPSILON * size),
    })
}

/// ∫ f over consecutive intervals to a relative tolerance, or to the best of `most` subdivisions.
pub(crate) fn integrate<E>(
    breaks: &[f64],
    tolerance: f64,
    most: usize,
    mut f: impl FnMut(f64) -> Result<f64, E>,
) -> Result<Integral, E> {
    let mut pieces = Vec::new();
    for pair in breaks.windows(2) {
        pieces.push((pair[0], pair[1], rule(pair[0], pair[1], &mut f)?));
    }
    for _ in 0..most {
        let value: f64 = pieces.iter().map(|piece| piece.2.value).sum();
        let error: f64 = pieces.iter().map(|piece| piece.2.error).sum();
        if error <= tolerance * value.abs() {
            break;
        }
        let Some(worst) =
            (0..pieces.len()).max_by(|&a, &b| pieces[a].2.error.total_cmp(&pieces[b].2.error))
        else {
            break;
        };
        let (from, to, _) = pieces[worst];
        let middle = 0.5 * (from + to);
        if !(middle > from && middle < to) {
            break;
        }
        pieces[worst] = (from, middle, rule(from, middle, &mut f)?);
        pieces.push((middle, to, rule(middle, to, &mut f)?));
    }
    // Small ones first, so that the sum does not depend on where the large ones stand.
    pieces.sort_by(|a, b| a.2.value.abs().total_cmp(&b.2.value.abs()));
    Ok(Integral {
        value: pieces.iter().map(|piece| piece.2.value).sum(),
        error: pieces.iter().map(|piece| piece.2.error).sum(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resonance_and_polynomial() {
        // ∫ dx/(x² + ε²) over [-1, 1] = 2 atan(1/ε)/ε; a polynomial of degree 13 is exact.
        let e = 1e-4;
        let sharp =
            integrate::<()>(&[-1.0, 1.0], 1e-12, 2000, |x| Ok(1.0 / (x * x + e * e))).unwrap();
        let exact = 2.0 * (1.0 / e).atan() / e;
        assert!(
            (sharp.value / exact - 1.0).abs() < 1e-11,
            "{sharp:?} {exact}"
        );
        let smooth = integrate::<()>(&[0.0, 1.0], 1e-12, 1, |x| Ok(x.powi(13))).unwrap();
        assert!((smooth.value * 14.0 - 1.0).abs() < 1e-14);
    }
}
