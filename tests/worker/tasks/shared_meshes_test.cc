#include "worker/tasks/shared_meshes.h"

#include <algorithm>
#include <filesystem>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <Eigen/Geometry>

#include "common/store/memory_blob_store.h"
#include "common/store/mesh_blob.h"
#include "tests/common/store/scratch_folder.h"
#include "tests/testing/status_matchers.h"
#include "worker/tasks/mesh_cache.h"

namespace cohort {
namespace {

using testing::IsOk;

constexpr int64_t kCacheBytes = 1'000'000;

Similarity Turned() {
  Similarity T;
  T.scale = 1.25;
  T.rotation = Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitY()).toRotationMatrix();
  T.translation = {1, -2, 3};
  return T;
}

class SharedMeshesTest : public ::testing::Test {
 protected:
  SharedMeshesTest() {
    TriangleMesh mesh;
    mesh.vertices = Eigen::Matrix3Xd::Random(3, 1000) * 90;
    blob_ = *store_.Put(EncodeRawMeshBlob(mesh));
  }
  const Similarity T_ = Turned();
  const Eigen::Vector3d center_{0.1, 0.2, 0.3};
  testing::ScratchFolder scratch_;
  std::unique_ptr<SharedFolder> folder_ =
      SharedFolder::Create(scratch_.Path(), kCacheBytes).value();
  SharedMeshes shared_{*folder_};
  MemoryBlobStore store_;
  MemoryBlobStore empty_store_;  ///< Of another worker of the same machine: it has no blob.
  Digest blob_;
};

TEST_F(SharedMeshesTest, AnotherWorkerNeedsNoBlob) {
  MeshCache maker(store_, kCacheBytes, &shared_);
  MeshCache reader(empty_store_, kCacheBytes, &shared_);
  ASSERT_THAT(maker.SharePlaced(blob_, T_, center_), IsOk());

  const auto got = reader.GetPlaced(blob_, T_, center_);

  ASSERT_THAT(got, IsOk());
  const auto made = maker.GetPlaced(blob_, T_, center_).value();
  ASSERT_EQ((*got)->SlotCount(), made->SlotCount());
  EXPECT_EQ((*got)->VertexCount(), 1000);
  EXPECT_TRUE(std::ranges::equal((*got)->VertexOfSlot(), made->VertexOfSlot()));
  for (int slot = 0; slot < made->SlotCount(); ++slot) {
    EXPECT_EQ((*got)->PointOfSlot(slot), made->PointOfSlot(slot));
  }
}

TEST_F(SharedMeshesTest, WhatOneWorkerNeededIsSharedToo) {
  MeshCache maker(store_, kCacheBytes, &shared_);
  ASSERT_THAT(maker.GetPlaced(blob_, T_, center_), IsOk());

  EXPECT_THAT(MeshCache(empty_store_, kCacheBytes, &shared_).GetPlaced(blob_, T_, center_), IsOk());
}

TEST_F(SharedMeshesTest, AnotherPlaceIsAnotherMesh) {
  MeshCache maker(store_, kCacheBytes, &shared_);
  MeshCache reader(empty_store_, kCacheBytes, &shared_);
  ASSERT_THAT(maker.SharePlaced(blob_, T_, center_), IsOk());
  Similarity moved = T_;
  moved.translation.x() += 1e-12;

  EXPECT_THAT(reader.GetPlaced(blob_, moved, center_), ::testing::Not(IsOk()));
  EXPECT_THAT(reader.GetPlaced(blob_, T_, center_ * 2), ::testing::Not(IsOk()));
}

TEST_F(SharedMeshesTest, BytesThatAreNoMeshAreNone) {
  const std::string key = "a key";
  shared_.Keep(key, PackedMesh(Eigen::Matrix3Xf::Random(3, 20)));
  ASSERT_NE(shared_.Get(key), nullptr);
  for (const auto& file : std::filesystem::recursive_directory_iterator(scratch_.Path())) {
    if (file.is_regular_file()) {
      std::filesystem::permissions(file.path(), std::filesystem::perms::owner_all);
      std::filesystem::resize_file(file.path(), 100);
    }
  }

  EXPECT_EQ(shared_.Get(key), nullptr);
}

TEST_F(SharedMeshesTest, WithoutAFolderNothingIsMadeReady) {
  MeshCache alone(empty_store_, kCacheBytes);

  EXPECT_THAT(alone.SharePlaced(blob_, T_, center_), IsOk());
}

}  // namespace
}  // namespace cohort
