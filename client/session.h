#pragma once

#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include <absl/status/statusor.h>
#include <grpcpp/channel.h>

#include "cohort/v1/admin_service.grpc.pb.h"
#include "cohort/v1/job_service.grpc.pb.h"
#include "cohort/v1/mesh_service.grpc.pb.h"
#include "cohort/v1/result_service.grpc.pb.h"
#include "common/analysis/metric_matrix.h"
#include "common/jobs/estimate.h"
#include "common/jobs/job_state.h"
#include "common/jobs/worker_status.h"
#include "common/rpc/rpc_blob_store.h"

namespace cohort {

/// Values of rows x columns of a matrix, row by row; both are indices of the job's meshes.
struct MatrixPart {
  std::span<const int32_t> rows;
  std::span<const int32_t> columns;
  std::span<const double> values;
};
using MatrixTaker = std::function<absl::Status(const MatrixPart&)>;

/// A client's connection to a server: one method per call, plain types, a deadline each. An
/// unreachable server is kUnavailable and names the address. Not thread-safe.
class Session {
 public:
  static constexpr double kUploadPatienceSeconds = 120;

  /// @param address  HOST:PORT or unix:PATH.
  [[nodiscard]] static absl::StatusOr<std::unique_ptr<Session>> Open(const std::string& address);

  /// Waits until the server answers. @return kUnavailable after `seconds`.
  [[nodiscard]] absl::Status WaitUntilReady(double seconds);

  [[nodiscard]] absl::StatusOr<std::vector<Digest>> FindMissing(const std::vector<Digest>& digests);
  /// @param path  file to send; empty: the server has the bytes.
  [[nodiscard]] absl::Status AddMesh(const std::string& set,
                                     const SetMesh& mesh,
                                     const std::string& path);
  /// Sends the bytes of a mesh file. Goes on where it was when the connection breaks or the server
  /// is started again, as long as it gets on at least once in `patience_seconds`.
  /// @return kUnavailable after that; kDataLoss if the file no longer has the mesh's digest.
  [[nodiscard]] absl::Status UploadFile(const SetMesh& mesh,
                                        const std::string& path,
                                        double patience_seconds = kUploadPatienceSeconds);
  /// Has the server remove blobs that nothing needs; empty options: as the server was started.
  [[nodiscard]] absl::StatusOr<v1::CollectGarbageResponse> CollectGarbage(
      std::optional<double> age_hours, std::optional<double> remember_days);
  /// Makes a call that may be repeated until the server answers it.
  /// @return kUnavailable after `patience_seconds`.
  [[nodiscard]] absl::Status Persist(const std::function<absl::Status()>& call,
                                     double patience_seconds = kUploadPatienceSeconds);
  [[nodiscard]] absl::StatusOr<std::vector<SetMesh>> ListMeshes(const std::string& set);
  [[nodiscard]] absl::Status RemoveMesh(const std::string& set, const std::string& name);
  [[nodiscard]] absl::Status DeleteSet(const std::string& set);
  /// By name.
  [[nodiscard]] absl::StatusOr<std::vector<WorkerStatus>> ListWorkers();

  [[nodiscard]] absl::StatusOr<Job> CreateJob(const std::string& set,
                                              const JobSpec& spec,
                                              const std::string& request_id);
  /// What such a job would take.
  [[nodiscard]] absl::StatusOr<Estimate> EstimateJob(const std::string& set, const JobSpec& spec);
  [[nodiscard]] absl::StatusOr<Job> GetJob(const JobId& id);
  /// Newest first, at most `limit`.
  [[nodiscard]] absl::StatusOr<std::vector<Job>> ListJobs(int limit);
  [[nodiscard]] absl::StatusOr<Job> CancelJob(const JobId& id);
  [[nodiscard]] absl::StatusOr<Job> PauseJob(const JobId& id);
  [[nodiscard]] absl::StatusOr<Job> ResumeJob(const JobId& id);
  [[nodiscard]] absl::StatusOr<Job> RetryJob(const JobId& id);
  [[nodiscard]] absl::Status DeleteJob(const JobId& id);
  /// Calls `on_change` with the job now and after every change until it has ended or `on_change`
  /// returns false. Reconnects and goes on where it was when the stream breaks.
  /// @return the last state; kUnavailable when the server stays away for a minute.
  [[nodiscard]] absl::StatusOr<Job> WatchJob(const JobId& id,
                                             const std::function<bool(const Job&)>& on_change);

  [[nodiscard]] absl::StatusOr<std::vector<JobMesh>> ListJobMeshes(const JobId& id);
  [[nodiscard]] absl::StatusOr<JobOutputs> GetOutputs(const JobId& id);
  /// Directed values, part by part as they come. Ends with the first error of `take`.
  [[nodiscard]] absl::Status ReadMatrix(const JobId& id, Metric metric, const MatrixTaker& take);
  /// The preview, undirected: a part of two different sets of meshes stands for its transpose too.
  /// @return kFailedPrecondition if there is none (yet).
  [[nodiscard]] absl::Status ReadPreview(const JobId& id, const MatrixTaker& take);
  /// Writes the blob unless the server has it.
  [[nodiscard]] absl::Status SendBlob(const std::string& bytes);
  [[nodiscard]] BlobStore& Blobs() { return blobs_; }
  [[nodiscard]] const std::string& Address() const { return address_; }

 private:
  Session(std::shared_ptr<grpc::Channel> channel, const std::string& address);
  /// What the server has of a file; -1: all of it.
  absl::StatusOr<int64_t> UploadedBytes(const SetMesh& mesh);
  /// One connection's part of UploadFile.
  absl::Status UploadFrom(int64_t offset, const SetMesh& mesh, const std::string& path);
  /// One stream until it breaks; `last` is the newest state seen.
  absl::Status WatchOnce(const JobId& id,
                         const std::function<bool(const Job&)>& on_change,
                         Job& last,
                         bool& wanted);

  std::string address_;
  std::shared_ptr<grpc::Channel> channel_;
  std::unique_ptr<v1::MeshService::Stub> meshes_;
  std::unique_ptr<v1::JobService::Stub> jobs_;
  std::unique_ptr<v1::ResultService::Stub> results_;
  std::unique_ptr<v1::AdminService::Stub> admin_;
  RpcBlobStore blobs_;
};

}  // namespace cohort
