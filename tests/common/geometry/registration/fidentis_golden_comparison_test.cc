// Comparison from the predecessor's own meshes and distances: no eigenvectors, hence every bit.
// See ../shared/golden/README.md.

#include <memory>
#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/geometry/comparison/fidentis_metrics.h"
#include "common/geometry/registration/fidentis_mean_shape.h"
#include "tests/common/geometry/registration/fidentis_golden.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;
using testing::GoldenFolder;
using testing::GoldenMatrices;
using testing::kGoldenCount;
using testing::kGoldenNames;
using testing::ReadGoldenMesh;
using testing::ReadTable;

std::vector<float> ReadDistances(const fs::path& folder, int main, int compared) {
  std::vector<float> distances;
  for (const std::vector<std::string>& line :
       ReadTable(folder / "distances" /
                 ("main" + std::to_string(main) + "_comp" + std::to_string(compared) + ".txt"))) {
    distances.push_back(testing::ParseFloat(line.at(0)));
  }
  return distances;
}

/// The three studies that keep their distances and aligned meshes.
class FidentisGoldenComparison : public ::testing::TestWithParam<std::string_view> {
 protected:
  void SetUp() override {
    if (GoldenFolder().empty()) {
      GTEST_SKIP() << "no ../shared/golden beside this checkout";
    }
    folder_ = GoldenFolder() / "2016" / GetParam();
    for (const std::string_view name : kGoldenNames) {
      const std::string file = std::string(name) + ".obj";
      const TriangleMesh mesh = ReadGoldenMesh(folder_ / ("aligned_" + file));
      vertices_.emplace_back(mesh.vertices.cast<float>());
      faces_.push_back(mesh.faces);
      normals_.push_back(GetParam() == "vn/average"
                             ? testing::ReadNormals(GoldenFolder() / "meshes_vn" / file)
                             : FidentisNormals(vertices_.back(), mesh.faces));
    }
  }

  fs::path folder_;
  std::vector<Eigen::Matrix3Xf> vertices_;
  std::vector<Matrix3Xi> faces_;
  std::vector<Eigen::Matrix3Xf> normals_;
};

TEST_P(FidentisGoldenComparison, SignedDistancesAreThePredecessorsToTheLastBit) {
  for (int main = 0; main < kGoldenCount; ++main) {
    const auto index = NearestVertex::Build(vertices_[static_cast<size_t>(main)]);
    for (int compared = 0; compared < kGoldenCount; ++compared) {
      const auto j = static_cast<size_t>(compared);
      EXPECT_EQ(FidentisSignedDistances(vertices_[j], normals_[j], *index),
                ReadDistances(folder_, main, compared))
          << main << " " << compared;
    }
  }
}

TEST_P(FidentisGoldenComparison, MetricsOfItsDistancesAreThePredecessorsToTheLastBit) {
  GoldenMatrices matrices;
  for (int main = 0; main < kGoldenCount; ++main) {
    for (int compared = 0; compared < kGoldenCount; ++compared) {
      matrices.Set(compared, main, ReadDistances(folder_, main, compared));
    }
  }
  matrices.ExpectNear(folder_, 0, 0);
}

INSTANTIATE_TEST_SUITE_P(Studies,
                         FidentisGoldenComparison,
                         ::testing::Values("scale/average", "scale/one", "vn/average"),
                         [](const auto& study) {
                           return std::string(study.param.substr(0, study.param.find('/'))) +
                                  std::string(study.param.substr(study.param.find('/') + 1));
                         });

}  // namespace
}  // namespace cohort
