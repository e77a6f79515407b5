// What the analysis of the matrix gives: tree, principal coordinates, distribution, persons.
#include <algorithm>
#include <cmath>
#include <set>

#include "common/analysis/identification.h"
#include "common/analysis/ordination.h"
#include "common/analysis/verification.h"
#include "common/report/decimal.h"
#include "common/report/html/html_table.h"
#include "common/report/html/sections.h"
#include "common/report/job_meshes.h"
#include "common/report/markup.h"
#include "common/report/pair_distribution.h"
#include "common/report/plots/plots.h"

namespace cohort {
namespace {

constexpr int64_t kMostOrdinated = 1000;  // The time grows with the third power.
constexpr size_t kMostRanks = 20;

std::string Percent(double share, int digits) {
  return FixedDecimal(100 * share, digits) + " %";
}

// The groups of the meshes that have no missing cell.
Groups OfRows(const Groups& groups, const std::vector<int64_t>& rows) {
  Groups some{groups.title, groups.names, {}};
  for (const int64_t row : rows) some.group_of.push_back(groups.group_of[static_cast<size_t>(row)]);
  return some;
}

// What must be said where a statistic does without some meshes, or halves two directions.
std::string Reservations(const ReportInput& input, const ReportAnalysis& analysis) {
  std::string text;
  const size_t left_out = input.matrix.labels.size() - analysis.rows.size();
  if (left_out > 0) {
    text += HtmlHint("Without " + Counted(static_cast<int64_t>(left_out), "mesh", "meshes") +
                     " that have pairs without a value.");
  }
  if (input.description.symmetrization == Symmetrization::kDirected) {
    text += HtmlHint("Of the mean of both directions.");
  }
  return text;
}

std::string AxisTitle(const Ordination& found, int axis, const ReportInput& input) {
  return "axis " + std::to_string(axis + 1) + " (" + ValueUnit(input.description) + "), explains " +
         Percent(found.explained[static_cast<size_t>(axis)], 1);
}

ScatterPlot PointsOf(const Ordination& found,
                     const ReportInput& input,
                     const ReportAnalysis& analysis) {
  ScatterPlot plot;
  const bool has_second = found.coordinates.cols() > 1;
  plot.x_title = AxisTitle(found, 0, input);
  plot.y_title = has_second ? AxisTitle(found, 1, input) : "no second axis";
  for (Eigen::Index mesh = 0; mesh < found.coordinates.rows(); ++mesh) {
    plot.points.push_back(
        {found.coordinates(mesh, 0), has_second ? found.coordinates(mesh, 1) : 0});
  }
  plot.labels = analysis.complete.labels;
  return plot;
}

std::string OrdinationPlots(const Ordination& found,
                            const ReportInput& input,
                            const ReportAnalysis& analysis) {
  ScatterPlot plot = PointsOf(found, input, analysis);
  const std::vector<Groups> all_groups = GroupsOfRows(input);
  std::string html;
  for (const Groups& groups : all_groups) {
    plot.groups = OfRows(groups, analysis.rows);
    plot.description = "Principal coordinates of the meshes, coloured by " + groups.title;
    html += "<figure><figcaption>Coloured by " + EscapeMarkup(groups.title) + "</figcaption>" +
            ScatterSvg(plot) + "</figure>\n";
  }
  if (all_groups.empty()) {
    plot.description = "Principal coordinates of the meshes";
    html += ScatterSvg(plot);
  }
  return "<div class=\"plots\">\n" + html + "</div>\n";
}

Curve NewCurve(std::string name, int style, std::vector<Spot> points) {
  return {std::move(name), std::move(points), StyleOfGroup(style)};
}

std::string CmcPlot(const Identification& found) {
  std::vector<Spot> points;
  for (size_t k = 0; k < std::min(found.match_share.size(), kMostRanks); ++k) {
    points.push_back({static_cast<double>(k + 1), found.match_share[k]});
  }
  if (points.size() < 2) return "";
  const double low = std::min(0.9, std::floor(10 * points.front().y) / 10);
  return CurvesSvg(
      {.x = {.title = "rank k", .range = {1, static_cast<double>(points.size())}, .ticks = 8},
       .y = {.title = "right person among the k nearest",
             .range = {low, 1},
             .numbers = AxisNumbers::kPercent},
       .curves = {NewCurve("", 0, points)},
       .description = "Cumulative match characteristic"});
}

std::string RocPlot(const Verification& found) {
  std::vector<Spot> points;
  for (const ErrorRates& rates : found.roc) {
    points.push_back({rates.false_accept_rate, 1 - rates.false_reject_rate});
  }
  Curve chance = NewCurve("chance", -1, {{0, 0}, {1, 1}});
  chance.dashes = {4, 4};
  return CurvesSvg(
      {.x = {.title = "false accept rate", .range = {0, 1}, .numbers = AxisNumbers::kPercent},
       .y = {.title = "right pairs accepted", .range = {0, 1}, .numbers = AxisNumbers::kPercent},
       .curves = {NewCurve("this matrix", 0, points), chance},
       .description = "Receiver operating characteristic"});
}

std::string NumbersTable(const Identification& ranks,
                         const Verification& rates,
                         const VerificationScores& scores,
                         const ReportInput& input) {
  HtmlTable table("", {{"measure"}, {"value", ColumnKind::kNumber}, {"what it says"}});
  table.AddRow({"rank 1", Percent(ranks.ShareAtRank(1), 1),
                "the nearest mesh is of the same person, of " +
                    Counted(ranks.with_mate, "mesh", "meshes") + " that have another one"});
  table.AddRow({"rank 5", Percent(ranks.ShareAtRank(5), 1), "one of the 5 nearest is"});
  table.AddRow(
      {"EER", Percent(rates.equal_error_rate, 2),
       "error where as many of two people are accepted as of one refused; near " +
           WithUnit(ReadableDecimal(rates.nearest_equal.threshold, 3), input.description)});
  table.AddRow({"d'", std::isfinite(rates.d_prime) ? FixedDecimal(rates.d_prime, 2) : "-",
                "distance of the two means in standard deviations"});
  table.AddRow({"area under ROC", FixedDecimal(rates.area, 4),
                "chance that a pair of one person is nearer than one of two"});
  table.AddRow(
      {"pairs",
       std::to_string(scores.genuine.size()) + " / " + std::to_string(scores.impostor.size()),
       "of one person / of two people"});
  return table.Html();
}

}  // namespace

std::string DendrogramSection(const ReportInput& input, const ReportAnalysis& analysis) {
  if (input.matrix.labels.size() < 2) return "";
  if (!analysis.tree) return HtmlSection("dendrogram", "Dendrogram", HtmlHint(analysis.no_tree));
  const std::vector<Groups> groups = GroupsOfRows(input);
  const Groups shown = groups.empty() ? Groups{} : OfRows(groups.front(), analysis.rows);
  std::string hint =
      "Average linkage: two branches meet at the mean distance between their meshes.";
  if (!groups.empty()) hint += " Squares are coloured by " + groups.front().title + ".";
  return HtmlSection(
      "dendrogram", "Dendrogram",
      HtmlHint(hint) + Reservations(input, analysis) +
          HtmlScroll("Dendrogram", DendrogramSvg(*analysis.tree, analysis.complete.labels, shown,
                                                 ValueTitle(input.description))));
}

std::string OrdinationSection(const ReportInput& input, const ReportAnalysis& analysis) {
  const std::string title = "Principal coordinates";
  if (input.matrix.labels.size() < 3) return "";
  if (input.description.sign == DistanceSign::kSigned) return "";
  if (std::ssize(input.matrix.labels) > kMostAnalyzed ||
      std::ssize(analysis.rows) > kMostOrdinated) {
    return HtmlSection("ordination", title,
                       HtmlHint("Left out of this report for more than " +
                                std::to_string(kMostOrdinated) + " meshes."));
  }
  const absl::StatusOr<Ordination> found = OrdinateMeshes(analysis.complete, 2);
  if (!found.ok() || found->coordinates.cols() == 0) {
    const std::string why =
        found.ok() ? "all meshes coincide" : std::string(found.status().message());
    return HtmlSection("ordination", title, HtmlHint("Left out: " + why + "."));
  }
  std::string hint =
      "Classical scaling: a plane in which the distances between the points come as near as can be "
      "to those of the matrix. Point at a mark to see its mesh.";
  if (found->negative > 0) {
    hint += " The distances are not Euclidean: " + Percent(found->negative_share, 1) +
            " of the eigenvalues' sum is negative.";
  }
  return HtmlSection(
      "ordination", title,
      HtmlHint(hint) + Reservations(input, analysis) + OrdinationPlots(*found, input, analysis));
}

std::string DistributionSection(const ReportInput& input) {
  const PairValues pairs =
      CollectPairs(input.matrix, input.description.symmetrization, input.persons);
  const std::string svg = PairHistogramSvg(pairs, input.description);
  if (svg.empty()) return "";
  std::string html = "<div class=\"wide\">\n" + svg + "</div>\n";
  const Bins bins = ChooseBins(pairs);
  if (bins.beyond > 0) {
    html += HtmlHint("The last bar also holds " + Counted(bins.beyond, "value", "values") +
                     " far beyond it.");
  }
  if (pairs.missing > 0) {
    html += HtmlHint(Counted(pairs.missing, "pair has", "pairs have") + " no value.");
  }
  if (pairs.unknown > 0) {
    html += HtmlHint(Counted(pairs.unknown, "pair is", "pairs are") +
                     " left out, since a person is not known.");
  }
  return HtmlSection("distribution", "Distribution of the pairs", html);
}

std::string IdentificationSection(const ReportInput& input, const ReportAnalysis& analysis) {
  if (input.description.sign == DistanceSign::kSigned || input.matrix.labels.size() < 3) return "";
  const std::vector<std::string> persons(input.persons.begin(), input.persons.end());
  std::set<std::string> known(persons.begin(), persons.end());
  known.erase("");
  if (known.size() < 2) return "";
  const std::string title = "Identification and verification";
  if (std::ssize(persons) > kMostAnalyzed) {
    return HtmlSection(
        "identification", title,
        HtmlHint("Left out of this report for more than " + std::to_string(kMostAnalyzed) +
                 " meshes; cohort analyze --by person has it."));
  }
  const Identities identities{persons, {}};
  const auto ranks = IdentifyPersons(analysis.undirected, identities, Gallery::kAllOthers);
  const auto scores = CollectScores(analysis.undirected, identities, Gallery::kAllOthers);
  if (!ranks.ok() || !scores.ok() || ranks->with_mate == 0) return "";
  const absl::StatusOr<Verification> rates = VerifyPairs(*scores);
  if (!rates.ok()) return "";
  return HtmlSection(
      "identification", title,
      HtmlHint("Each mesh is sought among all others; each pair is taken for one person if its "
               "value is at or below a threshold.") +
          NumbersTable(*ranks, *rates, *scores, input) + "<div class=\"plots\">\n" +
          "<figure><figcaption>Cumulative match characteristic (CMC)</figcaption>" +
          CmcPlot(*ranks) +
          "</figure>\n<figure><figcaption>Receiver operating characteristic (ROC)</figcaption>" +
          RocPlot(*rates) + "</figure>\n</div>\n");
}

}  // namespace cohort
