#include "prepare/frame_check.hpp"

#include <cmath>

#include "model/side.hpp"
#include "core/text.hpp"
#include "core/trig.hpp"
#include "core/units.hpp"
#include "job/axis_map.hpp"
#include "prepare/template_joint.hpp"
#include "geometry/coarse_fit.hpp"
#include "geometry/knee_surfaces.hpp"

namespace vrda::prepare {
namespace {

// Knees prepared by the template are fitted as closely. Frames defined by different people differ by some 15
// degrees and mm.
constexpr double largest_reliable_residual_mm = 3.5;
constexpr double certain_side_margin = 1.15;
constexpr double largest_turn_deg = 30.0, largest_offset_mm = 30.0;

double turn_deg(const Eigen::Matrix3d& R)
{
  const Eigen::Quaterniond q(R);
  return deg_from_rad(2.0 * arc_tangent2(q.vec().norm(), std::abs(q.w())));
}

// The bones are compared together, so that both frames are meant.
std::string both(const FrameKeys& keys, const std::string& ending)
{
  if (keys.reference == keys.moving) return keys.reference + ending;
  return keys.reference + ending + ", " + keys.moving + ending;
}

}  // namespace

std::vector<std::string> frame_warnings(const job::Case& knee, const FrameKeys& keys)
{
  geometry::KneeSurfaces bones{surfaces_of(knee.reference), surfaces_of(knee.moving)};
  const Mesh femur = joined(bones.femur), tibia = joined(bones.tibia);
  if (knee.joint != "knee" || femur.triangles.rows() == 0 || tibia.triangles.rows() == 0) return {};
  const std::string remedy = "; vrda prepare finds unit, side and frame";
  const double unit_mm = geometry::unit_mm_of(femur, tibia);
  if (unit_mm != 1.0)
    return {both(keys, ".unit") + ": the bones have the size of a knee in " + job::unit_of_mm(unit_mm) +
            remedy};
  const geometry::TemplateKnee reference = geometry::generic_template();
  const geometry::CoarseFit fit = coarse_fit(bones, reference);
  const bool is_left = fit.left.residual_mm < fit.right.residual_mm;
  const Side side = is_left ? Side::left : Side::right;
  const geometry::SimilarityFit& best = is_left ? fit.left : fit.right;
  if (!(best.residual_mm < largest_reliable_residual_mm)) return {};
  std::vector<std::string> warnings;
  const double margin = (is_left ? fit.right : fit.left).residual_mm / best.residual_mm;
  if (margin > certain_side_margin && side != knee.frame.side)
    warnings.push_back("side: the bones are those of a " + side_name(side) + " knee in these axes" + remedy);
  const double turned_deg = turn_deg(best.R);
  const double off_mm =
      (best.t_mm - knee.frame.rotation_centre_mm).norm();  // the template's origin is its centre
  if (turned_deg > largest_turn_deg)
    warnings.push_back(both(keys, "") + ": the bones are turned by " +
                       shortest_decimal(std::round(turned_deg)) + " degrees from these axes" + remedy);
  else if (off_mm > largest_offset_mm)
    warnings.push_back(keys.reference + ".origin: " + shortest_decimal(std::round(off_mm)) +
                       " mm from the flexion axis between the condyles" + remedy);
  return warnings;
}

}  // namespace vrda::prepare
