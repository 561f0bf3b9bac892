//! Ranks and null spaces of the stamped system, decided once, independently of element values.
//!
//! Every element enters a symmetric positive semi-definite matrix with a non-negative factor, so the null spaces of
//! M, C and K do not depend on (positive) values and are found with values that are commensurate with the host.
//! Coordinates z = T y are split into
//!
//! * `a`: motions of internal nodes that only inerters hold (no damper, no spring): their momentum is conserved,
//!   they follow the rest and are no modes;
//! * `1`: coordinates with mass, second order;
//! * `2`: coordinates without mass that dampers hold, first order;
//! * `3`: coordinates that only springs hold, algebraic.
//!
//! Among the displacements of `1` and `2`, neutral directions W (internal nodes that no spring holds) have no
//! restoring force; the state keeps displacements modulo W, so that no artefact at zero appears.
//!
//! # References
//! The index reduction is that of modified nodal analysis (R. März, 1992; C. Tischendorf, 1999), in second-order form.

use crate::assembly::Stamp;
use crate::dense::{Dense, null_space, snap};
use crate::error::ResponseError;

/// Entries below this part of the largest are rounding errors of host matrices that were computed from parameters.
const RANK: f64 = 1e-9;
/// Diagonals are scaled to one down to this part of the largest, so that rounding errors are not scaled up.
const SCALE_FLOOR: f64 = 1e-6;

#[derive(Debug, Clone)]
pub(crate) struct Structure {
    /// z = T y, columns ordered a, 1, 2, 3.
    pub(crate) transform: Dense<f64>,
    /// Numbers of coordinates of each kind: a, 1, 2, 3.
    pub(crate) counts: [usize; 4],
    /// Incidence of every stamp on y.
    pub(crate) incidence: Vec<Vec<f64>>,
    /// Neutral directions over (1, 2) as columns, identity on `neutral_rows`.
    pub(crate) neutral: Dense<f64>,
    /// The rows of (1, 2) that are left out of the state, ascending.
    pub(crate) neutral_rows: Vec<usize>,
    /// The rows of (1, 2) that are kept, ascending.
    pub(crate) kept_rows: Vec<usize>,
}

impl Structure {
    /// `matrices` are the host's K, C, M; `deflate` takes out the host's own rigid-body motions as well.
    pub(crate) fn new(
        hosts: usize,
        size: usize,
        matrices: [&Dense<f64>; 3],
        stamps: &[Stamp],
        deflate: bool,
        names: &dyn Fn(usize) -> String,
    ) -> Result<Self, ResponseError> {
        let [stiffness, damping, mass] =
            [0, 1, 2].map(|order| commensurate(matrices[order], order, hosts, size, stamps));
        let allowed: Vec<usize> = if deflate {
            (0..size).collect()
        } else {
            (hosts..size).collect()
        };

        // (a) neither damper nor spring.
        let both = stack(&[
            &stiffness,
            &stiffness.transpose(),
            &damping,
            &damping.transpose(),
        ]);
        let free = scaled_null_space(&columns(&both, &allowed));
        let momentum = embed(&free.basis, &allowed, size);
        let mut rest: Vec<usize> = (0..size).filter(|i| !allowed.contains(i)).collect();
        rest.extend(free.pivots.iter().map(|&p| allowed[p]));
        rest.sort_unstable();
        let count_a = momentum.columns();
        let mass_a = momentum.transpose().times(&mass).times(&momentum);
        let null_a = scaled_null_space(&mass_a);
        if !null_a.free.is_empty() {
            return Err(floating(&momentum.times(&null_a.basis), names));
        }
        let factor_a = mass_a.lu().ok_or(ResponseError::Singular {
            what: "the mass of the internal nodes",
        })?;

        // (b) without mass. `follow` is how the momentum coordinates go along.
        let pick = embed(&Dense::identity(rest.len()), &rest, size);
        let follow = factor_a
            .solve(&momentum.transpose().times(&mass).times(&pick))
            .scale(-1.0);
        let dressed = pick.plus(&momentum.times(&follow));
        let mass_rest = pick.transpose().times(&mass).times(&dressed);
        let massless = scaled_null_space(&mass_rest);
        let pick_1 = columns(&pick, &massless.pivots);
        let massless_z = snapped(&dressed.times(&massless.basis));
        let damping_n = massless_z.transpose().times(&damping).times(&massless_z);
        let undamped = scaled_null_space(&damping_n);
        let pick_2 = columns(&massless_z, &undamped.pivots);
        let pick_3 = snapped(&massless_z.times(&undamped.basis));
        let coupling = damping
            .times(&pick_3)
            .largest()
            .max(pick_3.transpose().times(&damping).largest());
        if coupling > RANK * damping.largest() * pick_3.largest().max(1.0) {
            return Err(ResponseError::UnsymmetricDamping {
                coordinate: name_of(&pick_3, names),
            });
        }
        let algebraic = pick_3.transpose().times(&stiffness).times(&pick_3);
        let unheld = scaled_null_space(&algebraic);
        if !unheld.free.is_empty() {
            return Err(floating(&pick_3.times(&unheld.basis), names));
        }
        let counts = [
            count_a,
            pick_1.columns(),
            pick_2.columns(),
            pick_3.columns(),
        ];
        let mut transform = Dense::zeros(size, size);
        let mut first = 0;
        for block in [&momentum, &pick_1, &pick_2, &pick_3] {
            transform.place(0, first, block);
            first += block.columns();
        }

        // (d) no restoring force.
        let springs = stack(&[&stiffness, &stiffness.transpose()]);
        let loose = embed(
            &scaled_null_space(&columns(&springs, &allowed)).basis,
            &allowed,
            size,
        );
        let to_y = transform.lu().ok_or(ResponseError::Singular {
            what: "the coordinate transformation",
        })?;
        let loose_y = snapped(&to_y.solve(&loose))
            .block(count_a..count_a + counts[1] + counts[2], 0..loose.columns());
        let (neutral, neutral_rows) = column_space(&loose_y);
        let kept_rows = (0..counts[1] + counts[2])
            .filter(|row| !neutral_rows.contains(row))
            .collect();

        let incidence = stamps
            .iter()
            .map(|stamp| {
                let mut row = vec![0.0; size];
                for &(i, value) in &stamp.row.coordinates {
                    for (entry, factor) in row.iter_mut().zip(transform.row(i)) {
                        *entry += value * factor;
                    }
                }
                let largest = stamp
                    .row
                    .coordinates
                    .iter()
                    .fold(0.0_f64, |m, entry| m.max(entry.1.abs()));
                for entry in &mut row {
                    // What cancels does so exactly in exact arithmetic: element values must not bring it back.
                    if entry.abs() < 1e-11 * largest {
                        *entry = 0.0;
                    }
                }
                row
            })
            .collect();
        Ok(Self {
            transform,
            counts,
            incidence,
            neutral,
            neutral_rows,
            kept_rows,
        })
    }

    /// Number of states of the realisation.
    pub(crate) fn states(&self) -> usize {
        2 * self.counts[1] + self.counts[2] - self.neutral_rows.len()
    }
}

/// The host's matrix plus every element of this kind with a value that fits the host's scale.
fn commensurate(
    host: &Dense<f64>,
    order: usize,
    hosts: usize,
    size: usize,
    stamps: &[Stamp],
) -> Dense<f64> {
    let scale: Vec<f64> = (0..hosts)
        .map(|i| {
            let diagonal = host.get(i, i).abs();
            if diagonal > 0.0 {
                1.0 / diagonal.sqrt()
            } else {
                1.0
            }
        })
        .collect();
    let typical = {
        let largest = (0..hosts).map(|i| host.get(i, i).abs()).fold(0.0, f64::max);
        if largest > 0.0 {
            1.0 / largest.sqrt()
        } else {
            1.0
        }
    };
    let mut matrix = Dense::zeros(size, size);
    matrix.place(0, 0, host);
    for stamp in stamps.iter().filter(|stamp| stamp.order == order) {
        // Elements between internal nodes alone all get the same value, so that sums of them stay exact.
        let norm: f64 = stamp
            .row
            .coordinates
            .iter()
            .map(|&(i, a)| (a * if i < hosts { scale[i] } else { typical }).powi(2))
            .fold(0.0, f64::max);
        if norm > 0.0 {
            for &(i, a) in &stamp.row.coordinates {
                for &(j, b) in &stamp.row.coordinates {
                    matrix.add(i, j, a * b / norm);
                }
            }
        }
    }
    matrix
}

fn stack(blocks: &[&Dense<f64>]) -> Dense<f64> {
    let columns = blocks.first().map_or(0, |block| block.columns());
    let mut all = Dense::zeros(blocks.iter().map(|block| block.rows()).sum(), columns);
    let mut first = 0;
    for block in blocks {
        // Each block to the same size: stiffness and damping have different units.
        let largest = block.largest();
        all.place(
            first,
            0,
            &block.scale(if largest > 0.0 { 1.0 / largest } else { 1.0 }),
        );
        first += block.rows();
    }
    all
}

fn columns(matrix: &Dense<f64>, picked: &[usize]) -> Dense<f64> {
    Dense::from_fn(matrix.rows(), picked.len(), |i, j| matrix.get(i, picked[j]))
}

fn embed(block: &Dense<f64>, rows: &[usize], size: usize) -> Dense<f64> {
    let mut full = Dense::zeros(size, block.columns());
    for (i, &row) in rows.iter().enumerate() {
        for j in 0..block.columns() {
            full.set(row, j, block.get(i, j));
        }
    }
    full
}

fn snapped(matrix: &Dense<f64>) -> Dense<f64> {
    matrix.map(snap)
}

/// Null space after scaling rows and columns to comparable size.
fn scaled_null_space(matrix: &Dense<f64>) -> crate::dense::NullSpace {
    let largest = matrix.largest();
    let inverse_root = |size: f64| {
        if largest > 0.0 {
            1.0 / size.max(SCALE_FLOOR * largest).sqrt()
        } else {
            1.0
        }
    };
    let row: Vec<f64> = (0..matrix.rows())
        .map(|i| inverse_root(matrix.row(i).iter().fold(0.0, |m: f64, v| m.max(v.abs()))))
        .collect();
    let column: Vec<f64> = (0..matrix.columns())
        .map(|j| {
            inverse_root((0..matrix.rows()).fold(0.0, |m: f64, i| m.max(matrix.get(i, j).abs())))
        })
        .collect();
    let scaled = Dense::from_fn(matrix.rows(), matrix.columns(), |i, j| {
        matrix.get(i, j) * row[i] * column[j]
    });
    let mut space = null_space(&scaled, RANK);
    for c in 0..space.free.len() {
        let unit = column[space.free[c]];
        for (i, factor) in column.iter().enumerate() {
            let value = space.basis.get(i, c) * factor / unit;
            space.basis.set(i, c, snap(value));
        }
    }
    space
}

/// A basis of the column space with the identity on some rows; those rows.
fn column_space(matrix: &Dense<f64>) -> (Dense<f64>, Vec<usize>) {
    // The columns that carry the rank of the transpose are the rows wanted here.
    let space = null_space(&matrix.transpose(), RANK);
    let rows = space.pivots;
    let rank = rows.len();
    let picked = null_space(matrix, RANK).pivots;
    let basis = columns(matrix, &picked);
    let square = Dense::from_fn(rank, rank, |i, j| basis.get(rows[i], j));
    let normalised = square
        .lu()
        .map_or_else(|| basis.clone(), |lu| snapped(&basis.times(&lu.inverse())));
    (normalised, rows)
}

fn name_of(directions: &Dense<f64>, names: &dyn Fn(usize) -> String) -> String {
    let mut best = (0.0, 0);
    for i in 0..directions.rows() {
        for j in 0..directions.columns() {
            if directions.get(i, j).abs() > best.0 {
                best = (directions.get(i, j).abs(), i);
            }
        }
    }
    names(best.1)
}

fn floating(directions: &Dense<f64>, names: &dyn Fn(usize) -> String) -> ResponseError {
    ResponseError::Floating {
        coordinate: name_of(directions, names),
    }
}
