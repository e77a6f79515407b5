#pragma once

#include <algorithm>
#include <array>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "common/geometry/comparison/fidentis_metrics.h"
#include "common/geometry/io/read_mesh.h"
#include "common/geometry/mesh/file_mesh.h"
#include "common/geometry/registration/fidentis_icp.h"
#include "common/geometry/registration/fidentis_mean_shape.h"
#include "common/jobs/fidentis_spec.h"
#include "common/jobs/job_state.h"
#include "common/store/blob_store.h"

namespace cohort::testing {

/// A job with the predecessor's arithmetic, computed by calling the library in one go: what the
/// same job gives through plan, tasks and blobs must be equal to the last bit.
class DirectFidentis {
 public:
  DirectFidentis(const JobSpec& spec, const std::vector<SetMesh>& meshes, BlobStore& store)
      : spec_(spec) {
    for (const SetMesh& mesh : meshes) {
      files_.push_back(*ReadFileMesh(*store.Get(mesh.raw), mesh.name));
      placed_.push_back(FidentisCentered(files_.back().vertices.cast<double>()));
      base_ = mesh.name == spec.base ? files_.size() - 1 : base_;
    }
    pairs_.resize(files_.size() * files_.size());
    options_.scale =
        spec.icp.scale_mode == ScaleMode::kOff ? FidentisScale::kOff : FidentisScale::kFromX;
    options_.max_iterations = spec.icp.max_iterations;
    options_.tolerance = static_cast<float>(spec.icp.tolerance);
    if (spec.method == Method::kEach) {
      RunToEach();
    } else {
      RunToOneReference();
    }
    Summarize();
  }

  /// Row = compared, column = main.
  [[nodiscard]] const FidentisMetricValues& Pair(size_t source, size_t target) const {
    return pairs_[source * files_.size() + target];
  }
  [[nodiscard]] const std::vector<Eigen::Matrix3Xf>& Placed() const { return placed_; }
  [[nodiscard]] const Eigen::Matrix3Xf& MeanShape() const { return mean_shape_; }
  [[nodiscard]] const Eigen::Matrix3Xf& Surface() const { return surface_; }
  [[nodiscard]] const std::vector<FidentisMetricValues>& Variation() const { return variation_; }
  [[nodiscard]] int64_t AlignLookups() const { return lookups_; }

 private:
  using Meshes = std::vector<Eigen::Matrix3Xf>;

  /// Moves all meshes from where they are.
  void AlignAll(const Eigen::Matrix3Xf& target, Meshes& meshes) {
    const auto index = NearestVertex::Build(target);
    for (Eigen::Matrix3Xf& mesh : meshes) {
      const auto alignment = AlignByFidentisIcp(mesh, *index, options_);
      ASSERT_TRUE(alignment.ok()) << alignment.status();
      lookups_ += alignment->lookups;
      mesh = alignment->moved;
    }
  }
  [[nodiscard]] static Eigen::Matrix3Xf Averaged(const Eigen::Matrix3Xf& reference,
                                                 const Meshes& meshes) {
    FidentisMeanShape mean(reference);
    for (const Eigen::Matrix3Xf& mesh : meshes) {
      mean.Add(FidentisDisplacement(reference, *NearestVertex::Build(mesh)));
    }
    return mean.Moved();
  }
  void Measure(size_t source, size_t target, const Meshes& at, const NearestVertex& index) {
    const Eigen::Matrix3Xf normals = files_[source].HasNormals()
                                         ? files_[source].normals
                                         : FidentisNormals(at[source], files_[source].faces);
    pairs_[source * files_.size() + target] =
        Metrics(FidentisSignedDistances(at[source], normals, index));
  }
  [[nodiscard]] FidentisMetricValues Metrics(const std::vector<float>& distances) const {
    return ComputeFidentisMetrics(
        spec_.compare.sign == DistanceSign::kSigned ? distances : FidentisAbsolute(distances));
  }

  void RunToOneReference() {
    Eigen::Matrix3Xf reference = placed_[base_];
    if (spec_.method == Method::kAverage) {
      for (int round = 0; round < spec_.rounds; ++round) {
        AlignAll(reference, placed_);
        reference = Averaged(reference, placed_);
      }
      mean_shape_ = reference;
    }
    AlignAll(reference, placed_);
    for (size_t target = 0; target < files_.size(); ++target) {
      const auto index = NearestVertex::Build(placed_[target]);
      for (size_t source = 0; source < files_.size(); ++source) {
        Measure(source, target, placed_, *index);
      }
    }
  }

  void RunToEach() {
    const Meshes loaded = placed_;
    for (size_t target = 0; target < files_.size(); ++target) {
      Meshes moved = loaded;
      AlignAll(loaded[target], moved);
      const auto index = NearestVertex::Build(loaded[target]);
      for (size_t source = 0; source < files_.size(); ++source) {
        Measure(source, target, moved, *index);
      }
      if (target == base_) {
        placed_ = moved;
      }
    }
  }

  void Summarize() {
    surface_ = Averaged(placed_[base_], placed_);
    if (spec_.method != Method::kAverage) {
      mean_shape_ = surface_;
    }
    const Eigen::Matrix3Xf normals = FidentisNormals(surface_, files_[base_].faces);
    std::vector<std::vector<float>> of_vertex(static_cast<size_t>(surface_.cols()));
    for (const Eigen::Matrix3Xf& mesh : placed_) {
      const auto distances =
          FidentisSignedDistances(surface_, normals, *NearestVertex::Build(mesh));
      for (size_t k = 0; k < distances.size(); ++k) {
        of_vertex[k].push_back(distances[k]);
      }
    }
    for (const std::vector<float>& distances : of_vertex) {
      variation_.push_back(Metrics(distances));
    }
  }

  JobSpec spec_;
  FidentisIcpOptions options_;
  std::vector<FileMesh> files_;
  size_t base_ = 0;
  Meshes placed_;
  std::vector<FidentisMetricValues> pairs_;
  Eigen::Matrix3Xf mean_shape_;
  Eigen::Matrix3Xf surface_;
  std::vector<FidentisMetricValues> variation_;
  int64_t lookups_ = 0;
};

}  // namespace cohort::testing
