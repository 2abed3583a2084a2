#include "load/anatomy_warnings.hpp"

#include <algorithm>
#include <cmath>

#include "core/text.hpp"
#include "load/condyles.hpp"
#include "load/unit_check.hpp"

namespace vrda {
namespace {

std::string lower_case(std::string text)
{
  for (char& c : text) {
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  }
  return text;
}

bool mentions(const std::string& name, const std::string& word)
{
  return lower_case(name).find(word) != std::string::npos;
}

// Whether the name of an object or of one of its components has one of the words.
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
  const std::string name = "\"" + loaded.reference.name + "\" and \"" + loaded.moving.name + "\"";
  if (job.joint == "knee" &&
      (mentions(loaded.reference, bones_elsewhere) || mentions(loaded.moving, bones_elsewhere))) {
    warnings.push_back("joint: \"knee\", but the objects " + name +
                       " have names of other bones; of another joint: joint = \"other\"");
  }
  if (job.joint != "knee" && mentions(loaded.reference, {"femur", "femoral"}) &&
      mentions(loaded.moving, {"tibia"})) {
    warnings.push_back("joint: \"" + job.joint + "\", but the objects " + name +
                       " have names of a knee's bones; joint = \"knee\" gives compartments and more checks");
  }
}

Eigen::Vector3d middle_of(const Box& box)
{
  return 0.5 * (box.min_mm + box.max_mm);
}

// The axis of the files, with its sign, that a direction along canonical axis `k` has.
std::string file_axis(const FrameJob& frame, Eigen::Index k, bool is_positive)
{
  const std::string& word = k == 0 ? frame.anterior : k == 1 ? frame.proximal : frame.right;
  return ((word.at(0) == '+') == is_positive ? "+" : "-") + word.substr(1);
}

// The femur lies above the tibia. Whether it does not, along some other axis of the files.
bool warn_of_axes(const Job& job, const Case& loaded, std::vector<std::string>& warnings)
{
  const Eigen::Vector3d upward_mm = middle_of(bounding_box(loaded.reference.contact.mesh)) -
                                    middle_of(bounding_box(loaded.moving.contact.mesh));
  constexpr double clearly = 1.5;  // times the height
  Eigen::Index k = 0;
  const double largest_mm = upward_mm.cwiseAbs().maxCoeff(&k);
  if (k == 1 && upward_mm.y() >= 0.0) return false;
  if (k != 1 && largest_mm < clearly * std::abs(upward_mm.y())) return false;
  constexpr double apart = 0.2;  // of the smaller object: less says nothing about directions
  const double smaller_mm = std::min(diagonal_mm(bounding_box(loaded.reference.contact.mesh)),
                                     diagonal_mm(bounding_box(loaded.moving.contact.mesh)));
  if (largest_mm < apart * smaller_mm) return false;
  const bool is_exchanged =
      mentions(loaded.reference, {"tibia"}) || mentions(loaded.moving, {"femur", "femoral"});
  const std::string axis = file_axis(job.frame, k, upward_mm[k] > 0.0);
  warnings.push_back("frame.proximal: the reference \"" + loaded.reference.name + "\" lies along " + axis +
                     " of the files from the moving object \"" + loaded.moving.name + "\", not along " +
                     job.frame.proximal + "; " +
                     (is_exchanged ? "the names say that [reference] and [moving] are exchanged"
                                   : "frame.proximal = \"" + axis + "\", with anterior and right to match"));
  return true;
}

// Mean z of the components whose name says one side; nothing when none does.
std::optional<double> mean_z_mm(const std::vector<ComponentSurvey>& survey, const char* word,
                                const char* also)
{
  double sum = 0.0;
  int n = 0;
  for (const ComponentSurvey& component : survey) {
    if (!mentions(component.name, word) && !mentions(component.name, also)) continue;
    sum += middle_of(component.box).z();
    ++n;
  }
  return n == 0 ? std::nullopt : std::optional<double>(sum / n);
}

// Lateral lies to the right on a right knee; the fibula is lateral too.
void warn_of_side(const Job& job, const Case& loaded, std::vector<std::string>& warnings)
{
  const std::optional<double> medial_mm = mean_z_mm(loaded.survey, "medial", "medial");
  const std::optional<double> lateral_mm = mean_z_mm(loaded.survey, "lateral", "fibula");
  if (!medial_mm && !lateral_mm) return;
  const double centre_mm = loaded.frame.rotation_centre_mm.z();
  const double to_the_right_mm = lateral_mm.value_or(centre_mm) - medial_mm.value_or(centre_mm);
  const std::string looks = to_the_right_mm > 0.0 ? "right" : "left";
  const std::string says = job.side == Side::right ? "right" : "left";
  if (to_the_right_mm == 0.0 || looks == says) return;
  warnings.push_back("side: the job says " + says + ", but the components named lateral lie to the " + looks +
                     " of those named medial, as in a " + looks + " knee; side = \"" + looks +
                     "\", unless frame.anterior and frame.right both have the wrong sign");
}

// A place as the job's frame.origin has it, to a tenth of a millimetre.
std::string origin_text(const Eigen::Vector3d& p_mm, const AxisMap& map)
{
  const Eigen::Vector3d native = map.X_canonical_native.inverse() * p_mm / map.unit_mm;
  const double tenths = 10.0 * map.unit_mm;  // of a millimetre, in the files' unit
  std::string text;
  for (const double value : native)
    text += (text.empty() ? "" : ", ") + shortest(std::round(value * tenths) / tenths + 0.0);
  return "frame.origin = [" + text + "]";
}

std::string tenths_text(double value_mm)
{
  const std::string text = shortest(std::round(10.0 * value_mm) / 10.0);
  return text.find('.') == std::string::npos ? text + ".0" : text;
}

// Of boxes that overlap the middle of what they share, of others that of what lies between them.
Eigen::Vector3d middle_between(const Box& a, const Box& b)
{
  return 0.5 * (a.min_mm.cwiseMax(b.min_mm) + a.max_mm.cwiseMin(b.max_mm));
}

double distance_mm(const Eigen::Vector3d& p_mm, const Box& box)
{
  return (p_mm - p_mm.cwiseMax(box.min_mm).cwiseMin(box.max_mm)).norm();
}

// Where no condyles are known: far from either object.
void warn_of_centre_off_objects(const Job& job, const AxisMap& map, const Case& loaded,
                                std::vector<std::string>& warnings)
{
  // A hip's centre lies 30 mm within its bones, an axis through the epicondyles 50 mm from the patella.
  const double farthest_mm = job.joint == "knee" ? 60.0 : 100.0;
  const Box reference = bounding_box(loaded.reference.contact.mesh);
  const Box moving = bounding_box(loaded.moving.contact.mesh);
  const Eigen::Vector3d& centre_mm = loaded.frame.rotation_centre_mm;
  const bool is_reference = distance_mm(centre_mm, reference) > distance_mm(centre_mm, moving);
  const double off_mm = distance_mm(centre_mm, is_reference ? reference : moving);
  if (off_mm <= farthest_mm) return;
  warnings.push_back("frame.origin: the rotation centre lies " + tenths_text(off_mm) +
                     " mm from the box of " + (is_reference ? loaded.reference.name : loaded.moving.name) +
                     "; the middle between both objects, to start from: " +
                     origin_text(middle_between(reference, moving), map));
}

void warn_of_centre(const Job& job, const AxisMap& map, const Case& loaded,
                    std::vector<std::string>& warnings)
{
  constexpr double farthest_mm = 30.0;  // DESIGN.md 3
  const std::optional<CondyleSpheres> spheres =
      job.joint == "knee" ? condyle_spheres(loaded.reference.contact.mesh) : std::nullopt;
  if (!spheres) return warn_of_centre_off_objects(job, map, loaded, warnings);
  const Eigen::Vector3d middle_mm = 0.5 * (spheres->left.centre_mm + spheres->right.centre_mm);
  const double off_mm = (loaded.frame.rotation_centre_mm - middle_mm).norm();
  if (off_mm <= farthest_mm) return;
  warnings.push_back("frame.origin: the rotation centre lies " + tenths_text(off_mm) +
                     " mm from the middle of the condyles; there it is " + origin_text(middle_mm, map));
}

}  // namespace

std::vector<std::string> anatomy_warnings(const Job& job, const AxisMap& map, const Case& loaded)
{
  std::vector<std::string> warnings;
  warn_of_joint(job, loaded, warnings);
  // With wrong axes neither side nor condyles are where they are looked for.
  if (job.joint == "knee" && warn_of_axes(job, loaded, warnings)) return warnings;
  if (job.joint == "knee") warn_of_side(job, loaded, warnings);
  warn_of_centre(job, map, loaded, warnings);
  return warnings;
}

}  // namespace vrda
