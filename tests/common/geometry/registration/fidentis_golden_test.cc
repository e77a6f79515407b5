// The preset fidentis against the predecessor's own output; see ../shared/golden/README.md.

#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/geometry/comparison/fidentis_metrics.h"
#include "common/geometry/registration/fidentis_icp.h"
#include "common/geometry/registration/fidentis_mean_shape.h"
#include "tests/common/geometry/registration/fidentis_golden.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;
using testing::GoldenFolder;
using testing::GoldenMatrices;
using testing::IsOk;
using testing::kGoldenCount;
using testing::kGoldenMetricTolerance;
using testing::kGoldenNames;
using testing::kGoldenRmsTolerance;
using testing::ParseFloat;
using testing::ReadGoldenMesh;
using testing::ReadNormals;
using testing::ReadTable;

// A few roundings of coordinates of 100 mm, 4e-6 each, which grow over up to 40 steps; on the
// machine this was written on nearly all are equal.
constexpr float kMeshTolerance = 5e-5F;
constexpr float kStepTolerance = 5e-6F;

using Meshes = std::vector<Eigen::Matrix3Xf>;
using Indexes = std::vector<std::unique_ptr<const NearestVertex>>;

/// The steps of icp_log.csv, read in their order.
class IcpLog {
 public:
  explicit IcpLog(const fs::path& file) : table_(ReadTable(file)) {}

  /// Compares with the next lines: these steps, no more and no fewer.
  void ExpectNext(const std::string& round,
                  int main,
                  int compared,
                  const std::vector<FidentisStep>& steps) {
    for (size_t i = 0; i < steps.size(); ++i) {
      ASSERT_LT(line_, table_.size());
      const std::vector<std::string>& line = table_[line_++];
      const std::vector<std::string> expected = {round, std::to_string(main),
                                                 std::to_string(compared), std::to_string(i)};
      ASSERT_EQ(std::vector<std::string>(line.begin(), line.begin() + 4), expected);
      Compare(line, steps[i]);
    }
  }
  [[nodiscard]] bool AtEnd() const { return line_ == table_.size(); }
  [[nodiscard]] size_t StepCount() const { return table_.size() - 1; }

 private:
  void Compare(const std::vector<std::string>& line, const FidentisStep& step) {
    Eigen::Matrix<float, 9, 1> logged;
    for (Eigen::Index i = 0; i < 9; ++i) {
      logged(i) = ParseFloat(line.at(static_cast<size_t>(4 + i)));
    }
    if (logged(8) < 0) {
      logged.tail<4>() *= -1;  // the sign of a quaternion has no meaning
    }
    Eigen::Matrix<float, 9, 1> ours;
    ours << step.mean_distance, step.translation, step.scale, step.rotation;
    EXPECT_LE((ours - logged).cwiseAbs().maxCoeff(), kStepTolerance)
        << ::testing::PrintToString(line);
  }

  std::vector<std::vector<std::string>> table_;
  size_t line_ = 1;  ///< After the head.
};

void ExpectSameMesh(const fs::path& file, const Eigen::Matrix3Xf& ours) {
  const Eigen::Matrix3Xf golden = ReadGoldenMesh(file).vertices.cast<float>();
  ASSERT_EQ(golden.cols(), ours.cols()) << file;
  EXPECT_LE((golden - ours).cwiseAbs().maxCoeff(), kMeshTolerance) << file;
}

FidentisIcpOptions OptionsOf(int max_iterations) {
  FidentisIcpOptions options;
  options.scale = FidentisScale::kFromX;
  options.max_iterations = max_iterations;
  return options;
}

Indexes IndexesOf(const Meshes& meshes) {
  Indexes indexes;
  for (const Eigen::Matrix3Xf& mesh : meshes) {
    indexes.push_back(NearestVertex::Build(mesh));
  }
  return indexes;
}

/// Loads the eight faces as the predecessor does; skips where there are none.
class FidentisGolden : public ::testing::Test {
 protected:
  void SetUp() override {
    if (GoldenFolder().empty()) {
      GTEST_SKIP() << "no ../shared/golden beside this checkout";
    }
    for (const std::string_view name : kGoldenNames) {
      const TriangleMesh mesh = ReadGoldenMesh(GoldenFolder() / "meshes" / ObjOf(name));
      vertices_.push_back(FidentisCentered(mesh.vertices));
      faces_.push_back(mesh.faces);
    }
  }

  static std::string ObjOf(std::string_view name) { return std::string(name) + ".obj"; }

  /// Moves all meshes to `target`; the log has them under `round`.
  void AlignAll(const Eigen::Matrix3Xf& target,
                const std::string& round,
                int main,
                const FidentisIcpOptions& options,
                IcpLog& log) {
    const std::unique_ptr<const NearestVertex> index = NearestVertex::Build(target);
    for (int j = 0; j < kGoldenCount; ++j) {
      Eigen::Matrix3Xf& mesh = vertices_[static_cast<size_t>(j)];
      const absl::StatusOr<FidentisAlignment> alignment = AlignByFidentisIcp(mesh, *index, options);
      ASSERT_THAT(alignment, IsOk());
      ASSERT_NO_FATAL_FAILURE(log.ExpectNext(round, main, j, alignment->steps));
      mesh = alignment->moved;
    }
  }

  /// To Average of all meshes as they are, three rounds.
  void RunToAverage(const fs::path& folder) {
    IcpLog log(folder / "icp_log.csv");
    Eigen::Matrix3Xf reference = vertices_[0];
    for (int round = 0; round < 3; ++round) {
      ASSERT_NO_FATAL_FAILURE(AlignAll(reference, std::to_string(round), -1, OptionsOf(10), log));
      FidentisMeanShape mean(reference);
      for (const auto& index : IndexesOf(vertices_)) {
        mean.Add(FidentisDisplacement(reference, *index));
      }
      reference = mean.Moved();
      ExpectSameMesh(folder / ("mean_shape_" + std::to_string(round + 1) + ".obj"), reference);
    }
    ExpectSameMesh(folder / "mean_shape.obj", reference);
    ASSERT_NO_FATAL_FAILURE(AlignAll(reference, "last", -1, OptionsOf(10), log));
    EXPECT_TRUE(log.AtEnd());
    EXPECT_EQ(log.StepCount(), 99U);
    ExpectAligned(folder);
    mean_shape_ = reference;
  }

  void ExpectAligned(const fs::path& folder) const {
    for (size_t j = 0; j < vertices_.size(); ++j) {
      ExpectSameMesh(folder / ("aligned_" + ObjOf(kGoldenNames.at(j))), vertices_[j]);
    }
  }

  /// All pairs of the aligned meshes.
  [[nodiscard]] GoldenMatrices CompareAll(const Meshes& normals) const {
    GoldenMatrices matrices;
    const Indexes indexes = IndexesOf(vertices_);
    for (size_t main = 0; main < vertices_.size(); ++main) {
      for (size_t compared = 0; compared < vertices_.size(); ++compared) {
        matrices.Set(
            static_cast<Eigen::Index>(compared), static_cast<Eigen::Index>(main),
            FidentisSignedDistances(vertices_[compared], normals[compared], *indexes[main]));
      }
    }
    return matrices;
  }

  [[nodiscard]] Meshes NormalsOfAligned() const {
    Meshes normals;
    for (size_t j = 0; j < vertices_.size(); ++j) {
      normals.push_back(FidentisNormals(vertices_[j], faces_[j]));
    }
    return normals;
  }

  Meshes vertices_;
  std::vector<Matrix3Xi> faces_;
  Eigen::Matrix3Xf mean_shape_;
};

TEST_F(FidentisGolden, ToAverageIsThePredecessors) {
  const fs::path folder = GoldenFolder() / "2016/scale/average";
  ASSERT_NO_FATAL_FAILURE(RunToAverage(folder));
  CompareAll(NormalsOfAligned()).ExpectNear(folder, kGoldenRmsTolerance, kGoldenMetricTolerance);
}

TEST_F(FidentisGolden, ToAverageWithNormalsOfTheFilesIsThePredecessors) {
  const fs::path folder = GoldenFolder() / "2016/vn/average";
  Meshes normals;
  for (size_t j = 0; j < vertices_.size(); ++j) {
    normals.push_back(ReadNormals(GoldenFolder() / "meshes_vn" / ObjOf(kGoldenNames.at(j))));
    ASSERT_EQ(normals[j].cols(), vertices_[j].cols());
  }
  ASSERT_NO_FATAL_FAILURE(RunToAverage(folder));
  CompareAll(normals).ExpectNear(folder, kGoldenRmsTolerance, kGoldenMetricTolerance);
}

TEST_F(FidentisGolden, TheSurfaceOfItsVariationMapIsNotTheMeanShape) {
  ASSERT_NO_FATAL_FAILURE(RunToAverage(GoldenFolder() / "2016/scale/average"));
  FidentisMeanShape surface(vertices_[0]);
  for (const auto& index : IndexesOf(vertices_)) {
    surface.Add(FidentisDisplacement(vertices_[0], *index));
  }
  const double mean_distance =
      (surface.Moved() - mean_shape_).colwise().norm().cast<double>().mean();
  EXPECT_NEAR(mean_distance, 0.85, 0.005);  // the figure of the reference, part (f)
}

TEST_F(FidentisGolden, TheSimilarityOfTheReportIsCloseToTheMovedFloats) {
  const std::unique_ptr<const NearestVertex> index = NearestVertex::Build(vertices_[0]);
  for (size_t j = 0; j < vertices_.size(); ++j) {
    const absl::StatusOr<FidentisAlignment> alignment =
        AlignByFidentisIcp(vertices_[j], *index, OptionsOf(40));
    ASSERT_THAT(alignment, IsOk());
    const Eigen::Matrix3Xd applied = alignment->T_target_source.Apply(vertices_[j].cast<double>());
    const double difference =
        (applied - alignment->moved.cast<double>()).colwise().norm().maxCoeff();
    EXPECT_LE(difference, 1e-4) << kGoldenNames.at(j);  // mm, up to 11 steps of float32
  }
}

TEST_F(FidentisGolden, ToOneIsThePredecessors) {
  const fs::path folder = GoldenFolder() / "2016/scale/one";
  IcpLog log(folder / "icp_log.csv");
  const Eigen::Matrix3Xf first = vertices_[0];
  ASSERT_NO_FATAL_FAILURE(AlignAll(first, "one", 0, OptionsOf(40), log));
  EXPECT_TRUE(log.AtEnd());
  EXPECT_EQ(log.StepCount(), 51U);
  ExpectAligned(folder);
  CompareAll(NormalsOfAligned()).ExpectNear(folder, kGoldenRmsTolerance, kGoldenMetricTolerance);
}

TEST_F(FidentisGolden, ToEachIsThePredecessors) {
  const fs::path folder = GoldenFolder() / "2016/scale/each";
  IcpLog log(folder / "icp_log.csv");
  const Meshes loaded = vertices_;
  GoldenMatrices matrices;
  for (int main = 0; main < kGoldenCount; ++main) {
    vertices_ = loaded;
    const Eigen::Matrix3Xf& target = loaded[static_cast<size_t>(main)];
    ASSERT_NO_FATAL_FAILURE(AlignAll(target, "each", main, OptionsOf(40), log));
    const std::unique_ptr<const NearestVertex> index = NearestVertex::Build(target);
    const Meshes normals = NormalsOfAligned();
    for (size_t j = 0; j < loaded.size(); ++j) {
      matrices.Set(static_cast<Eigen::Index>(j), main,
                   FidentisSignedDistances(vertices_[j], normals[j], *index));
    }
  }
  EXPECT_TRUE(log.AtEnd());
  EXPECT_EQ(log.StepCount(), 335U);
  matrices.ExpectNear(folder, kGoldenRmsTolerance, kGoldenMetricTolerance);
}

}  // namespace
}  // namespace cohort
