#include "common/geometry/synthetic/demo_cohort.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <set>
#include <tuple>
#include <utility>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "common/base/sha256.h"
#include "common/base/thread_pool.h"
#include "common/geometry/synthetic/triangulate_patch.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using ::testing::StartsWith;
using testing::StatusIs;

DemoOptions Small() {
  DemoOptions options;
  options.people = 3;
  options.captures = 2;
  options.vertices = 700;
  return options;
}

/// All bytes of the cohort's meshes, one after another.
std::string Bytes(const std::vector<DemoScan>& scans) {
  std::string bytes;
  for (const DemoScan& scan : scans) {
    const auto append = [&](const void* data, size_t size) {
      bytes.append(static_cast<const char*>(data), size);
    };
    append(scan.mesh.vertices.data(),
           static_cast<size_t>(scan.mesh.vertices.size()) * sizeof(double));
    append(scan.mesh.faces.data(), static_cast<size_t>(scan.mesh.faces.size()) * sizeof(int32_t));
  }
  return bytes;
}

TEST(DemoOptions, DefaultsAreValid) {
  EXPECT_THAT(DemoOptions().Validate(), IsOk());
}

TEST(DemoOptions, RefusalNamesTheFieldTheValueAndTheRange) {
  DemoOptions options;
  options.people = 0;
  EXPECT_THAT(options.Validate(), StatusIs(absl::StatusCode::kInvalidArgument,
                                           "demo: people is 0, must be 1 to 100000"));
  options = {};
  options.captures = 27;
  EXPECT_THAT(options.Validate(), StatusIs(absl::StatusCode::kInvalidArgument,
                                           "demo: captures is 27, must be 1 to 26"));
  options = {};
  options.vertices = 99;
  EXPECT_THAT(options.Validate(), StatusIs(absl::StatusCode::kInvalidArgument,
                                           "demo: vertices is 99, must be 100 to 2000000"));
  options = {};
  options.noise = std::nan("");
  EXPECT_THAT(options.Validate(), StatusIs(absl::StatusCode::kInvalidArgument, "noise is nan"));
  options = {};
  options.pose.scale_sd = 0.5;
  EXPECT_THAT(options.Validate(),
              StatusIs(absl::StatusCode::kInvalidArgument, "scale_sd is 0.5, must be 0 to 0.2"));
}

TEST(MakeDemoScan, RefusesAScanThatIsNotInTheCohort) {
  EXPECT_THAT(MakeDemoScan(Small(), 3, 0), StatusIs(absl::StatusCode::kOutOfRange, "person 3"));
  EXPECT_THAT(MakeDemoScan(Small(), 0, 2), StatusIs(absl::StatusCode::kOutOfRange, "capture 2"));
  EXPECT_THAT(MakeDemoScan(Small(), -1, 0), StatusIs(absl::StatusCode::kOutOfRange, "person -1"));
}

TEST(MakeDemoCohort, IsTheSameTwiceAndWithThreeThreads) {
  SerialExecutor serial;
  ThreadPool threads(3);
  const auto once = MakeDemoCohort(Small(), serial);
  const auto twice = MakeDemoCohort(Small(), serial);
  const auto threaded = MakeDemoCohort(Small(), threads);
  ASSERT_THAT(once, IsOk());
  ASSERT_THAT(twice, IsOk());
  ASSERT_THAT(threaded, IsOk());
  EXPECT_EQ(Bytes(*once), Bytes(*twice));
  EXPECT_EQ(Bytes(*once), Bytes(*threaded));
}

TEST(MakeDemoCohort, HasTheBytesItAlwaysHad) {
  // Pinned: the demo must not change with the compiler, its options or the machine. Whoever changes
  // the faces on purpose replaces the number.
  SerialExecutor serial;
  const auto scans = MakeDemoCohort(Small(), serial);
  ASSERT_THAT(scans, IsOk());
  EXPECT_EQ(Sha256::Of(Bytes(*scans)).Hex(),
            "9826c1c4c7bd2c3993969ce8bb4b0ca7756524045e4b93f177c078f36bfb6ea1");
}

TEST(MakeDemoCohort, AnotherSeedGivesOtherPeople) {
  SerialExecutor serial;
  DemoOptions other = Small();
  other.seed = 2;
  EXPECT_NE(Bytes(*MakeDemoCohort(Small(), serial)), Bytes(*MakeDemoCohort(other, serial)));
}

TEST(MakeDemoScan, IsTheSameAsInTheWholeCohort) {
  SerialExecutor serial;
  const auto cohort = MakeDemoCohort(Small(), serial);
  const auto scan = MakeDemoScan(Small(), 1, 1);
  ASSERT_THAT(cohort, IsOk());
  ASSERT_THAT(scan, IsOk());
  EXPECT_EQ(scan->mesh.vertices, (*cohort)[3].mesh.vertices);
  EXPECT_EQ(scan->mesh.faces, (*cohort)[3].mesh.faces);
  EXPECT_EQ(scan->capture.file, (*cohort)[3].capture.file);
}

TEST(MakeDemoScan, GivesAPersonTheSameShapeInABiggerCohort) {
  DemoOptions bigger = Small();
  bigger.people = 200;
  bigger.captures = 5;
  bigger.vertices = 900;
  const auto one = DescribeDemoCapture(Small(), 2, 1);
  const auto other = DescribeDemoCapture(bigger, 2, 1);
  ASSERT_THAT(one, IsOk());
  ASSERT_THAT(other, IsOk());
  EXPECT_EQ(one->face.identity.nose_length, other->face.identity.nose_length);
  EXPECT_EQ(one->expression, other->expression);
  EXPECT_EQ(one->file, "person03_b.ply");
  EXPECT_EQ(other->file, "person003_b.ply");
}

TEST(MakeDemoScan, IsAnOrientedManifoldWithExactlyTheVerticesAskedFor) {
  DemoOptions options = Small();
  options.vertices = 3001;
  for (int capture = 0; capture < 2; ++capture) {
    const auto scan = MakeDemoScan(options, 0, capture);
    ASSERT_THAT(scan, IsOk());
    const TriangleMesh& mesh = scan->mesh;
    EXPECT_EQ(mesh.VertexCount(), 3001);
    EXPECT_TRUE(mesh.vertices.allFinite());
    std::set<std::pair<int, int>> directed;
    for (Eigen::Index f = 0; f < mesh.faces.cols(); ++f) {
      for (int k = 0; k < 3; ++k) {
        ASSERT_TRUE(directed.insert({mesh.faces(k, f), mesh.faces((k + 1) % 3, f)}).second);
      }
    }
    const auto inner = std::count_if(directed.begin(), directed.end(), [&](const auto& edge) {
      return directed.count({edge.second, edge.first}) == 1;
    });
    const auto edges = static_cast<int64_t>(directed.size()) - inner / 2;
    EXPECT_EQ(mesh.VertexCount() - edges + mesh.FaceCount(), 1);  // Euler: one disc, no hole
  }
}

TEST(MakeDemoScan, FacesLookOutwards) {
  DemoOptions options = Small();
  options.pose = {0, 0, 0};
  const auto scan = MakeDemoScan(options, 1, 0);
  ASSERT_THAT(scan, IsOk());
  // Seen from a point deep in the head, every part of a face but nostrils and lids looks away.
  const Eigen::Vector3d inside(0, -5, -60);
  int64_t away = 0;
  for (Eigen::Index f = 0; f < scan->mesh.faces.cols(); ++f) {
    const Eigen::Vector3d a = scan->mesh.vertices.col(scan->mesh.faces(0, f));
    const Eigen::Vector3d b = scan->mesh.vertices.col(scan->mesh.faces(1, f));
    const Eigen::Vector3d c = scan->mesh.vertices.col(scan->mesh.faces(2, f));
    away += (b - a).cross(c - a).dot(a - inside) > 0 ? 1 : 0;
  }
  EXPECT_GT(away, scan->mesh.FaceCount() * 98 / 100);
}

TEST(MakeDemoScan, HasNoFlatTriangles) {
  DemoOptions options;
  double smallest = 1;
  for (int person = 0; person < 2; ++person) {
    for (int capture = 0; capture < 2; ++capture) {
      const auto scan = MakeDemoScan(options, person, capture);
      ASSERT_THAT(scan, IsOk());
      for (Eigen::Index f = 0; f < scan->mesh.faces.cols(); ++f) {
        smallest = std::min(smallest,
                            SineOfSmallestAngle(scan->mesh.vertices.col(scan->mesh.faces(0, f)),
                                                scan->mesh.vertices.col(scan->mesh.faces(1, f)),
                                                scan->mesh.vertices.col(scan->mesh.faces(2, f))));
      }
    }
  }
  EXPECT_GT(smallest, std::sin(10.0 * 3.14159265358979 / 180.0));
}

TEST(MakeDemoScan, TwoCapturesOfAPersonShareNoVertex) {
  DemoOptions options = Small();
  options.pose = {0, 0, 0};  // both in the canonical frame
  const auto a = MakeDemoScan(options, 0, 0);
  const auto b = MakeDemoScan(options, 0, 1);
  ASSERT_THAT(a, IsOk());
  ASSERT_THAT(b, IsOk());
  std::set<std::tuple<double, double, double>> points;
  for (Eigen::Index i = 0; i < a->mesh.vertices.cols(); ++i) {
    points.emplace(a->mesh.vertices(0, i), a->mesh.vertices(1, i), a->mesh.vertices(2, i));
  }
  EXPECT_EQ(points.size(), 700u);
  for (Eigen::Index i = 0; i < b->mesh.vertices.cols(); ++i) {
    EXPECT_EQ(
        points.count({b->mesh.vertices(0, i), b->mesh.vertices(1, i), b->mesh.vertices(2, i)}), 0u);
  }
}

TEST(MakeDemoScan, PosedScanIsTheCanonicalOneMovedByItsTruth) {
  DemoOptions still = Small();
  still.pose = {0, 0, 0};
  const auto canonical = MakeDemoScan(still, 2, 1);
  const auto posed = MakeDemoScan(Small(), 2, 1);
  ASSERT_THAT(canonical, IsOk());
  ASSERT_THAT(posed, IsOk());
  const CapturePose& pose = posed->capture.pose;
  const Eigen::Quaterniond q(pose.quaternion(0), pose.quaternion(1), pose.quaternion(2),
                             pose.quaternion(3));
  EXPECT_NEAR(q.norm(), 1.0, 1e-12);
  EXPECT_NE(pose.quaternion(0), 1.0);
  const Similarity& T = pose.T_file_canonical;
  EXPECT_TRUE(T.rotation.isApprox(q.toRotationMatrix(), 1e-12));
  EXPECT_TRUE(posed->mesh.vertices.isApprox(T.Apply(canonical->mesh.vertices), 1e-12));
}

TEST(DrawPose, StaysWithinItsOptions) {
  for (uint64_t seed = 0; seed < 200; ++seed) {
    const CapturePose pose = DrawPose(seed, {30, 12, 0.02});
    const double degrees = 2 * std::acos(std::min(1.0, pose.quaternion(0))) * 180 / 3.14159265;
    EXPECT_LE(degrees, 30.001);
    EXPECT_LE(pose.T_file_canonical.translation.cwiseAbs().maxCoeff(), 12.0);
    EXPECT_NEAR(pose.T_file_canonical.scale, 1.0, 0.05);  // truncated at 2.5 deviations
    EXPECT_NEAR(pose.T_file_canonical.rotation.determinant(), 1.0, 1e-12);
  }
}

TEST(LabelsCsv, HasALineForEachScan) {
  DemoOptions options = Small();
  options.expression_strength = 0;
  const auto captures = DescribeDemoCohort(options);
  ASSERT_THAT(captures, IsOk());
  EXPECT_EQ(LabelsCsv(*captures),
            "file,person,capture,expression\n"
            "person01_a.ply,person01,a,neutral\nperson01_b.ply,person01,b,neutral\n"
            "person02_a.ply,person02,a,neutral\nperson02_b.ply,person02,b,neutral\n"
            "person03_a.ply,person03,a,neutral\nperson03_b.ply,person03,b,neutral\n");
}

TEST(TruthCsv, HoldsThePoseAsNumbersThatReadBack) {
  const auto captures = DescribeDemoCohort(Small());
  ASSERT_THAT(captures, IsOk());
  const std::string csv = TruthCsv(*captures);
  EXPECT_THAT(csv, StartsWith("file,person,capture,scale,qw,qx,qy,qz,tx,ty,tz\n"
                              "person01_a.ply,person01,a,"));
  const size_t start = csv.find(",a,") + 3;
  EXPECT_EQ(std::stod(csv.substr(start)), (*captures)[0].pose.T_file_canonical.scale);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 7);
  EXPECT_EQ(std::count(csv.begin(), csv.end(), ','), 7 * 10);
}

TEST(TruthRms, PeopleDifferMoreThanCaptures) {
  DemoOptions options;
  options.people = 6;
  const auto captures = DescribeDemoCohort(options);
  ASSERT_THAT(captures, IsOk());
  SerialExecutor serial;
  ThreadPool threads(3);
  const auto rms = TruthRms(*captures, serial);
  ASSERT_THAT(rms, IsOk());
  EXPECT_EQ(*rms, *TruthRms(*captures, threads));
  for (int i = 0; i < 12; ++i) {
    EXPECT_EQ((*rms)(i, i), 0.0);
    for (int j = 0; j < 12; ++j) {
      if (i / 2 != j / 2) {
        EXPECT_GT((*rms)(i, j), 1.5) << i << " " << j;
        EXPECT_GT((*rms)(i, j), (*rms)(i, i ^ 1)) << i << " " << j;
      }
    }
  }
}

TEST(TruthRms, WithoutExpressionsTwoCapturesAreOneShape) {
  DemoOptions options = Small();
  options.expression_strength = 0;
  const auto captures = DescribeDemoCohort(options);
  ASSERT_THAT(captures, IsOk());
  SerialExecutor serial;
  const auto rms = TruthRms(*captures, serial);
  ASSERT_THAT(rms, IsOk());
  EXPECT_NEAR((*rms)(2, 3), 0.0, 1e-9);
  const std::string csv = TruthRmsCsv(*captures, *rms);
  EXPECT_THAT(csv, StartsWith("file,person01_a.ply,person01_b.ply,"));
  EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 7);
}

TEST(TruthRms, RefusesMoreScansThanItsMatrixShouldHold) {
  const std::vector<DemoCapture> many(2001);
  SerialExecutor serial;
  EXPECT_THAT(TruthRms(many, serial), StatusIs(absl::StatusCode::kInvalidArgument, "2001 scans"));
}

}  // namespace
}  // namespace cohort
