#include "virtual_bench/tracker_frame.hpp"

#include <cmath>

#include "core/units.hpp"
#include "tracking/screw.hpp"

namespace vrda {
namespace {

/// Where a tool truly is; nothing where nobody uses it.
std::optional<Pose> place_of_tool(const BenchFile& bench, const VirtualTruth& truth, const Standing& standing,
                                  const std::string& used, const std::string& tool)
{
  if (tool == used) return standing.X_tracker_tool;
  for (std::size_t k = 0; k < n_body_roles; ++k) {
    if (!bench.bodies[k]) continue;
    const BodySettings& body = *bench.bodies[k];
    const auto role = static_cast<BodyRole>(k);
    const Pose X = role == BodyRole::head ? standing.X_tracker_headbody : X_tracker_body(truth, role);
    if (tool == body.tool) return X;
    for (std::size_t m = 0; m < body.markers.size(); ++m) {
      if (tool != body.markers[m]) continue;
      Pose marker = X;
      marker.translation() = X * body.markers_body_mm[m];
      return marker;
    }
  }
  return std::nullopt;
}

}  // namespace

Pose measured(const Pose& X, const VirtualNoise& noise, Draws& draws)
{
  Pose seen = X;
  seen.translation() += noise.tracker_mm * draws.normal_vector();
  seen.linear() = rotation_of(rad_from_deg(noise.tracker_deg) * draws.normal_vector()) * X.linear();
  return seen;
}

std::vector<Sample> tracker_frame(const BenchFile& bench, const VirtualTruth& truth, const Standing& standing,
                                  const FrameFacts& facts, Draws& draws)
{
  std::vector<Sample> samples;
  Sample sample;
  sample.arrival_ns = sample.device_ns = facts.time_ns;
  if (bench.board && bench.board->has_stage) {
    sample.kind = SampleKind::stage;
    sample.source = static_cast<std::uint16_t>(DeviceId::board);
    sample.state = facts.is_stage_zeroed ? stage_zeroed : 0;
    sample.count = static_cast<std::int32_t>(
        std::lround((standing.stage_mm + facts.stage_offset_mm) / bench.stage_mm_per_count));
    samples.push_back(sample);
  }
  sample.kind = SampleKind::place;
  sample.count = 0;
  for (std::size_t k = 0; k < bench.tracker->tools.size(); ++k) {
    const std::optional<Pose> X = place_of_tool(bench, truth, standing, facts.tool, bench.tracker->tools[k]);
    sample.source = static_cast<std::uint16_t>(k);
    sample.state = static_cast<std::uint8_t>(X ? SeenState::seen : SeenState::missing);
    // Drawn for hidden ones too: hiding one changes no other.
    const Pose seen = measured(X.value_or(Pose::Identity()), facts.noise, draws);
    sample.place = X ? place_of(seen) : Place{};
    samples.push_back(sample);
  }
  return samples;
}

}  // namespace vrda
