#include "server/catalog/page_token.h"

#include <absl/strings/escaping.h>

namespace cohort {

std::string MakePageToken(Listing listing, std::string_view key) {
  std::string text(1, static_cast<char>(listing));
  text.append(key);
  return absl::WebSafeBase64Escape(text);
}

absl::StatusOr<std::string> ReadPageToken(Listing listing, const std::string& token) {
  if (token.empty()) {
    return std::string();
  }
  std::string text;
  if (!absl::WebSafeBase64Unescape(token, &text) || text.size() < 2 ||
      text[0] != static_cast<char>(listing)) {
    return absl::InvalidArgumentError("page token '" + token.substr(0, 80) +
                                      "' is not one of this listing");
  }
  return text.substr(1);
}

absl::Status CheckPageSize(int page_size) {
  if (page_size < 1) {
    return absl::InvalidArgumentError("page size " + std::to_string(page_size) +
                                      ": expected at least 1");
  }
  return absl::OkStatus();
}

}  // namespace cohort
