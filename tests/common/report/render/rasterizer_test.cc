#include "common/report/render/rasterizer.h"

#include <cmath>
#include <numbers>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/common/geometry/mesh/shapes.h"

namespace cohort {
namespace {

using ::testing::Gt;
using ::testing::Lt;

// A sphere of `rings` x 2 rings quads about the origin, normals outwards.
TriangleMesh Sphere(double radius, int rings) {
  const int columns = 2 * rings;
  TriangleMesh mesh;
  mesh.vertices.resize(3, Eigen::Index{rings + 1} * columns);
  mesh.faces.resize(3, Eigen::Index{2} * rings * columns);
  Eigen::Index face = 0;
  for (int ring = 0; ring <= rings; ++ring) {
    const double latitude = std::numbers::pi * (ring / double{1} / rings - 0.5);
    for (int column = 0; column < columns; ++column) {
      const double longitude = 2 * std::numbers::pi * column / columns;
      mesh.vertices.col(Eigen::Index{ring} * columns + column)
          << radius * std::cos(latitude) * std::cos(longitude),
          radius * std::sin(latitude), -radius * std::cos(latitude) * std::sin(longitude);
      if (ring == rings) continue;
      const int next = (column + 1) % columns;
      const int a = ring * columns + column;
      const int b = ring * columns + next;
      mesh.faces.col(face++) << a, b, b + columns;
      mesh.faces.col(face++) << a, b + columns, a + columns;
    }
  }
  return mesh;
}

// Looks along -z at [-1, 1] x [-1, 1].
Camera FrontCamera(double half = 1) {
  Camera camera;
  camera.half_width = half;
  camera.half_height = half;
  return camera;
}

// A square of side 2 `half` about (x, 0, z) that faces the viewer.
TriangleMesh Square(double half, double x, double z) {
  return testing::MakeMesh(
      {{x - half, -half, z}, {x + half, -half, z}, {x + half, half, z}, {x - half, half, z}},
      {{0, 1, 2}, {0, 2, 3}});
}

int64_t CountUnlike(const Image& image, Rgb color) {
  int64_t count = 0;
  for (const Rgb& pixel : image.pixels) count += pixel == color ? 0 : 1;
  return count;
}

TEST(RenderMesh, ASphereCoversThePixelsOfItsSilhouette) {
  const TriangleMesh sphere = Sphere(0.8, 90);
  const RenderOptions options{.width = 400, .height = 400, .samples = 1};
  const Image image = RenderMesh(sphere, {}, FrontCamera(), options);
  // The silhouette of a polyhedron of 180 sides falls short of the circle by 2e-4 of its area; the
  // border passes through about 8 * 0.8 * 200 pixels, of which half are off by chance.
  const double circle = std::numbers::pi * 160 * 160;
  EXPECT_NEAR(static_cast<double>(CountUnlike(image, kWhite)), circle, 0.002 * circle);
}

TEST(RenderMesh, SupersamplingGivesTheBorderItsShareOfTheBackground) {
  // A square that ends in the middle of pixels: 10.5 of 40 pixels to each side of the middle.
  const TriangleMesh square = Square(0.525, 0, 0);
  const RenderOptions options{.width = 40, .height = 40, .samples = 4, .background = {0, 0, 0}};
  const Image image = RenderMesh(square, {}, FrontCamera(), options);
  const double inside = image.At(20, 20).red;
  EXPECT_NEAR(image.At(9, 20).red, inside / 2, 1);
  EXPECT_EQ(image.At(8, 20), (Rgb{0, 0, 0}));
  EXPECT_EQ(image.At(10, 20), image.At(20, 20));
}

TEST(RenderMesh, NearerFacesHideFartherOnesWhateverTheirOrder) {
  const std::vector<Rgb> near_red_last = {{0, 0, 255}, {0, 0, 255}, {0, 0, 255}, {0, 0, 255},
                                          {255, 0, 0}, {255, 0, 0}, {255, 0, 0}, {255, 0, 0}};
  const std::vector<Rgb> near_red_first(near_red_last.rbegin(), near_red_last.rend());
  const TriangleMesh near = Square(0.4, 0, 0.5);
  const TriangleMesh far = Square(0.8, 0, -0.5);
  const RenderOptions options{.width = 20, .height = 20};
  const Image last = RenderMesh(testing::Together(far, near, Eigen::Vector3d::Zero()),
                                near_red_last, FrontCamera(), options);
  const Image first = RenderMesh(testing::Together(near, far, Eigen::Vector3d::Zero()),
                                 near_red_first, FrontCamera(), options);
  EXPECT_EQ(last.pixels, first.pixels);
  EXPECT_THAT(last.At(10, 10).red, Gt(4 * last.At(10, 10).blue));
  EXPECT_THAT(last.At(3, 10).blue, Gt(4 * last.At(3, 10).red));
}

TEST(RenderMesh, OfFacesAtTheSameDepthTheFirstIsSeen) {
  const TriangleMesh square = Square(0.5, 0, 0);
  const std::vector<Rgb> colors = {{255, 0, 0}, {255, 0, 0}, {255, 0, 0}, {255, 0, 0},
                                   {0, 0, 255}, {0, 0, 255}, {0, 0, 255}, {0, 0, 255}};
  const Image image = RenderMesh(testing::Together(square, square, Eigen::Vector3d::Zero()), colors,
                                 FrontCamera(), {.width = 20, .height = 20});
  EXPECT_THAT(image.At(10, 10).red, Gt(4 * image.At(10, 10).blue));
}

TEST(RenderMesh, TheLampShinesFromTheUpperLeft) {
  const Image image = RenderMesh(Sphere(0.9, 40), {}, FrontCamera(), {.width = 60, .height = 60});
  EXPECT_THAT(image.At(20, 17).red, Gt(image.At(40, 17).red));
  EXPECT_THAT(image.At(40, 17).red, Gt(image.At(40, 43).red));
  EXPECT_THAT(image.At(20, 43).red, Gt(image.At(40, 43).red));
}

TEST(RenderMesh, BackSidesAreDarkerThanFrontSides) {
  TriangleMesh square = Square(0.5, 0, 0);
  const RenderOptions options{.width = 20, .height = 20};
  const Rgb front = RenderMesh(square, {}, FrontCamera(), options).At(10, 10);
  square.faces.row(1).swap(square.faces.row(2));
  const Rgb back = RenderMesh(square, {}, FrontCamera(), options).At(10, 10);
  EXPECT_THAT(int{back.red}, Lt(0.7 * front.red));
  EXPECT_THAT(int{back.red}, Gt(0.3 * front.red));
}

TEST(RenderMesh, NeighbouringFacesLeaveNoGapBetweenThem) {
  const TriangleMesh sheet = testing::WavySheet(40);  // 117 x 117 mm.
  const Camera camera = FitCamera(sheet.vertices, {}, View::kLeftThreeQuarter);
  // Magenta would shine through a gap: the sheet is grey.
  const Image image = RenderMesh(
      sheet, {}, camera, {.width = 200, .height = 200, .samples = 1, .background = {255, 0, 255}});
  for (int x = 30; x < 170; ++x) EXPECT_EQ(image.At(x, 100).red, image.At(x, 100).green) << x;
}

TEST(RenderMesh, ShowsPointsWithoutFacesAsAClosedSurface) {
  TriangleMesh cloud = testing::WavySheet(40);
  cloud.faces.resize(3, 0);
  const Camera camera = FitCamera(cloud.vertices, {}, View::kFront);
  const Image image = RenderMesh(cloud, {}, camera, {.width = 60, .height = 60});
  EXPECT_EQ(image.At(30, 30).red, image.At(30, 30).green);
  EXPECT_THAT(image.At(30, 30).red, Lt(200));
}

TEST(RenderMesh, CutsOffWhatLiesBeyondThePicture) {
  const Image image =
      RenderMesh(Square(1000, 0, 0), {}, FrontCamera(), {.width = 10, .height = 10});
  EXPECT_EQ(CountUnlike(image, image.At(0, 0)), 0);
}

}  // namespace
}  // namespace cohort
