//! `matrices`: files or lists of rows.

use std::path::Path;

use faer::Mat;
use quell_document::{Fault, Value};
use quell_expression::{Dimension, Quantity};

use super::coordinates::Layout;
use super::damping;
use super::elements::ratio;
use super::keys;
use crate::matrix::read_matrix;

/// The matrices that were given, over all rows.
pub(super) struct Given {
    pub mass: Option<Mat<f64>>,
    pub damping: Option<Mat<f64>>,
    pub stiffness: Option<Mat<f64>>,
    /// A fault at the mass matrix, to be given its message.
    pub mass_place: Option<Fault>,
}

/// Reads M, C and K and checks their sizes, and the symmetry of M.
pub(super) fn read(
    value: &Value<'_>,
    layout: &Layout,
    parameters: &[(String, Quantity)],
    folder: &Path,
) -> Result<Given, Fault> {
    let table = value.as_table()?;
    table.check(&keys::MATRICES)?;
    let get = |key: &'static str, times: i16| {
        table
            .get(key)
            .map(|value| matrix(key, times, &value, layout, parameters, folder))
            .transpose()
    };
    let mut given = Given {
        mass: get("M", 2)?,
        damping: get("C", 1)?,
        stiffness: get("K", 0)?,
        mass_place: table.get("M").map(|value| value.fault("")),
    };
    if let (Some(mass), Some(place)) = (&mut given.mass, table.get("M")) {
        if let Some((row, column)) = damping::asymmetry(mass) {
            return Err(place
                .fault(format!(
                    "M is not symmetric: entry ({}, {}) is {}, but ({}, {}) is {}",
                    row + 1,
                    column + 1,
                    mass[(row, column)],
                    column + 1,
                    row + 1,
                    mass[(column, row)]
                ))
                .help(format!(
                    "differences up to {:e} of the largest entry pass",
                    damping::SYMMETRY
                )));
        }
        let symmetric = Mat::from_fn(mass.nrows(), mass.ncols(), |row, column| {
            f64::midpoint(mass[(row, column)], mass[(column, row)])
        });
        *mass = symmetric;
    }
    Ok(given)
}

fn matrix(
    key: &'static str,
    times: i16,
    value: &Value<'_>,
    layout: &Layout,
    parameters: &[(String, Quantity)],
    folder: &Path,
) -> Result<Mat<f64>, Fault> {
    let matrix = if value.is_text() {
        read_matrix(value.as_str()?, folder).map_err(|error| Fault {
            help: error.help.clone(),
            ..value.fault(error.to_string())
        })?
    } else {
        inline(times, value, layout, parameters)?
    };
    let size = layout.rows.len();
    let (rows, columns) = (matrix.nrows(), matrix.ncols());
    if (rows, columns) == (size, size) {
        return Ok(matrix);
    }
    let message = if rows == columns {
        format!("{key} is {rows} x {columns}, but there are {size} coordinates")
    } else {
        format!("{key} is not square: it is {rows} x {columns}, and there are {size} coordinates")
    };
    Err(value
        .fault(message)
        .help("`[coordinates]` names one coordinate for each row, supports included"))
}

fn inline(
    times: i16,
    value: &Value<'_>,
    layout: &Layout,
    parameters: &[(String, Quantity)],
) -> Result<Mat<f64>, Fault> {
    let rows = value.as_array()?;
    let columns = match rows.first() {
        Some(first) => first.as_array()?.len(),
        None => return Err(value.fault("the matrix is empty")),
    };
    let mut matrix = Mat::zeros(rows.len(), columns);
    for (i, row) in rows.iter().enumerate() {
        let entries = row.as_array()?;
        if entries.len() != columns {
            return Err(row.fault(format!(
                "expected {columns} entries, as in the first row; found {}",
                entries.len()
            )));
        }
        for (j, entry) in entries.iter().enumerate() {
            // Entries do work on both motions: N m over the two, times s for each derivative.
            let kind = |index: usize| {
                layout
                    .rows
                    .get(index)
                    .map_or(Dimension::LENGTH, |row| row.kind.dimension())
            };
            let time = Dimension::new(0, 0, times, 0);
            let dimension = Dimension::ENERGY / kind(i) / kind(j) * time;
            matrix[(i, j)] = ratio(parameters, entry, dimension)?;
        }
    }
    Ok(matrix)
}
