//! Closed-form problems of the literature: minimax, constrained and multimodal.
//!
//! Minimax problems: L. Luksan and J. Vlcek, "Test problems for nonsmooth unconstrained and linearly constrained
//! optimization", technical report 798, Institute of Computer Science, Prague (2000), with their optimum values.

use super::dual::Dual;
use super::linear;
use quell_search::{Pieces, Problem, Variable};

pub type Functions = fn(&[Dual], &mut Vec<Dual>);

/// The maximum of closed-form functions, with further ones as constraints `c <= 0`.
#[derive(Clone)]
pub struct Classical {
    pub name: &'static str,
    pub variables: Vec<Variable>,
    pub objectives: Functions,
    pub constraints: usize,
    pub constraint_functions: Functions,
    pub gradients: bool,
    pub optimum: f64,
}

impl Classical {
    fn duals(point: &[f64]) -> Vec<Dual> {
        point
            .iter()
            .enumerate()
            .map(|(index, &x)| Dual::variable(x, index))
            .collect()
    }

    pub fn without_gradients(mut self) -> Self {
        self.gradients = false;
        self
    }
}

impl Problem for Classical {
    type Scratch = Vec<Dual>;

    fn scratch(&self) -> Vec<Dual> {
        Vec::new()
    }

    fn variables(&self) -> &[Variable] {
        &self.variables
    }

    fn constraints(&self) -> usize {
        self.constraints
    }

    fn evaluate(&self, point: &[f64], constraints: &mut [f64], values: &mut Vec<Dual>) -> f64 {
        let x = Self::duals(point);
        values.clear();
        (self.constraint_functions)(&x, values);
        for (constraint, value) in constraints.iter_mut().zip(values.iter()) {
            *constraint = value.value;
        }
        values.clear();
        (self.objectives)(&x, values);
        values.iter().fold(f64::NEG_INFINITY, |a, b| {
            if b.value.is_nan() {
                f64::NAN
            } else {
                a.max(b.value)
            }
        })
    }

    fn pieces(&self, point: &[f64], _: f64, pieces: &mut Pieces, values: &mut Vec<Dual>) -> bool {
        let x = Self::duals(point);
        values.clear();
        (self.objectives)(&x, values);
        for value in values.iter() {
            pieces
                .push_objective(value.value)
                .copy_from_slice(&value.gradient[..point.len()]);
        }
        values.clear();
        (self.constraint_functions)(&x, values);
        for (index, value) in values.iter().enumerate() {
            pieces
                .push_constraint(index, value.value)
                .copy_from_slice(&value.gradient[..point.len()]);
        }
        self.gradients
    }
}

fn minimax(
    name: &'static str,
    bounds: &[(f64, f64)],
    objectives: Functions,
    optimum: f64,
) -> Classical {
    Classical {
        name,
        variables: linear(bounds),
        objectives,
        constraints: 0,
        constraint_functions: |_, _| {},
        gradients: true,
        optimum,
    }
}

pub fn charalambous_conn_2() -> Classical {
    minimax(
        "CB2",
        &[(-5.0, 5.0); 2],
        |x, f| {
            f.push(x[0].powi(2) + x[1].powi(4));
            f.push((2.0 - x[0]).powi(2) + (2.0 - x[1]).powi(2));
            f.push(2.0 * (x[1] - x[0]).exp());
        },
        1.952_224_5,
    )
}

pub fn charalambous_conn_3() -> Classical {
    minimax(
        "CB3",
        &[(-5.0, 5.0); 2],
        |x, f| {
            f.push(x[0].powi(4) + x[1].powi(2));
            f.push((2.0 - x[0]).powi(2) + (2.0 - x[1]).powi(2));
            f.push(2.0 * (x[1] - x[0]).exp());
        },
        2.0,
    )
}

pub fn ql() -> Classical {
    minimax(
        "QL",
        &[(-10.0, 10.0); 2],
        |x, f| {
            let base = x[0].powi(2) + x[1].powi(2);
            f.push(base);
            f.push(base + 10.0 * (-4.0 * x[0] - x[1] + 4.0));
            f.push(base + 10.0 * (-1.0 * x[0] - 2.0 * x[1] + 6.0));
        },
        7.2,
    )
}

fn rosen_suzuki_parts(x: &[Dual]) -> [Dual; 4] {
    let base = x[0].powi(2) + x[1].powi(2) + 2.0 * x[2].powi(2) + x[3].powi(2)
        - 5.0 * x[0]
        - 5.0 * x[1]
        - 21.0 * x[2]
        + 7.0 * x[3];
    [
        base,
        x[0].powi(2) + x[1].powi(2) + x[2].powi(2) + x[3].powi(2) + x[0] - x[1] + x[2] - x[3] - 8.0,
        x[0].powi(2) + 2.0 * x[1].powi(2) + x[2].powi(2) + 2.0 * x[3].powi(2) - x[0] - x[3] - 10.0,
        2.0 * x[0].powi(2) + x[1].powi(2) + x[2].powi(2) + 2.0 * x[0] - x[1] - x[3] - 5.0,
    ]
}

pub fn rosen_suzuki() -> Classical {
    minimax(
        "Rosen-Suzuki",
        &[(-10.0, 10.0); 4],
        |x, f| {
            let parts = rosen_suzuki_parts(x);
            f.push(parts[0]);
            f.extend(parts[1..].iter().map(|&part| parts[0] + 10.0 * part));
        },
        -44.0,
    )
}

/// The same programme with its constraints as constraints (W. Hock and K. Schittkowski 1981, problem 43).
pub fn rosen_suzuki_constrained() -> Classical {
    Classical {
        name: "HS43",
        objectives: |x, f| f.push(rosen_suzuki_parts(x)[0]),
        constraints: 3,
        constraint_functions: |x, c| {
            c.extend(rosen_suzuki_parts(x)[1..].iter().map(|&part| part * 0.1))
        },
        ..rosen_suzuki()
    }
}

fn wong_1_parts(x: &[Dual]) -> [Dual; 5] {
    let base = (x[0] - 10.0).powi(2)
        + 5.0 * (x[1] - 12.0).powi(2)
        + x[2].powi(4)
        + 3.0 * (x[3] - 11.0).powi(2)
        + 10.0 * x[4].powi(6)
        + 7.0 * x[5].powi(2)
        + x[6].powi(4)
        - 4.0 * x[5] * x[6]
        - 10.0 * x[5]
        - 8.0 * x[6];
    [
        base,
        2.0 * x[0].powi(2) + 3.0 * x[1].powi(4) + x[2] + 4.0 * x[3].powi(2) + 5.0 * x[4] - 127.0,
        7.0 * x[0] + 3.0 * x[1] + 10.0 * x[2].powi(2) + x[3] - x[4] - 282.0,
        23.0 * x[0] + x[1].powi(2) + 6.0 * x[5].powi(2) - 8.0 * x[6] - 196.0,
        4.0 * x[0].powi(2) + x[1].powi(2) - 3.0 * x[0] * x[1] + 2.0 * x[2].powi(2) + 5.0 * x[5]
            - 11.0 * x[6],
    ]
}

pub fn wong_1() -> Classical {
    minimax(
        "Wong 1",
        &[(-10.0, 10.0); 7],
        |x, f| {
            let parts = wong_1_parts(x);
            f.push(parts[0]);
            f.extend(parts[1..].iter().map(|&part| parts[0] + 10.0 * part));
        },
        680.630_057,
    )
}

/// The same programme with its constraints as constraints (W. Hock and K. Schittkowski 1981, problem 100).
pub fn wong_1_constrained() -> Classical {
    Classical {
        name: "HS100",
        objectives: |x, f| f.push(wong_1_parts(x)[0]),
        constraints: 4,
        constraint_functions: |x, c| c.extend(wong_1_parts(x)[1..].iter().map(|&part| part * 0.01)),
        ..wong_1()
    }
}

/// `10 n + sum (x^2 - 10 cos 2 pi x)` + 1, whose optimum 1 lies off the middle of the box.
pub fn rastrigin() -> Classical {
    minimax(
        "Rastrigin",
        &[(-4.12, 5.12); 2],
        |x, f| {
            let mut sum = Dual::from(10.0 * x.len() as f64 + 1.0);
            for &x in x {
                sum = sum + x.powi(2) - 10.0 * (2.0 * std::f64::consts::PI * x).cos();
            }
            f.push(sum);
        },
        1.0,
    )
}

/// Branin-Hoo, three global minima of 0.397887.
pub fn branin() -> Classical {
    use std::f64::consts::PI;
    minimax(
        "Branin",
        &[(-5.0, 10.0), (0.0, 15.0)],
        |x, f| {
            let inner = x[1] - 5.1 / (4.0 * PI * PI) * x[0].powi(2) + 5.0 / PI * x[0] - 6.0;
            f.push(inner.powi(2) + 10.0 * (1.0 - 1.0 / (8.0 * PI)) * x[0].cos() + 10.0);
        },
        0.397_887_357_73,
    )
}

/// Hartmann's function of six variables, optimum -3.32237 among several local ones.
pub fn hartmann_6() -> Classical {
    minimax(
        "Hartmann 6",
        &[(0.0, 1.0); 6],
        |x, f| {
            let a = [
                [10.0, 3.0, 17.0, 3.5, 1.7, 8.0],
                [0.05, 10.0, 17.0, 0.1, 8.0, 14.0],
                [3.0, 3.5, 1.7, 10.0, 17.0, 8.0],
                [17.0, 8.0, 0.05, 10.0, 0.1, 14.0],
            ];
            let p = [
                [0.1312, 0.1696, 0.5569, 0.0124, 0.8283, 0.5886],
                [0.2329, 0.4135, 0.8307, 0.3736, 0.1004, 0.9991],
                [0.2348, 0.1451, 0.3522, 0.2883, 0.3047, 0.6650],
                [0.4047, 0.8828, 0.8732, 0.5743, 0.1091, 0.0381],
            ];
            let alpha = [1.0, 1.2, 3.0, 3.2];
            let mut sum = Dual::from(0.0);
            for i in 0..4 {
                let mut inner = Dual::from(0.0);
                for j in 0..6 {
                    inner = inner - a[i][j] * (x[j] - p[i][j]).powi(2);
                }
                sum = sum - alpha[i] * inner.exp();
            }
            f.push(sum);
        },
        -3.322_368_011_4,
    )
}

pub fn minimax_problems() -> Vec<Classical> {
    vec![
        charalambous_conn_2(),
        charalambous_conn_3(),
        ql(),
        rosen_suzuki(),
        wong_1(),
    ]
}

pub fn constrained_problems() -> Vec<Classical> {
    vec![rosen_suzuki_constrained(), wong_1_constrained()]
}

pub fn global_problems() -> Vec<Classical> {
    vec![rastrigin(), branin(), hartmann_6()]
}
