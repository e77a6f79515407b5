#include "common/geometry/mesh/edge_graph.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/geometry/mesh/shapes.h"

namespace cohort {
namespace {

using ::testing::ElementsAre;
using ::testing::IsEmpty;
using testing::MakeMesh;

TEST(EdgeGraph, ListsEachNeighbourOnceAscending) {
  const TriangleMesh square =
      MakeMesh({{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {5, 5, 5}}, {{2, 0, 1}, {3, 0, 2}});
  const EdgeGraph graph(square);
  EXPECT_THAT(graph.NeighboursOf(0), ElementsAre(1, 2, 3));
  EXPECT_THAT(graph.NeighboursOf(1), ElementsAre(0, 2));
  EXPECT_THAT(graph.NeighboursOf(2), ElementsAre(0, 1, 3));
  EXPECT_THAT(graph.NeighboursOf(3), ElementsAre(0, 2));
  EXPECT_THAT(graph.NeighboursOf(4), IsEmpty());
}

TEST(EdgeGraph, HasNoEdgesInAPointCloud) {
  TriangleMesh cloud;
  cloud.vertices = Eigen::Matrix3Xd::Zero(3, 2);
  EXPECT_THAT(EdgeGraph(cloud).NeighboursOf(1), IsEmpty());
}

}  // namespace
}  // namespace cohort
