#include "common/jobs/landmark_blob.h"

#include <set>
#include <span>
#include <utility>
#include <vector>

#include <absl/strings/str_cat.h>

#include "common/base/byte_io.h"
#include "common/base/status_macros.h"
#include "common/jobs/blob_decoder.h"

namespace cohort {
namespace {

constexpr std::string_view kLandmarkMagic = "COHLAND1";
constexpr uint64_t kLandmarkBytes = sizeof(uint32_t) + 3 * sizeof(double);

absl::Status GetNames(BlobDecoder& blob, std::vector<std::string>& names) {
  uint64_t count = 0;
  COHORT_RETURN_IF_ERROR(blob.GetCount("names", sizeof(uint64_t), count));
  names.resize(count);
  for (std::string& name : names) {
    COHORT_RETURN_IF_ERROR(blob.GetString("names", name));
  }
  return absl::OkStatus();
}

absl::Status GetLandmarks(BlobDecoder& blob,
                          const std::vector<std::string>& names,
                          LandmarkSet& landmarks) {
  uint64_t count = 0;
  COHORT_RETURN_IF_ERROR(blob.GetCount("landmarks", kLandmarkBytes, count));
  std::vector<uint32_t> places(count);
  COHORT_RETURN_IF_ERROR(blob.GetArray<uint32_t>("landmarks", places));
  std::set<uint32_t> seen;
  for (const uint32_t place : places) {
    if (place >= names.size() || !seen.insert(place).second) {
      return blob.Damaged(absl::StrCat("name ", place, " of ", names.size(), " for a landmark",
                                       place < names.size() ? ", twice" : ""));
    }
    landmarks.names.push_back(names[place]);
  }
  landmarks.points.resize(3, static_cast<Eigen::Index>(count));
  COHORT_RETURN_IF_ERROR(blob.GetArray<double>(
      "points", {landmarks.points.data(), static_cast<size_t>(landmarks.points.size())}));
  return landmarks.points.allFinite() ? absl::OkStatus()
                                      : blob.Damaged("a point that is not finite");
}

}  // namespace

std::string EncodeLandmarkBlob(const LandmarkTable& table) {
  std::map<std::string_view, uint32_t> places;
  for (const auto& [mesh, landmarks] : table) {
    for (const std::string& name : landmarks.names) {
      places.emplace(name, 0);
    }
  }
  ByteWriter writer;
  writer.PutBytes(kLandmarkMagic);
  writer.Put<uint64_t>(places.size());
  uint32_t next = 0;
  for (auto& [name, place] : places) {
    place = next++;
    writer.PutString(name);
  }
  writer.Put<uint64_t>(table.size());
  for (const auto& [mesh, landmarks] : table) {
    writer.PutString(mesh);
    writer.Put<uint64_t>(landmarks.names.size());
    for (const std::string& name : landmarks.names) {
      writer.Put<uint32_t>(places.at(name));
    }
    writer.PutArray<double>(
        {landmarks.points.data(), static_cast<size_t>(landmarks.points.size())});
  }
  return std::move(writer).Take();
}

absl::StatusOr<LandmarkTable> DecodeLandmarkBlob(std::string_view bytes) {
  BlobDecoder blob("landmark", bytes);
  COHORT_RETURN_IF_ERROR(blob.Start(kLandmarkMagic));
  std::vector<std::string> names;
  COHORT_RETURN_IF_ERROR(GetNames(blob, names));
  uint64_t meshes = 0;
  COHORT_RETURN_IF_ERROR(blob.GetCount("meshes", 2 * sizeof(uint64_t), meshes));
  LandmarkTable table;
  for (uint64_t i = 0; i < meshes; ++i) {
    std::string mesh;
    COHORT_RETURN_IF_ERROR(blob.GetString("mesh name", mesh));
    if (!table.empty() && mesh <= table.rbegin()->first) {
      return blob.Damaged("mesh names that do not ascend");
    }
    COHORT_RETURN_IF_ERROR(
        GetLandmarks(blob, names, table.emplace_hint(table.end(), mesh, LandmarkSet())->second));
  }
  COHORT_RETURN_IF_ERROR(blob.Finish());
  return table;
}

int64_t SizeOf(const LandmarkTable& table) {
  constexpr int64_t kMeshBytes = 160;     // node, name, two vectors
  constexpr int64_t kLandmarkInUse = 56;  // short name and point
  int64_t bytes = 0;
  for (const auto& [mesh, landmarks] : table) {
    bytes += kMeshBytes + landmarks.Count() * kLandmarkInUse;
  }
  return bytes;
}

}  // namespace cohort
