/// A second joint beside the shown one or over it: another motion model, or the same one with another motion,
/// varus or without a bundle; and differences over flexion, the second minus the first. Angles are in rad.
#pragma once

#include <array>
#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "show/joint_view.hpp"
#include "store/motion.hpp"
#include "store/motion_model.hpp"
#include "view/gui.hpp"
#include "view/renderer.hpp"
#include "view/scene.hpp"

namespace vrda::show {

/// Of the command line.
struct ComparisonOptions {
  std::string file;                 ///< a second motion model; empty: the first one
  std::string set;                  ///< default: that of the first if it is of the same file, else its own
  std::optional<double> varus_deg;  ///< added to the varus of the first, or to its own balanced one
  std::string without;              ///< a bundle that the second joint lacks
  bool is_over = false;             ///< over the first, translucent, instead of beside it
  std::shared_ptr<const store::MotionModel> model = nullptr;  ///< of `file`, once it is read

  bool is_wanted() const { return !file.empty() || !set.empty() || varus_deg || !without.empty(); }
};

/// The viewport of column `row` of `n` side by side.
view::Viewport column(const view::Viewport& area, std::size_t row, std::size_t n);

class Comparison {
 public:
  /// `first` and its motion must outlive it. Throws InputError for options that the second model does not
  /// have, and for a sequence of frames.
  Comparison(const store::MotionModel& first, const ComparisonOptions& options,
             const view::AppearanceOptions& look, view::Backdrop backdrop);

  bool is_beside() const { return !options_.is_over; }

  /// Shows the second joint as the first, which shows `pose`; `varus_rad` is empty for the balanced one.
  /// Allocates nothing once warm.
  void show(JointView& first, const store::JointPose& pose, std::optional<double> varus_rad,
            const view::LayerSet& layers);
  /// The plots of differences from a motion of the first model, computed when it or the varus changes; with
  /// what show() shows.
  const view::Differences& differences(const store::Motion& first, std::optional<double> varus_rad);
  /// Appends the shots of a camera over `area`: of both joints, or of each of them.
  void add_shots(std::vector<view::Shot>& shots, const view::Camera& camera,
                 const view::Viewport& area) const;
  /// The names of the joint of each shot, of the first where both are; valid until the next call. Allocates
  /// nothing once warm.
  std::span<const view::ScreenLabel> labels(JointView& first, std::span<const view::Shot> shots);
  /// The points to be framed at the second's pose there, world.
  std::vector<Eigen::Vector3d> framed_points(const store::JointPose& pose, std::optional<double> varus_rad,
                                             BodyIndex fixed, view::Framing framing);

  const JointView& joint() const { return joint_; }

 private:
  const store::MotionModel& model() const { return options_.model ? *options_.model : first_; }
  store::JointPose pose_at(double flexion_rad, std::optional<double> varus_rad) const;
  void sample(const store::Motion& first, std::optional<double> varus_rad);

  const store::MotionModel& first_;
  ComparisonOptions options_;
  store::Motion motion_;
  JointView joint_;
  view::BundleReader first_bundles_;
  std::vector<std::size_t> lacking_;  ///< rows of structures that are removed
  std::string name_;
  std::array<std::array<char, 240>, 2> captions_{};
  std::vector<view::ScreenLabel> labels_;
  view::Differences differences_;
  const store::Motion* sampled_ = nullptr;  ///< of the first, in `differences_`
  std::optional<double> sampled_varus_rad_;
};

}  // namespace vrda::show
