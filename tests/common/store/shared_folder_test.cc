#include "common/store/decoded_mesh_folder.h"

#include <filesystem>
#include <fstream>
#include <optional>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/store/mesh_blob.h"
#include "tests/common/store/scratch_folder.h"
#include "tests/testing/status_matchers.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

using testing::IsOk;

/// A flat grid of side x side vertices, `shift` high: another mesh for each shift.
TriangleMesh MakeGrid(int side, float shift) {
  TriangleMesh mesh;
  mesh.vertices.resize(3, int64_t{side} * side);
  mesh.faces.resize(3, 2 * int64_t{side - 1} * (side - 1));
  Eigen::Index face = 0;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const int v = y * side + x;
      mesh.vertices.col(v) << x * 0.1, y * 0.3, shift;
      if (x + 1 < side && y + 1 < side) {
        mesh.faces.col(face++) << v, v + 1, v + side;
        mesh.faces.col(face++) << v + 1, v + side + 1, v + side;
      }
    }
  }
  mesh.vertices = mesh.vertices.cast<float>().cast<double>();
  return mesh;
}

class DecodedMeshFolderTest : public ::testing::Test {
 protected:
  [[nodiscard]] std::unique_ptr<DecodedMeshFolder> Open(int64_t max_bytes = 1'000'000) const {
    return DecodedMeshFolder::Create(folder_.Path(), max_bytes).value();
  }
  [[nodiscard]] fs::path FileOf(const Digest& blob) const {
    return folder_.Path() / "sha256" / blob.Hex().substr(0, 2) / blob.Hex();
  }
  void Overwrite(const Digest& blob, const std::string& bytes) const {
    fs::permissions(FileOf(blob), fs::perms::owner_all);
    std::ofstream(FileOf(blob), std::ios::binary | std::ios::trunc) << bytes;
  }
  [[nodiscard]] std::string BytesOf(const Digest& blob) const {
    std::ifstream file(FileOf(blob), std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
  }

  testing::ScratchFolder folder_;
  const Digest blob_ = Digest(Sha256::Of("a blob"));
  const Digest other_ = Digest(Sha256::Of("another blob"));
};

TEST_F(DecodedMeshFolderTest, GivesAnotherWorkerTheSameMesh) {
  const TriangleMesh mesh = MakeGrid(7, 2);
  Open()->Keep(blob_, mesh);

  const std::optional<TriangleMesh> got = Open()->Get(blob_);

  ASSERT_TRUE(got.has_value());
  EXPECT_EQ(got->vertices, mesh.vertices);
  EXPECT_EQ(got->faces, mesh.faces);
  EXPECT_FALSE(Open()->Get(other_).has_value());
}

TEST_F(DecodedMeshFolderTest, WhatDracoGivesIsKeptExactly) {
  const std::string bytes = EncodeDracoMeshBlob(MakeGrid(9, 1), {}).value();
  const TriangleMesh decoded = DecodeMeshBlob(bytes).value();
  const auto folder = Open();

  folder->Keep(Sha256::Of(bytes), decoded);

  const std::optional<TriangleMesh> got = folder->Get(Sha256::Of(bytes));
  ASSERT_TRUE(got.has_value());
  EXPECT_EQ(got->vertices, decoded.vertices);
  EXPECT_EQ(got->faces, decoded.faces);
}

TEST_F(DecodedMeshFolderTest, LeavesOutWhatFloatsCannotHold) {
  TriangleMesh mesh = MakeGrid(3, 1);
  mesh.vertices(0, 0) += 1e-12;
  const auto folder = Open();

  folder->Keep(blob_, mesh);

  EXPECT_FALSE(folder->Get(blob_).has_value());
}

TEST_F(DecodedMeshFolderTest, EveryFlippedByteIsFound) {
  const auto folder = Open();
  folder->Keep(blob_, MakeGrid(2, 1));
  const std::string whole = BytesOf(blob_);
  ASSERT_FALSE(whole.empty());
  for (size_t place = 0; place < whole.size(); ++place) {
    folder->Keep(blob_, MakeGrid(2, 1));
    std::string damaged = whole;
    damaged[place] = static_cast<char>(damaged[place] ^ 4);
    Overwrite(blob_, damaged);

    EXPECT_FALSE(folder->Get(blob_).has_value()) << "byte " << place;
    EXPECT_FALSE(fs::exists(FileOf(blob_))) << "byte " << place;
  }
}

TEST_F(DecodedMeshFolderTest, FilesCutShortEmptyOrUnderAnotherNameAreFound) {
  const auto folder = Open();
  folder->Keep(blob_, MakeGrid(4, 1));
  const std::string whole = BytesOf(blob_);
  for (const std::string& bytes : {std::string(), whole.substr(0, 10), whole.substr(0, 64),
                                   whole.substr(0, whole.size() - 1)}) {
    folder->Keep(blob_, MakeGrid(4, 1));
    Overwrite(blob_, bytes);
    EXPECT_FALSE(folder->Get(blob_).has_value()) << bytes.size() << " bytes";
  }
  folder->Keep(other_, MakeGrid(4, 2));
  Overwrite(other_, whole);
  EXPECT_FALSE(folder->Get(other_).has_value());
}

TEST_F(DecodedMeshFolderTest, TheLeastRecentlyUsedGoesFirst) {
  const TriangleMesh mesh = MakeGrid(16, 1);
  const auto bytes = static_cast<int64_t>(mesh.VertexCount() * 12 + mesh.FaceCount() * 12 + 100);
  const auto folder = Open(4 * bytes);
  const auto name = [](int i) { return Sha256::Of(std::to_string(i)); };
  const auto now = fs::file_time_type::clock::now();
  for (int i = 0; i < 4; ++i) {
    folder->Keep(name(i), mesh);
    fs::last_write_time(FileOf(name(i)), now - std::chrono::minutes(10 - i));
  }
  ASSERT_TRUE(folder->Get(name(0)).has_value()) << "used now";

  folder->Keep(name(4), mesh);

  EXPECT_TRUE(fs::exists(FileOf(name(0))));
  EXPECT_FALSE(fs::exists(FileOf(name(1))));
  EXPECT_TRUE(fs::exists(FileOf(name(4))));
}

TEST_F(DecodedMeshFolderTest, LargerThanTheLimitIsNotKept) {
  const auto folder = Open(1000);

  folder->Keep(blob_, MakeGrid(30, 1));

  EXPECT_FALSE(fs::exists(FileOf(blob_)));
}

TEST_F(DecodedMeshFolderTest, AFolderThatCannotBeWrittenCostsNothingElse) {
  const auto folder = Open();
  fs::remove_all(folder_.Path());

  folder->Keep(blob_, MakeGrid(3, 1));

  EXPECT_FALSE(folder->Get(blob_).has_value());
}

TEST_F(DecodedMeshFolderTest, NoFolderThereIsAnError) {
  std::ofstream(folder_.Path() / "file") << "x";
  EXPECT_THAT(DecodedMeshFolder::Create(folder_.Path() / "file" / "below", 1000),
              ::testing::Not(IsOk()));
}

}  // namespace
}  // namespace cohort
