#include "fcl_search.hpp"

#include <fcl/narrowphase/collision.h>

#include <algorithm>
#include <cmath>

#include "processor_time.hpp"
#include "solve/stability_search.hpp"
#include "solve/sweep.hpp"

namespace vrda::benchmarks {
namespace {

enum class LastMotion { none, turn, slide };

class Search {
 public:
  Search(const solve::Joint& joint, const FclPair& models, const Attitude& attitude, const MovingPose& seed,
         const SearchOptions& options)
      : joint_(joint),
        attitude_(attitude),
        options_(options),
        fixed_(models.reference),
        moving_(models.moving),
        reference_(geometry::rotated_reference(joint.reference.tree_mesh, attitude)),
        pose_(seed),
        translation_step_mm_(options.translation_step_mm),
        rotation_step_rad_(options.rotation_step_rad)
  {
    fixed_.setRotation(reference_rotation(attitude));
    step_.record.varus_rad = attitude.varus_rad;
  }

  FclStep run()
  {
    StepRecord& record = step_.record;
    record.status = search();
    record.pose = pose_;
    if (record.status == StepStatus::stable) {
      solve::measure_contacts(joint_, touching(), resolution_mm(), record);
      solve::measure_gaps(joint_, attitude_, pose_, record);
    }
    record.queries += step_.n_collisions;
    return step_;
  }

 private:
  double resolution_mm() const { return options_.translation_resolution_mm; }

  StepStatus search()
  {
    if (collides(pose_) && !retreat()) return StepStatus::no_clearance;
    for (int& i = step_.record.iterations; i < options_.max_steps; ++i) {
      if (!approach()) return StepStatus::no_contact;
      adapt_steps();
      const std::vector<contact::Contact> contacts = touching();
      const solve::RotationPrediction rotation = solve::predict_rotation(contacts);
      if (rotation.sign != 0 && rotation_step_rad_ >= options_.rotation_resolution_rad) {
        turn(rotation);
      } else if (!slides_by(contacts)) {
        return StepStatus::stable;
      }
    }
    return StepStatus::iteration_limit;
  }

  bool collides(const MovingPose& pose)
  {
    const double start_s = thread_s();
    moving_.setTransform(fcl::Transform3d(pose_of(pose).matrix()));
    const fcl::CollisionRequestd request;
    fcl::CollisionResultd result;
    const bool is_hit = fcl::collide(&fixed_, &moving_, request, result) > 0;
    ++step_.n_collisions;
    step_.collision_s += thread_s() - start_s;
    return is_hit;
  }

  std::vector<contact::Contact> touching()
  {
    ++step_.record.queries;
    return contact::find_contacts(
        {reference_, joint_.reference.features, joint_.moving}, pose_, narrow_phase_,
        {resolution_mm(), options_.rotation_resolution_rad, options_.points, options_.normals});
  }

  // The same strides as the product, short ones first.
  bool retreat()
  {
    const double limit_mm = std::min(solve::extent_along_delta_mm(reference_.mesh),
                                     solve::extent_along_delta_mm(joint_.moving.tree_mesh.mesh));
    double stride_mm = resolution_mm();
    for (double gone_mm = 0.0; gone_mm < limit_mm; gone_mm += stride_mm) {
      if (gone_mm > 0.0) stride_mm = std::min(2.0 * stride_mm, options_.translation_step_mm);
      pose_.translation_mm.y() -= stride_mm;
      if (!collides(pose_)) return true;
    }
    return false;
  }

  // Moves up until blocked; false once the whole moving object is above the whole reference.
  bool approach()
  {
    const double above_mm = reference_.tree.nodes().front().max_mm[1];
    const double bottom_mm = joint_.moving.tree_mesh.tree.nodes().front().min_mm[1];
    const Eigen::Vector3d step_mm = options_.translation_step_mm * Eigen::Vector3d::UnitY();
    while (pose_.translation_mm.y() + bottom_mm <= above_mm) {
      const MovingPose start = pose_;
      const bool is_free = move_while_free(step_mm.norm(), resolution_mm(), 1, [&](double share) {
        return MovingPose{start.translation_mm + share * step_mm, start.theta_rad};
      });
      if (!is_free) return true;
    }
    return false;
  }

  bool slides_by(const std::vector<contact::Contact>& contacts)
  {
    const Eigen::Vector3d by_mm = translation_step_mm_ * solve::predict_translation(contacts);
    step_.record.residual_mm = by_mm.norm();
    if (by_mm.norm() < resolution_mm()) return false;
    const MovingPose start = pose_;
    move_while_free(by_mm.norm(), resolution_mm(), substeps(by_mm.norm()), [&](double share) {
      return MovingPose{start.translation_mm + share * by_mm, start.theta_rad};
    });
    last_motion_ = LastMotion::slide;
    return true;
  }

  void turn(const solve::RotationPrediction& rotation)
  {
    const MovingPose start = pose_;
    const Eigen::Vector3d arm_mm = start.translation_mm - rotation.centre_mm;
    const double angle_rad = rotation.sign * rotation_step_rad_;
    const double sweep_mm = rotation_step_rad_ * farthest_from_mm(rotation.centre_mm);
    move_while_free(rotation_step_rad_, options_.rotation_resolution_rad, substeps(sweep_mm),
                    [&](double share) {
                      MovingPose pose{rotation.centre_mm + rotation_y(share * angle_rad) * arm_mm,
                                      start.theta_rad + share * angle_rad};
                      pose.translation_mm.y() = start.translation_mm.y();
                      return pose;
                    });
    last_motion_ = LastMotion::turn;
  }

  int substeps(double length_mm) const
  {
    return std::max(1, static_cast<int>(std::ceil(length_mm / std::max(joint_.substep_mm, resolution_mm()))));
  }

  // From share 0 to 1 in equal parts; the first colliding part is bisected. Returns whether the whole
  // motion was free.
  template <typename PoseAt>
  bool move_while_free(double length, double resolution, int n_parts, const PoseAt& pose_at)
  {
    double free = 0.0;
    for (int k = 1; k <= n_parts; ++k) {
      const double next = static_cast<double>(k) / n_parts;
      if (!goes_to(pose_at(next))) {
        double blocked = next;
        while ((blocked - free) * length > resolution) {
          const double middle = 0.5 * (free + blocked);
          (goes_to(pose_at(middle)) ? free : blocked) = middle;
        }
        return false;
      }
      free = next;
    }
    return true;
  }

  bool goes_to(const MovingPose& pose)
  {
    if (collides(pose)) return false;
    pose_ = pose;
    return true;
  }

  // Of the corners of the moving object's box, perpendicular to Delta.
  double farthest_from_mm(const Eigen::Vector3d& centre_mm) const
  {
    const geometry::BoxTree::Node& box = joint_.moving.tree_mesh.tree.nodes().front();
    const geometry::Placement place(pose_);
    double farthest_mm = 0.0;
    for (const double x : {box.min_mm[0], box.max_mm[0]}) {
      for (const double z : {box.min_mm[2], box.max_mm[2]}) {
        const Eigen::Vector3d arm = place(Eigen::Vector3d(x, 0.0, z)) - centre_mm;
        farthest_mm = std::max(farthest_mm, std::hypot(arm.x(), arm.z()));
      }
    }
    return farthest_mm;
  }

  // Cycle detection (thesis 3.6).
  void adapt_steps()
  {
    const bool was_here = std::any_of(history_.begin(), history_.end(), [&](const MovingPose& earlier) {
      return (earlier.translation_mm - pose_.translation_mm).norm() < resolution_mm() &&
             std::abs(earlier.theta_rad - pose_.theta_rad) < options_.rotation_resolution_rad;
    });
    if (was_here) {
      if (last_motion_ == LastMotion::turn) rotation_step_rad_ *= 0.5;
      if (last_motion_ == LastMotion::slide) translation_step_mm_ *= 0.5;
      return;
    }
    history_.push_back(pose_);
    if (last_motion_ == LastMotion::turn) translation_step_mm_ = options_.translation_step_mm;
    if (last_motion_ == LastMotion::slide) rotation_step_rad_ = options_.rotation_step_rad;
  }

  const solve::Joint& joint_;
  Attitude attitude_;
  const SearchOptions& options_;
  fcl::CollisionObjectd fixed_;
  fcl::CollisionObjectd moving_;
  geometry::TreeMesh reference_;  // at the current attitude
  contact::NarrowPhase narrow_phase_;
  MovingPose pose_;
  double translation_step_mm_;
  double rotation_step_rad_;
  LastMotion last_motion_ = LastMotion::none;
  std::vector<MovingPose> history_;
  FclStep step_;
};

}  // namespace

std::shared_ptr<FclModel> fcl_model(const Mesh& mesh)
{
  auto model = std::make_shared<FclModel>();
  model->beginModel();
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const auto [a, b, c] = corners(mesh, t);
    model->addTriangle(a, b, c);
  }
  model->endModel();
  return model;
}

FclPair::FclPair(const solve::Joint& joint)
    : reference(fcl_model(joint.reference.tree_mesh.mesh)), moving(fcl_model(joint.moving.tree_mesh.mesh))
{
}

FclStep find_stable_pose_by_fcl(const solve::Joint& joint, const FclPair& models, const Attitude& attitude,
                                const MovingPose& seed, const SearchOptions& options)
{
  return Search(joint, models, attitude, seed, options).run();
}

}  // namespace vrda::benchmarks
