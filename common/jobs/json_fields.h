#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/status.h>
#include <nlohmann/json.hpp>

#include "common/base/sha256.h"

namespace cohort {

/// What a field that is not there means.
enum class Presence { kRequired, kOptional };

/// Reads the fields of one JSON object without trusting any of it. The first problem is kept and
/// names the field ("task result.counters.pairs: expected an integer, not \"7\""); reads after it
/// do nothing. An optional field that is missing leaves its variable as it was.
/// Not thread-safe. The JSON must outlive it.
class JsonFields {
 public:
  /// @param path  names the object in messages.
  /// @param code  of every error.
  JsonFields(const nlohmann::json& json,
             std::string path,
             absl::StatusCode code,
             Presence presence);

  void Read(std::string_view key, bool& value);
  void Read(std::string_view key, int32_t& value);
  void Read(std::string_view key, int64_t& value);
  void Read(std::string_view key, double& value);
  void Read(std::string_view key, std::string& value);
  /// Bytes that stand there as base64, RFC 4648 section 4.
  void ReadBase64(std::string_view key, std::string& bytes);
  /// The empty string is the empty digest.
  void Read(std::string_view key, Digest& value);
  void Read(std::string_view key, std::array<double, 3>& value);
  void Read(std::string_view key, std::vector<Digest>& value);
  void Read(std::string_view key, std::vector<std::string>& value);
  void Read(std::string_view key, std::vector<int32_t>& value);

  /// Reads an enumerator by its name.
  template <typename T>
  void ReadName(std::string_view key, std::optional<T> (*from_name)(std::string_view), T& value) {
    std::string name;
    if (!Find(key)) {
      return;
    }
    Read(key, name);
    if (!status_.ok()) {
      return;
    }
    if (const std::optional<T> found = from_name(name)) {
      value = *found;
    } else {
      Refuse(key, "unknown name \"" + name + "\"");
    }
  }
  /// Reads an object with the same rules.
  void ReadObject(std::string_view key, const std::function<void(JsonFields&)>& read);
  /// Reads an array of objects; `read` is called once for each, in order.
  void ReadObjects(std::string_view key, const std::function<void(JsonFields&)>& read);

  /// @return the first problem; else, an error if the object has a field that was never read.
  [[nodiscard]] absl::Status Finish();

 private:
  /// Null if the field is not there or a problem was found before.
  [[nodiscard]] const nlohmann::json* Find(std::string_view key);
  void Refuse(std::string_view key, const std::string& problem);
  void Expected(std::string_view key, std::string_view what, const nlohmann::json& found);
  void ReadInteger(std::string_view key, int64_t low, int64_t high, int64_t& value);
  void ReadNested(std::string_view key,
                  const nlohmann::json& json,
                  const std::function<void(JsonFields&)>& read);

  const nlohmann::json& json_;
  std::string path_;
  absl::StatusCode code_;
  Presence presence_;
  absl::Status status_;
  std::vector<std::string> known_;
};

}  // namespace cohort
