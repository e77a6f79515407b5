#include "client/name_pattern.h"

#include <algorithm>

#include <absl/strings/str_cat.h>

namespace cohort {

absl::StatusOr<NamePattern> NamePattern::Create(std::string_view pattern) {
  const auto refused = [&](const std::string& reason) {
    return absl::InvalidArgumentError(absl::StrCat("pattern '", std::string(pattern), "': ", reason,
                                                   "; expected e.g. {person}_{session}"));
  };
  NamePattern parsed;
  std::string_view rest = pattern;
  for (size_t open = rest.find('{'); open != std::string_view::npos; open = rest.find('{')) {
    const size_t close = rest.find('}', open);
    if (close == std::string_view::npos) {
      return refused("a brace is not closed");
    }
    const std::string label(rest.substr(open + 1, close - open - 1));
    if (label.empty() || label.find('{') != std::string::npos ||
        std::find(parsed.labels_.begin(), parsed.labels_.end(), label) != parsed.labels_.end()) {
      return refused("labels must have names, each another one");
    }
    if (open == 0 && !parsed.labels_.empty()) {
      return refused("there must be text between two labels");
    }
    parsed.texts_.emplace_back(rest.substr(0, open));
    parsed.labels_.push_back(label);
    rest.remove_prefix(close + 1);
  }
  parsed.texts_.emplace_back(rest);
  if (parsed.labels_.empty()) {
    return refused("it has no label");
  }
  const auto has_brace = [](const std::string& text) {
    return text.find('}') != std::string::npos;
  };
  if (std::any_of(parsed.texts_.begin(), parsed.texts_.end(), has_brace)) {
    return refused("a brace is not opened");
  }
  return parsed;
}

std::optional<std::map<std::string, std::string>> NamePattern::Match(std::string_view name) const {
  std::string_view rest = name.substr(0, name.rfind('.'));
  if (!rest.starts_with(texts_.front())) {
    return std::nullopt;
  }
  rest.remove_prefix(texts_.front().size());
  std::map<std::string, std::string> labels;
  for (size_t i = 0; i < labels_.size(); ++i) {
    const std::string& after = texts_[i + 1];
    const bool is_last = i + 1 == labels_.size();
    // The last text must end the name; any other ends the label where it is found first.
    const bool ends = is_last && rest.ends_with(after);
    const size_t end = ends      ? rest.size() - after.size()
                       : is_last ? std::string_view::npos
                                 : rest.find(after, 1);
    if (end == std::string_view::npos || end == 0) {
      return std::nullopt;
    }
    labels[labels_[i]] = std::string(rest.substr(0, end));
    rest.remove_prefix(end + after.size());
  }
  return labels;
}

}  // namespace cohort
