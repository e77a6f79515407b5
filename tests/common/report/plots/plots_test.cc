#include "common/report/plots/plots.h"

#include <sstream>

#include <absl/strings/str_cat.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace cohort {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;
using ::testing::StartsWith;

// All numbers that follow `key` in the text.
std::vector<double> NumbersAfter(const std::string& text, const std::string& key) {
  std::vector<double> numbers;
  for (size_t at = text.find(key); at != std::string::npos; at = text.find(key, at + 1)) {
    numbers.push_back(std::stod(text.substr(at + key.size())));
  }
  return numbers;
}

int64_t Count(const std::string& text, const std::string& part) {
  int64_t count = 0;
  for (size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1)) ++count;
  return count;
}

TEST(SvgPage, EscapesTextsAndSaysWhatItShows) {
  SvgPage page(100, 50, "a < b");
  page.Text({1, 2}, "<b>", {}, Anchor::kEnd, "\"tip\"");
  EXPECT_THAT(page.Svg(),
              AllOf(StartsWith("<svg xmlns=\"http://www.w3.org/2000/svg\" width=\"100\""),
                    HasSubstr("aria-label=\"a &lt; b\""), HasSubstr(">&lt;b&gt;<title>&quot;tip"),
                    HasSubstr("text-anchor=\"end\""), EndsWith("</svg>\n")));
}

TEST(SvgPage, EndsEveryElement) {
  SvgPage page(100, 50, "");
  page.Line(std::vector<Spot>{{1, 2}, {3, 4.256}}, {kInk, 1.5, {4, 2}});
  page.Fill({0, 0, 5, 5}, kInk, 0.5, "tip");
  page.Mark({9, 9}, 3, MarkShape::kDiamond, kInk, "tip");
  page.Mark({9, 9}, 3, MarkShape::kCircle, kInk);
  const std::string svg = page.Svg();
  EXPECT_THAT(svg, HasSubstr("points=\"1,2 3,4.26\""));
  EXPECT_THAT(svg, HasSubstr("stroke-dasharray=\"4 2\""));
  EXPECT_EQ(Count(svg, "<title>"), Count(svg, "</title>"));
  EXPECT_EQ(Count(svg, "<"), Count(svg, ">"));
  EXPECT_EQ(Count(svg, "</polygon>"), 1);
}

TEST(MakeGroups, NumbersTheValuesInOrderAndLeavesUnknownOut) {
  const std::vector<std::string> values = {"m", "", "f", "m"};
  const Groups groups = MakeGroups("sex", values);
  EXPECT_THAT(groups.names, ::testing::ElementsAre("f", "m"));
  EXPECT_THAT(groups.group_of, ::testing::ElementsAre(1, -1, 0, 1));
}

TEST(StyleOfGroup, TwentyEightGroupsLookDifferent) {
  for (int a = 0; a < 28; ++a) {
    for (int b = 0; b < a; ++b) {
      const bool alike = StyleOfGroup(a).color == StyleOfGroup(b).color &&
                         StyleOfGroup(a).shape == StyleOfGroup(b).shape;
      EXPECT_FALSE(alike) << a << " " << b;
    }
  }
  EXPECT_EQ(StyleOfGroup(-1).color, kNoValueColor);
}

ScatterPlot ThreePoints() {
  ScatterPlot plot;
  plot.points = {{0, 0}, {3, 0}, {0, 4}};
  plot.labels = {"a.ply", "b.ply", "<c>.ply"};
  return plot;
}

TEST(ScatterSvg, HasEqualScalesOnBothAxes) {
  const std::string svg = ScatterSvg(ThreePoints());
  const std::vector<double> x = NumbersAfter(svg, "cx=\"");
  const std::vector<double> y = NumbersAfter(svg, "cy=\"");
  ASSERT_EQ(x.size(), 3);
  // 3 to the right of the first, and 4 above it; places are to 0.01.
  EXPECT_NEAR((x[1] - x[0]) / 3, (y[0] - y[2]) / 4, 0.02);
  EXPECT_GT(x[1], x[0]);
  EXPECT_THAT(svg, HasSubstr("&lt;c&gt;.ply"));
}

TEST(ScatterSvg, GroupsHaveALegendThatNamesTheUnknownToo) {
  ScatterPlot plot = ThreePoints();
  EXPECT_THAT(ScatterSvg(plot), Not(HasSubstr("not known")));
  plot.groups = MakeGroups("person", std::vector<std::string>{"p1", "p2", ""});
  const std::string svg = ScatterSvg(plot);
  EXPECT_THAT(svg, AllOf(HasSubstr(">p1<"), HasSubstr(">p2<"), HasSubstr("not known")));
}

TEST(ScatterSvg, MorePersonsThanStylesAreCounted) {
  ScatterPlot plot;
  std::vector<std::string> persons;
  for (int i = 0; i < 40; ++i) {
    plot.points.push_back({1.0 * i, 1.0 * i * i});
    plot.labels.push_back(absl::StrCat("m", i));
    persons.push_back(absl::StrCat("p", i));
  }
  plot.groups = MakeGroups("person", persons);
  EXPECT_THAT(ScatterSvg(plot), HasSubstr("and 12 more"));
}

TEST(ScatterSvg, PointsAtOnePlaceAreDrawn) {
  ScatterPlot plot = ThreePoints();
  plot.points = {{2, 2}, {2, 2}, {2, 2}};
  EXPECT_EQ(NumbersAfter(ScatterSvg(plot), "cx=\"").size(), 3);
  EXPECT_THAT(ScatterSvg(plot), Not(HasSubstr("NA")));
}

TEST(CurvesSvg, PutsPointsWhereTheAxesSay) {
  const std::string svg = CurvesSvg(
      {.x = {.title = "x", .range = {0, 1}},
       .y = {.title = "y", .range = {0, 1}},
       .curves = {{"one", {{0, 0}, {1, 1}}, StyleOfGroup(0)}, {"two", {{0, 1}}, StyleOfGroup(1)}},
       .description = ""});
  const std::vector<double> x = NumbersAfter(svg, "cx=\"");
  const std::vector<double> y = NumbersAfter(svg, "cy=\"");
  ASSERT_EQ(x.size(), 3);
  EXPECT_DOUBLE_EQ(x[1] - x[0], 380);
  EXPECT_DOUBLE_EQ(y[0] - y[1], 280);
  EXPECT_DOUBLE_EQ(y[2], y[1]);
  EXPECT_THAT(svg, AllOf(HasSubstr(">one<"), HasSubstr(">two<")));
}

TEST(PairHistogramSvg, CountsEveryPairOnce) {
  const PairValues pairs{.by_person = true, .same = {1, 1.1, 1.2}, .different = {2, 2.1, 2.2, 3}};
  const std::string svg = PairHistogramSvg(pairs, {});
  // Tooltips of bars: "name, low to high: n pairs".
  double sum = 0;
  for (size_t end = svg.find("</title>"); end != std::string::npos;
       end = svg.find("</title>", end + 1)) {
    sum += std::stod(svg.substr(svg.rfind(": ", end) + 2));
  }
  EXPECT_EQ(sum, 7);
  EXPECT_THAT(svg, AllOf(HasSubstr("same person: 3 pairs, median 1.10 mm"),
                         HasSubstr("different people: 4 pairs")));
}

TEST(PairHistogramSvg, IsEmptyWithoutPairs) {
  EXPECT_EQ(PairHistogramSvg({}, {}), "");
}

// ((a, b) at 1, c) at 3.
Dendrogram ThreeLeaves() {
  return {{{0, 1, 1, 2}, {2, 3, 3, 3}}, {0, 1, 2}};
}

// The x of the four corners of each branch.
std::vector<std::vector<double>> Branches(const std::string& svg) {
  const std::string open = "<polyline points=\"";
  std::vector<std::vector<double>> branches;
  for (size_t at = svg.find(open); at != std::string::npos; at = svg.find(open, at + 1)) {
    const size_t begin = at + open.size();
    std::istringstream points(svg.substr(begin, svg.find('"', begin) - begin));
    std::vector<double> x;
    for (std::string point; points >> point;) x.push_back(std::stod(point));
    if (x.size() == 4) branches.push_back(x);
  }
  return branches;
}

TEST(DendrogramSvg, BranchesMeetAtTheirHeights) {
  const std::vector<std::string> labels = {"a", "b", "c"};
  const std::string svg = DendrogramSvg(ThreeLeaves(), labels, {}, "RMS distance (mm)");
  const std::vector<std::vector<double>> branches = Branches(svg);
  ASSERT_EQ(branches.size(), 2);
  // x of a leaf or node, of the merge twice, and of the other leaf or node.
  const double leaves = branches[0][0];
  const double first = leaves - branches[0][1];
  const double second = leaves - branches[1][1];
  EXPECT_NEAR(second / first, 3, 0.001);
  EXPECT_NEAR(branches[1][0], leaves, 0.01);
  EXPECT_NEAR(branches[1][3], leaves - first, 0.01);  // The first merge is in the second.
}

TEST(DendrogramSvg, ManyLeavesHaveNoNames) {
  Dendrogram tree;
  std::vector<std::string> labels;
  for (int64_t i = 0; i < 300; ++i) {
    labels.push_back(absl::StrCat("mesh", i));
    tree.leaf_order.push_back(i);
    if (i > 0)
      tree.merges.push_back({i == 1 ? 0 : i, i == 1 ? 1 : 298 + i, static_cast<double>(i), i + 1});
  }
  EXPECT_THAT(DendrogramSvg(tree, labels, {}, ""), Not(HasSubstr("mesh7")));
}

TEST(DendrogramSvg, CoincidingMeshesAreATreeOfHeightZero) {
  const std::vector<std::string> labels = {"a", "b"};
  EXPECT_THAT(DendrogramSvg({{{0, 1, 0, 2}}, {0, 1}}, labels, {}, ""), Not(HasSubstr("NA")));
}

}  // namespace
}  // namespace cohort
