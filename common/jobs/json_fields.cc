#include "common/jobs/json_fields.h"

#include <algorithm>
#include <limits>
#include <utility>

#include <absl/strings/escaping.h>
#include <absl/strings/str_cat.h>

namespace cohort {
namespace {

using nlohmann::json;

constexpr size_t kShownBytes = 60;

/// What was found, short enough for a message; never throws, whatever bytes strings hold.
std::string Shown(const json& found) {
  std::string text = found.dump(-1, ' ', /*ensure_ascii=*/true, json::error_handler_t::replace);
  if (text.size() > kShownBytes) {
    text.resize(kShownBytes);
    text += "...";
  }
  return text;
}

}  // namespace

JsonFields::JsonFields(const json& json, std::string path, absl::StatusCode code, Presence presence)
    : json_(json), path_(std::move(path)), code_(code), presence_(presence) {
  if (!json_.is_object()) {
    status_ = absl::Status(code_, absl::StrCat(path_, ": expected an object, not ", Shown(json_)));
  }
}

void JsonFields::Read(std::string_view key, bool& value) {
  const json* found = Find(key);
  if (found == nullptr) {
    return;
  }
  if (!found->is_boolean()) {
    return Expected(key, "true or false", *found);
  }
  value = found->get<bool>();
}

void JsonFields::Read(std::string_view key, int32_t& value) {
  int64_t wide = value;
  ReadInteger(key, std::numeric_limits<int32_t>::min(), std::numeric_limits<int32_t>::max(), wide);
  value = static_cast<int32_t>(wide);
}

void JsonFields::Read(std::string_view key, int64_t& value) {
  ReadInteger(key, std::numeric_limits<int64_t>::min(), std::numeric_limits<int64_t>::max(), value);
}

void JsonFields::ReadInteger(std::string_view key, int64_t low, int64_t high, int64_t& value) {
  const json* found = Find(key);
  if (found == nullptr) {
    return;
  }
  if (!found->is_number_integer()) {
    return Expected(key, "an integer", *found);
  }
  const bool above_int64 =
      found->is_number_unsigned() &&
      found->get<uint64_t>() > static_cast<uint64_t>(std::numeric_limits<int64_t>::max());
  if (above_int64 || found->get<int64_t>() < low || found->get<int64_t>() > high) {
    return Expected(key, absl::StrCat("an integer from ", low, " to ", high), *found);
  }
  value = found->get<int64_t>();
}

void JsonFields::Read(std::string_view key, double& value) {
  const json* found = Find(key);
  if (found == nullptr) {
    return;
  }
  if (!found->is_number()) {
    return Expected(key, "a number", *found);
  }
  value = found->get<double>();
}

void JsonFields::Read(std::string_view key, std::string& value) {
  const json* found = Find(key);
  if (found == nullptr) {
    return;
  }
  if (!found->is_string()) {
    return Expected(key, "a string", *found);
  }
  value = found->get_ref<const std::string&>();
}

void JsonFields::ReadBase64(std::string_view key, std::string& bytes) {
  const json* found = Find(key);
  if (found == nullptr) {
    return;
  }
  if (!found->is_string() || !absl::Base64Unescape(found->get_ref<const std::string&>(), &bytes)) {
    Expected(key, "base64", *found);
  }
}

void JsonFields::Read(std::string_view key, Digest& value) {
  const json* found = Find(key);
  if (found == nullptr) {
    return;
  }
  if (!found->is_string()) {
    return Expected(key, "a digest", *found);
  }
  const std::string& hex = found->get_ref<const std::string&>();
  if (hex.empty()) {
    value = Digest();
    return;
  }
  absl::StatusOr<Digest> digest = Digest::FromHex(hex);
  if (!digest.ok()) {
    return Expected(key, "a digest", *found);
  }
  value = *std::move(digest);
}

void JsonFields::Read(std::string_view key, std::array<double, 3>& value) {
  const json* found = Find(key);
  if (found == nullptr) {
    return;
  }
  const bool three_numbers =
      found->is_array() && found->size() == value.size() &&
      std::all_of(found->begin(), found->end(), [](const json& item) { return item.is_number(); });
  if (!three_numbers) {
    return Expected(key, "three numbers", *found);
  }
  for (size_t i = 0; i < value.size(); ++i) {
    value[i] = (*found)[i].get<double>();
  }
}

void JsonFields::Read(std::string_view key, std::vector<Digest>& value) {
  std::vector<std::string> names;
  Read(key, names);
  std::vector<Digest> digests;
  for (const std::string& hex : names) {
    absl::StatusOr<Digest> digest = Digest::FromHex(hex);
    if (!digest.ok()) {
      return Expected(key, "digests", json(hex));
    }
    digests.push_back(*std::move(digest));
  }
  if (status_.ok()) {
    value = std::move(digests);
  }
}

void JsonFields::Read(std::string_view key, std::vector<std::string>& value) {
  const json* found = Find(key);
  if (found == nullptr) {
    return;
  }
  const bool all_strings =
      found->is_array() &&
      std::all_of(found->begin(), found->end(), [](const json& item) { return item.is_string(); });
  if (!all_strings) {
    return Expected(key, "an array of strings", *found);
  }
  value = found->get<std::vector<std::string>>();
}

void JsonFields::Read(std::string_view key, std::vector<int32_t>& value) {
  const json* found = Find(key);
  if (found == nullptr) {
    return;
  }
  const bool all_integers =
      found->is_array() && std::all_of(found->begin(), found->end(), [](const json& item) {
        return item.is_number_integer() && item >= std::numeric_limits<int32_t>::min() &&
               item <= std::numeric_limits<int32_t>::max();
      });
  if (!all_integers) {
    return Expected(key, "an array of integers", *found);
  }
  value = found->get<std::vector<int32_t>>();
}

void JsonFields::ReadObject(std::string_view key, const std::function<void(JsonFields&)>& read) {
  if (const json* found = Find(key)) {
    ReadNested(key, *found, read);
  }
}

void JsonFields::ReadObjects(std::string_view key, const std::function<void(JsonFields&)>& read) {
  const json* found = Find(key);
  if (found == nullptr) {
    return;
  }
  if (!found->is_array()) {
    return Expected(key, "an array", *found);
  }
  for (size_t i = 0; i < found->size() && status_.ok(); ++i) {
    ReadNested(absl::StrCat(std::string(key), "[", i, "]"), (*found)[i], read);
  }
}

void JsonFields::ReadNested(std::string_view key,
                            const json& json,
                            const std::function<void(JsonFields&)>& read) {
  JsonFields fields(json, absl::StrCat(path_, ".", std::string(key)), code_, presence_);
  read(fields);
  status_ = fields.Finish();
}

absl::Status JsonFields::Finish() {
  if (!status_.ok()) {
    return status_;
  }
  for (const auto& [key, value] : json_.items()) {
    if (std::find(known_.begin(), known_.end(), key) == known_.end()) {
      Refuse(key, "unknown field");
      break;
    }
  }
  return status_;
}

const json* JsonFields::Find(std::string_view key) {
  if (!status_.ok()) {
    return nullptr;
  }
  known_.emplace_back(key);
  const auto found = json_.find(known_.back());
  if (found != json_.end()) {
    return &*found;
  }
  if (presence_ == Presence::kRequired) {
    Refuse(key, "missing");
  }
  return nullptr;
}

void JsonFields::Refuse(std::string_view key, const std::string& problem) {
  if (status_.ok()) {
    status_ = absl::Status(code_, absl::StrCat(path_, ".", std::string(key), ": ", problem));
  }
}

void JsonFields::Expected(std::string_view key, std::string_view what, const json& found) {
  Refuse(key, absl::StrCat("expected ", std::string(what), ", not ", Shown(found)));
}

}  // namespace cohort
