#include "job/axis_map.hpp"

#include "core/error.hpp"

namespace vrda::job {
namespace {

Eigen::Vector3d axis_of(const std::string& word)
{
  Eigen::Vector3d axis = Eigen::Vector3d::Zero();
  axis[word.at(1) - 'X'] = word.at(0) == '-' ? -1.0 : 1.0;
  return axis;
}

std::string opposite(const std::string& word)
{
  return (word.at(0) == '-' ? "+" : "-") + word.substr(1);
}

}  // namespace

double mm_per_unit(const std::string& unit)
{
  return unit == "m" ? 1000.0 : unit == "cm" ? 10.0 : 1.0;
}

const char* unit_of_mm(double mm)
{
  return mm == 1.0 ? "mm" : mm == 10.0 ? "cm" : "m";
}

namespace {

// The axes of the files' names, as rows.
Eigen::Matrix3d named_axes(const Job& job, const FrameJob& frame)
{
  const std::string words = "anterior = \"" + frame.anterior + "\", proximal = \"" + frame.proximal +
                            "\", right = \"" + frame.right + "\"";
  Eigen::Matrix3d R_canonical_native;
  R_canonical_native.row(0) = axis_of(frame.anterior).transpose();
  R_canonical_native.row(1) = axis_of(frame.proximal).transpose();
  R_canonical_native.row(2) = axis_of(frame.right).transpose();
  const std::string source = job.document.source_of_conflict(
      {frame.key + ".anterior", frame.key + ".proximal", frame.key + ".right"});
  const double handedness =
      R_canonical_native.row(0).cross(R_canonical_native.row(1)).dot(R_canonical_native.row(2));
  if (handedness == 0.0) throw InputError({source, frame.key, words, "each of X, Y and Z once"});
  if (handedness < 0.0) {
    throw InputError({source, frame.key, words + ", a left-handed map",
                      "a right-handed map; if anterior and proximal are correct: right = \"" +
                          opposite(frame.right) + "\""});
  }
  return R_canonical_native;
}

AxisMap map_of(const Job& job, const FrameJob& frame)
{
  const Eigen::Matrix3d R_canonical_native = named_axes(job, frame);
  const Eigen::Matrix3d R_align = rotation_z(frame.align_rotation_rad.z()) *
                                  rotation_y(frame.align_rotation_rad.y()) *
                                  rotation_x(frame.align_rotation_rad.x());
  AxisMap map;
  map.unit_mm = mm_per_unit(frame.unit);
  map.X_canonical_native.linear() = R_canonical_native * R_align;
  map.X_canonical_native.translation() = R_canonical_native * frame.align_translation_mm;
  return map;
}

}  // namespace

AxisMap axis_map(const Job& job)
{
  return map_of(job, job.frame);
}

AxisMap body_map(const Job& job, const BodyJob& body)
{
  const AxisMap joint = axis_map(job);
  if (!body.frame) return joint;
  AxisMap map = map_of(job, *body.frame);
  const Eigen::Vector3d origin_mm = map.unit_mm * body.frame->origin_native;
  map.X_canonical_native.translation() +=
      joint(job.frame.origin_native) - map.X_canonical_native.linear() * origin_mm;
  return map;
}

BodyMaps body_maps(const Job& job)
{
  return {body_map(job, job.reference), body_map(job, job.moving)};
}

}  // namespace vrda::job
