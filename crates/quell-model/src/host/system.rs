//! Stamping of elements, prescribed motion and damping into the matrices of a host.

use faer::Mat;

use super::damping;
use crate::linear::CoordinateKind;

/// The motion of a point, or the relative motion of two: h·q + g·u.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Motion {
    /// h, length coordinates.
    pub coordinates: Vec<f64>,
    /// g, length inputs.
    pub inputs: Vec<f64>,
    /// Translation (m) or rotation (rad).
    pub kind: CoordinateKind,
}

impl Motion {
    /// No motion: the ground.
    pub(crate) fn none(coordinates: usize, inputs: usize, kind: CoordinateKind) -> Self {
        Self {
            coordinates: vec![0.0; coordinates],
            inputs: vec![0.0; inputs],
            kind,
        }
    }

    /// This motion relative to another.
    pub(crate) fn minus(&self, other: &Self) -> Self {
        let subtract =
            |left: &[f64], right: &[f64]| left.iter().zip(right).map(|(a, b)| a - b).collect();
        Self {
            coordinates: subtract(&self.coordinates, &other.coordinates),
            inputs: subtract(&self.inputs, &other.inputs),
            kind: self.kind,
        }
    }

    /// True where no coordinate takes part.
    pub(crate) fn is_free_of_coordinates(&self) -> bool {
        self.coordinates
            .iter()
            .all(|&coefficient| coefficient == 0.0)
    }

    /// True where no input takes part.
    pub(crate) fn is_free_of_inputs(&self) -> bool {
        self.inputs.iter().all(|&coefficient| coefficient == 0.0)
    }
}

/// Uniform or patterned motion of the base to which all coordinates are relative.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Base {
    /// ι: absolute motion of each coordinate for a unit of the input, length coordinates.
    pub influence: Vec<f64>,
    /// Index of the input.
    pub input: usize,
}

/// The matrices of a host while they are put together.
#[derive(Debug, Clone)]
pub(crate) struct System {
    /// Mass that feels absolute acceleration.
    pub mass: Mat<f64>,
    /// Inertance, which feels relative acceleration.
    pub inertance: Mat<f64>,
    pub damping: Mat<f64>,
    /// Stiffness without a loss factor of its own.
    pub stiffness: Mat<f64>,
    /// Stiffness of elements that state their own loss factor.
    pub lossy_stiffness: Mat<f64>,
    /// Imaginary part that those elements add.
    pub loss: Mat<f64>,
    pub forcing: [Mat<f64>; 3],
}

impl System {
    pub(crate) fn new(coordinates: usize, inputs: usize) -> Self {
        let square = || Mat::zeros(coordinates, coordinates);
        let wide = || Mat::zeros(coordinates, inputs);
        Self {
            mass: square(),
            inertance: square(),
            damping: square(),
            stiffness: square(),
            lossy_stiffness: square(),
            loss: square(),
            forcing: [wide(), wide(), wide()],
        }
    }

    /// A spring of stiffness k over a relative motion; with a loss factor η its force is k (1 + jη) x.
    pub(crate) fn spring(&mut self, motion: &Motion, stiffness: f64, loss: Option<f64>) {
        match loss {
            None => stamp(&mut self.stiffness, motion, stiffness),
            Some(loss) => {
                stamp(&mut self.lossy_stiffness, motion, stiffness);
                stamp(&mut self.loss, motion, loss * stiffness);
            }
        }
        stamp_input(&mut self.forcing[0], motion, stiffness);
    }

    /// A damper over a relative motion.
    pub(crate) fn damper(&mut self, motion: &Motion, damping: f64) {
        stamp(&mut self.damping, motion, damping);
        stamp_input(&mut self.forcing[1], motion, damping);
    }

    /// An inerter over a relative motion.
    pub(crate) fn inerter(&mut self, motion: &Motion, inertance: f64) {
        stamp(&mut self.inertance, motion, inertance);
        stamp_input(&mut self.forcing[2], motion, inertance);
    }

    /// A mass at a point.
    pub(crate) fn mass(&mut self, motion: &Motion, mass: f64) {
        stamp(&mut self.mass, motion, mass);
        stamp_input(&mut self.forcing[2], motion, mass);
    }

    /// Forces of the moving base on the masses, -M ι u''. Called once, after all masses are in.
    pub(crate) fn base_excitation(&mut self, base: &Base) {
        for row in 0..self.mass.nrows() {
            let force: f64 = base
                .influence
                .iter()
                .enumerate()
                .map(|(column, influence)| self.mass[(row, column)] * influence)
                .sum();
            self.forcing[2][(row, base.input)] -= force;
        }
    }

    /// True where some stiffness couples a coordinate to an input that is a motion.
    pub(crate) fn stiffness_touches(&self, motions: &[usize]) -> bool {
        motions
            .iter()
            .any(|&input| (0..self.mass.nrows()).any(|row| self.forcing[0][(row, input)] != 0.0))
    }

    pub(crate) fn total_mass(&self) -> Mat<f64> {
        &self.mass + &self.inertance
    }

    pub(crate) fn total_stiffness(&self) -> Mat<f64> {
        &self.stiffness + &self.lossy_stiffness
    }

    /// Adds damping by modal ratios, acting on the motion relative to the quasi-static one under prescribed `motions`.
    pub(crate) fn add_modal(
        &mut self,
        ratios: &damping::Ratios,
        motions: &[usize],
    ) -> Result<(), damping::DampingError> {
        let modes = damping::Modes::of(&self.total_mass(), &self.total_stiffness())?;
        let rates = modes.rates(ratios)?;
        self.damping += modes.damping_matrix(&rates);
        for &input in motions {
            let column: Vec<f64> = (0..self.mass.nrows())
                .map(|row| self.forcing[0][(row, input)])
                .collect();
            for (row, force) in modes
                .quasi_static_drag(&rates, &column)
                .into_iter()
                .enumerate()
            {
                self.forcing[1][(row, input)] += force;
            }
        }
        Ok(())
    }

    /// Adds C = α M + β K, acting on the motion relative to the quasi-static one under prescribed `motions`.
    pub(crate) fn add_rayleigh(
        &mut self,
        alpha: f64,
        beta: f64,
        motions: &[usize],
    ) -> Result<(), damping::DampingError> {
        let mass = self.total_mass();
        let stiffness = self.total_stiffness();
        let size = mass.nrows();
        if alpha != 0.0 && self.stiffness_touches(motions) {
            let forces = Mat::from_fn(size, motions.len(), |row, column| {
                self.forcing[0][(row, motions[column])]
            });
            let motion = damping::quasi_static(&stiffness, &forces)?;
            let drag = &mass * &motion;
            for (column, &input) in motions.iter().enumerate() {
                for row in 0..size {
                    self.forcing[1][(row, input)] += alpha * drag[(row, column)];
                }
            }
        }
        for &input in motions {
            for row in 0..size {
                let force = self.forcing[0][(row, input)];
                self.forcing[1][(row, input)] += beta * force;
            }
        }
        for column in 0..size {
            for row in 0..size {
                self.damping[(row, column)] +=
                    alpha * mass[(row, column)] + beta * stiffness[(row, column)];
            }
        }
        Ok(())
    }
}

fn stamp(matrix: &mut Mat<f64>, motion: &Motion, value: f64) {
    for (row, left) in motion.coordinates.iter().enumerate() {
        if *left == 0.0 {
            continue;
        }
        for (column, right) in motion.coordinates.iter().enumerate() {
            if *right != 0.0 {
                matrix[(row, column)] += value * left * right;
            }
        }
    }
}

fn stamp_input(forcing: &mut Mat<f64>, motion: &Motion, value: f64) {
    for (row, left) in motion.coordinates.iter().enumerate() {
        for (input, right) in motion.inputs.iter().enumerate() {
            if *left != 0.0 && *right != 0.0 {
                forcing[(row, input)] -= value * left * right;
            }
        }
    }
}
