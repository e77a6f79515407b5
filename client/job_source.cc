#include "client/job_source.h"

#include <filesystem>

#include <absl/strings/str_cat.h>
#include <nlohmann/json.hpp>

#include "client/files.h"
#include "common/base/status_macros.h"
#include "common/store/directory_blob_store.h"

namespace cohort {
namespace {

constexpr double kStartSeconds = 30;
constexpr char kDataFolder[] = ".cohort-data";

absl::StatusOr<JobId> JobOfFolder(const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "job.json";
  COHORT_ASSIGN_OR_RETURN(const std::string text, ReadWholeFile(file));
  const auto json = nlohmann::json::parse(text, nullptr, /*allow_exceptions=*/false);
  if (!json.is_object() || !json.contains("job") || !json["job"].is_string()) {
    return absl::InvalidArgumentError(file.string() + ": expected the job.json of `cohort run`");
  }
  return JobId{json["job"].get<std::string>()};
}

absl::StatusOr<OpenedJob> OpenFolder(const std::filesystem::path& folder) {
  const std::filesystem::path data = folder / kDataFolder;
  if (!std::filesystem::is_directory(data)) {
    return absl::FailedPreconditionError(
        absl::StrCat(folder.string(), " has no ", kDataFolder,
                     ": only results of `cohort run --keep-data` can be worked with further; run "
                     "it so, or give the id of a job on a server"));
  }
  OpenedJob opened;
  COHORT_ASSIGN_OR_RETURN(opened.id, JobOfFolder(folder));
  COHORT_ASSIGN_OR_RETURN(opened.cluster, LocalCluster::Start({.data_dir = data, .workers = 0}));
  COHORT_ASSIGN_OR_RETURN(opened.session, Session::Open(opened.cluster->Address()));
  COHORT_RETURN_IF_ERROR(opened.session->WaitUntilReady(kStartSeconds));
  COHORT_ASSIGN_OR_RETURN(opened.store, DirectoryBlobStore::Create(data / "blobs"));
  return opened;
}

}  // namespace

void JobSource::AddTo(CLI::App& command) {
  server.AddTo(command);
  command
      .add_option("job", job,
                  "job id, e.g. j-000001, or the folder of results of cohort run --keep-data")
      ->required();
}

absl::StatusOr<OpenedJob> JobSource::Open() const {
  if (std::filesystem::is_directory(job)) {
    return OpenFolder(job);
  }
  OpenedJob opened;
  opened.id = JobId{job};
  COHORT_ASSIGN_OR_RETURN(opened.session, server.Connect());
  return opened;
}

}  // namespace cohort
