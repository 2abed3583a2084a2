/// Gap and penetration of a body that follows the joint, at poses of a motion.
#pragma once

#include <algorithm>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "analysis/audit.hpp"
#include "core/parallel.hpp"
#include "solve/followers.hpp"

namespace vrda::analysis {

/// A follower and what it touches, for one thread.
class FollowerMeter {
 public:
  /// `shared`: the scene of a follower that touches only the body of its coordinates, else empty.
  FollowerMeter(const store::MotionModel& model, const store::FollowerRows& rows,
                std::shared_ptr<const AuditScene> shared)
      : model_(model), rows_(rows), scene_(std::move(shared)), is_shared_(scene_ != nullptr)
  {
    if (is_shared_) meter_.emplace(*scene_);
  }

  static std::shared_ptr<const AuditScene> shared_scene(const store::MotionModel& model,
                                                        const store::FollowerRows& rows)
  {
    if (!solve::touches_one_body(touched_bodies(model, rows), static_cast<BodyIndex>(rows.of)))
      return nullptr;
    return scene_at(model, rows, {});
  }

  static std::vector<solve::TouchedBody> touched_bodies(const store::MotionModel& model,
                                                        const store::FollowerRows& rows)
  {
    std::vector<solve::TouchedBody> touched;
    for (std::size_t k = 0; k < rows.touches.size(); ++k) {
      const auto index = static_cast<BodyIndex>(rows.touches[k]);
      const bool has_drawn = !rows.touches_drawn.empty() && rows.touches_drawn[k] == 1;
      touched.push_back({&body_of(model, index), index, has_drawn});
    }
    return touched;
  }

  /// In canonical axes of the body of its coordinates.
  static Mesh touched(const store::MotionModel& model, const store::FollowerRows& rows,
                      const store::JointPose& pose)
  {
    BodyPoses placed{Pose::Identity(), pose.X_reference_moving};
    placed.insert(placed.end(), pose.X_reference_follower.begin(), pose.X_reference_follower.end());
    return solve::touched_mesh(touched_bodies(model, rows), static_cast<BodyIndex>(rows.of), placed);
  }

  /// `pose` places the other bodies, X_of the follower relative to the body of its coordinates.
  PoseAudit measure(const store::JointPose& pose, const Pose& X_of, OverlapTest judge)
  {
    place(pose);
    return meter_->measure(attitude_of(X_of), X_of, judge);
  }
  double travel_mm(const store::JointPose& pose, const Pose& X_of)
  {
    place(pose);
    return meter_->travel_into_contact_mm(attitude_of(X_of), X_of);
  }
  Attitude attitude_of(const Pose& X_of) const
  {
    return solve::solver_position(frame_of(model_, rows_), X_of).attitude;
  }
  /// Of the last pose.
  PoseMeter& meter() { return *meter_; }

 private:
  static SolverFrame frame_of(const store::MotionModel& model, const store::FollowerRows& rows)
  {
    return {side_named(model.side), rows.centre_mm, rows.delta};
  }

  static std::shared_ptr<const AuditScene> scene_at(const store::MotionModel& model,
                                                    const store::FollowerRows& rows,
                                                    const store::JointPose& pose)
  {
    return std::make_shared<const AuditScene>(
        make_audit_scene(touched(model, rows, pose), rows.body.contact.mesh, frame_of(model, rows)));
  }

  static const Body& body_of(const store::MotionModel& model, BodyIndex index)
  {
    if (index == BodyIndex::reference) return model.reference;
    if (index == BodyIndex::moving) return model.moving;
    return std::find_if(model.followers.begin(), model.followers.end(),
                        [&](const auto& other) { return static_cast<BodyIndex>(other.body_index) == index; })
        ->body;
  }

  void place(const store::JointPose& pose)
  {
    if (is_shared_) return;
    meter_.reset();
    scene_ = scene_at(model_, rows_, pose);
    meter_.emplace(*scene_);
  }

  const store::MotionModel& model_;
  const store::FollowerRows& rows_;
  std::shared_ptr<const AuditScene> scene_;
  bool is_shared_;
  std::optional<PoseMeter> meter_;
};

/// Calls `measure(row, meter)` once for every row, with a meter of the thread.
template <typename Measure>
void for_each_follower_row(const store::MotionModel& model, const store::FollowerRows& rows, std::size_t n,
                           int n_threads, const Measure& measure)
{
  const std::shared_ptr<const AuditScene> shared = FollowerMeter::shared_scene(model, rows);
  for_each_index(n, n_threads, [&] {
    return [&, meter = std::make_shared<FollowerMeter>(model, rows, shared)](std::size_t row) {
      measure(row, *meter);
    };
  });
}

}  // namespace vrda::analysis
