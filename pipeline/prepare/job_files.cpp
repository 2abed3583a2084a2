#include "prepare/job_files.hpp"

#include <cmath>

#include "core/document.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "prepare/joint_frame.hpp"
#include "prepare/template_joint.hpp"

namespace vrda::prepare {
namespace {

std::string component_text(const std::string& body, const JobComponent& component)
{
  std::string text = "\n[[" + body + ".component]]\nname = \"" + component.name + "\"\nfile = \"" +
                     component.name + ".stl\"\nmaterial = \"" + component.material + "\"\n";
  if (component.inset_mm != 0.0)
    text += "inset_mm = " + shortest_decimal(component.inset_mm) +
            "                # thickened by the missing cartilage\n";
  if (!component.has_contact) text += "contact = false                 # drawn only\n";
  return text;
}

std::string scan_text(const ClinicalCoordinates& scanned)
{
  const auto degrees = [](double rad) { return short_decimal(deg_from_rad(rad), 1); };
  return "# In the scan: flexion " + degrees(scanned.flexion_rad) + ", varus " + degrees(scanned.varus_rad) +
         ", internal rotation " + degrees(scanned.internal_rotation_rad) + " degrees.\n";
}

std::string scan_frame_text(const JobDescription& job)
{
  std::string text = "\n[scan]                                # for vrda export --to stl and --to mrk\n";
  if (!job.scan_space.empty()) text += "space = \"" + job.scan_space + "\"\n";
  text += "unit = \"" + job.scan_unit + "\"\nX_scan_reference = [";
  for (Eigen::Index i = 0; i < 3; ++i)
    text += std::string(i == 0 ? "[" : ", [") + core::numbers_text(job.X_scan_reference->linear().row(i)) +
            ", " + shortest_decimal(job.X_scan_reference->translation()[i]) + "]";
  return text + "]\n";
}

// Stiffnesses and spreads of a trial on six real knees and three held out (results/believable.md).
constexpr const char* prior_text =
    "\n# A weak pull to the mean passive motion of cadaver knees (Walker et al. 1988): bones and fibres "
    "alone "
    "do\n# not determine the rotation about the tibia. vrda run solves the motion without it too. "
    "--no-prior leaves\n# it out; schemas/prior.md.\n"
    "[[prior]]\ncoordinate = \"internal\"                # N mm per rad\nshape = \"walker-1988\"\n"
    "stiffness = { at_least = 4126, times_own = 4, at_most_times = 30 }\nlevel = \"free\"\n\n"
    "[[prior]]\ncoordinate = \"centre_anterior\"         # N per mm, times the same factor\n"
    "shape = \"walker-1988\"\nstiffness = { at_least = 4 }\nlevel = \"free\"\n";

std::string parameter_text(const std::string& quantity, const std::string& rest)
{
  return "\n[[uncertainty.parameter]]\nquantity = \"" + quantity + "\"\n" + rest + "\n";
}

// The band of the motion: what is not known about a knee of which the bones are scanned.
std::string uncertainty_text(const JobDescription& job)
{
  const auto normal = [](const char* sd) {
    return "distribution = \"normal\"\nsd = " + std::string(sd) + "\n";
  };
  std::string text = "\n[uncertainty]                         # the band of the motion\nsamples = 24\n";
  if (job.has_ligaments) {
    text += parameter_text("reference_strain", normal("0.02") + "shared_by = \"bundle\"");
    text += parameter_text("stiffness", "distribution = \"lognormal\"\nsd = 0.3\nshared_by = \"all\"");
  }
  text += parameter_text(
      "thickness", normal("0.4") + "body = \"reference\"                  # mm, of both cartilages together");
  text += parameter_text("prior_shape", normal("5") + "coordinate = \"internal\"             # degrees");
  text += parameter_text("prior_shape", normal("2.5") + "coordinate = \"centre_anterior\"      # mm");
  return text +
         parameter_text("prior_level", normal("3") + "coordinate = \"internal\"             # degrees");
}

std::string coordinates_text(const JointCoordinates& q)
{
  std::string text;
  for (const double number : in_files(q)) text += (text.empty() ? "[" : ", ") + short_decimal(number, 4);
  return text + "]";
}

std::string kneecap_text(const JobKneecap& patella)
{
  std::string text =
      "\n[[follower]]                          # the kneecap: schemas/followers.md\nname = \"patella\"\n"
      "centre_mm = [" +
      core::numbers_text(patella.centre_mm, ", ") + "]\nfibres = \"patella_fibres.csv\"\n" +
      (patella.has_wraps ? "wraps = \"patella_wraps.json\"\n" : "") +
      "tension_n = 30                        # of the four lines of the quadriceps together\n"
      "scan = { joint = " +
      coordinates_text(patella.scanned_joint) + ", follower = " + coordinates_text(patella.scanned) + " }\n";
  for (const job::TendonDirection& direction : patella.directions)
    text += "\n[[follower.direction]]\nbundle = " + quoted_text(direction.bundle) +
            "\nstiffness_nmm_per_rad = " + shortest_decimal(direction.stiffness_nmm) + "\naxis = [" +
            core::numbers_text(direction.axis, ", ") + "]\n" +
            (direction.rest_rad == 0.0
                 ? ""
                 : "rest_deg = " + shortest_decimal(deg_from_rad(direction.rest_rad)) + "\n");
  for (const JobComponent& component : patella.components) text += component_text("follower", component);
  return text;
}

// R = Rx Ry Rz.
Eigen::Vector3d body_fixed_angles_rad(const Eigen::Matrix3d& R)
{
  return {arc_tangent2(-R(1, 2), R(2, 2)), arc_sine(R(0, 2)), arc_tangent2(-R(0, 1), R(0, 0))};
}

Eigen::Vector3d rounded_to(const Eigen::Vector3d& v, double per_unit)
{
  return ((v * per_unit).array().round() / per_unit + 0.0).matrix();
}

std::string bodies_text(const JobDescription& job)
{
  const JointBones bones = bones_of(job.joint);
  std::string text = "\n[reference]\nname = \"" + std::string(bones.reference) + "\"\n";
  for (const JobComponent& component : job.reference) text += component_text("reference", component);
  text += "\n[moving]\nname = \"" + std::string(bones.moving) + "\"\n";
  for (const JobComponent& component : job.moving) text += component_text("moving", component);
  if (job.X_scan_reference) text += scan_frame_text(job);
  return text;
}

// Inversion about an oblique axis: the other two rotations over the one that is driven.
std::string about_axis_text(const JobDescription& job)
{
  constexpr int most_deg = 10;
  const auto at = [&](double turn_rad) {
    Pose X = Pose::Identity();
    const SinCos turn = sin_cos(turn_rad);
    Eigen::Matrix3d K;
    K << 0.0, -job.axis.z(), job.axis.y(), job.axis.z(), 0.0, -job.axis.x(), -job.axis.y(), job.axis.x(), 0.0;
    X.linear() = Eigen::Matrix3d::Identity() + turn.sin * K + (1.0 - turn.cos) * K * K;
    return clinical_coordinates(X, job.side, Eigen::Vector3d::Zero());
  };
  std::string driving, flexion, internal;
  for (int inversion_deg = -most_deg; inversion_deg <= most_deg; ++inversion_deg) {
    const double wanted_rad = rad_from_deg(inversion_deg), slope = at(1e-3).varus_rad / 1e-3;
    double turn_rad = 0.0;
    for (int round = 0; round < 30; ++round) turn_rad += (wanted_rad - at(turn_rad).varus_rad) / slope;
    const ClinicalCoordinates q = at(turn_rad);
    const auto add = [&](std::string& list, double rad) {
      list += (list.empty() ? "" : ", ") + short_decimal(deg_from_rad(rad), 4);
    };
    add(driving, wanted_rad);
    add(flexion, q.flexion_rad);
    add(internal, q.internal_rotation_rad);
  }
  const auto table = [&](const std::string& values) {
    return "]\ndriving = [" + driving + "]\nvalue = [" + values + "]\n";
  };
  return "varus = { from = -10, to = 10, step = 1 }         # inversion about the axis of the joint, " +
         core::numbers_text(rounded_to(job.axis, 1e3), ", ") + "\n\n[coordinates.flexion" + table(flexion) +
         "\n[coordinates.internal" + table(internal);
}

std::string other_joint_text(const JobDescription& job)
{
  std::string text =
      "# Written by vrda prepare; details in prepare.json. Both bones are in the frame of the joint: zero is "
      "the pose\n# of the scan.\n";
  for (const std::string& axis : job.axes) text += "# " + axis + ".\n";
  text += "title = " + quoted_text(job.title) + "\njoint = \"" + job.joint + "\"\nside = \"" +
          side_name(job.side) +
          "\"\n\n[frame]                               # origin: the centre of the joint\nunit = \"mm\"\n"
          "anterior = \"+X\"\nproximal = \"+Y\"\nright = \"+Z\"\n" +
          bodies_text(job) + "\n[push]\nforce_n = 20\ndelta = [" +
          core::numbers_text(rounded_to(job.delta, 1e4), ", ") + "]\n";
  if (job.joint != "ankle") text += "frame = \"reference\"\n";
  if (!job.fibres.empty())
    text +=
        "\n# Not from the scan: fans from the ends of the axis, where the malleoli are, to the talus. Nearly "
        "isometric as\n# the collateral ligaments are, they hold the bones together; --no-ligaments leaves "
        "them out.\n";
  for (const model::Fibre& fibre : job.fibres)
    text += "[[ligaments.fibre]]\nname = \"" + fibre.name + "\"\nbundle = \"" + fibre.bundle +
            "\"\nreference_mm = [" + core::numbers_text(rounded_to(fibre.reference_mm, 1e2), ", ") +
            "]\nmoving_mm = [" + core::numbers_text(rounded_to(fibre.moving_mm, 1e2), ", ") +
            "]\nstiffness_n = 1000\nreference_strain = 0.02\n";
  text += "\n[coordinates]                         # degrees\n";
  if (job.joint == "hip")
    text += "flexion = { from = " + shortest_decimal(job.least_flexion_deg) +
            ", to = " + shortest_decimal(job.most_flexion_deg) +
            ", step = 5 }      # extension is positive\nvarus = 0\ninternal = 0\n";
  if (job.joint == "ankle")
    text +=
        "flexion = { from = -20, to = 40, step = 5 }       # plantarflexion is positive\nvarus = \"free\"\n"
        "internal = \"free\"\n";
  if (job.joint == "subtalar") text += about_axis_text(job);
  return text + "\n[solver]\nmethod = \"equilibrium\"\n\n[smooth]\ndegrees = []\n";
}

}  // namespace

std::string job_text(const JobDescription& job)
{
  if (job.joint != "knee") return other_joint_text(job);
  std::string text =
      "# Written by vrda prepare; details in prepare.json. Each bone is in its own anatomical frame, so zero "
      "is the\n"
      "# neutral pose for any pose in the scan.\n" +
      (job.scanned ? scan_text(*job.scanned) : std::string()) + "title = " + quoted_text(job.title) +
      "\njoint = \"knee\"\nside = \"" + side_name(job.side) +
      "\"\n\n[frame]                               # origin: the rotation centre\nunit = \"mm\"\n"
      "anterior = \"+X\"\nproximal = \"+Y\"\nright = \"+Z\"\n" +
      bodies_text(job);
  text += "\n[push]\nforce_n = 20                          # along the tibia\n";
  if (job.has_ligaments) {
    text += "\n[ligaments]\nfibres = \"ligaments.csv\"\n";
    if (job.has_wraps) text += "wraps = \"wraps.json\"\n";
  }
  if (job.patella) text += kneecap_text(*job.patella);
  if (job.has_prior) text += prior_text + uncertainty_text(job);
  return text +
         "\n[grid]                                # degrees\nflexion = { from = 0, to = 90, step = 5 }\n"
         "varus = \"free\"\n\n[solver]\nmethod = \"equilibrium\"\n\n[solver.equilibrium]\n"
         "branch = \"continuous\"\n"
         "contact = { model = \"compliant\", stiffness_n_per_mm3 = " +
         shortest_decimal(contact_stiffness_n_per_mm3) +
         ", thickness_mm = " + shortest_decimal(contact_thickness_mm) + " }\n\n[smooth]\ndegrees = [6]\n";
}

std::string ligament_table(const model::Ligaments& ligaments, const std::string& comment)
{
  std::string text = "# " + comment +
                     "\nname,bundle,femur_x_mm,femur_y_mm,femur_z_mm,tibia_x_mm,tibia_y_mm,tibia_z_mm,"
                     "stiffness_n,slack_length_mm,wrap\n";
  for (const model::Fibre& fibre : ligaments.fibres) {
    text += fibre.name + "," + fibre.bundle + "," + core::numbers_text(fibre.reference_mm, ",") + "," +
            core::numbers_text(fibre.moving_mm, ",") + "," + shortest_decimal(fibre.stiffness_n) + "," +
            shortest_decimal(fibre.slack_length_mm) + "," +
            (fibre.wrap < 0 ? "" : ligaments.wraps[static_cast<std::size_t>(fibre.wrap)].name) + "\n";
  }
  return text;
}

std::string follower_table(const model::Ligaments& ligaments, const std::vector<std::string>& followers,
                           std::optional<double> strain, const std::string& comment)
{
  std::string text = "# " + comment +
                     "\nname,bundle,from_body,from_x_mm,from_y_mm,from_z_mm,to_body,to_x_mm,to_y_mm,to_z_mm,"
                     "stiffness_n_per_strain," +
                     (strain ? "reference_strain" : "slack_length_mm") + ",tension_share,wrap\n";
  for (const model::Fibre& fibre : ligaments.fibres) {
    const bool is_line = fibre.tension_n > 0.0;
    text += fibre.name + "," + fibre.bundle + "," + model::object_name(fibre.from, followers) + "," +
            core::numbers_text(fibre.reference_mm, ",") + "," + model::object_name(fibre.to, followers) +
            "," + core::numbers_text(fibre.moving_mm, ",") + "," +
            (is_line ? ",," + shortest_decimal(fibre.tension_n)
                     : shortest_decimal(fibre.stiffness_n) + "," +
                           shortest_decimal(strain.value_or(fibre.slack_length_mm)) + ",") +
            "," + (fibre.wrap < 0 ? "" : ligaments.wraps[static_cast<std::size_t>(fibre.wrap)].name) + "\n";
  }
  return text;
}

std::string wraps_text(const model::Ligaments& ligaments, const std::vector<std::string>& followers)
{
  std::string text = "[";
  for (const model::Wrap& wrap : ligaments.wraps) {
    const bool is_cylinder = wrap.shape == model::WrapShape::cylinder;
    text += std::string(text.size() > 1 ? "," : "") + "\n  {\"name\": " + quoted_text(wrap.name) +
            ", \"type\": \"" + (is_cylinder ? "WrapCylinder" : "WrapEllipsoid") + "\", \"body\": \"" +
            model::object_name(wrap.body, followers) + "\", \"unit\": \"mm\",\n   \"xyz_body_rotation\": [" +
            core::numbers_text(body_fixed_angles_rad(wrap.X_body_wrap.linear()), ",") +
            "], \"translation\": [" + core::numbers_text(wrap.X_body_wrap.translation(), ",") + "],\n   ";
    if (is_cylinder) {
      text += "\"radius\": " + shortest_decimal(wrap.radii_mm.x()) +
              ", \"length\": " + shortest_decimal(2.0 * wrap.radii_mm.z()) + "}";
    } else {
      text += "\"dimensions\": [" + core::numbers_text(wrap.radii_mm, ",") + "]}";
    }
  }
  return text + "\n]\n";
}

}  // namespace vrda::prepare
