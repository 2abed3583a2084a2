/// What a tracker saw of a body's markers, message by message: what a body is built from.
#pragma once

#include <vector>

#include "devices/sample.hpp"
#include "tracking/rigid_body.hpp"

namespace vrda {

class MarkerFrames {
 public:
  /// The markers are the tracker's tools from `first_tool` on, as BenchFile lists them.
  MarkerFrames(std::size_t first_tool, std::size_t n_markers);

  /// In the order of arrival; other tools' samples are passed over.
  void take(const Sample& sample);

  /// Those that saw a marker, `most` of them at most, evenly chosen.
  std::vector<MarkerRow> frames(std::size_t most) const;

 private:
  void end_row();

  std::size_t first_tool_, n_markers_;
  std::vector<bool> has_come_;  ///< since the row began
  MarkerRow row_;
  std::vector<MarkerRow> rows_;
};

}  // namespace vrda
