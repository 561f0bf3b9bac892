//! Damping from modal ratios and from Rayleigh's two coefficients; checks of symmetry and definiteness.

use faer::Mat;
use faer::Side;
use faer::linalg::solvers::Solve;

/// Eigenvalues of the mass-normalised stiffness below this share of the largest are rigid-body modes: rounding leaves
/// about 1e-16 times the number of coordinates, and true modes with frequencies a million times apart are kept.
const RIGID_SHARE: f64 = 1e-12;

/// Relative residual above which quasi-static motion is not determined by the stiffness.
const RESIDUAL: f64 = 1e-8;

/// Largest relative difference between entries (i, j) and (j, i) of a matrix that counts as symmetric: files with eight
/// significant digits pass.
pub(crate) const SYMMETRY: f64 = 1e-7;

/// Smallest eigenvalue, of the mass matrix scaled to a unit diagonal, that counts as not negative: condensation and
/// rounding leave about 1e-10 in models of a thousand coordinates.
pub(crate) const SEMI_DEFINITE: f64 = 1e-9;

/// Why damping cannot be put together, in words.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{message}")]
pub(crate) struct DampingError {
    pub message: String,
    pub help: Option<String>,
}

fn fail<T>(message: impl Into<String>, help: Option<&str>) -> Result<T, DampingError> {
    Err(DampingError {
        message: message.into(),
        help: help.map(str::to_owned),
    })
}

/// Damping ratios as given.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Ratios {
    /// One for all vibrating modes.
    All(f64),
    /// One for each vibrating mode, lowest frequency first.
    Each(Vec<f64>),
}

/// Undamped modes: K φ = ω² M φ, φᵀ M φ = 1, lowest first.
pub(crate) struct Modes {
    /// ω of each mode, rad/s; zero for rigid-body modes.
    pub frequencies: Vec<f64>,
    /// The shapes, one a column.
    pub shapes: Mat<f64>,
    /// M times the shapes.
    pub momenta: Mat<f64>,
}

impl Modes {
    /// Modes of symmetric M (positive definite) and K (positive semi-definite).
    pub(crate) fn of(mass: &Mat<f64>, stiffness: &Mat<f64>) -> Result<Self, DampingError> {
        if asymmetry(stiffness).is_some() {
            return fail(
                "modal damping needs a symmetric stiffness matrix",
                Some("give the damping matrix itself, `matrices = { C = … }`"),
            );
        }
        // With M = L Lᵀ and φ = L⁻ᵀ y the problem is the symmetric L⁻¹ K L⁻ᵀ y = ω² y.
        let Ok(factor) = mass.llt(Side::Lower) else {
            return fail(
                "modal damping needs a coordinate's inertia everywhere, but the mass matrix is singular",
                Some("give every coordinate a mass, or give dampers or a damping matrix instead"),
            );
        };
        let lower = factor.L().to_owned();
        let size = mass.nrows();
        let half = lower_solve(&lower, stiffness);
        let normal = lower_solve(&lower, &half.transpose().to_owned());
        let symmetric = Mat::from_fn(size, size, |row, column| {
            f64::midpoint(normal[(row, column)], normal[(column, row)])
        });
        let Ok(eigen) = symmetric.self_adjoint_eigen(Side::Lower) else {
            return fail(
                "the modes of the mass and stiffness matrices cannot be computed",
                None,
            );
        };
        let squares: Vec<f64> = (0..size).map(|mode| eigen.S()[mode]).collect();
        let largest = squares
            .iter()
            .fold(0.0_f64, |largest, square| largest.max(square.abs()));
        let threshold = RIGID_SHARE * largest;
        if let Some(negative) = squares.iter().find(|&&square| square < -threshold) {
            return fail(
                format!(
                    "modal damping needs a stiffness matrix without negative eigenvalues, but ω² = {negative:.3e} rad²/s² is one"
                ),
                None,
            );
        }
        let momenta = &lower * eigen.U();
        let shapes = upper_solve(&lower, &eigen.U().to_owned());
        let frequencies = squares
            .iter()
            .map(|&square| {
                if square <= threshold {
                    0.0
                } else {
                    square.sqrt()
                }
            })
            .collect();
        Ok(Self {
            frequencies,
            shapes,
            momenta,
        })
    }

    /// 2 ζ ω of each mode, 1/s; rigid-body modes are undamped.
    pub(crate) fn rates(&self, ratios: &Ratios) -> Result<Vec<f64>, DampingError> {
        let vibrating = self
            .frequencies
            .iter()
            .filter(|&&omega| omega > 0.0)
            .count();
        if let Ratios::Each(each) = ratios
            && each.len() != vibrating
        {
            return fail(
                format!(
                    "`modal` gives {} ratios, but the host has {vibrating} vibrating mode{}",
                    each.len(),
                    if vibrating == 1 { "" } else { "s" }
                ),
                Some("give one ratio for each, lowest frequency first, or one number for all"),
            );
        }
        let mut given = match ratios {
            Ratios::All(_) => [].iter(),
            Ratios::Each(each) => each.iter(),
        };
        Ok(self
            .frequencies
            .iter()
            .map(|&omega| {
                if omega == 0.0 {
                    return 0.0;
                }
                let ratio = match ratios {
                    Ratios::All(ratio) => *ratio,
                    Ratios::Each(_) => given.next().copied().unwrap_or(0.0),
                };
                2.0 * ratio * omega
            })
            .collect())
    }

    /// C = Σ (M φ) 2 ζ ω (M φ)ᵀ.
    ///
    /// # References
    /// R. W. Clough, J. Penzien, Dynamics of Structures (1975), equation 13-12.
    pub(crate) fn damping_matrix(&self, rates: &[f64]) -> Mat<f64> {
        let size = self.momenta.nrows();
        let scaled = Mat::from_fn(size, size, |row, mode| {
            self.momenta[(row, mode)] * rates[mode]
        });
        &scaled * self.momenta.transpose()
    }

    /// C r where r is the quasi-static motion K r = force: Σ (M φ) (2 ζ/ω) (φ·force).
    pub(crate) fn quasi_static_drag(&self, rates: &[f64], force: &[f64]) -> Vec<f64> {
        let size = self.momenta.nrows();
        let mut drag = vec![0.0; size];
        for (mode, (&omega, &rate)) in self.frequencies.iter().zip(rates).enumerate() {
            if omega == 0.0 {
                continue;
            }
            let share: f64 = (0..size)
                .map(|row| self.shapes[(row, mode)] * force[row])
                .sum();
            for (row, drag) in drag.iter_mut().enumerate() {
                *drag += self.momenta[(row, mode)] * rate * share / (omega * omega);
            }
        }
        drag
    }
}

fn lower_solve(lower: &Mat<f64>, right: &Mat<f64>) -> Mat<f64> {
    let mut solution = right.clone();
    faer::linalg::triangular_solve::solve_lower_triangular_in_place(
        lower.as_ref(),
        solution.as_mut(),
        faer::Par::Seq,
    );
    solution
}

fn upper_solve(lower: &Mat<f64>, right: &Mat<f64>) -> Mat<f64> {
    let mut solution = right.clone();
    faer::linalg::triangular_solve::solve_upper_triangular_in_place(
        lower.transpose(),
        solution.as_mut(),
        faer::Par::Seq,
    );
    solution
}

/// R with K R = F, the motion that prescribed motions impose slowly.
pub(crate) fn quasi_static(
    stiffness: &Mat<f64>,
    forces: &Mat<f64>,
) -> Result<Mat<f64>, DampingError> {
    let motion = stiffness.full_piv_lu().solve(forces);
    let residual = (stiffness * &motion - forces).norm_max();
    if motion.is_all_finite() && residual <= RESIDUAL * forces.norm_max() {
        return Ok(motion);
    }
    fail(
        "damping in proportion to mass needs a host that its supports hold, but part of this one is free to move",
        Some("make the coordinates relative to the base, `base = { influence = […], input = … }`"),
    )
}

/// The place (row, column) where a matrix differs most from its transpose, if it does beyond [`SYMMETRY`].
pub(crate) fn asymmetry(matrix: &Mat<f64>) -> Option<(usize, usize)> {
    let limit = SYMMETRY * matrix.norm_max();
    let mut worst = None;
    let mut largest = limit;
    for column in 0..matrix.ncols() {
        for row in column + 1..matrix.nrows() {
            let difference = (matrix[(row, column)] - matrix[(column, row)]).abs();
            if difference > largest {
                largest = difference;
                worst = Some((row, column));
            }
        }
    }
    worst
}

/// What keeps a symmetric matrix from being positive semi-definite.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Indefinite {
    /// The diagonal entry of this coordinate is negative.
    Diagonal(usize),
    /// This coordinate has no inertia of its own but is coupled to another.
    Coupled(usize, usize),
    /// Some combination of coordinates has negative inertia.
    Combination,
}

/// Checks xᵀ M x ≥ 0 within [`SEMI_DEFINITE`], M scaled to a unit diagonal so that kg and kg m² weigh the same.
pub(crate) fn check_semi_definite(mass: &Mat<f64>) -> Result<(), Indefinite> {
    let size = mass.nrows();
    let scale: Vec<f64> = (0..size).map(|row| mass[(row, row)]).collect();
    for (row, &diagonal) in scale.iter().enumerate() {
        if diagonal < 0.0 {
            return Err(Indefinite::Diagonal(row));
        }
        if diagonal == 0.0
            && let Some(other) = (0..size).find(|&other| mass[(row, other)] != 0.0)
        {
            return Err(Indefinite::Coupled(row, other));
        }
    }
    let root: Vec<f64> = scale
        .iter()
        .map(|&diagonal| if diagonal > 0.0 { diagonal.sqrt() } else { 1.0 })
        .collect();
    let scaled = Mat::from_fn(size, size, |row, column| {
        mass[(row, column)] / (root[row] * root[column])
            + if row == column { SEMI_DEFINITE } else { 0.0 }
    });
    match scaled.llt(Side::Lower) {
        Ok(_) => Ok(()),
        Err(_) => Err(Indefinite::Combination),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn matrix(rows: &[&[f64]]) -> Mat<f64> {
        Mat::from_fn(rows.len(), rows[0].len(), |row, column| rows[row][column])
    }

    #[test]
    fn shapes_diagonalise_both_matrices() {
        let mass = matrix(&[&[2.0, 0.3, 0.0], &[0.3, 1.0, 0.0], &[0.0, 0.0, 4.0]]);
        let stiffness = matrix(&[&[5.0, -2.0, 0.0], &[-2.0, 4.0, -2.0], &[0.0, -2.0, 3.0]]);
        let modes = Modes::of(&mass, &stiffness).unwrap();
        let identity = modes.shapes.transpose() * &mass * &modes.shapes;
        let squares = modes.shapes.transpose() * &stiffness * &modes.shapes;
        for row in 0..3 {
            for column in 0..3 {
                let unit = f64::from(u8::from(row == column));
                // Rounding of a 3 x 3 eigenproblem with entries of order one.
                assert!((identity[(row, column)] - unit).abs() < 1e-13);
                let square = unit * modes.frequencies[row].powi(2);
                assert!((squares[(row, column)] - square).abs() < 1e-13);
            }
        }
        assert!(modes.frequencies.is_sorted());
    }

    #[test]
    fn modal_matrix_gives_the_ratios_and_leaves_rigid_modes_alone() {
        // A free chain of three masses: one rigid-body mode.
        let mass = matrix(&[&[2.0, 0.0, 0.0], &[0.0, 1.0, 0.0], &[0.0, 0.0, 3.0]]);
        let stiffness = matrix(&[
            &[10.0, -10.0, 0.0],
            &[-10.0, 30.0, -20.0],
            &[0.0, -20.0, 20.0],
        ]);
        let modes = Modes::of(&mass, &stiffness).unwrap();
        assert_eq!(modes.frequencies[0], 0.0);
        let ratios = Ratios::Each(vec![0.02, 0.05]);
        let rates = modes.rates(&ratios).unwrap();
        let damping = modes.damping_matrix(&rates);
        let modal = modes.shapes.transpose() * &damping * &modes.shapes;
        for (mode, ratio) in [(0, 0.0), (1, 0.02), (2, 0.05)] {
            assert!((modal[(mode, mode)] - 2.0 * ratio * modes.frequencies[mode]).abs() < 1e-13);
        }
        assert!(modal[(1, 2)].abs() < 1e-13);
        // No force on a rigid-body motion.
        for row in 0..3 {
            let force: f64 = (0..3).map(|column| damping[(row, column)]).sum();
            assert!(force.abs() < 1e-12);
        }
        assert!(
            modes
                .rates(&Ratios::Each(vec![0.02]))
                .unwrap_err()
                .message
                .contains("2 vibrating modes")
        );
    }

    #[test]
    fn definiteness() {
        assert_eq!(
            check_semi_definite(&matrix(&[&[1.0, 0.0], &[0.0, 0.0]])),
            Ok(())
        );
        assert_eq!(
            check_semi_definite(&matrix(&[&[1e6, 1.0], &[1.0, 1e-6]])),
            Ok(())
        );
        assert_eq!(
            check_semi_definite(&matrix(&[&[1.0, 0.0], &[0.0, -1.0]])),
            Err(Indefinite::Diagonal(1))
        );
        assert_eq!(
            check_semi_definite(&matrix(&[&[0.0, 1.0], &[1.0, 2.0]])),
            Err(Indefinite::Coupled(0, 1))
        );
        assert_eq!(
            check_semi_definite(&matrix(&[&[1.0, 1.1], &[1.1, 1.0]])),
            Err(Indefinite::Combination)
        );
    }
}
