#include "common/analysis/leading_eigenpairs.h"

#include <cassert>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>

#include "common/base/random.h"

namespace cohort {
namespace {

constexpr int kIterations = 4;  // One is enough but for chance; three are usual.

/// P L U of a tridiagonal matrix minus `shift`, to solve with it.
class ShiftedTridiagonal {
 public:
  /// @param scale  magnitude of the matrix: what is too small beside it counts as rounding.
  ShiftedTridiagonal(const Eigen::VectorXd& diagonal,
                     const Eigen::VectorXd& beside,
                     double shift,
                     double scale)
      : lower_(beside),
        diagonal_(diagonal.array() - shift),
        upper_(beside),
        second_upper_(Eigen::VectorXd::Zero(diagonal.size())),
        swapped_(static_cast<size_t>(diagonal.size()), 0) {
    const Eigen::Index size = diagonal_.size();
    const double least = std::numeric_limits<double>::epsilon() * scale;
    for (Eigen::Index i = 0; i + 1 < size; ++i) {
      if (std::abs(lower_(i)) > std::abs(diagonal_(i))) {
        Swap(i);
      }
      KeepFromZero(diagonal_(i), least);
      lower_(i) /= diagonal_(i);
      diagonal_(i + 1) -= lower_(i) * upper_(i);
      if (i + 2 < size) {
        upper_(i + 1) -= lower_(i) * second_upper_(i);
      }
    }
    KeepFromZero(diagonal_(size - 1), least);
  }

  void SolveInPlace(Eigen::Ref<Eigen::VectorXd> x) const {
    const Eigen::Index size = diagonal_.size();
    for (Eigen::Index i = 0; i + 1 < size; ++i) {
      if (swapped_[static_cast<size_t>(i)] != 0) {
        std::swap(x(i), x(i + 1));
      }
      x(i + 1) -= lower_(i) * x(i);
    }
    for (Eigen::Index i = size - 1; i >= 0; --i) {
      double rest = x(i);
      if (i + 1 < size) {
        rest -= upper_(i) * x(i + 1);
      }
      if (i + 2 < size) {
        rest -= second_upper_(i) * x(i + 2);
      }
      x(i) = rest / diagonal_(i);
    }
  }

 private:
  /// Exchanges rows i and i + 1 of what is left.
  void Swap(Eigen::Index i) {
    swapped_[static_cast<size_t>(i)] = 1;
    std::swap(diagonal_(i), lower_(i));
    std::swap(upper_(i), diagonal_(i + 1));
    if (i + 2 < diagonal_.size()) {
      second_upper_(i) = upper_(i + 1);
      upper_(i + 1) = 0;
    }
  }

  /// The shift is an eigenvalue, so that some pivot is nearly zero: large solutions are wanted.
  static void KeepFromZero(double& pivot, double least) {
    if (std::abs(pivot) < least) {
      pivot = pivot < 0 ? -least : least;
    }
  }

  Eigen::VectorXd lower_;
  Eigen::VectorXd diagonal_;
  Eigen::VectorXd upper_;
  Eigen::VectorXd second_upper_;
  std::vector<char> swapped_;
};

/// Takes what `x` has of the first `count` columns out of it, and makes it of unit length.
void MakeOrthonormal(const Eigen::MatrixXd& columns,
                     Eigen::Index count,
                     Eigen::Ref<Eigen::VectorXd> x) {
  x /= x.cwiseAbs().maxCoeff();
  // Twice is enough (Kahan, Parlett).
  for (int round = 0; round < 2; ++round) {
    for (Eigen::Index column = 0; column < count; ++column) {
      x -= columns.col(column).dot(x) * columns.col(column);
    }
    x.normalize();
  }
}

}  // namespace

absl::StatusOr<LeadingEigenpairs> FindLeadingEigenpairs(const Eigen::MatrixXd& symmetric,
                                                        Eigen::Index count) {
  const Eigen::Index size = symmetric.rows();
  assert(size >= 1 && size == symmetric.cols() && count >= 0 && count <= size);
  const Eigen::Tridiagonalization<Eigen::MatrixXd> tridiagonal(symmetric);
  const Eigen::VectorXd diagonal = tridiagonal.diagonal();
  const Eigen::VectorXd beside = tridiagonal.subDiagonal();
  Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver;
  solver.computeFromTridiagonal(diagonal, beside, Eigen::EigenvaluesOnly);
  if (solver.info() != Eigen::Success) {
    return absl::InternalError("the eigenvalues were not found");
  }
  LeadingEigenpairs pairs;
  pairs.values = solver.eigenvalues().reverse();
  pairs.vectors.resize(size, count);
  const double scale = pairs.values.cwiseAbs().maxCoeff();
  Random random(1);
  for (Eigen::Index i = 0; i < count; ++i) {
    const ShiftedTridiagonal shifted(diagonal, beside, pairs.values(i), scale);
    Eigen::VectorXd x(size);
    for (double& entry : x) {
      entry = random.Uniform(0.5, 1.5) * (random.NextBits() % 2 == 0 ? 1 : -1);
    }
    for (int iteration = 0; iteration < kIterations; ++iteration) {
      if (scale > 0) {
        shifted.SolveInPlace(x);
      }
      MakeOrthonormal(pairs.vectors, i, x);
    }
    pairs.vectors.col(i) = x;
  }
  // One by one: for many, Eigen multiplies in blocks that depend on the processor's caches.
  for (Eigen::Index i = 0; i < count; ++i) {
    Eigen::VectorXd x = pairs.vectors.col(i);
    x.applyOnTheLeft(tridiagonal.matrixQ());
    pairs.vectors.col(i) = x;
  }
  return pairs;
}

}  // namespace cohort
