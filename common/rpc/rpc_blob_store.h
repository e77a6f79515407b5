#pragma once

#include <memory>
#include <string>

#include <grpcpp/channel.h>

#include "common/store/blob_store.h"

namespace cohort {

/// The server's blob store, over BlobService: for workers and clients that do not see its disk.
/// What is read is checked against the digest on this side.
class RpcBlobStore final : public BlobStore {
 public:
  /// @param peer  the channel's address, for messages.
  RpcBlobStore(std::shared_ptr<grpc::Channel> channel, std::string peer);

  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobWriter>> StartPut() override;
  [[nodiscard]] absl::StatusOr<std::unique_ptr<BlobReader>> Open(const Digest& digest) override;
  [[nodiscard]] absl::StatusOr<bool> Contains(const Digest& digest) override;

 private:
  std::shared_ptr<grpc::Channel> channel_;
  std::string peer_;
};

}  // namespace cohort
