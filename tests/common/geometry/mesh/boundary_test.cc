#include "common/geometry/mesh/boundary.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/geometry/mesh/shapes.h"

namespace cohort {
namespace {

using ::testing::Each;
using ::testing::ElementsAre;
using testing::MakeMesh;
using testing::Tetrahedron;
using testing::WavySheet;

TEST(BoundaryVertices, AreNoneOnAClosedSurface) {
  EXPECT_THAT(BoundaryVertices(Tetrahedron()), ElementsAre(0, 0, 0, 0));
}

TEST(BoundaryVertices, AreAllOnASingleTriangle) {
  EXPECT_THAT(BoundaryVertices(MakeMesh({{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}})),
              ElementsAre(1, 1, 1));
}

TEST(BoundaryVertices, AreTheRimOfASheet) {
  constexpr int kSide = 7;
  const std::vector<uint8_t> flags = BoundaryVertices(WavySheet(kSide));
  for (int row = 0; row < kSide; ++row) {
    for (int column = 0; column < kSide; ++column) {
      const bool on_rim = row == 0 || column == 0 || row == kSide - 1 || column == kSide - 1;
      EXPECT_EQ(flags[static_cast<size_t>(row * kSide + column)], on_rim ? 1 : 0)
          << row << " " << column;
    }
  }
}

TEST(BoundaryVertices, AreNotAtAnEdgeOfThreeFaces) {
  // A book of three pages on the spine 0-1: the spine is no boundary, the tips are.
  const TriangleMesh book = MakeMesh({{0, 0, 0}, {0, 1, 0}, {1, 0, 0}, {-1, 0, 1}, {-1, 0, -1}},
                                     {{0, 1, 2}, {0, 1, 3}, {0, 1, 4}});
  // Vertices 0 and 1 still lie on the free sides of each page.
  EXPECT_THAT(BoundaryVertices(book), Each(1));
  // With both sides of each page closed to its tip only by the spine, nothing else is left.
  TriangleMesh doubled = book;
  doubled.faces.resize(3, 6);
  doubled.faces << book.faces, book.faces.colwise().reverse();
  EXPECT_THAT(BoundaryVertices(doubled), Each(0));
}

TEST(BoundaryVertices, AreNoneInAPointCloud) {
  TriangleMesh cloud = Tetrahedron();
  cloud.faces.resize(3, 0);
  EXPECT_THAT(BoundaryVertices(cloud), ElementsAre(0, 0, 0, 0));
}

}  // namespace
}  // namespace cohort
