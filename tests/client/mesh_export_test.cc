#include "client/mesh_export.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cohort {
namespace {

using ::testing::ElementsAre;

TEST(ExportNames, ExchangeTheExtension) {
  EXPECT_THAT(ExportNames({"a.obj", "b.c.ply", "d"}, MeshFormat::kStl),
              ElementsAre("a.stl", "b.c.stl", "d.stl"));
}

TEST(ExportNames, KeepTheExtensionWhereTwoWouldBeCalledTheSame) {
  EXPECT_THAT(ExportNames({"a.obj", "a.ply", "b.ply"}, MeshFormat::kPly),
              ElementsAre("a.obj.ply", "a.ply.ply", "b.ply"));
}

TEST(ExportNames, AreDifferentWhateverTheMeshesAreCalled) {
  EXPECT_THAT(ExportNames({"a.obj", "a.obj.x", "a.ply", "a/b.ply", "a_b.ply"}, MeshFormat::kPly),
              ElementsAre("a.obj.ply", "a.obj_.ply", "a.ply.ply", "a_b.ply.ply", "a_b.ply_.ply"));
}

TEST(ExportNames, StayInTheirFolder) {
  EXPECT_THAT(
      ExportNames({"../../etc/x.ply", "..", "\\\\host\\y.obj", ".hidden"}, MeshFormat::kObj),
      ElementsAre(".._.._etc_x.obj", "_..obj", "__host_y.obj", ".hidden.obj"));
}

TEST(MeshFormatFromName, KnowsThreeFormats) {
  EXPECT_EQ(MeshFormatFromName("ply"), MeshFormat::kPly);
  EXPECT_EQ(MeshFormatFromName("obj"), MeshFormat::kObj);
  EXPECT_EQ(MeshFormatFromName("stl"), MeshFormat::kStl);
  EXPECT_EQ(MeshFormatFromName("PLY"), std::nullopt);
}

}  // namespace
}  // namespace cohort
