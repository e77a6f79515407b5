#pragma once

#include <Eigen/Core>

#include <absl/status/statusor.h>

namespace cohort {

/// Eigenvalues of a symmetric matrix, and the eigenvectors of the largest ones.
struct LeadingEigenpairs {
  Eigen::VectorXd values;   ///< All N, descending.
  Eigen::MatrixXd vectors;  ///< N x count, column i of values(i); orthonormal, signs arbitrary.
};

/// Householder's tridiagonal form, its eigenvalues by QR, its leading eigenvectors by inverse
/// iteration, made orthogonal one after the other. Same bytes for the same matrix.
///
/// O(N^3), 4/3 N^3 of it in the tridiagonal form: for few vectors about five times faster at N =
/// 5,000 than Eigen's SelfAdjointEigenSolver, which turns all N of them along.
/// @param symmetric  N x N, N >= 1; its lower triangle is read.
/// @param count  0..N.
/// @return kInternal if the eigenvalues do not converge.
/// Source: Golub, Van Loan 2013, sec. 8.3, 8.4.4; LAPACK's dgttrf (pivots).
[[nodiscard]] absl::StatusOr<LeadingEigenpairs> FindLeadingEigenpairs(
    const Eigen::MatrixXd& symmetric, Eigen::Index count);

}  // namespace cohort
