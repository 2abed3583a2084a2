// Warnings about the axes, the side and the rotation centre of a joint, judged from its geometry.
#include "job/case_warnings.hpp"

#include <algorithm>
#include <cmath>

#include "model/side.hpp"
#include "core/text.hpp"
#include "job/condyles.hpp"
#include "job/joint_shape.hpp"
#include "job/unit_check.hpp"

namespace vrda::job {
namespace {

bool mentions(const std::string& name, const std::string& word)
{
  return lower_case(name).find(word) != std::string::npos;
}

// Whether the name of an object or of one of its components contains one of the words.
bool mentions(const Body& body, const std::vector<std::string>& words)
{
  std::vector<std::string> names{body.name};
  for (const Component& component : body.components) names.push_back(component.name);
  return std::any_of(names.begin(), names.end(), [&](const std::string& name) {
    return std::any_of(words.begin(), words.end(),
                       [&](const std::string& word) { return mentions(name, word); });
  });
}

void warn_of_joint(const Job& job, const Case& loaded, std::vector<std::string>& warnings)
{
  const std::vector<std::string> bones_elsewhere{"pelvis", "acetab", "scapula", "glenoid", "humer",
                                                 "talus",  "calcan", "ulna",    "vertebra"};
  const std::string names = "\"" + loaded.reference.name + "\" and \"" + loaded.moving.name + "\"";
  if (job.joint == "knee" &&
      (mentions(loaded.reference, bones_elsewhere) || mentions(loaded.moving, bones_elsewhere))) {
    warnings.push_back("joint: \"knee\", but the objects " + names +
                       " have names of other bones; for another joint write joint = \"hip\", \"ankle\", "
                       "\"subtalar\" or \"other\"");
  }
  if (job.joint != "knee" && mentions(loaded.reference, {"femur", "femoral"}) &&
      mentions(loaded.moving, {"tibia"})) {
    warnings.push_back("joint: \"" + job.joint + "\", but the objects " + names +
                       " have names of knee bones; joint = \"knee\" adds compartments and checks");
  }
}

Eigen::Vector3d middle_of(const Box& box)
{
  return 0.5 * (box.min_mm + box.max_mm);
}

// The signed axis of the files for a direction along canonical axis `k`.
std::string file_axis(const FrameJob& frame, Eigen::Index k, bool is_positive)
{
  const std::string& word = k == 0 ? frame.anterior : k == 1 ? frame.proximal : frame.right;
  return ((word.at(0) == '+') == is_positive ? "+" : "-") + word.substr(1);
}

std::string tenths_text(double value_mm)
{
  const std::string text = shortest_decimal(std::round(10.0 * value_mm) / 10.0);
  return text.find('.') == std::string::npos ? text + ".0" : text;
}

// The femur must be above the tibia. Returns true if a warning was added.
bool warn_of_axes(const Job& job, const Case& loaded, std::vector<std::string>& warnings)
{
  const Eigen::Vector3d upward_mm = middle_of(bounding_box(loaded.reference.contact.mesh)) -
                                    middle_of(bounding_box(loaded.moving.contact.mesh));
  constexpr double min_ratio = 1.5;  // to the vertical distance, for a clear decision
  Eigen::Index k = 0;
  const double largest_mm = upward_mm.cwiseAbs().maxCoeff(&k);
  if (k == 1 && upward_mm.y() >= 0.0) return false;
  if (k != 1 && largest_mm < min_ratio * std::abs(upward_mm.y())) return false;
  constexpr double min_share = 0.2;  // of the smaller object: a shorter distance gives no clear direction
  const double smaller_mm = std::min(diagonal_mm(bounding_box(loaded.reference.contact.mesh)),
                                     diagonal_mm(bounding_box(loaded.moving.contact.mesh)));
  if (largest_mm < min_share * smaller_mm) return false;
  const bool is_exchanged =
      mentions(loaded.reference, {"tibia"}) || mentions(loaded.moving, {"femur", "femoral"});
  if (job.reference.frame || job.moving.frame) {
    warnings.push_back("frame: in the frames of both objects the reference \"" + loaded.reference.name +
                       "\" is not proximal of the moving object \"" + loaded.moving.name +
                       "\"; check origin, axes and align of both, or exchange [reference] and [moving]");
    return true;
  }
  const std::string axis = file_axis(job.frame, k, upward_mm[k] > 0.0);
  warnings.push_back("frame.proximal: the reference \"" + loaded.reference.name + "\" is along " + axis +
                     " of the files from the moving object \"" + loaded.moving.name + "\", not along " +
                     job.frame.proximal + "; " +
                     (is_exchanged ? "by their names [reference] and [moving] are exchanged"
                                   : "frame.proximal = \"" + axis +
                                         "\", with anterior and right to match, or exchange [reference] and "
                                         "[moving]"));
  return true;
}

// Delta pushes the moving object into the reference, which must be ahead of it.
void warn_of_exchange(const Case& loaded, std::vector<std::string>& warnings)
{
  const Box reference = bounding_box(loaded.reference.contact.mesh);
  const Box moving = bounding_box(loaded.moving.contact.mesh);
  const double ahead_mm = (middle_of(reference) - middle_of(moving)).dot(loaded.push_at_meshes.delta);
  constexpr double min_share = 0.2;  // of the smaller object: a shorter distance gives no clear direction
  if (ahead_mm >= -min_share * std::min(diagonal_mm(reference), diagonal_mm(moving))) return;
  warnings.push_back("push.delta: it points away from the reference \"" + loaded.reference.name + "\", " +
                     tenths_text(-ahead_mm) + " mm behind the moving object \"" + loaded.moving.name +
                     "\"; reverse push.delta, or exchange [reference] and [moving]");
}

// Mean z of the components whose name contains a word; empty without such components.
std::optional<double> mean_z_mm(const std::vector<ComponentSurvey>& survey, const char* word,
                                const char* synonym)
{
  double sum = 0.0;
  int n = 0;
  for (const ComponentSurvey& component : survey) {
    if (!mentions(component.name, word) && !mentions(component.name, synonym)) continue;
    sum += middle_of(component.box).z();
    ++n;
  }
  return n == 0 ? std::nullopt : std::optional<double>(sum / n);
}

// On a right knee lateral is to the right; the fibula is lateral.
void warn_of_side(const Job& job, const Case& loaded, std::vector<std::string>& warnings)
{
  const std::optional<double> medial_mm = mean_z_mm(loaded.survey, "medial", "medial");
  const std::optional<double> lateral_mm = mean_z_mm(loaded.survey, "lateral", "fibula");
  if (!medial_mm && !lateral_mm) return;
  const double centre_mm = loaded.frame.rotation_centre_mm.z();
  const double to_the_right_mm = lateral_mm.value_or(centre_mm) - medial_mm.value_or(centre_mm);
  const std::string found = side_name(to_the_right_mm > 0.0 ? Side::right : Side::left);
  const std::string given = side_name(job.side);
  if (to_the_right_mm == 0.0 || found == given) return;
  warnings.push_back("side: the job has \"" + given + "\", but the components named lateral are to the " +
                     found + " of those named medial, as in a " + found + " knee; side = \"" + found +
                     "\", unless frame.anterior and frame.right both have the wrong sign");
}

// A position as a value of the reference's origin, rounded to 0.1 mm.
std::string origin_text(const Job& job, const Eigen::Vector3d& p_mm)
{
  const AxisMap map = body_map(job, job.reference);
  const Eigen::Vector3d native = map.X_canonical_native.inverse() * p_mm / map.unit_mm;
  const double tenths = 10.0 * map.unit_mm;  // of a millimetre, in the files' unit
  std::string text;
  for (const double value : native)
    text += (text.empty() ? "" : ", ") + shortest_decimal(std::round(value * tenths) / tenths + 0.0);
  return frame_of(job, job.reference).key + ".origin = [" + text + "]";
}

// Centre of the intersection of two boxes, or of the gap between them.
Eigen::Vector3d middle_between(const Box& a, const Box& b)
{
  return 0.5 * (a.min_mm.cwiseMax(b.min_mm) + a.max_mm.cwiseMin(b.max_mm));
}

double distance_mm(const Eigen::Vector3d& p_mm, const Box& box)
{
  return (p_mm - p_mm.cwiseMax(box.min_mm).cwiseMin(box.max_mm)).norm();
}

// Without condyle spheres: a centre far from either object.
void warn_of_centre_off_objects(const Job& job, const Case& loaded, std::vector<std::string>& warnings)
{
  // The centre of a hip is 30 mm inside its bones; an epicondylar axis is 50 mm from the patella.
  const double farthest_mm = job.joint == "knee" ? 60.0 : 100.0;
  const Box reference = bounding_box(loaded.reference.contact.mesh);
  const Box moving = bounding_box(loaded.moving.contact.mesh);
  const Eigen::Vector3d& centre_mm = loaded.frame.rotation_centre_mm;
  const bool is_reference = distance_mm(centre_mm, reference) > distance_mm(centre_mm, moving);
  const double off_mm = distance_mm(centre_mm, is_reference ? reference : moving);
  if (off_mm <= farthest_mm) return;
  warnings.push_back(frame_of(job, job.reference).key + ".origin: the rotation centre is " +
                     tenths_text(off_mm) + " mm from the box of " +
                     (is_reference ? loaded.reference.name : loaded.moving.name) +
                     "; the midpoint between both objects as a start value: " +
                     origin_text(job, middle_between(reference, moving)));
}

void warn_of_centre(const Job& job, const Case& loaded, std::vector<std::string>& warnings)
{
  constexpr double farthest_mm = 30.0;  // from the midpoint of the condyles' centres
  const std::optional<CondyleSpheres> spheres =
      job.joint == "knee" ? condyle_spheres(loaded.reference.contact.mesh) : std::nullopt;
  if (!spheres) return warn_of_centre_off_objects(job, loaded, warnings);
  const Eigen::Vector3d middle_mm = 0.5 * (spheres->left.centre_mm + spheres->right.centre_mm);
  const double off_mm = (loaded.frame.rotation_centre_mm - middle_mm).norm();
  if (off_mm <= farthest_mm) return;
  warnings.push_back(frame_of(job, job.reference).key + ".origin: the rotation centre is " +
                     tenths_text(off_mm) + " mm from the middle of the condyles, which is " +
                     origin_text(job, middle_mm));
}

}  // namespace

std::vector<std::string> anatomy_warnings(const Job& job, const Case& loaded)
{
  std::vector<std::string> warnings;
  warn_of_joint(job, loaded, warnings);
  const std::string shape = joint_shape_warning(job.joint, loaded);
  if (!shape.empty()) warnings.push_back(shape);
  // With wrong axes the checks of side and condyles are meaningless.
  if (job.joint == "knee" && warn_of_axes(job, loaded, warnings)) return warnings;
  if (job.joint == "knee") warn_of_side(job, loaded, warnings);
  if (job.joint != "knee") warn_of_exchange(loaded, warnings);
  warn_of_centre(job, loaded, warnings);
  return warnings;
}

}  // namespace vrda::job
