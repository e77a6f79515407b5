// The distances that are found once more, those that were kept, and those that a job measured.
#include <cmath>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "common/geometry/comparison/distance_codec.h"
#include "common/geometry/mesh/boundary.h"
#include "common/geometry/mesh/vertex_areas.h"
#include "common/geometry/mesh/vertex_normals.h"
#include "common/geometry/synthetic/demo_cohort.h"
#include "common/pairs/distance_finder.h"
#include "common/pairs/kept_distances.h"
#include "common/pairs/pair_meter.h"
#include "common/pairs/vertex_weights.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

using testing::IsOk;
using testing::StatusIs;

constexpr int64_t kVertices = 400;

TriangleMesh Face(int person) {
  DemoOptions options;
  options.vertices = kVertices;
  return MakeDemoScan(options, person, 0).value().mesh;
}

Similarity SomePose() {
  Similarity T;
  T.scale = 1.02;
  T.rotation = Eigen::AngleAxisd(0.1, Eigen::Vector3d(1, 2, 3).normalized()).toRotationMatrix();
  T.translation = {1, -2, 0.5};
  return T;
}

struct Pair {
  TriangleMesh a = Face(0);
  TriangleMesh b = Face(1);
  Similarity T = SomePose();
  Eigen::Vector3d center = b.vertices.rowwise().mean();

  [[nodiscard]] PairMesh MadeA(const PairMeshOptions& options) const {
    return MakePairMesh(a, T, center, options).value();
  }
  [[nodiscard]] PairMesh MadeB(const PairMeshOptions& options) const {
    return MakePairMesh(b, Similarity{}, center, options).value();
  }
};

/// What a job keeps of the pair.
MeasuredPair Measured(const Pair& pair, CompareOptions compare, Retention retention) {
  compare.retention = retention;
  const PairMesh a = pair.MadeA({.compare = compare});
  const PairMesh b = pair.MadeB({.compare = compare});
  return PairMeter(compare)
      .Measure(a.vertices,
               {.vertices = b.vertices, .unplaced = b.unplaced.get(), .surface = b.surface.get()})
      .value();
}

class Distances : public ::testing::TestWithParam<CompareOptions> {};

TEST_P(Distances, FoundOnceMoreAreThoseOfTheJob) {
  const Pair pair;
  const MeasuredPair measured = Measured(pair, GetParam(), Retention::kVectors);
  DistanceFinder finder(GetParam(), DistanceSign::kAbsolute);
  const PairMesh a = pair.MadeA({.compare = GetParam()});
  const PairMesh b = pair.MadeB({.compare = GetParam()});
  const PairDistances& found = finder.Find(a, b);
  EXPECT_EQ(found.distances, DecodeVectors(measured.field.bytes, measured.field.values).value());
  EXPECT_EQ(found.slots.size(), found.distances.size());
}

TEST_P(Distances, KeptOnesGiveEveryMetricBitByBit) {
  const Pair pair;
  for (const Retention retention : {Retention::kVectors, Retention::kCompact, Retention::kSketch}) {
    const MeasuredPair measured = Measured(pair, GetParam(), retention);
    for (const Metric metric : kAllMetrics) {
      MeasureSpec spec;
      spec.metric = metric;
      const auto value = MeasureKept(measured.field, retention, {}, spec);
      ASSERT_THAT(value, IsOk());
      const double first = measured.metrics[static_cast<size_t>(metric)];
      if (value->bound == 0) {
        EXPECT_EQ(value->value, first) << MetricName(metric);
      } else {
        EXPECT_EQ(retention, Retention::kSketch);
        EXPECT_LE(std::abs(value->value - first), value->bound) << MetricName(metric);
      }
    }
  }
}

TEST_P(Distances, OfSketchesAreWithinTheirBoundForEveryMeasure) {
  const Pair pair;
  const MeasuredPair vectors = Measured(pair, GetParam(), Retention::kVectors);
  const MeasuredPair sketch = Measured(pair, GetParam(), Retention::kSketch);
  for (const char* name : {"rms", "mean", "min", "max", "variance", "p10", "p50", "p95", "p99"}) {
    for (const auto& [lower, upper] : {std::pair{0.0, 1.0}, {0.0, 0.9}, {0.1, 0.8}}) {
      MeasureSpec spec = ParseMeasure(name).value();
      spec.lower_share = lower;
      spec.upper_share = upper;
      const auto exact = MeasureKept(vectors.field, Retention::kVectors, {}, spec);
      const auto rough = MeasureKept(sketch.field, Retention::kSketch, {}, spec);
      ASSERT_THAT(exact, IsOk());
      ASSERT_THAT(rough, IsOk());
      EXPECT_EQ(exact->bound, 0);
      EXPECT_LE(std::abs(rough->value - exact->value), rough->bound + 1e-12)
          << name << " " << lower << " " << upper;
      EXPECT_LT(rough->bound, 1) << "useless";
    }
  }
}

CompareOptions With(Correspondence correspondence, BoundaryPairs boundary) {
  CompareOptions options;
  options.correspondence = correspondence;
  options.boundary_pairs = boundary;
  return options;
}

INSTANTIATE_TEST_SUITE_P(All,
                         Distances,
                         ::testing::Values(With(Correspondence::kVertex, BoundaryPairs::kKeep),
                                           With(Correspondence::kVertex, BoundaryPairs::kReject),
                                           With(Correspondence::kSurface, BoundaryPairs::kKeep)));

TEST(DistanceFinder, SignsAgreeWithBruteForce) {
  const Pair pair;
  const PairMeshOptions options = {.compare = {}, .sign = DistanceSign::kSigned};
  const PairMesh a = pair.MadeA(options);
  const PairMesh b = pair.MadeB(options);
  DistanceFinder finder({}, DistanceSign::kSigned);
  const PairDistances& found = finder.Find(a, b);
  const Eigen::Matrix3Xd placed = pair.T.Apply(pair.a.vertices);
  const Eigen::Matrix3Xd normals = pair.T.rotation * VertexNormals(pair.a);
  int64_t negative = 0;
  for (size_t i = 0; i < found.slots.size(); ++i) {
    const int32_t vertex = a.vertices.VertexOfSlot()[static_cast<size_t>(found.slots[i])];
    Eigen::Index nearest = 0;
    const double squared =
        (pair.b.vertices.colwise() - placed.col(vertex)).colwise().squaredNorm().minCoeff(&nearest);
    const double side =
        (placed.col(vertex) - pair.b.vertices.col(nearest)).dot(normals.col(vertex));
    EXPECT_NEAR(found.distances[i], std::copysign(std::sqrt(squared), side), 1e-4);
    negative += found.distances[i] < 0 ? 1 : 0;
  }
  EXPECT_GT(negative, 10);
  EXPECT_LT(negative, kVertices - 10);
}

TEST(DistanceFinder, SaysWhichVerticesCount) {
  const Pair pair;
  const CompareOptions reject = With(Correspondence::kVertex, BoundaryPairs::kReject);
  const PairMesh a = pair.MadeA({.compare = reject});
  const PairMesh b = pair.MadeB({.compare = reject});
  DistanceFinder all({}, DistanceSign::kAbsolute);
  DistanceFinder some(reject, DistanceSign::kAbsolute);
  const PairDistances every = all.Find(a, b);
  const PairDistances& kept = some.Find(a, b);
  EXPECT_LT(kept.slots.size(), every.slots.size());
  for (size_t i = 0; i < kept.slots.size(); ++i) {
    EXPECT_EQ(kept.distances[i], every.distances[static_cast<size_t>(kept.slots[i])]);
  }
}

TEST(MakePairMesh, RefusesPointCloudsWhereFacesAreNeeded) {
  TriangleMesh cloud = Face(0);
  cloud.faces.resize(3, 0);
  EXPECT_THAT(MakePairMesh(cloud, {}, {0, 0, 0}, {}).status(), IsOk());
  EXPECT_THAT(
      MakePairMesh(cloud, {}, {0, 0, 0}, {.compare = {}, .sign = DistanceSign::kSigned}).status(),
      StatusIs(absl::StatusCode::kFailedPrecondition, "point cloud"));
}

TEST(MeasureKept, SaysWhyItCannotAnswer) {
  const std::vector<double> weights(10, 1.0);
  EXPECT_THAT(MeasureKept({.values = 10, .bytes = ""}, Retention::kMetrics, {}, {}).status(),
              StatusIs(absl::StatusCode::kFailedPrecondition, "nothing"));
  EXPECT_THAT(MeasureKept({.values = 10, .bytes = ""}, Retention::kSketch, weights, {}).status(),
              StatusIs(absl::StatusCode::kFailedPrecondition, "sketches"));
  EXPECT_THAT(MeasureKept({.values = 10, .bytes = "x"}, Retention::kVectors, {}, {}).status(),
              StatusIs(absl::StatusCode::kDataLoss, ""));
}

TEST(MeasurePair, OfNothingIsNoNumber) {
  EXPECT_TRUE(std::isnan(MeasurePair({}, {}, {})->value));
  const std::vector<float> distances = {1, 2, 3};
  const std::vector<double> zero(3, 0.0);
  EXPECT_TRUE(std::isnan(MeasurePair(distances, zero, {})->value));
}

TEST(SlotWeights, ByAreaAddUpToTheArea) {
  const Pair pair;
  const PairMesh a = pair.MadeA({});
  const std::vector<double> weights = SlotWeights(pair.a, a.vertices, /*by_area=*/true, nullptr);
  double sum = 0;
  for (size_t slot = 0; slot < weights.size(); ++slot) {
    sum += weights[slot];
    EXPECT_EQ(weights[slot], VertexAreas(pair.a)(a.vertices.VertexOfSlot()[slot]));
  }
  EXPECT_NEAR(sum, VertexAreas(pair.a).sum(), 1e-6);
}

TEST(SlotWeights, OfARegionAreThoseOfTheNearestReferenceVertex) {
  const Pair pair;
  const PairMesh a = pair.MadeA({});
  RegionMask region{.reference = PackedMesh(PlaceVertices(pair.b, {}, pair.center)), .weights = {}};
  for (Eigen::Index i = 0; i < pair.b.vertices.cols(); ++i) {
    region.weights.push_back(pair.b.vertices(0, i) > pair.center.x() ? 1 : 0);
  }
  const std::vector<double> weights = SlotWeights(pair.a, a.vertices, /*by_area=*/false, &region);
  const Eigen::Matrix3Xd placed = pair.T.Apply(pair.a.vertices);
  for (size_t slot = 0; slot < weights.size(); ++slot) {
    Eigen::Index nearest = 0;
    (pair.b.vertices.colwise() - placed.col(a.vertices.VertexOfSlot()[slot]))
        .colwise()
        .squaredNorm()
        .minCoeff(&nearest);
    EXPECT_EQ(weights[slot], region.weights[static_cast<size_t>(nearest)]);
  }
}

TEST(ParseRegionWeights, NamesFileAndLine) {
  EXPECT_THAT(*ParseRegionWeights("# mask\n1\n0.5\n\n0\n", "mask.txt", 3),
              ::testing::ElementsAre(1, 0.5, 0));
  EXPECT_THAT(ParseRegionWeights("1\n-2\n", "mask.txt", 2).status(),
              StatusIs(absl::StatusCode::kInvalidArgument, "mask.txt:2"));
  EXPECT_THAT(ParseRegionWeights("1\nx\n", "mask.txt", 2).status(),
              StatusIs(absl::StatusCode::kInvalidArgument, "mask.txt:2"));
  EXPECT_THAT(ParseRegionWeights("1\n1\n", "mask.txt", 3).status(),
              StatusIs(absl::StatusCode::kInvalidArgument, "2 weights for the 3"));
  EXPECT_THAT(ParseRegionWeights("0\n0\n", "mask.txt", 2).status(),
              StatusIs(absl::StatusCode::kInvalidArgument, "all weights are 0"));
}

}  // namespace
}  // namespace cohort
