/// What stands before an operator: a bench with its devices, or one that exists in numbers.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "calibrate/placed_model.hpp"
#include "guide/drawing.hpp"
#include "guide/session.hpp"

namespace vrda {

/// What the window shows of a task, in its pixels.
struct GuideView {
  std::vector<GuideLine> lines;
  std::optional<std::array<ShownBox, 2>> boxes;  ///< where each eye's lines end; nothing: nowhere
  std::vector<std::string> notes;                ///< what a ruler says
};

class GuideBench {
 public:
  virtual ~GuideBench() = default;
  /// What the devices said since the last call.
  virtual void send_samples(GuideSession& session, PlacedModel* model) = 0;
  /// ns of the samples' clock.
  virtual std::int64_t now_ns() const = 0;
  virtual void zero_stage() = 0;
  /// Of devices that the task at hand waits for; empty: all answer.
  virtual std::vector<std::string> troubles(const Task& task) const = 0;
  /// Of the task at hand.
  virtual GuideView view(const GuideSession& session) const = 0;
};

/// Tracker and board of the bench file.
std::unique_ptr<GuideBench> open_live_bench(const BenchFile& bench);
/// The virtual bench of that seed, seen as its person sees it.
std::unique_ptr<GuideBench> open_virtual_bench(const BenchFile& bench, std::uint64_t seed);

}  // namespace vrda
