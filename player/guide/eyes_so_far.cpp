#include "guide/eyes_so_far.hpp"

#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "core/units.hpp"

namespace vrda {
namespace {

Eye& eye_in(EyePair& eyes, bool is_right)
{
  return is_right ? eyes.right : eyes.left;
}

void put_aspect(Eye& eye, double aspect)
{
  eye.pixel_aspect = eye.distortion.pixel_aspect = aspect;
}

void put_viewport(Eye& eye, const std::string& name, const Estimate& found)
{
  const auto edge = [&](const char* which) { return value_in(found, name + ".edge_" + which); };
  const Eigen::Vector2d low(edge("left"), edge("top")), high(edge("right"), edge("bottom"));
  const auto whole = [](double x) { return static_cast<int>(std::lround(x)); };
  eye.visible = {whole(low.x()), whole(low.y()), whole(high.x()) - whole(low.x()),
                 whole(high.y()) - whole(low.y())};
  put_aspect(eye, value_in(found, name + ".pixel_aspect"));
  eye.sight_px = 0.5 * (low + high);
  if (eye.distortion.k1 == 0.0 && eye.distortion.k2 == 0.0) eye.distortion.centre_px = eye.sight_px;
}

void put_distortion(Eye& eye, const std::string& name, const Estimate& found)
{
  const auto value = [&](const char* which) { return value_in(found, name + which); };
  eye.distortion.k1 = value(".k1");
  eye.distortion.k2 = value(".k2");
  eye.distortion.centre_px = {value(".centre_x"), value(".centre_y")};
  eye.distortion.unit_px = 0.5 * eye.window.width;
  put_aspect(eye, value(".pixel_aspect"));
}

void put_eyepoints(EyePair& eyes, const Estimate& found)
{
  eyes.left.distance_px = value_in(found, "left.distance");
  eyes.right.distance_px = value_in(found, "right.distance");
  // The head frame's origin stays in the middle; the eye that is further from the plane is further back.
  const double apart_mm = value_in(found, "left.depth") - value_in(found, "right.depth");
  eyes.left.position_head_mm.z() = 0.5 * apart_mm;
  eyes.right.position_head_mm.z() = -0.5 * apart_mm;
}

}  // namespace

const char* side_text(bool is_right)
{
  return is_right ? "right" : "left";
}

std::vector<std::string> distortion_names(bool is_right)
{
  std::vector<std::string> names = numbers_read_of(CalibrationPart::distortion);
  std::erase_if(names, [&](const std::string& name) { return !name.starts_with(side_text(is_right)); });
  return names;
}

double value_in(const Estimate& estimate, const std::string& name)
{
  const Eigen::Index k = index_of(estimate, name);
  check(k >= 0, "an estimate has the numbers of its part");
  return estimate.values[k];
}

Pose place_in(const Estimate& estimate, const std::string& name)
{
  Eigen::Matrix<double, 6, 1> six;
  Eigen::Index k = 0;
  for (const std::string& number : names_of_place(name)) six[k++] = value_in(estimate, number);
  return pose_of(SixNumbers{six.head<3>(), six.tail<3>() * rad_from_deg(1.0)});
}

void put_found(EyePair& eyes, CalibrationPart part, const Estimate& found)
{
  for (const bool is_right : {false, true}) {
    Eye& eye = eye_in(eyes, is_right);
    if (part == CalibrationPart::viewport) put_viewport(eye, side_text(is_right), found);
    if (part == CalibrationPart::distortion) put_distortion(eye, side_text(is_right), found);
  }
  if (part == CalibrationPart::eyepoints) put_eyepoints(eyes, found);
  if (part == CalibrationPart::ipd) set_ipd(eyes, value_in(found, "ipd"));
}

EyePair eyes_before(CalibrationPart part, const BenchFile& bench, const Calibration& calibration)
{
  EyePair eyes = nominal_calibration(bench).eyes;
  for (const CalibrationPart earlier : {CalibrationPart::viewport, CalibrationPart::distortion,
                                        CalibrationPart::eyepoints, CalibrationPart::ipd}) {
    const auto record = calibration.records.find(earlier);
    if (earlier < part && record != calibration.records.end() && record->second.estimate)
      put_found(eyes, earlier, *record->second.estimate);
  }
  return eyes;
}

const Estimate& estimate_of(CalibrationPart part, const Calibration& calibration, const std::string& path)
{
  const auto record = calibration.records.find(part);
  if (record == calibration.records.end() || !record->second.estimate)
    throw InputError({path, name_of(part), "nothing found yet", "the part done, as others rest on it"});
  return *record->second.estimate;
}

Eigen::MatrixXd known_covariance(const Estimate& estimate, const std::vector<std::string>& names)
{
  const auto n = static_cast<Eigen::Index>(names.size());
  Eigen::MatrixXd covariance(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      const Eigen::Index a = index_of(estimate, names[static_cast<std::size_t>(i)]);
      const Eigen::Index b = index_of(estimate, names[static_cast<std::size_t>(j)]);
      check(a >= 0 && b >= 0, "an estimate has the numbers of its part");
      covariance(i, j) = estimate.covariance(a, b);
    }
  }
  // The normal distribution that has the same 95 % interval.
  const double widening = t_95(estimate.dof) / t_95(std::numeric_limits<double>::infinity());
  return widening * widening * covariance;
}

}  // namespace vrda
