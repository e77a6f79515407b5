#include "common/analysis/clustering.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <charconv>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include <absl/strings/str_cat.h>

#include "common/analysis/distances.h"
#include "common/base/status_macros.h"

namespace cohort {
namespace {

constexpr std::array<std::pair<Linkage, std::string_view>, 4> kNames = {
    {{Linkage::kAverage, "average"},
     {Linkage::kComplete, "complete"},
     {Linkage::kSingle, "single"},
     {Linkage::kWard, "ward"}}};

/// Distance of a third cluster from the union of x and y (Lance, Williams 1967). Ward's distances
/// are squared ones.
double UnionDistance(
    Linkage linkage, double to_x, double to_y, double x_to_y, const std::array<double, 3>& sizes) {
  const auto [third, x, y] = sizes;
  switch (linkage) {
    case Linkage::kAverage:
      return (x * to_x + y * to_y) / (x + y);
    case Linkage::kComplete:
      return std::max(to_x, to_y);
    case Linkage::kSingle:
      return std::min(to_x, to_y);
    case Linkage::kWard:
      return ((third + x) * to_x + (third + y) * to_y - third * x_to_y) / (third + x + y);
  }
  assert(false);
  return 0;
}

/// Two clusters, each by its lowest mesh.
struct FoundMerge {
  int64_t low = 0;
  int64_t high = 0;
  double height = 0;
};

/// Clusters that may still merge, each in the row and column of its lowest mesh.
class NeighbourChain {
 public:
  NeighbourChain(const MatrixView& distances, Linkage linkage)
      : copy_(distances),
        distances_(copy_.Values()),
        linkage_(linkage),
        sizes_(static_cast<size_t>(distances_.rows()), 1),
        heights_(sizes_.size(), 0) {
    // Both values of a pair the same to the last bit, or a chain could go round for ever.
    for (Eigen::Index row = 0; row < distances_.rows(); ++row) {
      for (Eigen::Index column = 0; column < row; ++column) {
        const double value = distances_(row, column);
        distances_(row, column) = linkage_ == Linkage::kWard ? value * value : value;
        distances_(column, row) = distances_(row, column);
      }
    }
  }

  /// In the order found, which is not that of their heights.
  std::vector<FoundMerge> FindMerges() {
    std::vector<FoundMerge> merges;
    std::vector<int64_t> chain;
    while (merges.size() + 1 < sizes_.size()) {
      if (chain.empty()) {
        chain.push_back(FirstActive());
      }
      const int64_t before = chain.size() > 1 ? chain[chain.size() - 2] : -1;
      const int64_t nearest = Nearest(chain.back(), before);
      if (nearest != before) {
        chain.push_back(nearest);
        continue;
      }
      // Each is the other's nearest: no later merge can come between them.
      const auto [low, high] = std::minmax(chain.back(), before);
      merges.push_back(Unite(low, high));
      chain.resize(chain.size() - 2);
    }
    return merges;
  }

 private:
  [[nodiscard]] int64_t FirstActive() const {
    return std::find_if(sizes_.begin(), sizes_.end(), [](double size) { return size > 0; }) -
           sizes_.begin();
  }

  [[nodiscard]] int64_t Nearest(int64_t cluster, int64_t preferred) const {
    int64_t nearest = preferred;
    double least =
        preferred < 0 ? std::numeric_limits<double>::infinity() : distances_(cluster, preferred);
    for (int64_t other = 0; other < std::ssize(sizes_); ++other) {
      if (other != cluster && sizes_[static_cast<size_t>(other)] > 0 &&
          (distances_(cluster, other) < least || nearest < 0)) {
        least = distances_(cluster, other);
        nearest = other;
      }
    }
    return nearest;
  }

  FoundMerge Unite(int64_t low, int64_t high) {
    const auto x = static_cast<size_t>(low);
    const auto y = static_cast<size_t>(high);
    const double distance = distances_(low, high);
    for (size_t other = 0; other < sizes_.size(); ++other) {
      if (sizes_[other] > 0 && other != x && other != y) {
        const auto third = static_cast<Eigen::Index>(other);
        distances_(low, third) =
            UnionDistance(linkage_, distances_(low, third), distances_(high, third), distance,
                          {sizes_[other], sizes_[x], sizes_[y]});
        distances_(third, low) = distances_(low, third);
      }
    }
    sizes_[x] += sizes_[y];
    sizes_[y] = 0;
    // Rounding must not put a merge below those it is made of.
    const double height = linkage_ == Linkage::kWard ? std::sqrt(distance) : distance;
    heights_[x] = std::max({height, heights_[x], heights_[y]});
    return {low, high, heights_[x]};
  }

  LargeMatrix copy_;
  Eigen::Map<RowMajorMatrix> distances_;
  Linkage linkage_;
  std::vector<double> sizes_;    ///< Meshes by lowest mesh; 0: merged into another.
  std::vector<double> heights_;  ///< Of the merge that made the cluster.
};

/// By height, with the numbers of clusters in place of their lowest meshes.
std::vector<Merge> NumberMerges(std::vector<FoundMerge> found) {
  std::stable_sort(found.begin(), found.end(),
                   [](const FoundMerge& a, const FoundMerge& b) { return a.height < b.height; });
  const size_t count = found.size() + 1;
  std::vector<int64_t> number(count);  // Of the cluster whose lowest mesh it is.
  std::iota(number.begin(), number.end(), int64_t{0});
  std::vector<int64_t> size(count, 1);
  std::vector<Merge> merges;
  merges.reserve(found.size());
  for (const FoundMerge& merge : found) {
    const auto low = static_cast<size_t>(merge.low);
    const auto high = static_cast<size_t>(merge.high);
    const auto [left, right] = std::minmax(number[low], number[high]);
    size[low] += size[high];
    merges.push_back({left, right, merge.height, size[low]});
    number[low] = static_cast<int64_t>(count + merges.size() - 1);
  }
  return merges;
}

/// No recursion, since a tree may be as deep as it has meshes.
std::vector<int64_t> LeavesInOrder(const std::vector<Merge>& merges) {
  const auto count = std::ssize(merges) + 1;
  std::vector<int64_t> order;
  order.reserve(static_cast<size_t>(count));
  std::vector<int64_t> waiting = {2 * count - 2};
  while (!waiting.empty()) {
    const int64_t cluster = waiting.back();
    waiting.pop_back();
    if (cluster < count) {
      order.push_back(cluster);
      continue;
    }
    const Merge& merge = merges[static_cast<size_t>(cluster - count)];
    waiting.push_back(merge.right);
    waiting.push_back(merge.left);
  }
  return order;
}

std::string ShortestText(double value) {
  std::array<char, 32> text{};
  return {text.data(), std::to_chars(text.data(), text.data() + text.size(), value).ptr};
}

std::string NewickLabel(std::string_view label) {
  std::string text(label);
  std::replace_if(
      text.begin(), text.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  if (!text.empty() && text.find_first_of(" \t()[]{}':;,\"") == std::string::npos) {
    return text;
  }
  std::string quoted = "'";
  for (const char c : text) {
    quoted.append(c == '\'' ? 2 : 1, c);
  }
  quoted.push_back('\'');
  return quoted;
}

}  // namespace

std::string_view LinkageName(Linkage linkage) {
  return kNames[static_cast<size_t>(linkage)].second;
}

std::optional<Linkage> LinkageFromName(std::string_view name) {
  for (const auto& [linkage, its_name] : kNames) {
    if (its_name == name) {
      return linkage;
    }
  }
  return std::nullopt;
}

absl::StatusOr<Dendrogram> ClusterMeshes(const MatrixView& distances, Linkage linkage) {
  COHORT_RETURN_IF_ERROR(RequireDissimilarities(distances, 2));
  COHORT_RETURN_IF_ERROR(RequireComplete(distances));
  Dendrogram dendrogram;
  dendrogram.merges = NumberMerges(NeighbourChain(distances, linkage).FindMerges());
  dendrogram.leaf_order = LeavesInOrder(dendrogram.merges);
  return dendrogram;
}

std::string NewickText(const Dendrogram& dendrogram, std::span<const std::string> labels) {
  const auto count = std::ssize(labels);
  assert(std::ssize(dendrogram.merges) + 1 == count);
  const auto height = [&](int64_t cluster) {
    return cluster < count ? 0 : dendrogram.merges[static_cast<size_t>(cluster - count)].height;
  };
  // A cluster to open, or (cluster < 0) what closes one that is open.
  struct Step {
    int64_t cluster;
    std::string after;
  };
  std::string text;
  std::vector<Step> steps = {{2 * count - 2, ";\n"}};
  while (!steps.empty()) {
    const Step step = std::move(steps.back());
    steps.pop_back();
    if (step.cluster < 0) {
      text += step.after;
    } else if (step.cluster < count) {
      absl::StrAppend(&text, NewickLabel(labels[static_cast<size_t>(step.cluster)]), step.after);
    } else {
      const Merge& merge = dendrogram.merges[static_cast<size_t>(step.cluster - count)];
      const auto branch = [&](int64_t child) {
        return absl::StrCat(":", ShortestText(0.5 * (merge.height - height(child))));
      };
      text += "(";
      steps.push_back({-1, absl::StrCat(")", step.after)});
      steps.push_back({merge.right, branch(merge.right)});
      steps.push_back({merge.left, absl::StrCat(branch(merge.left), ",")});
    }
  }
  return text;
}

std::vector<int64_t> CutDendrogram(const Dendrogram& dendrogram, int64_t count) {
  const auto meshes = std::ssize(dendrogram.leaf_order);
  assert(count >= 1 && count <= meshes);
  // Which merge, of those that are kept, each cluster goes into.
  std::vector<int64_t> parent(static_cast<size_t>(2 * meshes), -1);
  for (int64_t m = 0; m < meshes - count; ++m) {
    const Merge& merge = dendrogram.merges[static_cast<size_t>(m)];
    parent[static_cast<size_t>(merge.left)] = meshes + m;
    parent[static_cast<size_t>(merge.right)] = meshes + m;
  }
  // From the last merge down, each takes its parent's root: one step is enough.
  std::vector<int64_t> root(parent.size());
  for (int64_t cluster = 2 * meshes - 1; cluster >= 0; --cluster) {
    const int64_t above = parent[static_cast<size_t>(cluster)];
    root[static_cast<size_t>(cluster)] = above < 0 ? cluster : root[static_cast<size_t>(above)];
  }
  std::vector<int64_t> number(root.size(), -1);
  std::vector<int64_t> clusters;
  int64_t next = 0;
  for (int64_t mesh = 0; mesh < meshes; ++mesh) {
    int64_t& assigned = number[static_cast<size_t>(root[static_cast<size_t>(mesh)])];
    if (assigned < 0) {
      assigned = next++;
    }
    clusters.push_back(assigned);
  }
  return clusters;
}

}  // namespace cohort
