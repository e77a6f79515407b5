// The preset fidentis through the whole job against the predecessor's own matrices
// (../shared/golden, see its README).
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <string>
#include <vector>

#include <gmock/gmock.h>

#include "common/store/memory_blob_store.h"
#include "tests/common/geometry/registration/fidentis_golden.h"
#include "tests/worker/tasks/fidentis_jobs.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;
using testing::DirectFidentis;
using testing::ExpectSame;
using testing::FinishedJob;
using testing::GoldenFolder;
using testing::IsOk;
using testing::kGoldenCount;
using testing::kGoldenMetrics;
using testing::MetricsOfPairs;
using testing::PairMetrics;

struct Study {
  std::string folder;  ///< Under 2016/.
  std::string meshes;
  Method method = Method::kAverage;
  int64_t steps = 0;  ///< Of all alignments together: lines of icp_log.csv; 0: it is not there.
};

void PrintTo(const Study& study, std::ostream* out) {
  *out << study.folder;
}

class FidentisGoldenJob : public ::testing::TestWithParam<Study> {
 protected:
  void SetUp() override {
    if (GoldenFolder().empty()) {
      GTEST_SKIP() << "no ../shared/golden beside this checkout";
    }
    for (const std::string_view name : testing::kGoldenNames) {
      const std::string file = std::string(name) + ".obj";
      const std::string bytes = testing::ReadWhole(GoldenFolder() / GetParam().meshes / file);
      SetMesh mesh;
      mesh.name = file;
      mesh.raw = *store_.Put(bytes);
      mesh.size_bytes = static_cast<int64_t>(bytes.size());
      meshes_.push_back(mesh);
    }
  }

  [[nodiscard]] JobSpec Spec(DistanceSign sign) const {
    JobSpec spec = *PresetSpec("fidentis", GetParam().method);
    spec.compare.sign = sign;
    return spec;
  }

  /// Holds one metric against its two CSV files; the symmetric one is what matrix.csv has.
  void ExpectGolden(const PairMetrics& pairs, size_t metric, const std::string& sign) const {
    const std::string name = std::string(kGoldenMetrics.at(metric)) + "_" + sign;
    const fs::path folder = GoldenFolder() / "2016" / GetParam().folder;
    const Eigen::MatrixXf directed = testing::ReadMatrix(folder / (name + ".csv"));
    const Eigen::MatrixXf symmetric = testing::ReadMatrix(folder / (name + "_symmetric.csv"));
    const double tolerance =
        double{metric == 0 ? testing::kGoldenRmsTolerance : testing::kGoldenMetricTolerance};
    double worst = 0;
    for (int row = 0; row < kGoldenCount; ++row) {
      for (int column = 0; column < kGoldenCount; ++column) {
        const double there = pairs.at({row, column})[metric];
        const double back = pairs.at({column, row})[metric];
        worst = std::max(worst, Difference(there, directed(row, column)));
        // Both are floats: their mean rounded once is the predecessor's, which adds floats.
        const auto mean = static_cast<float>((there + back) / 2);
        worst = std::max(worst, Difference(double{mean}, symmetric(row, column)));
      }
    }
    EXPECT_LE(worst, tolerance) << name;
    worst_ = std::max(worst_, worst);
  }

  /// NaN is equal to NaN and infinitely far from everything else.
  static double Difference(double ours, float golden) {
    if (std::isnan(ours) || std::isnan(golden)) {
      return std::isnan(ours) && std::isnan(golden) ? 0 : HUGE_VAL;
    }
    return std::abs(ours - double{golden});
  }

  MemoryBlobStore store_;
  std::vector<SetMesh> meshes_;
  mutable double worst_ = 0;
};

TEST_P(FidentisGoldenJob, HasThePredecessorsMatrices) {
  for (const DistanceSign sign : {DistanceSign::kAbsolute, DistanceSign::kSigned}) {
    const FinishedJob job = testing::RunJobWithWorkers(Spec(sign), meshes_, store_, 3, 11);
    ASSERT_THAT(job.status, IsOk());
    const PairMetrics pairs = MetricsOfPairs(job, store_);
    for (size_t metric = 0; metric < kGoldenMetrics.size(); ++metric) {
      ExpectGolden(pairs, metric, std::string(DistanceSignName(sign)));
    }
    if (GetParam().steps > 0) {
      const int64_t vertices = job.plan->Meshes()[0].ingested->vertices;
      EXPECT_EQ(job.plan->TotalCounters().align.lookups, GetParam().steps * vertices);
    }
    if (GetParam().method == Method::kAverage) {
      const TriangleMesh golden =
          testing::ReadGoldenMesh(GoldenFolder() / "2016" / GetParam().folder / "mean_shape.obj");
      const auto ours = DecodeMeshBlob(*store_.Get(job.plan->Outputs().mean_shape));
      ASSERT_EQ(ours->VertexCount(), golden.VertexCount());
      // A few roundings of coordinates of 100 mm, as in fidentis_golden_test.
      EXPECT_LE((ours->vertices - golden.vertices).cwiseAbs().maxCoeff(), 5e-5);
    }
  }
  std::printf("%s: worst difference of all matrices %.3g\n", GetParam().folder.c_str(), worst_);
}

TEST_P(FidentisGoldenJob, EqualsTheLibraryToTheLastBit) {
  const JobSpec spec = Spec(DistanceSign::kAbsolute);
  ExpectSame(testing::RunJob(spec, meshes_, store_), store_, DirectFidentis(spec, meshes_, store_));
}

INSTANTIATE_TEST_SUITE_P(Studies,
                         FidentisGoldenJob,
                         ::testing::Values(Study{"scale/average", "meshes", Method::kAverage, 99},
                                           Study{"scale/one", "meshes", Method::kOne, 51},
                                           Study{"scale/each", "meshes", Method::kEach, 335},
                                           Study{"vn/average", "meshes_vn", Method::kAverage, 99}),
                         [](const auto& study) {
                           std::string name = study.param.folder;
                           name.erase(std::remove(name.begin(), name.end(), '/'), name.end());
                           return name;
                         });

}  // namespace
}  // namespace cohort
