#include "client/landmark_files.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <iterator>
#include <map>
#include <string_view>
#include <system_error>
#include <utility>

#include <absl/strings/str_cat.h>
#include <absl/strings/str_join.h>

#include "client/files.h"
#include "common/base/sha256.h"
#include "common/base/status_macros.h"
#include "common/geometry/io/landmarks.h"

namespace cohort {
namespace {

namespace fs = std::filesystem;

constexpr size_t kNamed = 3;
constexpr size_t kNeeded = 3;
constexpr std::array<std::string_view, 4> kExtensions = {".mrk.json", ".csv", ".pp", ".fcsv"};
constexpr std::string_view kMeshLabSuffix = "_picked_points";

/// ".mrk.json", ...; empty if the name ends in none of them.
std::string_view LandmarkExtension(const std::string& file_name) {
  std::string lower = file_name;
  std::transform(lower.begin(), lower.end(), lower.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  const auto found = std::find_if(kExtensions.begin(), kExtensions.end(),
                                  [&](std::string_view ending) { return lower.ends_with(ending); });
  return found == kExtensions.end() ? std::string_view() : *found;
}

/// "anna" of "anna.mrk.json" and of MeshLab's "anna_picked_points.pp".
std::string StemOf(const std::string& file_name) {
  std::string stem = file_name.substr(0, file_name.size() - LandmarkExtension(file_name).size());
  if (stem.ends_with(kMeshLabSuffix)) {
    stem.resize(stem.size() - kMeshLabSuffix.size());
  }
  return stem;
}

absl::StatusOr<std::vector<fs::path>> ListLandmarkFiles(const fs::path& folder) {
  std::error_code error;
  std::vector<fs::path> files;
  for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error)) {
    if (it->is_regular_file() && !LandmarkExtension(it->path().filename().string()).empty()) {
      files.push_back(it->path());
    }
  }
  if (error) {
    return absl::UnknownError(absl::StrCat("folder ", folder.string(), ": ", error.message()));
  }
  if (files.empty()) {
    return absl::FailedPreconditionError(absl::StrCat(
        "folder ", folder.string(), " has no landmark file (.csv, .pp, .fcsv, .mrk.json)"));
  }
  std::sort(files.begin(), files.end());
  return files;
}

absl::Status ReadInto(const fs::path& path, std::vector<ReadLandmarkSet>& sets) {
  COHORT_ASSIGN_OR_RETURN(const std::string bytes, ReadWholeFile(path));
  COHORT_ASSIGN_OR_RETURN(std::vector<MeshLandmarks> entries,
                          ReadLandmarkTable(bytes, path.string()));
  for (MeshLandmarks& entry : entries) {
    sets.push_back({.path = path.string(),
                    .file = path.filename().string(),
                    .mesh = std::move(entry.mesh),
                    .landmarks = std::move(entry.landmarks)});
  }
  return absl::OkStatus();
}

/// "a, b, c and 4 more".
std::string Some(const std::vector<std::string>& names) {
  const std::vector<std::string> shown(
      names.begin(), names.begin() + static_cast<std::ptrdiff_t>(std::min(names.size(), kNamed)));
  return absl::StrCat(
      absl::StrJoin(shown, ", "),
      names.size() > kNamed ? absl::StrCat(" and ", names.size() - kNamed, " more") : "");
}

/// Finds the mesh that landmarks belong to.
class MeshFinder {
 public:
  explicit MeshFinder(std::span<const std::string> meshes) {
    for (const std::string& mesh : meshes) {
      names_[mesh].push_back(mesh);
      by_stem_[fs::path(mesh).stem().string()].push_back(mesh);
    }
  }
  /// None, one, or several that it could be.
  [[nodiscard]] std::vector<std::string> Find(const ReadLandmarkSet& set) const {
    const std::string key =
        set.mesh.empty() ? StemOf(set.file) : set.mesh.substr(set.mesh.find_last_of("/\\") + 1);
    if (const auto exact = names_.find(key); exact != names_.end()) {
      return exact->second;
    }
    const auto found = by_stem_.find(key);
    return found == by_stem_.end() ? std::vector<std::string>() : found->second;
  }

 private:
  std::map<std::string, std::vector<std::string>> names_;
  std::map<std::string, std::vector<std::string>> by_stem_;
};

/// How messages call it: "marks/anna.pp", or "landmarks.csv (anna.ply)".
std::string PlaceOf(const ReadLandmarkSet& set) {
  return set.mesh.empty() ? set.path : absl::StrCat(set.path, " (", set.mesh, ")");
}

absl::Status CheckAllMatched(std::span<const std::string> meshes,
                             const LandmarkTable& table,
                             const std::vector<std::string>& stray_files,
                             const std::vector<std::string>& stray_rows) {
  std::vector<std::string> without;
  std::copy_if(meshes.begin(), meshes.end(), std::back_inserter(without),
               [&](const std::string& mesh) { return !table.contains(mesh); });
  if (without.empty() && stray_files.empty()) {
    return absl::OkStatus();
  }
  std::string message = "landmarks: ";
  if (!without.empty()) {
    absl::StrAppend(&message, without.size(), " of ", meshes.size(),
                    " meshes have none: ", Some(without));
  }
  std::vector<std::string> stray = stray_files;
  if (!without.empty()) {
    stray.insert(stray.end(), stray_rows.begin(), stray_rows.end());
  }
  if (!stray.empty()) {
    absl::StrAppend(&message, without.empty() ? "" : "; ",
                    "no mesh has the name of: ", Some(stray));
  }
  return absl::InvalidArgumentError(message);
}

/// The names of `base` that `landmarks` has, and those it lacks, in bytewise order.
struct Shared {
  std::vector<std::string> common;
  std::vector<std::string> missing;
};
Shared CompareNames(const LandmarkSet& landmarks, const LandmarkSet& base) {
  Shared shared;
  shared.common = CommonLandmarks(std::array<LandmarkSet, 2>{landmarks, base});
  std::vector<std::string> names = base.names;
  std::sort(names.begin(), names.end());
  std::set_difference(names.begin(), names.end(), shared.common.begin(), shared.common.end(),
                      std::back_inserter(shared.missing));
  return shared;
}

}  // namespace

absl::StatusOr<std::vector<fs::path>> ExpandLandmarkPaths(std::span<const std::string> paths) {
  std::vector<fs::path> files;
  for (const std::string& path : paths) {
    if (!fs::is_directory(path)) {
      files.emplace_back(path);
      continue;
    }
    COHORT_ASSIGN_OR_RETURN(const std::vector<fs::path> inside, ListLandmarkFiles(path));
    files.insert(files.end(), inside.begin(), inside.end());
  }
  return files;
}

absl::StatusOr<std::vector<ReadLandmarkSet>> ReadLandmarkFiles(std::span<const std::string> paths) {
  std::vector<ReadLandmarkSet> sets;
  COHORT_ASSIGN_OR_RETURN(const std::vector<fs::path> files, ExpandLandmarkPaths(paths));
  for (const fs::path& file : files) {
    const absl::Status read = ReadInto(file, sets);
    const bool was_named = std::find(paths.begin(), paths.end(), file.string()) != paths.end();
    if (!read.ok() && !was_named) {
      return absl::Status(read.code(), absl::StrCat(std::string(read.message()),
                                                    "; if it has no landmarks, name the files "
                                                    "that have instead of the folder"));
    }
    COHORT_RETURN_IF_ERROR(read);
  }
  return sets;
}

absl::StatusOr<LandmarkTable> MatchLandmarks(std::span<const ReadLandmarkSet> sets,
                                             std::span<const std::string> meshes) {
  const MeshFinder finder(meshes);
  LandmarkTable table;
  std::map<std::string, std::string> place_of;  // mesh -> where its landmarks came from
  std::vector<std::string> stray_files;
  std::vector<std::string> stray_rows;
  for (const ReadLandmarkSet& set : sets) {
    const std::vector<std::string> found = finder.Find(set);
    if (found.empty()) {
      (set.mesh.empty() ? stray_files : stray_rows).push_back(PlaceOf(set));
      continue;
    }
    if (found.size() > 1) {
      return absl::InvalidArgumentError(absl::StrCat(
          "landmarks: ", PlaceOf(set), " could belong to any of ", Some(found),
          "; write the whole file name into a table with the columns file, landmark, x, y, z"));
    }
    const auto [place, is_new] = place_of.emplace(found.front(), PlaceOf(set));
    if (!is_new) {
      return absl::InvalidArgumentError(absl::StrCat("landmarks: mesh ", found.front(),
                                                     " has them twice: in ", place->second, " and ",
                                                     PlaceOf(set)));
    }
    table[found.front()] = set.landmarks;
  }
  COHORT_RETURN_IF_ERROR(CheckAllMatched(meshes, table, stray_files, stray_rows));
  return table;
}

absl::Status CheckCommonLandmarks(const LandmarkTable& table, const std::string& base) {
  const auto base_entry = table.find(base);
  std::vector<std::string> too_few;
  for (const auto& [mesh, landmarks] : table) {
    const Shared shared =
        CompareNames(landmarks, base_entry == table.end() ? landmarks : base_entry->second);
    if (shared.common.size() < kNeeded) {
      too_few.push_back(absl::StrCat(
          mesh, " has ", shared.common.size(),
          shared.missing.empty() ? "" : absl::StrCat(" (without ", Some(shared.missing), ")")));
    }
  }
  if (too_few.empty()) {
    return absl::OkStatus();
  }
  return absl::InvalidArgumentError(
      absl::StrCat("landmarks: ", kNeeded, " are needed",
                   base.empty() ? "" : absl::StrCat(" in common with the base mesh ", base), ": ",
                   Some(too_few)));
}

absl::StatusOr<std::string> MakeLandmarkBlob(std::span<const std::string> paths,
                                             std::span<const std::string> meshes,
                                             JobSpec& spec) {
  COHORT_ASSIGN_OR_RETURN(const std::vector<ReadLandmarkSet> sets, ReadLandmarkFiles(paths));
  COHORT_ASSIGN_OR_RETURN(const LandmarkTable table, MatchLandmarks(sets, meshes));
  std::string base = spec.base;
  if (base.empty() && spec.base_rule == BaseRule::kGiven && !meshes.empty()) {
    base = meshes.front();
  }
  COHORT_RETURN_IF_ERROR(CheckCommonLandmarks(table, base));
  std::string blob = EncodeLandmarkBlob(table);
  spec.landmarks = Sha256::Of(blob);
  return blob;
}

}  // namespace cohort
