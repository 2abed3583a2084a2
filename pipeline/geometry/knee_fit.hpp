/// The two bones of a knee, of a subject or of a template.
#pragma once

#include <Eigen/Core>

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "geometry/nearest_surface.hpp"
#include "model/coordinates.hpp"
#include "model/frames.hpp"
#include "model/mesh.hpp"

namespace vrda::geometry {

/// A bone by the surfaces that are known of it; normals outward.
struct BoneSurfaces {
  Mesh bone;       ///< empty: unknown
  Mesh cartilage;  ///< empty: unknown
};

/// Both surfaces in one mesh.
Mesh joined(const BoneSurfaces& surfaces);

/// Exchanges inside and outside: faces and normals.
void reverse_winding(Mesh& mesh);

/// Both bones in one pose and one frame, mm.
struct KneeSurfaces {
  BoneSurfaces femur;
  BoneSurfaces tibia;
};

/// Reflected in Z = 0.
KneeSurfaces mirrored_z(const KneeSurfaces& knee);

/// A right knee in canonical axes near extension, to which others are compared.
struct TemplateKnee {
  KneeSurfaces surfaces;
  Eigen::Vector3d origin_mm{0.0, 0.0, 0.0};  ///< the rotation centre
};

/// Width of a knee's joint, of the template too: the geometric mean over both bones of the second-largest
/// extent along principal axes, however much of the shafts is there. In the unit of the meshes.
double joint_width(const Mesh& femur, const Mesh& tibia);
inline constexpr double usual_joint_width_mm = 75.0;
/// Widths of knees that are fitted, over the usual one: from a small child's.
inline constexpr double least_knee_size = 0.4, largest_knee_size = 1.45;

/// Factor from the unit of the meshes to mm: 1, 10 or 1000, whichever makes the joint's width nearest to the
/// usual one.
double unit_mm_of(const Mesh& femur, const Mesh& tibia);

/// Where both bones are near each other, and the direction from the tibia to the femur there.
struct JointRegion {
  Eigen::Vector3d centre_mm{0.0, 0.0, 0.0};
  Eigen::Vector3d up{0.0, 1.0, 0.0};
  double nearest_mm = 0.0;  ///< smallest distance between samples of the bones
};
JointRegion joint_region(const Mesh& femur, const Mesh& tibia);

/// The knee that is registered where no other template is given: the generated "knee-template", divided into
/// bone and cartilage.
TemplateKnee generic_template();

// Pose, size and side of a knee in any orientation, without a start value.

/// A template of one side placed on the subject: p_subject = scale * R * p_template + t.
struct SimilarityFit {
  double scale = 1.0;
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_mm = Eigen::Vector3d::Zero();
  /// Root mean square distance of the nearest 80 % of the template's points, at the template's size;
  /// infinite where too few points have a counterpart.
  double residual_mm = std::numeric_limits<double>::infinity();
  double flexion_rad = 0.0;  ///< by which the template's femur was turned before the fit
};

struct CoarseFit {
  SimilarityFit right;      ///< of the template
  SimilarityFit left;       ///< of the mirrored template
  double nearest_mm = 0.0;  ///< smallest distance between samples of the subject's bones
};

/// Both bones as one: 12 turns about the direction through the joint, of the template and of the mirrored
/// template, each followed by a trimmed similarity fit; the best four of each side are fitted further. Moved
/// and mirrored subjects give moved and mirrored fits. Where a quarter of the points find no turn with a
/// residual below `hopeless_mm`, the search ends there, with infinite residuals.
CoarseFit coarse_fit(const KneeSurfaces& subject, const TemplateKnee& reference,
                     double hopeless_mm = std::numeric_limits<double>::infinity());

// The precise fit of one bone, from a start within some degrees and millimetres.

/// A bone of the template placed on the subject's: p_subject = R * scale * p_template + t.
struct BoneFit {
  Eigen::Vector3d scale = Eigen::Vector3d::Ones();  ///< along the template's axes
  Eigen::Matrix3d R = Eigen::Matrix3d::Identity();
  Eigen::Vector3d t_mm = Eigen::Vector3d::Zero();
  double residual_mm = 0.0;  ///< root mean square distance of the pairs kept, at the template's size
  /// The same of all points; one farther than 5 mm or without counterpart counts as 5 mm.
  /// Known points count with their weight, one farther than 15 mm as 15 mm.
  double mismatch_mm = 0.0;

  Eigen::Vector3d operator()(const Eigen::Vector3d& p_template_mm) const
  {
    return R * scale.cwiseProduct(p_template_mm) + t_mm;
  }
  /// Unit normal of the placed surface.
  Eigen::Vector3d normal(const Eigen::Vector3d& n_template) const
  {
    return (R * n_template.cwiseQuotient(scale)).normalized();
  }
};

/// Which scale is fitted.
enum class ScaleFreedom {
  held,        ///< that of the start
  similarity,  ///< one factor
  axes,        ///< similarity first, then a factor per axis, regularised to their mean
  near_start,  ///< held first, then a factor per axis, regularised to that of the start, least along Y
};

/// A point that is known of both, such as an epicondyle.
struct KnownPoint {
  Eigen::Vector3d template_mm = Eigen::Vector3d::Zero();
  Eigen::Vector3d subject_mm = Eigen::Vector3d::Zero();
};

struct BoneFitOptions {
  ScaleFreedom freedom = ScaleFreedom::axes;
  double kept = 0.9;  ///< share of the pairs, the nearest
  /// Each weighs as much as a hundredth of the surface, so it matters where the surface does not
  /// determine the fit. One that stays 15 mm off weighs a quarter of that, and less beyond.
  std::vector<KnownPoint> known = {};
  std::function<bool()> is_stopped = {};  ///< polled; true: returns a fit that means nothing
};

/// Point-to-plane fit of the template's points, from the best of several starts. The points are fixed for a
/// template: random ones would move the frame by 1 to 7 degrees. Each step solves a linear least-squares
/// problem. Expects at least one start.
BoneFit fit_bone(const SurfacePoints& template_points, const NearestSurface& subject,
                 const std::vector<BoneFit>& starts, const BoneFitOptions& options);

// Registers a subject's knee with a template: unit, side, and the frame of each bone.

struct KneeFitOptions {
  std::optional<Side> side;       ///< known side; absent: found
  std::optional<double> unit_mm;  ///< known unit; absent: found
  /// Points known of each bone; the subject's in its own unit.
  std::vector<KnownPoint> femur_points = {}, tibia_points = {};
  std::function<bool()> is_stopped = {};  ///< polled by any thread; true: returns a fit that means nothing
  int n_threads = 1;                      ///< two fit both bones at once; the same bits for any number
};

/// Between the bones of one knee with 5 mm of cartilage, with room for flexed scans.
constexpr double largest_gap_mm = 20.0;

/// The template, mirrored for a left knee, placed on the subject.
struct KneeFit {
  double unit_mm = 1.0;  ///< of the subject's meshes
  /// Of a child's knee: its width over the template's, by which it was enlarged for the fit; else 1.
  double size = 1.0;
  Side side = Side::right;
  double side_margin = 1.0;  ///< coarse residual of the other side over that of `side`
  double coarse_residual_mm = 0.0;
  double nearest_mm = 0.0;  ///< smallest distance between samples of the bones
  BoneFit femur, tibia;
  /// Canonical axes of each bone (X anterior, Y proximal, Z the subject's right) with its origin at the
  /// image of the template's rotation centre, in the subject's axes, mm.
  Pose X_scan_femur = Pose::Identity();
  Pose X_scan_tibia = Pose::Identity();
  ClinicalCoordinates scanned;  ///< tibia in the femur's frame, as in the scan
};

/// `subject` is in any unit and orientation. A knee of 0.4 to 0.8 of the usual width that is refused as it
/// is, is fitted at the usual width.
KneeFit fit_knee(const KneeSurfaces& subject, const TemplateKnee& reference,
                 const KneeFitOptions& options = {});

// Whether a fit is that of a knee.

/// Whether both bones have the shape of the template's, not only one like it.
bool is_template_itself(const KneeFit& fit);

/// Why a knee is refused: which measure is out of range, with its limit; empty: accepted.
std::vector<std::string> rejection_reasons(const KneeFit& fit, const KneeSurfaces& subject);

/// The mistake that explains a refusal: a wrong side or unit in `known`, exchanged bones, or an open sheet
/// wound inward; empty: none found. Repeats the whole fit for each, unless only the length of a bone is
/// refused.
std::string probable_cause(const KneeFit& fit, const KneeSurfaces& subject, const TemplateKnee& reference,
                           const KneeFitOptions& known = {});

/// Accepted, but doubtful: little bone, cartilage only, an uncertain side.
std::vector<std::string> fit_warnings(const KneeFit& fit, const KneeSurfaces& subject, bool is_side_given);

/// What shows that a mesh is no surface, such as random triangles; empty: none. A search of the nearest point
/// visits all of its triangles, so a fit takes minutes. In any unit.
std::string tangle_in(const Mesh& mesh);

/// Whether a mesh is the part that it is said to be.
struct PartCheck {
  std::string rejection;  ///< empty: accepted
  std::string doubt;      ///< of an accepted part; empty: none
};

enum class CartilageOf { femur, tibia };

/// Cartilage lies on its own bone, not on the other nor, as a meniscus does, between both. In the scan's
/// axes, mm; either bone may be empty.
PartCheck cartilage_check(const Mesh& part, CartilageOf bone, const Mesh& own_bone, const Mesh& other_bone);

/// Whether nine tenths of the points of `part` are on `surface`, within 0.5 mm or less for small parts: the
/// same surface, a copy with other triangles, or a piece of it. Meshes in mm without unused vertices.
bool is_part_of(const Mesh& part, const Mesh& surface);

/// A meniscus lies near the tibia (bone and cartilage). In the scan's axes, mm.
PartCheck meniscus_check(const Mesh& part, const Mesh& tibia);

/// Why a mesh is not the fibula of a tibia: a copy of the tibia, the height of its head, or its distance;
/// empty: accepted. Both are in the tibia's anatomical frame, mm; `size` is that of the fit.
std::string fibula_rejection(const Mesh& fibula, const Mesh& tibia, double size = 1.0);

/// Whether the head of the fibula, its highest 20 mm, is lateral of the rotation centre. `fibula` is in the
/// tibia's anatomical frame.
bool is_fibula_lateral(const Mesh& fibula, Side side);

}  // namespace vrda::geometry
