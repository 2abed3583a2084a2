// Checks of a fitted knee: factors, lengths and distances beyond which a fit is rejected or doubted.
#include "geometry/knee_fit.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::geometry {
namespace {

// Limits that accepted all of 16 knees in a trial and refused wrong bones.
constexpr double largest_coarse_mm = 3.5, largest_residual_mm = 1.9;
constexpr double largest_varus_deg = 10.0, largest_internal_deg = 30.0;
constexpr double least_flexion_deg = -15.0, largest_flexion_deg = 120.0;
constexpr double refused_length_mm = 40.0;  // frames of shorter stumps are wrong by more than 5 degrees
constexpr double identical_mm = 0.5;  // residual of a bone with the template's shape, whose frame is exact
constexpr double short_length_mm = 45.0;
constexpr double least_margin = 1.05;

void require_at_most(double value, double limit, const std::string& what, std::vector<std::string>& found)
{
  if (value <= limit) return;
  found.push_back(std::isfinite(value)
                      ? what + " " + short_decimal(value, 3) + " mm (at most " + shortest_decimal(limit) + ")"
                      : what + ": no fit");
}

void require_within(double value, double least, double most, const std::string& what,
                    std::vector<std::string>& found)
{
  if (value >= least && value <= most) return;
  found.push_back(what + " " + short_decimal(value, 1) + " degrees (" + shortest_decimal(least) + " to " +
                  shortest_decimal(most) + ")");
}

// From the joint to the end of the bone, along the bone's own axis.
double length_mm(const Mesh& bone, const KneeFit& fit, const Pose& X_scan_bone, double sign)
{
  if (bone.vertices_mm.rows() == 0) return 0.0;
  const Pose X_bone_scan = X_scan_bone.inverse();
  double farthest = 0.0;
  for (const auto& row : bone.vertices_mm.rowwise())
    farthest = std::max(farthest, sign * (X_bone_scan * Eigen::Vector3d(fit.unit_mm * row.transpose())).y());
  return farthest;
}

struct Lengths {
  double femur_mm, tibia_mm;
};

// The joint line is 20 mm below the rotation centre of a knee.
Lengths lengths_of(const KneeFit& fit, const KneeSurfaces& subject)
{
  const double line_mm = 20.0 * fit.size;
  return {length_mm(subject.femur.bone, fit, fit.X_scan_femur, 1.0) + line_mm,
          length_mm(subject.tibia.bone, fit, fit.X_scan_tibia, -1.0) - line_mm};
}

bool has_bone(const BoneSurfaces& surfaces)
{
  return surfaces.bone.triangles.rows() > 0;
}

void require_length(const char* name, const BoneFit& bone, double length_mm, double size,
                    std::vector<std::string>& found)
{
  const double least_mm = refused_length_mm * size;
  if (length_mm >= least_mm || bone.residual_mm < identical_mm) return;
  found.push_back(std::string(name) + ": " + short_decimal(length_mm, 1) + " mm of bone (at least " +
                  short_decimal(least_mm, 1) + ")");
}

// A size outside the template's explains a bad fit.
void name_size(const KneeFit& fit, const KneeSurfaces& subject, std::vector<std::string>& found)
{
  if (found.empty()) return;
  const double width_mm = fit.unit_mm * joint_width(joined(subject.femur), joined(subject.tibia));
  const double size = width_mm / usual_joint_width_mm;
  if (size >= least_knee_size && size <= largest_knee_size) return;
  found.insert(found.begin(), "the size: a joint " + short_decimal(width_mm, 1) + " mm wide (" +
                                  short_decimal(least_knee_size * usual_joint_width_mm, 1) + " to " +
                                  short_decimal(largest_knee_size * usual_joint_width_mm, 1) + ")");
}

std::vector<std::string> fit_rejections(const KneeFit& fit)
{
  std::vector<std::string> found;
  require_at_most(fit.coarse_residual_mm, largest_coarse_mm, "both bones together: residual", found);
  require_at_most(fit.femur.residual_mm, largest_residual_mm, "femur: residual", found);
  require_at_most(fit.tibia.residual_mm, largest_residual_mm, "tibia: residual", found);
  require_within(deg_from_rad(fit.scanned.varus_rad), -largest_varus_deg, largest_varus_deg, "scanned varus",
                 found);
  require_within(deg_from_rad(fit.scanned.internal_rotation_rad), -largest_internal_deg, largest_internal_deg,
                 "scanned internal rotation", found);
  require_within(deg_from_rad(fit.scanned.flexion_rad), least_flexion_deg, largest_flexion_deg,
                 "scanned flexion", found);
  require_at_most(fit.nearest_mm, largest_gap_mm, "bones not in one pose: distance", found);
  return found;
}

// Of at most some 5000 points of a part from a surface, ascending.
std::vector<double> distances_mm(const Mesh& part, const Mesh& surface)
{
  constexpr Eigen::Index most = 5000;
  const NearestSurface nearest(surface);
  const Eigen::Index stride = 1 + part.vertices_mm.rows() / most;
  std::vector<double> distances;
  for (Eigen::Index row = 0; row < part.vertices_mm.rows(); row += stride)
    distances.push_back(nearest.nearest(part.vertices_mm.row(row).transpose()).distance_mm);
  std::sort(distances.begin(), distances.end());
  return distances;
}

double quantile(const std::vector<double>& ascending, double share)
{
  return ascending.at(static_cast<std::size_t>(share * static_cast<double>(ascending.size() - 1)));
}

// A part whose middle point is far away has another place or unit; a tenth beyond `usual_mm` is doubtful.
PartCheck distance_check(const std::vector<double>& distances, double usual_mm, const std::string& from)
{
  constexpr double elsewhere_mm = 30.0;
  const double middle_mm = quantile(distances, 0.5), outer_mm = quantile(distances, 0.9);
  if (middle_mm > elsewhere_mm)
    return {"a mesh whose points are " + short_decimal(middle_mm, 1) + " mm from the " + from + " (median)",
            ""};
  if (outer_mm > usual_mm)
    return {"", "a tenth of its points is more than " + short_decimal(outer_mm, 1) + " mm from the " + from +
                    " (usual: at most " + shortest_decimal(usual_mm) + "); check its place, side and unit"};
  return {};
}

double mean(const std::vector<double>& values)
{
  double sum = 0.0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

// Closed surfaces are oriented when they are read.
bool is_open(const BoneSurfaces& surfaces)
{
  return edge_counts(joined(surfaces)).boundary > 0;
}

BoneSurfaces reversed(BoneSurfaces surfaces)
{
  for (Mesh* mesh : {&surfaces.bone, &surfaces.cartilage}) reverse_winding(*mesh);
  return surfaces;
}

}  // namespace

bool is_template_itself(const KneeFit& fit)
{
  return fit.femur.residual_mm < identical_mm && fit.tibia.residual_mm < identical_mm;
}

// What sizes or a distance beyond any scan tell about the units; empty for bones of usual sizes.
std::string suspected_units(const KneeFit& fit, const KneeSurfaces& subject)
{
  constexpr double longest_scan_mm = 1000.0, most_alike = 6.0;
  const auto size_mm = [&](const BoneSurfaces& bone) {
    const Box box = bounding_box(joined(bone));
    return fit.unit_mm * (box.max_mm - box.min_mm).norm();
  };
  const double femur_mm = size_mm(subject.femur), tibia_mm = size_mm(subject.tibia);
  const bool are_alike = std::max(femur_mm, tibia_mm) < most_alike * std::min(femur_mm, tibia_mm);
  if (are_alike && fit.nearest_mm < longest_scan_mm) return "";
  return "; probably the unit is wrong, or that of one file: in the same unit the femur is " +
         short_decimal(femur_mm, 1) + " mm across, the tibia " + short_decimal(tibia_mm, 1) + " mm";
}

std::vector<std::string> rejection_reasons(const KneeFit& fit, const KneeSurfaces& subject)
{
  std::vector<std::string> found = fit_rejections(fit);
  if (found.empty()) {  // frames that are wrong give no length
    const Lengths lengths = lengths_of(fit, subject);
    if (has_bone(subject.femur)) require_length("femur", fit.femur, lengths.femur_mm, fit.size, found);
    if (has_bone(subject.tibia)) require_length("tibia", fit.tibia, lengths.tibia_mm, fit.size, found);
  }
  name_size(fit, subject, found);
  return found;
}

std::string probable_cause(const KneeFit& fit, const KneeSurfaces& subject, const TemplateKnee& reference,
                           const KneeFitOptions& known)
{
  if (fit_rejections(fit).empty()) return "";
  KneeFitOptions free;
  free.is_stopped = known.is_stopped;
  std::optional<KneeFit> found;
  const auto fits = [&](const KneeSurfaces& other) {
    KneeFit one = fit_knee(other, reference, free);
    if (!rejection_reasons(one, other).empty()) return false;
    found = one;
    return true;
  };
  if ((known.side || known.unit_mm) && fits(subject)) {
    if (known.unit_mm && found->unit_mm != *known.unit_mm)
      return std::string("the wrong unit: the bones are in ") + (found->unit_mm < 5.0     ? "mm"
                                                                 : found->unit_mm < 100.0 ? "cm"
                                                                                          : "m");
    if (known.side && found->side != *known.side)
      return "the wrong side: the bones are those of a " + side_name(found->side) + " knee";
  }
  if (fit.nearest_mm > largest_gap_mm)
    return "the bones are not in one pose: " + short_decimal(fit.nearest_mm, 1) + " mm apart" +
           suspected_units(fit, subject);
  if (fits({subject.tibia, subject.femur})) return "femur and tibia are exchanged";
  const bool femur_open = is_open(subject.femur), tibia_open = is_open(subject.tibia);
  if (femur_open && fits({reversed(subject.femur), subject.tibia}))
    return "the femur is inside out: reverse the winding of its open surface";
  if (tibia_open && fits({subject.femur, reversed(subject.tibia)}))
    return "the tibia is inside out: reverse the winding of its open surface";
  if (femur_open && tibia_open && fits({reversed(subject.femur), reversed(subject.tibia)}))
    return "both bones are inside out: reverse the winding of their open surfaces";
  return "";
}

std::vector<std::string> fit_warnings(const KneeFit& fit, const KneeSurfaces& subject, bool is_side_given)
{
  std::vector<std::string> found;
  const Lengths lengths = lengths_of(fit, subject);
  const bool has_any_bone = has_bone(subject.femur) || has_bone(subject.tibia);
  if (!has_any_bone) found.push_back("cartilage only: size and axes are uncertain; give the bones");
  const auto short_bone = [&](const char* name, const BoneSurfaces& bone, double mm) {
    if (!has_bone(bone)) {
      if (has_any_bone)
        found.push_back(std::string(name) + ": cartilage only; its size is taken from the other bone");
    } else if (mm < short_length_mm * fit.size) {
      found.push_back(std::string(name) + ": only " + short_decimal(mm, 1) +
                      " mm of bone; its axes may be off by 5 degrees");
    }
  };
  short_bone("femur", subject.femur, lengths.femur_mm);
  short_bone("tibia", subject.tibia, lengths.tibia_mm);
  if (!is_side_given && fit.side_margin < least_margin)
    found.push_back("side: found " + side_name(fit.side) + " with a margin of only " +
                    short_decimal(fit.side_margin, 3) + "; give --side");
  if (is_side_given && fit.side_margin < 1.0)
    found.push_back("side: the other side fits better (margin " + short_decimal(fit.side_margin, 3) + ")");
  return found;
}

std::string tangle_in(const Mesh& mesh)
{
  // A real bone has about the area of its box; one with all the walls of its spongy bone some ten times it.
  constexpr double most_boxes = 20.0;
  const Box box = bounding_box(mesh);
  const Eigen::Vector3d size_mm = box.max_mm - box.min_mm;
  const double box_mm2 =
      2.0 * (size_mm.x() * size_mm.y() + size_mm.y() * size_mm.z() + size_mm.z() * size_mm.x());
  const double own_mm2 = area_mm2(mesh);
  if (own_mm2 <= most_boxes * box_mm2) return "";
  return "triangles with " + short_decimal(own_mm2 / box_mm2, 1) + " times the area of their box";
}

bool is_part_of(const Mesh& part, const Mesh& surface)
{
  // Cartilage is at least 1 mm thick over most of its area, so a closed layer is half as far from its bone.
  constexpr double same_mm = 0.5, same_share = 0.005;  // of the part's size
  const Box inner = bounding_box(part), outer = bounding_box(surface);
  const double limit_mm = std::min(same_mm, same_share * (inner.max_mm - inner.min_mm).norm());
  const bool is_within = ((inner.min_mm - outer.min_mm).array() > -limit_mm).all() &&
                         ((outer.max_mm - inner.max_mm).array() > -limit_mm).all();
  return is_within && quantile(distances_mm(part, surface), 0.9) < limit_mm;
}

PartCheck cartilage_check(const Mesh& part, CartilageOf bone, const Mesh& own_bone, const Mesh& other_bone)
{
  // Up to 7 mm in the trial's knees.
  constexpr double thick_mm = 8.0;
  // Menisci are within 8 mm of the tibia, cartilage of a femur reaches 32 mm and more. Their mean distance
  // from the femur is at least 0.6 of that from the tibia, that of cartilage at most 0.1.
  constexpr double near_mm = 12.0, femur_share = 0.35;
  // On the tibia: at least 0.8 of that from the femur, with no more than a tenth of a meniscus within 1.1 mm;
  // cartilage 0.3 (0.5 from a femur with cartilage), with a tenth within 0.4 mm.
  constexpr double tibia_share = 0.6, touching_mm = 0.8;
  const std::vector<double> other =
      other_bone.triangles.rows() == 0 ? std::vector<double>{} : distances_mm(part, other_bone);
  const bool is_near_other = !other.empty() && quantile(other, 0.9) < near_mm;
  const auto as_meniscus = [&](const std::string& detail) {
    return PartCheck{"a mesh between both bones, as a meniscus is: nine tenths of it within " +
                         short_decimal(quantile(other, 0.9), 1) + " mm of the other bone" + detail,
                     ""};
  };
  if (own_bone.triangles.rows() == 0)
    return bone == CartilageOf::femur && is_near_other ? as_meniscus("") : PartCheck{};
  const std::vector<double> own = distances_mm(part, own_bone);
  PartCheck check = distance_check(own, thick_mm, "bone");
  if (!check.rejection.empty() || other.empty()) return check;
  const double own_mm = mean(own), other_mm = mean(other);
  if (other_mm < own_mm)
    return {"a mesh that is nearer to the other bone: " + short_decimal(other_mm, 1) +
                " mm on average, to its own " + short_decimal(own_mm, 1) + " mm",
            ""};
  const bool is_meniscus = bone == CartilageOf::femur
                               ? own_mm > femur_share * other_mm
                               : own_mm > tibia_share * other_mm && quantile(own, 0.1) > touching_mm;
  if (is_near_other && is_meniscus)
    return as_meniscus(", on average " + short_decimal(other_mm, 1) + " mm from it and " +
                       short_decimal(own_mm, 1) + " mm from its own");
  return check;
}

PartCheck meniscus_check(const Mesh& part, const Mesh& tibia)
{
  // Up to 7 mm in the trial's knees.
  constexpr double high_mm = 15.0;
  return distance_check(distances_mm(part, tibia), high_mm, "tibia");
}

std::string fibula_rejection(const Mesh& fibula, const Mesh& tibia, double size)
{
  // Below the rotation centre by the joint line's 20 mm and at most the length of a stump.
  const double highest_mm = -15.0 * size, lowest_mm = -90.0 * size;
  constexpr double largest_distance_mm = 15.0, same_mm = 0.1;
  if (quantile(distances_mm(fibula, tibia), 0.5) < same_mm) return "the surface of the tibia";
  const double top_mm = bounding_box(fibula).max_mm.y();
  if (top_mm > highest_mm || top_mm < lowest_mm)
    return "a mesh that ends " + short_decimal(std::abs(top_mm), 1) + " mm " +
           (top_mm > 0.0 ? "above" : "below") + " the rotation centre";
  const NearestSurface surface(tibia);
  double least_mm = std::numeric_limits<double>::infinity();
  for (const std::int32_t row : fibula.triangles.reshaped())
    least_mm = std::min(least_mm, surface.nearest(fibula.vertices_mm.row(row).transpose()).distance_mm);
  if (least_mm > largest_distance_mm)
    return "a mesh that is " + short_decimal(least_mm, 1) + " mm from the tibia";
  return "";
}

bool is_fibula_lateral(const Mesh& fibula, Side side)
{
  constexpr double head_mm = 20.0;
  const double top_mm = bounding_box(fibula).max_mm.y();
  double sum = 0.0;
  for (const std::int32_t row : fibula.triangles.reshaped()) {
    if (fibula.vertices_mm(row, 1) > top_mm - head_mm) sum += fibula.vertices_mm(row, 2);
  }
  return side == Side::right ? sum > 0.0 : sum < 0.0;
}

}  // namespace vrda::geometry
