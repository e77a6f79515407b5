#include "common/report/html/mesh_flags.h"

#include <cmath>
#include <limits>

#include "common/report/decimal.h"
#include "common/report/quantiles.h"

namespace cohort {
namespace {

constexpr double kSmallOverlap = 0.7;

// Mean of each row of the matrix without the diagonal and NaN; NaN if nothing is left.
std::vector<double> RowMeans(const Eigen::Ref<const RowMajorMatrix>& values) {
  std::vector<double> means;
  for (Eigen::Index row = 0; row < values.rows(); ++row) {
    double sum = 0;
    int64_t count = 0;
    for (Eigen::Index column = 0; column < values.cols(); ++column) {
      if (row == column || std::isnan(values(row, column))) continue;
      sum += values(row, column);
      ++count;
    }
    means.push_back(count > 0 ? sum / static_cast<double>(count)
                              : std::numeric_limits<double>::quiet_NaN());
  }
  return means;
}

void FlagDistances(const ReportInput& input, std::vector<MeshFlags>& flags) {
  const std::vector<double> means = RowMeans(input.matrix.values);
  const std::optional<double> fence = FarFence(means);
  size_t row = 0;
  for (size_t mesh = 0; mesh < input.meshes.size(); ++mesh) {
    if (!input.meshes[mesh].rejection.empty()) continue;
    const double mean = means[row++];
    if (std::isnan(mean) && means.size() > 1) {
      flags[mesh].distances.emplace_back("no value to any other mesh");
    } else if (fence && mean > *fence) {
      flags[mesh].distances.push_back("far from all others: mean " +
                                      WithUnit(ReadableDecimal(mean, 3), input.description));
    }
  }
}

void FlagAlignments(const ReportInput& input, std::vector<MeshFlags>& flags) {
  std::vector<double> residuals;
  int64_t not_converged = 0;
  for (const MeshAlignment& one : input.alignments) {
    residuals.push_back(one.alignment.rms_residual);
    not_converged += one.alignment.converged ? 0 : 1;
  }
  const std::optional<double> fence = FarFence(residuals);
  const bool convergence_is_the_rule = 2 * not_converged < std::ssize(input.alignments);
  for (const MeshAlignment& one : input.alignments) {
    std::vector<std::string>& found = flags[static_cast<size_t>(one.mesh)].registration;
    const Alignment& alignment = one.alignment;
    if (!alignment.converged && convergence_is_the_rule) {
      found.push_back("not converged after " + std::to_string(alignment.iterations) +
                      " iterations");
    }
    if (alignment.at_scale_limit) found.emplace_back("scale at its limit");
    if (alignment.overlap < kSmallOverlap) {
      found.push_back("overlap " + FixedDecimal(100 * alignment.overlap, 0) + " %");
    }
    if (fence && alignment.rms_residual > *fence) {
      found.push_back(
          "residual far above the others: " + ReadableDecimal(alignment.rms_residual, 3) + " mm");
    }
  }
}

}  // namespace

std::vector<const MeshAlignment*> AlignmentOfEach(const ReportInput& input) {
  std::vector<const MeshAlignment*> of_mesh(input.meshes.size(), nullptr);
  for (const MeshAlignment& one : input.alignments) of_mesh[static_cast<size_t>(one.mesh)] = &one;
  return of_mesh;
}

std::vector<MeshFlags> FindFlags(const ReportInput& input) {
  std::vector<MeshFlags> flags(input.meshes.size());
  for (size_t mesh = 0; mesh < flags.size(); ++mesh) {
    const std::optional<IngestedMesh>& ingested = input.meshes[mesh].ingested;
    if (ingested) flags[mesh].file = ingested->health.warnings;
  }
  if (input.job.spec.method != Method::kNone) FlagAlignments(input, flags);
  if (input.description.sign == DistanceSign::kAbsolute) FlagDistances(input, flags);
  return flags;
}

}  // namespace cohort
