//! Meshes that equidistribute the collocation error.

use super::collocation::Collocation;
use super::rule::lagrange;
use crate::settings::MeshSettings;

/// N equal intervals.
pub(crate) fn uniform(count: usize) -> Vec<f64> {
    (0..=count).map(|i| i as f64 / count as f64).collect()
}

/// Values on the nodes of `mesh` of something on the nodes of the collocation's own; `wrap` is its advance over a period.
pub(crate) fn transfer(c: &Collocation<'_>, z: &[f64], wrap: &[f64], mesh: &[f64]) -> Vec<f64> {
    let (m, n, count) = (c.rule.m, c.n, c.count());
    let mut out = Vec::with_capacity((mesh.len() - 1) * m * n);
    let mut l = vec![0.0; m + 1];
    let mut i = 0;
    for pair in mesh.windows(2) {
        for k in 0..m {
            let tau = pair[0] + c.rule.nodes[k] * (pair[1] - pair[0]);
            while i + 1 < count && tau >= c.mesh[i + 1] {
                i += 1;
            }
            while i > 0 && tau < c.mesh[i] {
                i -= 1;
            }
            lagrange(&c.rule.nodes, (tau - c.mesh[i]) / c.step(i), &mut l);
            for j in 0..n {
                let mut sum = 0.0;
                for (k, l) in l.iter().enumerate() {
                    let index = i * m + k;
                    let x = if index == count * m {
                        z[j] + wrap[j]
                    } else {
                        z[index * n + j]
                    };
                    sum += l * x;
                }
                out.push(sum);
            }
        }
    }
    out
}

/// The mesh that equidistributes the error, with the number of intervals that holds the tolerance within its bounds.
///
/// The error of an interval is estimated as C h^{m+1} |x^{(m+1)}| with C = (m!)² / (2 (2m)! (m+1)!), relative to the range of
/// each coordinate; the derivative comes from jumps of the m-th (de Boor 1973). None where the present mesh serves: its largest
/// error is below the tolerance, or the number of intervals is fixed and they share the error well enough.
pub(crate) fn equidistribute(
    c: &Collocation<'_>,
    z: &[f64],
    settings: &MeshSettings,
) -> Option<Vec<f64>> {
    let (m, n, count) = (c.rule.m, c.n, c.count());
    let mut scales = vec![0.0_f64; n];
    for (j, scale) in scales.iter_mut().enumerate() {
        let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
        for i in 0..count * m {
            low = low.min(z[i * n + j]);
            high = high.max(z[i * n + j]);
        }
        *scale = high - low;
    }
    let floor = 1e-3 * scales.iter().fold(0.0_f64, |a, b| a.max(*b)).max(1e-12);
    let mut top = vec![0.0; count * n];
    for i in 0..count {
        let power = c.step(i).powi(m as i32);
        for j in 0..n {
            let sum: f64 = (0..=m).map(|k| c.rule.top[k] * c.node(z, i, k, j)).sum();
            top[i * n + j] = sum / power / scales[j].max(floor);
        }
    }
    // The (m+1)-st derivative at mesh points, then its larger neighbour per interval.
    let at = |i: usize| {
        let (a, b) = ((i + count - 1) % count, i % count);
        let width = 0.5 * (c.step(a) + c.step(b));
        (0..n)
            .map(|j| ((top[b * n + j] - top[a * n + j]) / width).powi(2))
            .sum::<f64>()
            .sqrt()
    };
    let points: Vec<f64> = (0..count).map(at).collect();
    let exponent = 1.0 / (m as f64 + 1.0);
    let mut monitor: Vec<f64> = (0..count)
        .map(|i| (0.5 * (points[i] + points[(i + 1) % count])).powf(exponent))
        .collect();
    let average: f64 = (0..count).map(|i| monitor[i] * c.step(i)).sum();
    let factorial = |k: usize| (1..=k).map(|k| k as f64).product::<f64>();
    let constant = factorial(m).powi(2) / (2.0 * factorial(2 * m) * factorial(m + 1));
    let worst = (0..count)
        .map(|i| constant * (c.step(i) * monitor[i]).powi(m as i32 + 1))
        .fold(0.0_f64, f64::max);
    for v in &mut monitor {
        *v += 0.2 * average.max(1e-12);
    }
    let total: f64 = (0..count).map(|i| monitor[i] * c.step(i)).sum();
    let wanted = total * (constant / settings.tolerance).powf(exponent);
    let (least, most) = settings.bounds;
    let mut number = count;
    if wanted > 1.05 * count as f64 || wanted < 0.7 * count as f64 {
        number = (1.1 * wanted)
            .min(1.6 * count as f64 + 1.0)
            .max(0.7 * count as f64)
            .ceil() as usize;
    }
    number = number.clamp(least.max(2), most.max(least.max(2)));
    let largest = (0..count)
        .map(|i| monitor[i] * c.step(i))
        .fold(0.0_f64, f64::max);
    let serves = if least == most {
        largest * (count as f64) < EVEN * total
    } else {
        worst < settings.tolerance
    };
    if number == count && serves {
        return None;
    }
    let mut mesh = Vec::with_capacity(number + 1);
    let mut i = 0;
    let mut done = 0.0;
    for k in 0..number {
        let goal = total * k as f64 / number as f64;
        while i + 1 < count && done + monitor[i] * c.step(i) < goal {
            done += monitor[i] * c.step(i);
            i += 1;
        }
        mesh.push(c.mesh[i] + (goal - done) / monitor[i]);
    }
    mesh.push(1.0);
    mesh[0] = 0.0;
    Some(mesh)
}

/// Share of an interval in what is to be equidistributed, over the mean, up to which it counts as even: another mesh would
/// cost a factorisation, and this one's largest error is at most 1.2^(m + 1) of the least possible.
const EVEN: f64 = 1.2;
