/// The comparison of a found motion with a measured one, coordinate by coordinate.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "analysis/rigid_alignment.hpp"
#include "analysis/sequence.hpp"
#include "analysis/statistics.hpp"

namespace vrda::analysis {

/// What is fitted to the measurement before it is scored.
enum class Alignment {
  none,
  constant,  ///< an offset of each coordinate
  rigid,     ///< a rigid transform of each body's frame
};

/// What the straight line of the baseline depends on.
enum class LineOver { flexion, key };

/// Rows [first, last) of the measurement.
struct RowRange {
  std::size_t first = 0;
  std::size_t last = static_cast<std::size_t>(-1);
  bool contains(std::size_t row) const { return row >= first && row < last; }
};

struct ScoreOptions {
  Convention convention;
  Alignment align = Alignment::none;
  LineOver line_over = LineOver::flexion;
  RowRange scored;              ///< rows to score
  std::optional<RowRange> fit;  ///< rows that fit alignment and baselines; default: those scored
};

/// Of one coordinate; rad or mm.
struct CoordinateScore {
  Statistics statistics;
  std::size_t largest_row = 0;            ///< of the measurement
  double offset = 0.0;                    ///< subtracted from the found values
  double constant_rms = nan;              ///< baseline: the mean of the measurement
  double line_rms = nan;                  ///< baseline: its least-squares line
  std::vector<std::size_t> undetermined;  ///< rows with a pose that does not determine the coordinate
};

struct Score {
  std::array<CoordinateScore, n_scored> coordinates;
  std::size_t n_scored_rows = 0, n_fit_rows = 0;
  std::map<std::string, std::vector<std::size_t>> missing;  ///< rows to score without a pose, by reason
  std::optional<RigidAlignment> rigid;  ///< of the joint's own side; with Alignment::rigid
};

/// Scores `found`, a row for each of `measured`. A row counts if both have a pose; of these a coordinate
/// counts where both determine it. Baselines and offsets are fitted to the same rows. Throws InputError
/// naming the measurement if no row to score or to fit counts.
Score score(const std::vector<Row>& found, const Sequence& measured, const ScoreOptions& options);

}  // namespace vrda::analysis
