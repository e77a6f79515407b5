#pragma once

#include <span>
#include <string>
#include <vector>

#include "common/analysis/clustering.h"
#include "common/report/matrix_description.h"
#include "common/report/pair_distribution.h"
#include "common/report/plots/group_style.h"
#include "common/report/plots/svg_axes.h"

namespace cohort {

// Plots as SVG, one <svg> element each. Points and bars tell what they are under the pointer.

/// Points in a plane, with equal scales on both axes.
struct ScatterPlot {
  std::string x_title;
  std::string y_title;
  std::vector<Spot> points;         ///< In data units, y up; one per mesh, finite.
  std::vector<std::string> labels;  ///< One per point.
  Groups groups;                    ///< Without names: all points look alike, no legend.
  std::string description;          ///< For who cannot see it.
};
[[nodiscard]] std::string ScatterSvg(const ScatterPlot& plot);

/// Curves of numbers, e.g. rates.
struct Curve {
  std::string name;
  std::vector<Spot> points;  ///< In data units, y up.
  GroupStyle style;
  std::vector<double> dashes = {};
};
struct CurvePlot {
  SvgAxis x;
  SvgAxis y;
  std::vector<Curve> curves;
  std::string description;
};
[[nodiscard]] std::string CurvesSvg(const CurvePlot& plot);

/// The pairs of a matrix by value; those of one person and of two people apart, as shares of their
/// own pairs, if `pairs.by_person`. Empty if there is no value.
[[nodiscard]] std::string PairHistogramSvg(const PairValues& pairs,
                                           const MatrixDescription& description);

/// The tree with its leaves on the right, in `leaf_order`; a leaf has the colour of its group. More
/// than 250 leaves have no names.
/// @param labels  one per leaf.
/// @param value_title  of the axis of heights, with the unit.
[[nodiscard]] std::string DendrogramSvg(const Dendrogram& dendrogram,
                                        std::span<const std::string> labels,
                                        const Groups& groups,
                                        const std::string& value_title);

}  // namespace cohort
