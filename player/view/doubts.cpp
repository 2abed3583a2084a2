#include "view/doubts.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "model/step_record.hpp"
#include "core/units.hpp"

namespace vrda::view {
namespace {

struct Rows {
  Eigen::Index first = 0, last = 0;  ///< equal at a node
};

/// The nodes of an ascending axis around a value.
Rows rows_around(const std::vector<double>& axis, double value)
{
  constexpr double rounding = 1e-9;
  const auto above = std::upper_bound(axis.begin(), axis.end(), value + rounding);
  if (above == axis.begin()) return {};
  const Eigen::Index row = above - axis.begin() - 1;
  const bool is_node = above == axis.end() || value - *(above - 1) <= rounding;
  return {row, is_node ? row : row + 1};
}

/// Without the remedy.
int reason_length(const std::string_view meaning)
{
  return static_cast<int>(std::min(meaning.find(';'), meaning.size()));
}

std::string words_of(Plausibility plausibility)
{
  std::string words = name_of(plausibility);
  std::ranges::replace(words, '_', ' ');
  return words;
}

bool is_hole(const store::MotionModel& model, Eigen::Index cell)
{
  return model.status.data()[cell] != status_stable;
}

}  // namespace

PoseDoubt DoubtReader::at(const store::JointPose& pose) const
{
  PoseDoubt doubt;
  doubt.is_beside_hole = pose.status != store::PoseStatus::solved;
  if (model_.frames && std::isnan(pose.key)) return doubt;
  const Rows flexion = model_.frames
                           ? rows_around(model_.frames->key, pose.key)
                           : rows_around(model_.flexion_deg, deg_from_rad(pose.attitude.flexion_rad));
  const Rows varus = model_.varus_deg.size() > 1
                         ? rows_around(model_.varus_deg, deg_from_rad(pose.attitude.varus_rad))
                         : Rows{};
  std::size_t worst = std::size(doubtful_plausibilities);
  for (Eigen::Index i = flexion.first; i <= flexion.last; ++i) {
    for (Eigen::Index j = varus.first; j <= varus.last; ++j) {
      doubt.is_beside_hole |= model_.status(i, j) != status_stable;
      if (model_.plausibility.size() == 0) continue;
      const auto here = static_cast<Plausibility>(model_.plausibility(i, j));
      const auto found = std::ranges::find(doubtful_plausibilities, here);
      worst = std::min(worst, static_cast<std::size_t>(found - std::begin(doubtful_plausibilities)));
    }
  }
  if (worst < std::size(doubtful_plausibilities)) doubt.plausibility = doubtful_plausibilities[worst];
  return doubt;
}

std::vector<MarkedSpan> DoubtReader::marks(const store::Motion& motion,
                                           std::optional<double> varus_rad) const
{
  std::vector<MarkedSpan> spans;
  const std::size_t n = motion.is_sequence() ? motion.keys().size() : model_.flexion_deg.size();
  const auto position = [&](std::size_t k) {
    return motion.is_sequence() ? static_cast<double>(k) : rad_from_deg(model_.flexion_deg[k]);
  };
  for (std::size_t k = 0; k + 1 < n; ++k) {
    const double middle = 0.5 * (position(k) + position(k + 1));
    const store::JointPose pose =
        motion.is_sequence()
            ? motion.at_frame(motion.key_at(middle))
            : motion.at({middle, varus_rad ? *varus_rad : motion.balanced_varus_rad(middle)});
    const PoseDoubt doubt = at(pose);
    if (!doubt.is_beside_hole && !is_doubtful(doubt.plausibility)) continue;
    const MarkedSpan span{position(k), position(k + 1), pose.status == store::PoseStatus::solved};
    const bool continues =
        !spans.empty() && spans.back().last == span.first && spans.back().has_pose == span.has_pose;
    if (continues) {
      spans.back().last = span.last;
    } else {
      spans.push_back(span);
    }
  }
  return spans;
}

DoubtText doubt_text(const store::JointPose& pose, const PoseDoubt& doubt, const char* drawn)
{
  DoubtText text{};
  if (pose.status != store::PoseStatus::solved) {
    const bool is_frame = !std::isnan(pose.key);
    std::snprintf(text.data(), text.size(), "no pose at %s%.4g%s: %s is unsolved; only the %s is drawn",
                  is_frame ? "frame " : "",
                  is_frame ? pose.key : std::round(1e3 * deg_from_rad(pose.attitude.flexion_rad)) / 1e3 + 0.0,
                  is_frame ? "" : " degrees", is_frame ? "it or a neighbour" : "a neighbouring attitude",
                  drawn);
  } else if (is_doubtful(doubt.plausibility)) {
    const char* meaning = meaning_of(doubt.plausibility);
    std::snprintf(text.data(), text.size(), "%s: %.*s", name_of(doubt.plausibility), reason_length(meaning),
                  meaning);
    // The names end before the meaning begins.
    std::replace(text.begin(), std::find(text.begin(), text.end(), ':'), '_', ' ');
  } else if (doubt.is_beside_hole) {
    std::snprintf(text.data(), text.size(),
                  "beside an attitude without a pose: the smoothed motion is extrapolated here");
  }
  return text;
}

std::vector<std::string> model_warnings(const store::MotionModel& model)
{
  std::vector<std::string> warnings;
  Eigen::Index n_holes = 0;
  for (Eigen::Index cell = 0; cell < model.status.size(); ++cell) n_holes += is_hole(model, cell) ? 1 : 0;
  const Eigen::Index n_poses = model.status.size() - n_holes;
  for (const Plausibility plausibility : doubtful_plausibilities) {
    const Eigen::Index n = (model.plausibility == static_cast<std::int8_t>(plausibility)).count();
    if (n > 0)
      warnings.push_back(std::to_string(n) + " of " + std::to_string(n_poses) +
                         " poses: " + words_of(plausibility) + ": " + meaning_of(plausibility));
  }
  if (n_holes > 0)
    warnings.push_back(std::to_string(n_holes) + " of " + std::to_string(model.status.size()) +
                       " attitudes have no pose");
  warnings.insert(warnings.end(), model.job.warnings.begin(), model.job.warnings.end());
  return warnings;
}

std::string default_motion_remark(const store::MotionModel& model, const std::string& set)
{
  const store::DefaultMotion shown = store::default_motion(model);
  return shown.set != set || shown.reason.empty() ? "" : "The solved poses are shown: " + shown.reason;
}

bool has_doubtful_poses(const store::MotionModel& model)
{
  return model_warnings(model).size() > model.job.warnings.size();
}

}  // namespace vrda::view
