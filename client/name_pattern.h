#pragma once

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include <absl/status/statusor.h>

namespace cohort {

/// Labels that are in file names: "{person}_{session}" takes "anna_2016.ply" apart. Text outside of
/// braces must be there; each label is the shortest text, of one character at least, with which the
/// rest fits. The file's extension is not part of what is matched.
class NamePattern {
 public:
  /// @return kInvalidArgument if there is no label, one is empty or twice, a brace has no partner,
  ///         or two labels have nothing between them.
  [[nodiscard]] static absl::StatusOr<NamePattern> Create(std::string_view pattern);

  /// The labels of a name; empty if it does not fit.
  [[nodiscard]] std::optional<std::map<std::string, std::string>> Match(
      std::string_view name) const;

 private:
  NamePattern() = default;

  /// One more than labels: texts_[i] comes before label i, the last one ends the name.
  std::vector<std::string> texts_;
  std::vector<std::string> labels_;
};

}  // namespace cohort
