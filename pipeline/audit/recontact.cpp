#include "audit/recontact.hpp"

#include "audit/attitude_rows.hpp"
#include "core/units.hpp"

namespace vrda {

GridD recontact(const MotionModel& model, const SmoothedSet& set, int n_threads)
{
  const Motion motion(model, set);
  GridD travel_mm(static_cast<Eigen::Index>(model.flexion_deg.size()),
                  static_cast<Eigen::Index>(model.varus_deg.size()));
  for_each_row(model, motion, model.flexion_deg, n_threads, [&](std::size_t row, PoseMeter& meter) {
    for (Eigen::Index j = 0; j < travel_mm.cols(); ++j) {
      const JointPose pose = motion.at(
          {rad_from_deg(model.flexion_deg[row]), rad_from_deg(model.varus_deg[static_cast<std::size_t>(j)])});
      travel_mm(static_cast<Eigen::Index>(row), j) =
          meter.travel_into_contact_mm(pose.attitude, pose.X_reference_moving);
    }
  });
  return travel_mm;
}

}  // namespace vrda
