#include <string>
#include <vector>

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "common/jobs/task.h"
#include "server/catalog/catalog.h"
#include "tests/server/catalog/catalog_fixture.h"

namespace cohort {
namespace {

using testing::CatalogTest;
using testing::DatabaseName;
using testing::EachDatabase;
using ::testing::ElementsAre;
using testing::IsOk;
using testing::SomeIngested;
using testing::SomeMesh;
using testing::StatusIs;

class CatalogMeshesTest : public CatalogTest {};

/// Names of all pages of a set, and that each but the last is full.
std::vector<std::string> AllNames(Catalog& catalog, const std::string& set, int page_size) {
  std::vector<std::string> names;
  std::string token;
  do {
    const absl::StatusOr<Page<SetMesh>> page = catalog.ListMeshes(set, page_size, token);
    EXPECT_THAT(page, IsOk());
    if (!page.ok()) {
      break;
    }
    for (const SetMesh& mesh : page->items) {
      names.push_back(mesh.name);
    }
    token = page->next_token;
    EXPECT_TRUE(token.empty() || page->items.size() == static_cast<size_t>(page_size));
  } while (!token.empty());
  return names;
}

TEST_P(CatalogMeshesTest, KeepsAMeshAcrossAReopening) {
  const SetMesh mesh = SomeMesh("ž 'a'.ply");
  ASSERT_THAT(catalog_->AddMesh("brno 2016", mesh), IsOk());

  Reopen();

  const absl::StatusOr<Page<SetMesh>> page = catalog_->ListMeshes("brno 2016", 10, "");
  ASSERT_THAT(page, IsOk());
  ASSERT_EQ(page->items.size(), 1u);
  EXPECT_EQ(page->items[0].name, mesh.name);
  EXPECT_EQ(page->items[0].raw, mesh.raw);
  EXPECT_EQ(page->items[0].size_bytes, mesh.size_bytes);
  EXPECT_EQ(page->items[0].labels, mesh.labels);
  EXPECT_EQ(page->next_token, "");
}

TEST_P(CatalogMeshesTest, ChangesTheLabelsOfTheSameBytes) {
  SetMesh mesh = SomeMesh("a.ply");
  ASSERT_THAT(catalog_->AddMesh("s", mesh), IsOk());
  mesh.labels = {{"person", "2"}};

  ASSERT_THAT(catalog_->AddMesh("s", mesh), IsOk());

  const absl::StatusOr<Page<SetMesh>> page = catalog_->ListMeshes("s", 10, "");
  ASSERT_THAT(page, IsOk());
  ASSERT_EQ(page->items.size(), 1u);
  EXPECT_EQ(page->items[0].labels, mesh.labels);
}

TEST_P(CatalogMeshesTest, RefusesOtherBytesUnderAKnownName) {
  SetMesh mesh = SomeMesh("a.ply");
  ASSERT_THAT(catalog_->AddMesh("s", mesh), IsOk());
  mesh.raw = Sha256::Of("other");
  mesh.labels.clear();

  EXPECT_THAT(catalog_->AddMesh("s", mesh), StatusIs(absl::StatusCode::kAlreadyExists, "a.ply"));

  EXPECT_EQ(catalog_->ListMeshes("s", 1, "")->items[0].raw, Sha256::Of("a.ply"));
  EXPECT_EQ(catalog_->ListMeshes("s", 1, "")->items[0].labels, SomeMesh("a.ply").labels);
  EXPECT_THAT(catalog_->AddMesh("another set", mesh), IsOk());
}

TEST_P(CatalogMeshesTest, RefusesAMeshOrASetWithoutAName) {
  EXPECT_THAT(catalog_->AddMesh("", SomeMesh("a")),
              StatusIs(absl::StatusCode::kInvalidArgument, ""));
  EXPECT_THAT(catalog_->AddMesh("s", SomeMesh("")),
              StatusIs(absl::StatusCode::kInvalidArgument, ""));
}

TEST_P(CatalogMeshesTest, RefusesALabelThatIsNotUtf8) {
  SetMesh mesh = SomeMesh("a.ply");
  mesh.labels["person"] = "\xff";

  EXPECT_THAT(catalog_->AddMesh("s", mesh), StatusIs(absl::StatusCode::kInvalidArgument, "UTF-8"));
}

TEST_P(CatalogMeshesTest, ListsMeshesBytewiseOnPagesOfAnySize) {
  // Upper case before lower, and bytes above 127 last, whatever the locale.
  for (const char* name : {"b", "ž", "B", "a", "a0", "_", "č"}) {
    ASSERT_THAT(catalog_->AddMesh("s", SomeMesh(name)), IsOk());
  }
  const auto sorted = ElementsAre("B", "_", "a", "a0", "b", "č", "ž");

  EXPECT_THAT(AllNames(*catalog_, "s", 1), sorted);
  EXPECT_THAT(AllNames(*catalog_, "s", 3), sorted);
  EXPECT_THAT(AllNames(*catalog_, "s", 7), sorted);
  EXPECT_THAT(AllNames(*catalog_, "s", 1000), sorted);
}

TEST_P(CatalogMeshesTest, GoesOnAfterTheSameMeshWhenOthersAreAddedBetweenPages) {
  for (const char* name : {"b", "d", "f"}) {
    ASSERT_THAT(catalog_->AddMesh("s", SomeMesh(name)), IsOk());
  }
  const Page<SetMesh> first = catalog_->ListMeshes("s", 2, "").value();
  for (const char* name : {"a", "e"}) {
    ASSERT_THAT(catalog_->AddMesh("s", SomeMesh(name)), IsOk());
  }

  const Page<SetMesh> second = catalog_->ListMeshes("s", 2, first.next_token).value();

  ASSERT_EQ(second.items.size(), 2u);
  EXPECT_EQ(second.items[0].name, "e");
  EXPECT_EQ(second.items[1].name, "f");
}

TEST_P(CatalogMeshesTest, ListsSetsWithTheirSizes) {
  ASSERT_THAT(catalog_->ListSets(10, ""), IsOk());
  EXPECT_TRUE(catalog_->ListSets(10, "")->items.empty());
  ASSERT_THAT(catalog_->AddMesh("t", SomeMesh("a")), IsOk());
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("a")), IsOk());
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("b")), IsOk());

  const Page<MeshSet> first = catalog_->ListSets(1, "").value();
  const Page<MeshSet> second = catalog_->ListSets(1, first.next_token).value();

  ASSERT_EQ(first.items.size(), 1u);
  EXPECT_EQ(first.items[0].name, "s");
  EXPECT_EQ(first.items[0].meshes, 2);
  EXPECT_EQ(first.items[0].size_bytes, 10'000'000'000);
  ASSERT_EQ(second.items.size(), 1u);
  EXPECT_EQ(second.items[0].name, "t");
  EXPECT_EQ(second.next_token, "");
}

TEST_P(CatalogMeshesTest, NamesTheSetThatIsMissing) {
  EXPECT_THAT(catalog_->ListMeshes("nobody", 10, ""),
              StatusIs(absl::StatusCode::kNotFound, "nobody"));
}

TEST_P(CatalogMeshesTest, RefusesATokenOfAnotherListingAndAPageOfNothing) {
  ASSERT_THAT(catalog_->AddMesh("s", SomeMesh("a")), IsOk());
  ASSERT_THAT(catalog_->AddMesh("t", SomeMesh("a")), IsOk());
  const std::string of_sets = catalog_->ListSets(1, "")->next_token;

  EXPECT_THAT(catalog_->ListMeshes("s", 1, of_sets),
              StatusIs(absl::StatusCode::kInvalidArgument, "token"));
  EXPECT_THAT(catalog_->ListSets(1, "%%%"), StatusIs(absl::StatusCode::kInvalidArgument, "token"));
  EXPECT_THAT(catalog_->ListJobs(1, of_sets),
              StatusIs(absl::StatusCode::kInvalidArgument, "token"));
  EXPECT_THAT(catalog_->ListSets(0, ""), StatusIs(absl::StatusCode::kInvalidArgument, "0"));
}

TEST_P(CatalogMeshesTest, RemembersWhatIngestMadeByDigestAndQuantisation) {
  const Digest raw = Sha256::Of("raw");
  IngestedMesh mesh = SomeIngested("a");
  mesh.index = 12;
  ASSERT_THAT(catalog_->RecordIngested(raw, 18, mesh), IsOk());
  ASSERT_THAT(catalog_->RecordIngested(raw, 18, mesh), IsOk());

  Reopen();

  const absl::StatusOr<std::optional<IngestedMesh>> found = catalog_->FindIngested(raw, 18);
  ASSERT_THAT(found, IsOk());
  ASSERT_TRUE(found->has_value());
  EXPECT_EQ((*found)->index, 0);
  EXPECT_EQ((*found)->blob, mesh.blob);
  EXPECT_EQ((*found)->vertices, mesh.vertices);
  EXPECT_EQ((*found)->centroid, mesh.centroid);
  EXPECT_EQ((*found)->health.boundary_share, mesh.health.boundary_share);
  EXPECT_EQ((*found)->health.warnings, mesh.health.warnings);
  EXPECT_EQ(catalog_->FindIngested(raw, 20).value().has_value(), false);
  EXPECT_EQ(catalog_->FindIngested(Sha256::Of("x"), 18).value().has_value(), false);
}

INSTANTIATE_TEST_SUITE_P(On, CatalogMeshesTest, EachDatabase(), DatabaseName);

}  // namespace
}  // namespace cohort
