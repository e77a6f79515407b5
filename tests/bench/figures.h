#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace cohort {

/// What issue 3 demands of a figure.
struct Goal {
  enum class Kind { kNone, kAtLeast, kAtMost };
  Kind kind = Kind::kNone;
  double value = 0;
};
[[nodiscard]] inline Goal AtLeast(double value) {
  return {Goal::Kind::kAtLeast, value};
}
[[nodiscard]] inline Goal AtMost(double value) {
  return {Goal::Kind::kAtMost, value};
}

/// A row of the table.
struct Figure {
  std::string name;  ///< "all nearest neighbours, AVX-512, 10k".
  Goal goal;
  std::optional<double> value;  ///< Empty: could not be measured here.
  std::string unit;             ///< Behind value and goal: " x", " mm", "".
  std::string note;             ///< The times behind a ratio, or why there is no value.

  [[nodiscard]] bool FallsShort() const;
};

/// One cell of the table of times.
struct RivalTime {
  std::string rival;   ///< Row; "Cohort" for ours.
  std::string column;  ///< "vertex, 10k".
  double nanoseconds = 0;
  double ratio = 0;  ///< Of this time to Cohort's.
};

/// What a run found out. Not thread-safe.
class FigureTable {
 public:
  void Add(Figure figure) { figures_.push_back(std::move(figure)); }
  void Add(RivalTime time) { rivals_.push_back(std::move(time)); }

  [[nodiscard]] bool IsEmpty() const { return figures_.empty(); }
  /// The figures with goal and verdict, then the times of all candidates: two Markdown tables.
  [[nodiscard]] std::string Markdown() const;
  /// One line for each row that was measured and falls short.
  [[nodiscard]] std::vector<std::string> Shortfalls() const;

 private:
  [[nodiscard]] std::string RivalMarkdown() const;

  std::vector<Figure> figures_;
  std::vector<RivalTime> rivals_;
};

/// Three significant digits, no exponent where it can be avoided: "14.2", "0.41", "205", "3e-07".
[[nodiscard]] std::string Digits(double value);

}  // namespace cohort
