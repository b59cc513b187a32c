//! The eigenvalue of largest magnitude of a symmetric operator, by the method of Lanczos.
//!
//! In the orthonormal basis of A x, A² x, … the operator is tridiagonal, and the eigenvalue θ of that matrix with the
//! vector s is one of A up to |β s_k|, β being the norm of what the next vector adds. All vectors are kept and
//! orthogonalised twice.
//!
//! Source: Golub and Van Loan, "Matrix Computations", sections 10.1 and 10.3.

use nalgebra::DMatrix;

use super::linear::{dot, norm};

/// Vectors, at most.
const VECTORS: usize = 60;

/// The eigenvalue of largest magnitude of an operator and its vector of length 1, to a relative error of the eigenvalue.
/// None where the operator is not defined, or zero.
pub fn largest(
    start: Vec<f64>,
    tolerance: f64,
    mut apply: impl FnMut(&[f64]) -> Option<Vec<f64>>,
) -> Option<(f64, Vec<f64>)> {
    let mut basis = vec![unit(apply(&start)?)?];
    let (mut diagonal, mut beside) = (Vec::new(), Vec::new());
    loop {
        let last = basis.last()?;
        let mut next = apply(last)?;
        diagonal.push(dot(&next, last));
        for _ in 0..2 {
            basis.iter().for_each(|known| remove(&mut next, known));
        }
        let rest = norm(&next);
        let (value, weights) = largest_of(&diagonal, &beside)?;
        let error = rest * weights[weights.len() - 1].abs();
        if error <= tolerance * value.abs() || basis.len() == VECTORS {
            let mut vector = vec![0.0; start.len()];
            for (known, weight) in basis.iter().zip(&weights) {
                vector.iter_mut().zip(known).for_each(|(v, k)| *v += weight * k);
            }
            return Some((value, unit(vector)?));
        }
        beside.push(rest);
        basis.push(unit(next)?);
    }
}

/// A vector of length 1; none of what is zero or not finite.
fn unit(mut x: Vec<f64>) -> Option<Vec<f64>> {
    let length = norm(&x);
    x.iter_mut().for_each(|x| *x /= length);
    (length > 0.0 && length.is_finite()).then_some(x)
}

/// Takes away the part along a vector of length 1.
fn remove(from: &mut [f64], known: &[f64]) {
    let along = dot(from, known);
    from.iter_mut().zip(known).for_each(|(x, k)| *x -= along * k);
}

/// The eigenvalue of largest magnitude of a tridiagonal matrix, and its vector.
fn largest_of(diagonal: &[f64], beside: &[f64]) -> Option<(f64, Vec<f64>)> {
    let n = diagonal.len();
    let matrix = DMatrix::from_fn(n, n, |i, j| match i.abs_diff(j) {
        0 => diagonal[i],
        1 => beside[i.min(j)],
        _ => 0.0,
    });
    let eigen = matrix.symmetric_eigen();
    let values = eigen.eigenvalues.iter().enumerate();
    let (place, value) = values.max_by(|a, b| a.1.abs().total_cmp(&b.1.abs()))?;
    value.is_finite().then(|| (*value, eigen.eigenvectors.column(place).iter().copied().collect()))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A diagonal operator with eigenvalues 1, 2, …, 99 and −100.5, or of one value alone.
    #[test]
    fn the_largest_eigenvalue_is_found_with_its_sign() {
        let values: Vec<f64> = (1..100).map(f64::from).chain([-100.5]).collect();
        let times = |x: &[f64]| Some(x.iter().zip(&values).map(|(x, v)| x * v).collect());
        let (value, vector) = largest(vec![1.0; 100], 1e-10, times).expect("an eigenvalue");
        assert!((value / -100.5 - 1.0).abs() < 1e-12, "{value}");
        assert!((vector[99].abs() - 1.0).abs() < 1e-9, "{}", vector[99]);
        let same = |x: &[f64]| Some(x.iter().map(|x| 3.0 * x).collect());
        assert_eq!(largest(vec![1.0; 5], 1e-10, same).map(|(value, _)| value), Some(3.0));
        assert!(largest(vec![1.0; 5], 1e-10, |x| Some(vec![0.0; x.len()])).is_none());
    }
}
