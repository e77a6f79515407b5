#include <algorithm>
#include <array>

#include "common/report/axis_ticks.h"
#include "common/report/decimal.h"
#include "common/report/plot_style.h"
#include "common/report/plot_text.h"
#include "common/report/plots/plots.h"

namespace cohort {
namespace {

// Lengths in points.
constexpr double kLeft = 16;
constexpr double kTop = 14;
constexpr double kTreeWidth = 640;
constexpr double kLabelWidth = 230;
constexpr double kSwatch = 8;
constexpr double kBelow = 50;
constexpr size_t kMostNamed = 250;
constexpr double kMaxHeight = 4000;  // Of trees whose leaves have no names.
constexpr Rgb kBranchColor = {70, 70, 70};
constexpr Rgb kGridColor = {230, 230, 230};

struct Layout {
  double row = 0;  // Height of a leaf.
  double highest = 0;
  double bottom = 0;
  bool named = true;

  [[nodiscard]] double X(double height) const {
    return kLeft + (1 - height / highest) * kTreeWidth;
  }
};

Layout LayOut(const Dendrogram& tree) {
  const size_t leaves = tree.leaf_order.size();
  Layout layout;
  layout.named = leaves <= kMostNamed;
  layout.row = leaves <= 60 ? 16 : 12;
  if (!layout.named) layout.row = std::min(4.0, kMaxHeight / static_cast<double>(leaves));
  for (const Merge& merge : tree.merges) layout.highest = std::max(layout.highest, merge.height);
  if (layout.highest <= 0) layout.highest = 1;  // All meshes coincide.
  layout.bottom = kTop + layout.row * static_cast<double>(leaves);
  return layout;
}

void DrawScale(const Layout& layout, const std::string& title, SvgPage& page) {
  const AxisTicks ticks = NiceTicks(0, layout.highest, 7);
  for (const double tick : ticks.values) {
    const double x = layout.X(tick);
    page.Line(std::array<Spot, 2>{{{x, kTop}, {x, layout.bottom}}}, {kGridColor, 0.75});
    page.Text({x, layout.bottom + 14}, ticks.Text(tick), kTickStyle, Anchor::kMiddle);
  }
  page.Text({kLeft + kTreeWidth / 2, layout.bottom + 36}, title, kAxisStyle, Anchor::kMiddle);
}

void DrawBranches(const Dendrogram& tree, const Layout& layout, SvgPage& page) {
  const size_t leaves = tree.leaf_order.size();
  // The node of each leaf, then of each merge: its height and where it lies.
  std::vector<Spot> nodes(leaves);
  for (size_t place = 0; place < leaves; ++place) {
    nodes[static_cast<size_t>(tree.leaf_order[place])] = {
        layout.X(0), kTop + layout.row * (static_cast<double>(place) + 0.5)};
  }
  for (const Merge& merge : tree.merges) {
    const Spot a = nodes[static_cast<size_t>(merge.left)];
    const Spot b = nodes[static_cast<size_t>(merge.right)];
    const double x = layout.X(merge.height);
    page.Line(std::array<Spot, 4>{{a, {x, a.y}, {x, b.y}, b}}, {kBranchColor, 1});
    nodes.push_back({x, (a.y + b.y) / 2});
  }
}

void DrawLeaves(const Dendrogram& tree,
                std::span<const std::string> labels,
                const Groups& groups,
                const Layout& layout,
                SvgPage& page) {
  const TextStyle style{layout.row >= 16 ? 10.5 : 9, FontWeight::kNormal, kInk};
  const auto width = [&](const std::string& text) { return TextWidth(text, style); };
  std::vector<std::string> fitted;
  if (layout.named) fitted = FittedLabels(labels, kLabelWidth, width);
  for (size_t place = 0; place < tree.leaf_order.size(); ++place) {
    const auto mesh = static_cast<size_t>(tree.leaf_order[place]);
    const double y = kTop + layout.row * (static_cast<double>(place) + 0.5);
    double x = layout.X(0) + 5;
    if (!groups.names.empty()) {
      const int group = groups.group_of[mesh];
      const std::string& name =
          group < 0 ? std::string("not known") : groups.names[static_cast<size_t>(group)];
      const double side = std::min(kSwatch, layout.row);
      page.Fill({x, y - side / 2, kSwatch, side}, StyleOfGroup(group).color, 1,
                groups.title + ": " + name);
      x += kSwatch + 5;
    }
    if (layout.named) page.Text({x, y}, fitted[mesh], style, Anchor::kStart, labels[mesh]);
  }
}

}  // namespace

std::string DendrogramSvg(const Dendrogram& dendrogram,
                          std::span<const std::string> labels,
                          const Groups& groups,
                          const std::string& value_title) {
  const Layout layout = LayOut(dendrogram);
  const double label_width = layout.named ? kLabelWidth + 12 : 12;
  SvgPage page(
      kLeft + kTreeWidth + kSwatch + 10 + label_width, layout.bottom + kBelow,
      "Dendrogram of " + Counted(std::ssize(labels), "mesh", "meshes") + " by " + value_title);
  DrawScale(layout, value_title, page);
  DrawBranches(dendrogram, layout, page);
  DrawLeaves(dendrogram, labels, groups, layout, page);
  return page.Svg();
}

}  // namespace cohort
