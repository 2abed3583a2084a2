#include "bench/marker_frames.hpp"

#include <algorithm>

namespace vrda {
namespace {

bool has_marker(const MarkerRow& row)
{
  return std::any_of(row.begin(), row.end(), [](const auto& marker) { return marker.has_value(); });
}

}  // namespace

MarkerFrames::MarkerFrames(std::size_t first_tool, std::size_t n_markers)
    : first_tool_(first_tool), n_markers_(n_markers), has_come_(n_markers), row_(n_markers)
{
}

void MarkerFrames::end_row()
{
  if (has_marker(row_)) rows_.push_back(row_);
  std::fill(row_.begin(), row_.end(), std::nullopt);
  std::fill(has_come_.begin(), has_come_.end(), false);
}

void MarkerFrames::take(const Sample& sample)
{
  const bool is_marker = sample.kind == SampleKind::place && sample.source >= first_tool_ &&
                         sample.source < first_tool_ + n_markers_;
  if (!is_marker) return;
  const std::size_t k = sample.source - first_tool_;
  // One that comes a second time belongs to the next message.
  if (has_come_[k]) end_row();
  has_come_[k] = true;
  if (static_cast<SeenState>(sample.state) == SeenState::seen)
    row_[k] = Eigen::Vector3d::Map(sample.place.position_mm);
}

std::vector<MarkerRow> MarkerFrames::frames(std::size_t most) const
{
  std::vector<MarkerRow> all = rows_;
  if (has_marker(row_)) all.push_back(row_);
  if (all.size() <= most) return all;
  std::vector<MarkerRow> some;
  for (std::size_t k = 0; k < most; ++k) some.push_back(all[k * all.size() / most]);
  return some;
}

}  // namespace vrda
