//! Numbers to and from numpy arrays.

use numpy::{Element, PyArray1, PyArray2, PyArrayMethods, PyReadonlyArray2, PyUntypedArrayMethods};
use pyo3::exceptions::PyValueError;
use pyo3::prelude::*;

/// A matrix of doubles.
pub type Matrix<'py> = Bound<'py, PyArray2<f64>>;
/// A vector of doubles.
pub type Vector<'py> = Bound<'py, PyArray1<f64>>;

/// A matrix of numbers row by row.
pub fn matrix<T: Element>(
    py: Python<'_>,
    numbers: Vec<T>,
    columns: usize,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    let rows = numbers.len() / columns.max(1);
    PyArray1::from_vec(py, numbers).reshape([rows, columns])
}

/// A matrix of rows.
pub fn rows<T: Element, const N: usize>(
    py: Python<'_>,
    rows: impl IntoIterator<Item = [T; N]>,
) -> PyResult<Bound<'_, PyArray2<T>>> {
    matrix(py, rows.into_iter().flatten().collect(), N)
}

/// A vector of numbers.
pub fn vector<T: Element>(
    py: Python<'_>,
    numbers: impl IntoIterator<Item = T>,
) -> Bound<'_, PyArray1<T>> {
    PyArray1::from_vec(py, numbers.into_iter().collect())
}

/// The rows of a matrix that must have `N` columns.
pub fn rows_of<T: Element + Copy, const N: usize>(
    array: &PyReadonlyArray2<'_, T>,
    name: &str,
) -> PyResult<Vec<[T; N]>> {
    if array.shape()[1] != N {
        let shape = array.shape();
        let message = format!("{name} has the shape {shape:?}; it must have {N} columns");
        return Err(PyValueError::new_err(message));
    }
    Ok(array.as_slice()?.as_chunks::<N>().0.to_vec())
}
