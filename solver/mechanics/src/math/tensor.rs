//! 3×3 tensors and their fourth-order derivatives.

use nalgebra::allocator::Allocator;
use nalgebra::{Const, DefaultAllocator, DimDiff, DimSub, SMatrix};

/// A second-order tensor.
pub type Mat3 = nalgebra::Matrix3<f64>;

/// A fourth-order tensor ∂P/∂F; row and column index are 3·j + i for the
/// component (i, j), that is column-major `vec`.
pub type Mat9 = nalgebra::SMatrix<f64, 9, 9>;

/// Second derivatives by the components of four points.
pub type Mat12 = nalgebra::SMatrix<f64, 12, 12>;

/// Components of four points.
pub type Vec12 = nalgebra::SVector<f64, 12>;

/// cof A = det(A) A⁻ᵀ, defined for singular A too.
pub fn cofactor(a: &Mat3) -> Mat3 {
    let (c0, c1, c2) = (a.column(0), a.column(1), a.column(2));
    Mat3::from_columns(&[c1.cross(&c2), c2.cross(&c0), c0.cross(&c1)])
}

/// Column-major `vec` of a 3×3 tensor.
pub fn vec9(a: &Mat3) -> nalgebra::SVector<f64, 9> {
    nalgebra::SVector::<f64, 9>::from_column_slice(a.as_slice())
}

/// Largest eigenvalue of a symmetric tensor, in closed form; to about 1e-8 of its norm where
/// eigenvalues coincide, else to rounding.
///
/// With m = tr A / 3, B = A − m I and p² = B : B / 6 it is m + 2p cos(⅓ arccos(det(B/p) / 2)).
///
/// Source: O. K. Smith 1961, "Eigenvalues of a symmetric 3 × 3 matrix", doi:10.1145/355578.366316.
pub fn largest_eigenvalue(a: &Mat3) -> f64 {
    let m = a.trace() / 3.0;
    let b = a - m * Mat3::identity();
    let p = (b.norm_squared() / 6.0).sqrt();
    if p == 0.0 {
        return m;
    }
    let half_det = (0.5 * (b / p).determinant()).clamp(-1.0, 1.0);
    m + 2.0 * p * (half_det.acos() / 3.0).cos()
}

/// The nearest positive semidefinite matrix in the Frobenius norm: negative
/// eigenvalues are set to zero.
pub fn project_positive<const N: usize>(a: &SMatrix<f64, N, N>) -> SMatrix<f64, N, N>
where
    Const<N>: DimSub<Const<1>>,
    DefaultAllocator:
        Allocator<DimDiff<Const<N>, Const<1>>> + Allocator<Const<N>, DimDiff<Const<N>, Const<1>>>,
{
    // most are positive definite, which this tells without eigenvalues
    if a.cholesky().is_some() {
        return *a;
    }
    let eigen = a.symmetric_eigen();
    if eigen.eigenvalues.min() >= 0.0 {
        return *a;
    }
    let clamped = eigen.eigenvalues.map(|e| e.max(0.0));
    eigen.eigenvectors * SMatrix::from_diagonal(&clamped) * eigen.eigenvectors.transpose()
}

/// Couplings between principal shears, relative to the tangent, that are nothing but rounding.
const ISOTROPIC: f64 = 1e-10;

/// [`project_positive`] of the tangent ∂P/∂F of a body at F. Of an isotropic body it is faster:
/// with F = U Σ Vᵀ the tangent has, in the basis u_i v_jᵀ, a block for the three stretches
/// u_i v_iᵀ and one for each pair u_i v_jᵀ, u_j v_iᵀ.
///
/// Source: Smith, de Goes and Kim 2019, "Analytic eigensystems for isotropic distortion
/// energies", doi:10.1145/3241041.
pub fn project_isotropic(tangent: &Mat9, f: &Mat3) -> Mat9 {
    if tangent.cholesky().is_some() {
        return *tangent;
    }
    let svd = f.svd_unordered(true, true);
    let (Some(u), Some(v_t)) = (svd.u, svd.v_t) else { return project_positive(tangent) };
    // column 3 j + i is u_i v_jᵀ
    let basis: Mat9 = v_t.transpose().kronecker(&u);
    let mut rest = basis.transpose() * tangent * basis;
    let mut change = Mat9::zeros();
    take_block(&mut rest, &mut change, [0, 4, 8]);
    for pair in [[1, 3], [2, 6], [5, 7]] {
        take_block(&mut rest, &mut change, pair);
    }
    if rest.amax() > ISOTROPIC * tangent.amax() {
        return project_positive(tangent);
    }
    tangent + basis * change * basis.transpose()
}

/// Moves a block on some rows and columns out of a matrix, and adds what makes it positive
/// semidefinite to another.
fn take_block<const N: usize>(from: &mut Mat9, change: &mut Mat9, rows: [usize; N])
where
    Const<N>: DimSub<Const<1>>,
    DefaultAllocator:
        Allocator<DimDiff<Const<N>, Const<1>>> + Allocator<Const<N>, DimDiff<Const<N>, Const<1>>>,
{
    let block = SMatrix::<f64, N, N>::from_fn(|i, j| from[(rows[i], rows[j])]);
    let by = project_positive(&block) - block;
    for (i, &row) in rows.iter().enumerate() {
        for (j, &column) in rows.iter().enumerate() {
            from[(row, column)] = 0.0;
            change[(row, column)] = by[(i, j)];
        }
    }
}

/// [a]ₓ with [a]ₓ b = a × b.
pub fn cross_matrix(a: &nalgebra::Vector3<f64>) -> Mat3 {
    Mat3::new(0.0, -a.z, a.y, a.z, 0.0, -a.x, -a.y, a.x, 0.0)
}

/// The derivative of cof F along H, ∂²J/∂F² : H: column c of cof F is f_{c+1} × f_{c+2}.
pub fn cofactor_change(f: &Mat3, h: &Mat3) -> Mat3 {
    let column = |c: usize| {
        let (c1, c2) = ((c + 1) % 3, (c + 2) % 3);
        h.column(c1).cross(&f.column(c2)) + f.column(c1).cross(&h.column(c2))
    };
    Mat3::from_columns(&[column(0), column(1), column(2)])
}

/// Adds s ∂²J/∂F²: column c of cof F is f_{c+1} × f_{c+2}.
pub fn add_j_hessian(f: &Mat3, scale: f64, a: &mut Mat9) {
    for c in 0..3 {
        let (c1, c2) = ((c + 1) % 3, (c + 2) % 3);
        let (f1, f2) = (f.column(c1).into_owned(), f.column(c2).into_owned());
        let mut by_c1 = a.fixed_view_mut::<3, 3>(3 * c, 3 * c1);
        by_c1 -= scale * cross_matrix(&f2);
        let mut by_c2 = a.fixed_view_mut::<3, 3>(3 * c, 3 * c2);
        by_c2 += scale * cross_matrix(&f1);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_change_of_a_cofactor_is_that_of_a_quadratic_function() {
        let f = Mat3::new(1.0, 2.0, 0.5, -0.3, 1.5, 0.2, 0.1, 0.4, 2.0);
        let h = Mat3::new(0.3, -0.2, 0.5, 0.1, 0.4, -0.6, 0.7, 0.2, -0.3);
        let expected = cofactor(&(f + h)) - cofactor(&f) - cofactor(&h);
        assert!((cofactor_change(&f, &h) - expected).norm() < 1e-14);
        let mut hessian = Mat9::zeros();
        add_j_hessian(&f, 1.0, &mut hessian);
        assert!((hessian * vec9(&h) - vec9(&expected)).norm() < 1e-14);
    }

    #[test]
    fn largest_eigenvalues_are_those_of_an_iterative_method() {
        let general = Mat3::new(1.0, 2.0, 0.5, 2.0, -1.5, 0.2, 0.5, 0.2, 2.0);
        let twice = Mat3::from_diagonal_element(3.0) + Mat3::from_element(-1.0);
        let tiny = 1e-12 * general;
        for (a, accuracy) in [(general, 1e-14), (-general, 1e-14), (twice, 1e-7), (tiny, 1e-14)] {
            let expected = a.symmetric_eigenvalues().max();
            let error = (largest_eigenvalue(&a) - expected).abs() / a.norm();
            assert!(error < accuracy, "{a} {error}");
        }
        assert_eq!(largest_eigenvalue(&Mat3::from_diagonal_element(-2.0)), -2.0);
    }

    #[test]
    fn projection_keeps_positive_and_clamps_negative_eigenvalues() {
        let mut a = Mat9::from_diagonal_element(2.0);
        assert_eq!(project_positive(&a), a);
        a[(4, 4)] = -3.0;
        let p = project_positive(&a);
        assert!(p[(4, 4)].abs() < 1e-14 && (p[(0, 0)] - 2.0).abs() < 1e-14);
    }
}
