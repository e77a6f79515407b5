#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/status.h>
#include <absl/strings/str_cat.h>

#include "common/base/byte_io.h"
#include "common/base/status_macros.h"

namespace cohort {

/// A blob of a known kind being read: each step says what is wrong with the bytes.
class BlobDecoder {
 public:
  BlobDecoder(std::string_view kind, std::string_view bytes)
      : kind_(kind), size_(bytes.size()), reader_(bytes) {}

  [[nodiscard]] absl::Status Start(std::string_view magic) {
    if (!reader_.Rest().starts_with(magic)) {
      return Damaged(absl::StrCat("does not begin with ", std::string(magic)));
    }
    reader_ = ByteReader(reader_.Rest().substr(magic.size()));
    return absl::OkStatus();
  }
  template <typename T>
  [[nodiscard]] absl::Status Get(std::string_view what, T& value) {
    return reader_.Get(value) ? absl::OkStatus() : CutShort(what);
  }
  /// A 64-bit length and the bytes.
  [[nodiscard]] absl::Status GetString(std::string_view what, std::string& text) {
    return reader_.GetString(text) ? absl::OkStatus() : CutShort(what);
  }
  template <typename T>
  [[nodiscard]] absl::Status GetArray(std::string_view what, std::span<T> values) {
    return reader_.GetArray(values) ? absl::OkStatus() : CutShort(what);
  }
  /// A count of things of `item_bytes` each, all of which must still be there: no memory is taken
  /// for a count that the bytes cannot hold.
  [[nodiscard]] absl::Status GetCount(std::string_view what, uint64_t item_bytes, uint64_t& count) {
    COHORT_RETURN_IF_ERROR(Get(what, count));
    return CheckRoom(what, count, item_bytes);
  }
  [[nodiscard]] absl::Status CheckRoom(std::string_view what, uint64_t count, uint64_t item_bytes) {
    if (item_bytes != 0 && count > reader_.Remaining() / item_bytes) {
      return Damaged(absl::StrCat("announces ", count, " ", std::string(what), " in the last ",
                                  reader_.Remaining(), " bytes"));
    }
    return absl::OkStatus();
  }
  /// `count` mesh indices, none of them negative.
  [[nodiscard]] absl::Status GetIndices(uint64_t count, std::vector<int32_t>& indices) {
    COHORT_RETURN_IF_ERROR(CheckRoom("mesh indices", count, sizeof(int32_t)));
    indices.resize(count);
    COHORT_RETURN_IF_ERROR(GetArray<int32_t>("mesh indices", indices));
    for (const int32_t index : indices) {
      if (index < 0) {
        return Damaged(absl::StrCat("mesh index is ", index));
      }
    }
    return absl::OkStatus();
  }
  [[nodiscard]] absl::Status Finish() const {
    if (reader_.Remaining() != 0) {
      return Damaged(absl::StrCat(reader_.Remaining(), " bytes too many"));
    }
    return absl::OkStatus();
  }
  [[nodiscard]] absl::Status Damaged(std::string_view problem) const {
    return absl::DataLossError(
        absl::StrCat(std::string(kind_), " blob of ", size_, " bytes: ", std::string(problem)));
  }

 private:
  [[nodiscard]] absl::Status CutShort(std::string_view what) const {
    return Damaged(absl::StrCat("cut short in ", std::string(what)));
  }

  std::string_view kind_;
  size_t size_;
  ByteReader reader_;
};

}  // namespace cohort
