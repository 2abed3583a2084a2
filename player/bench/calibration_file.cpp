// Reads and writes calibration files (TOML, schemas/calibration.schema.json); angles in degrees in the file.
#include "bench/calibration_file.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <set>
#include <sstream>
#include <utility>

#include "bench/toml_table.hpp"
#include "core/files.hpp"
#include "core/schema.hpp"
#include "core/text.hpp"

namespace vrda::bench {

const core::DocumentSchema& calibration_schema();  // schemas/calibration.schema.json

namespace {

constexpr int version = 1;
/// Allowed deviation of the length of a stored direction from 1.
constexpr double unit_tolerance = 1e-3;

/// The six numbers of a pose.
template <typename Visit, typename Six>
void visit_six(const Visit& visit, Six& six)
{
  visit("shift_mm", six.shift_mm);
  visit.degrees("turn_deg", six.turn_rad);
}

/// What is stored of an eye; its window is that of the bench.
template <typename Visit, typename StoredEye>
void visit_eye(const Visit& visit, StoredEye& eye)
{
  visit("visible", eye.visible, "px: x, y, width, height");
  visit("distance_px", eye.distance_px);
  visit("pixel_aspect", eye.pixel_aspect);
  visit("sight_px", eye.sight_px);
  visit("eyepoint_mm", eye.position_head_mm);
  visit("k1", eye.distortion.k1);
  visit("k2", eye.distortion.k2);
  visit("distortion_centre_px", eye.distortion.centre_px);
  visit("distortion_unit_px", eye.distortion.unit_px);
}

template <typename Visit, typename AnyCalibration>
void visit_head(const Visit& visit, AnyCalibration& calibration)
{
  visit("image_distance_mm", calibration.image_distance_mm);
  visit("stage_direction", calibration.stage_direction_table, "unit vector in table axes");
  visit("subject_scale", calibration.subject_scale, "scale of the model's lengths");
}

/// Calls `use(table, comment, six)` for each pose, in the order of the file.
template <typename AnyCalibration, typename Use>
void for_each_pose(AnyCalibration& calibration, Use use)
{
  auto& models = calibration.X_body_model;
  use("table", "pose of the table in the tracker frame", calibration.X_tracker_table);
  use("eyes", "pose of the eyes' midpoint in the table frame, stage at zero", calibration.X_table_eyes);
  use("head", "pose of the eyes' midpoint in the frame of the display's body", calibration.X_headbody_eyes);
  use("leg", "pose of the knee model in the frame of the leg's body", models[0]);
  use("femur", "pose of the femur model in the frame of its body", models[1]);
  use("tibia", "pose of the tibia model in the frame of its body", models[2]);
}

/// The eyes with their tables and windows.
template <typename Pair, typename Use>
void for_each_eye(Pair& eyes, const view::EyeWindows& windows, Use use)
{
  use("left", eyes.left, windows.left);
  use("right", eyes.right, windows.right);
}

std::string display_text(const DisplaySettings& display)
{
  return std::to_string(display.width) + " x " + std::to_string(display.height) + ", " +
         view::layout_names()[static_cast<std::size_t>(display.layout)];
}

std::vector<double> numbers_of(const view::Viewport& v)
{
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.width),
          static_cast<double>(v.height)};
}

/// Measurements and coefficients are in pixels of the eye's window, so it must be the same. A file without
/// windows is accepted.
void require_window(const core::Document& document, const std::string& key, const view::Viewport& window)
{
  if (core::find_at(document.root, key) == nullptr) return;
  const std::vector<double> made_for = core::numbers_at(document.root, key), wanted = numbers_of(window);
  if (made_for == wanted) return;
  document.refuse(key, "a calibration of the window " + show::list_text(made_for),
                  "this bench's window, " + show::list_text(wanted) + "; calibrate again");
}

void require_bench(const core::Document& document, const BenchFile& bench)
{
  const core::DocumentValue& root = document.root;
  if (const std::string& title = core::text_at(root, "bench"); title != bench.title)
    document.refuse("bench", "'" + title + "'", "'" + bench.title + "', the title of " + bench.path);
  DisplaySettings made_for;
  const TableReader read(core::value_at(root, "display"));
  std::string layout;
  read("width", made_for.width);
  read("height", made_for.height);
  read("layout", layout);
  made_for.layout = view::layout_named(layout).value();
  if (display_text(made_for) != display_text(bench.display)) {
    document.refuse("display", "a calibration of " + display_text(made_for),
                    "this bench's display, " + display_text(bench.display) + "; calibrate again");
  }
  require_window(document, "display.left_window", bench.display.windows.left);
  require_window(document, "display.right_window", bench.display.windows.right);
}

view::Eye nominal_eye(const DisplaySettings& display, const view::Viewport& window, double x_mm)
{
  constexpr double nominal_distance_px = 880.0;
  view::Eye eye;
  eye.window = eye.visible = window;
  eye.distance_px = nominal_distance_px;
  eye.sight_px = view::middle_px(window);
  eye.position_head_mm = {x_mm, 0.0, 0.0};
  eye.distortion.centre_px = eye.sight_px;
  eye.distortion.unit_px = 0.5 * window.width;
  if (display.is_half_width) {
    // Half the columns for the same angle.
    eye.distance_px *= 0.5;
    eye.pixel_aspect = eye.distortion.pixel_aspect = 0.5;
  }
  return eye;
}

}  // namespace

Calibration nominal_calibration(const BenchFile& bench)
{
  constexpr double nominal_ipd_mm = 64.0, nominal_depth_mm = 800.0;
  Calibration calibration;
  calibration.eyes.left = nominal_eye(bench.display, bench.display.windows.left, -0.5 * nominal_ipd_mm);
  calibration.eyes.right = nominal_eye(bench.display, bench.display.windows.right, 0.5 * nominal_ipd_mm);
  calibration.image_distance_mm = nominal_depth_mm;
  calibration.X_table_eyes.shift_mm = {0.0, 0.0, nominal_depth_mm};
  return calibration;
}

std::string calibration_text(const Calibration& calibration, const BenchFile& bench)
{
  const DisplaySettings& display = bench.display;
  std::ostringstream text;
  const TableWriter write(text);
  text << "# See schemas/calibration.md.\n";
  write("version", version);
  write("bench", bench.title);
  visit_head(write, calibration);
  text << "\n[display]\n";
  write("width", display.width);
  write("height", display.height);
  write("layout", view::layout_names()[static_cast<std::size_t>(display.layout)]);
  write("left_window", numbers_of(display.windows.left), "px: x, y, width, height");
  write("right_window", numbers_of(display.windows.right));
  for_each_eye(calibration.eyes, display.windows,
               [&](const char* key, const view::Eye& eye, const view::Viewport&) {
                 text << "\n[" << key << "]\n";
                 visit_eye(write, eye);
               });
  for_each_pose(calibration, [&](const char* key, const char* comment, const PoseParameters& six) {
    text << "\n[" << key << "]  # " << comment << "\n";
    visit_six(write, six);
  });
  return text.str() + records_text(calibration.records);
}

CalibrationFile::CalibrationFile(const BenchFile& bench, std::string path, std::string text)
    : bench_(bench), path_(std::move(path)), text_(std::move(text))
{
}

void CalibrationFile::write(const Calibration& calibration)
{
  std::optional<Publication> result = Publication::begin(path_, "vrda-player");
  const std::optional<std::string> present = read_text_file(path_);
  if (present && *present != text_)
    throw InputError({path_, "", "a file that another program changed in the meantime",
                      "the file as it was read; start again, which reads it, or move it away to keep both"});
  std::string text = calibration_text(calibration, bench_);
  result->publish(text);
  text_ = std::move(text);
}

std::string text(double value, int decimals, const std::string& unit)
{
  return short_decimal(value, decimals) + (unit.empty() ? "" : " " + unit);
}

double rounded(double value, int decimals)
{
  const double parts = std::pow(10.0, decimals);
  return std::round(value * parts) / parts;
}

std::vector<std::string> pose_number_names(const std::string& name)
{
  std::vector<std::string> names;
  for (const char* number : {".shift_x", ".shift_y", ".shift_z", ".turn_x", ".turn_y", ".turn_z"})
    names.push_back(name + number);
  return names;
}

Estimate pose_estimate(const std::string& name, const Pose& X,
                       const Eigen::Matrix<double, 6, 6>& covariance_mm_rad)
{
  const PoseParameters six = pose_parameters_of(X);
  Estimate estimate;
  estimate.names = pose_number_names(name);
  estimate.units = {"mm", "mm", "mm", "deg", "deg", "deg"};
  Eigen::Matrix<double, 6, 1> unit = Eigen::Matrix<double, 6, 1>::Ones();
  unit.tail<3>().setConstant(deg_from_rad(1.0));
  estimate.values.resize(6);
  estimate.values << six.shift_mm, six.turn_rad * deg_from_rad(1.0);
  estimate.covariance = unit.asDiagonal() * covariance_mm_rad * unit.asDiagonal();
  return estimate;
}

/// t = sqrt(dof) tan(angle), whose density is cos(angle)^(dof - 1): smooth from 0 to the quantile, so that
/// Simpson's rule and Newton's method give eight digits. For many degrees of freedom Cornish and Fisher's
/// series (Abramowitz and Stegun 26.7.5), is as accurate from 1,000 on.
double t_95(double dof)
{
  constexpr double z = 1.959963984540054, z_3 = z * z * z, z_5 = z_3 * z * z;
  if (dof >= 1000.0)
    return z + (z_3 + z) / (4.0 * dof) + (5.0 * z_5 + 16.0 * z_3 + 3.0 * z) / (96.0 * dof * dof);
  constexpr int n_steps = 200, n_iterations = 12;
  const double wanted =
      0.475 * std::exp(std::lgamma(0.5 * dof) - std::lgamma(0.5 * (dof + 1.0))) * std::sqrt(std::numbers::pi);
  double angle = 0.0;
  for (int k = 0; k < n_iterations; ++k) {
    double sum = 0.0;  // of Simpson's rule from 0 to the angle
    for (int i = 0; i <= n_steps; ++i)
      sum += (i == 0 || i == n_steps ? 1.0
              : i % 2 == 0           ? 2.0
                                     : 4.0) *
             std::pow(std::cos(angle * i / n_steps), dof - 1.0);
    const double error = wanted - sum * angle / (3.0 * n_steps);
    angle += error / std::pow(std::cos(angle), dof - 1.0);
  }
  return std::sqrt(dof) * std::tan(angle);
}

double half_width_95(const Estimate& estimate, Eigen::Index k)
{
  return t_95(estimate.dof) * std::sqrt(estimate.covariance(k, k));
}

int decimals_for(double size)
{
  constexpr int most = 9;
  if (!(size > 0.0) || !std::isfinite(size)) return 3;
  return std::clamp(1 - static_cast<int>(std::floor(std::log10(size))), 0, most);
}

std::string interval_text(const Estimate& estimate, Eigen::Index k)
{
  const double half_width = half_width_95(estimate, k);
  const int decimals = decimals_for(half_width);
  return short_decimal(estimate.values[k], decimals) + " +- " +
         text(half_width, decimals, estimate.units[static_cast<std::size_t>(k)]);
}

void append(Estimate& whole, const Estimate& part)
{
  const Eigen::Index n = whole.values.size(), m = part.values.size();
  whole.dof = n == 0 ? part.dof : std::min(whole.dof, part.dof);
  whole.names.insert(whole.names.end(), part.names.begin(), part.names.end());
  whole.units.insert(whole.units.end(), part.units.begin(), part.units.end());
  Eigen::VectorXd values(n + m);
  values << whole.values, part.values;
  Eigen::MatrixXd covariance = Eigen::MatrixXd::Zero(n + m, n + m);
  covariance.topLeftCorner(n, n) = whole.covariance;
  covariance.bottomRightCorner(m, m) = part.covariance;
  whole.values = values;
  whole.covariance = covariance;
  const auto square_sum = [](const Estimate& e) {
    return e.residual_rms * e.residual_rms * static_cast<double>(e.residuals.size());
  };
  const double sum = square_sum(whole) + square_sum(part);
  whole.residuals.insert(whole.residuals.end(), part.residuals.begin(), part.residuals.end());
  whole.residual_unit = part.residual_unit;
  if (!whole.residuals.empty())
    whole.residual_rms = std::sqrt(sum / static_cast<double>(whole.residuals.size()));
  whole.remarks.insert(whole.remarks.end(), part.remarks.begin(), part.remarks.end());
}

void set_residuals(Estimate& estimate, const std::vector<double>& residuals, const std::string& unit)
{
  estimate.residuals = residuals;
  estimate.residual_unit = unit;
  estimate.residual_rms = rms_of(residuals);
}

Eigen::Index index_of(const Estimate& estimate, const std::string& name)
{
  const auto found = std::ranges::find(estimate.names, name);
  return found == estimate.names.end() ? -1 : found - estimate.names.begin();
}

namespace {

constexpr std::array<const char*, n_calibration_parts> part_names{
    "viewport", "distortion", "rails", "stop", "probe", "eyepoints", "ipd",
    "subject",  "bullseye",   "head",  "leg",  "femur", "tibia",     "functional"};

}  // namespace

const char* name_of(CalibrationPart part)
{
  return part_names[static_cast<std::size_t>(part)];
}

std::vector<std::string> shared_estimate_names(CalibrationPart part)
{
  const auto of_each_eye = [](const std::vector<std::string>& numbers) {
    std::vector<std::string> named;
    for (const char* side : {"left.", "right."}) {
      for (const std::string& number : numbers) named.push_back(side + number);
    }
    return named;
  };
  switch (part) {
    case CalibrationPart::viewport:
      return of_each_eye({"edge_left", "edge_right", "edge_top", "edge_bottom", "pixel_aspect"});
    case CalibrationPart::distortion:
      return of_each_eye({"k1", "k2", "centre_x", "centre_y", "pixel_aspect"});
    case CalibrationPart::eyepoints:
      return of_each_eye({"distance", "depth"});
    case CalibrationPart::ipd:
      return {"ipd"};
    case CalibrationPart::rails:
      return pose_number_names("table");
    case CalibrationPart::probe:
      return {"probe.tip_x", "probe.tip_y", "probe.tip_z"};
    case CalibrationPart::subject:
      return {"subject.scale"};
    case CalibrationPart::femur:
    case CalibrationPart::tibia:
      return pose_number_names(name_of(part));
    default:
      return {};
  }
}

bool is_per_bench(CalibrationPart part)
{
  return part < CalibrationPart::eyepoints;
}

std::string record_key(CalibrationPart part)
{
  return std::string(is_per_bench(part) ? "per_bench." : "per_person.") + name_of(part);
}

namespace {

/// Unit of a dimensionless number in the file: the list of texts must not contain empty texts.
constexpr const char* dimensionless_unit = "1";

template <typename Visit, typename Mark>
void visit_mark(const Visit& visit, Mark& mark)
{
  visit("task", mark.task);
  visit("rows", mark.rows);
}

/// The table of a record, without its marks and its result.
template <typename Visit, typename Record>
void visit_record(const Visit& visit, Record& record)
{
  visit("date", record.date);
  visit.optional("outdated", record.is_outdated, "must be repeated");
  visit.optional("made_with", record.made_with);
}

/// The table of an estimate, with its values and covariance as lists.
struct StoredEstimate {
  Estimate estimate;  ///< without units, values and covariance
  std::vector<std::string> units;
  std::vector<double> values;
  std::vector<std::vector<double>> covariance;
};

template <typename Visit, typename Stored>
void visit_estimate(const Visit& visit, Stored& stored)
{
  visit("names", stored.estimate.names);
  visit("units", stored.units);
  visit("values", stored.values);
  visit("covariance", stored.covariance);
  visit("dof", stored.estimate.dof);
  visit("residuals", stored.estimate.residuals);
  visit.optional("residual_unit", stored.estimate.residual_unit);
  visit("residual_rms", stored.estimate.residual_rms);
  visit.optional("remarks", stored.estimate.remarks);
}

std::vector<CalibrationMark> marks_in(const core::Document& document, const std::string& key)
{
  std::vector<CalibrationMark> marks;
  std::set<std::string> names;
  for (const core::DocumentValue& item : core::list_or_empty(document.root, key)) {
    CalibrationMark mark;
    visit_mark(TableReader(item), mark);
    if (!names.insert(mark.task).second) {
      document.refuse(key + "." + std::to_string(marks.size()) + ".task", "'" + mark.task + "' twice",
                      "each task only once");
    }
    marks.push_back(mark);
  }
  return marks;
}

/// Checks that a list has one item a name.
void require_size(const core::Document& document, const std::string& key, std::size_t found,
                  std::size_t wanted, const char* items)
{
  if (found == wanted) return;
  document.refuse(key, std::to_string(found) + " " + items, std::to_string(wanted) + ", one for each name");
}

/// Reads an [n, n] covariance; rows and columns follow `names`. A negative variance is an error.
Eigen::MatrixXd covariance_of(const core::Document& document, const std::string& key,
                              const std::vector<std::vector<double>>& rows, std::size_t n)
{
  if (n == 0) return {};
  require_size(document, key, rows.size(), n, "rows");
  const auto size = static_cast<Eigen::Index>(n);
  Eigen::MatrixXd covariance(size, size);
  for (std::size_t i = 0; i < n; ++i) {
    require_size(document, key + "." + std::to_string(i), rows[i].size(), n, "numbers");
    covariance.row(static_cast<Eigen::Index>(i)) = Eigen::RowVectorXd::Map(rows[i].data(), size);
  }
  if (!(covariance.diagonal().minCoeff() >= 0.0))
    document.refuse(key, "a negative variance", "a covariance with a non-negative diagonal");
  return covariance;
}

Estimate estimate_in(const core::Document& document, const std::string& key)
{
  StoredEstimate stored;
  visit_estimate(TableReader(core::value_at(document.root, key)), stored);
  Estimate& estimate = stored.estimate;
  const std::size_t n = estimate.names.size();
  require_size(document, key + ".units", stored.units.size(), n, "units");
  require_size(document, key + ".values", stored.values.size(), n, "numbers");
  for (const std::string& unit : stored.units)
    estimate.units.push_back(unit == dimensionless_unit ? "" : unit);
  estimate.values = Eigen::VectorXd::Map(stored.values.data(), static_cast<Eigen::Index>(n));
  estimate.covariance = covariance_of(document, key + ".covariance", stored.covariance, n);
  return estimate;
}

/// Checks that the numbers that other parts read by name are present.
void require_estimate_names(const core::Document& document, const std::string& key, const Estimate& estimate,
                            CalibrationPart part)
{
  for (const std::string& name : shared_estimate_names(part)) {
    if (index_of(estimate, name) >= 0) continue;
    document.refuse(key + ".names", "no '" + name + "'",
                    "the numbers that the part " + std::string(name_of(part)) + " estimates");
  }
}

CalibrationRecord record_in(const core::Document& document, const std::string& key, CalibrationPart part)
{
  const core::DocumentValue& table = core::value_at(document.root, key);
  CalibrationRecord record;
  visit_record(TableReader(table), record);
  record.marks = marks_in(document, key + ".mark");
  if (table.contains("result")) {
    record.estimate = estimate_in(document, key + ".result");
    require_estimate_names(document, key + ".result", *record.estimate, part);
  }
  return record;
}

Calibration calibration_in(const core::Document& document, const BenchFile& bench)
{
  const core::DocumentValue& root = document.root;
  require_bench(document, bench);
  Calibration calibration;
  for_each_eye(calibration.eyes, bench.display.windows,
               [&](const char* key, view::Eye& eye, const view::Viewport& window) {
                 eye.window = window;
                 visit_eye(TableReader(core::value_at(root, key)), eye);
                 eye.distortion.pixel_aspect = eye.pixel_aspect;
               });
  visit_head(TableReader(root), calibration);
  if (!(std::abs(calibration.stage_direction_table.norm() - 1.0) < unit_tolerance))
    document.refuse("stage_direction", "a vector whose length is not 1", "a unit vector");
  for_each_pose(calibration, [&](const char* key, const char*, PoseParameters& six) {
    visit_six(TableReader(core::value_at(root, key)), six);
  });
  for (std::size_t k = 0; k < n_calibration_parts; ++k) {
    const auto part = static_cast<CalibrationPart>(k);
    if (core::find_at(root, record_key(part)) != nullptr)
      calibration.records[part] = record_in(document, record_key(part), part);
  }
  view::require_usable(calibration.eyes, document.file);
  return calibration;
}

StoredEstimate stored(const Estimate& estimate)
{
  StoredEstimate stored{estimate, {}, {estimate.values.begin(), estimate.values.end()}, {}};
  for (const std::string& unit : estimate.units)
    stored.units.push_back(unit.empty() ? dimensionless_unit : unit);
  for (const auto& row : estimate.covariance.rowwise())
    stored.covariance.emplace_back(row.begin(), row.end());
  return stored;
}

}  // namespace

Calibration parse_calibration(const std::string& text, const std::string& path, const BenchFile& bench)
{
  return calibration_in(calibration_schema().read(text, path), bench);
}

Calibration read_calibration(const std::string& path, const BenchFile& bench)
{
  return parse_calibration(core::read_document_text(path, "a calibration file (schemas/calibration.md)"),
                           path, bench);
}

std::string records_text(const CalibrationRecords& records)
{
  std::ostringstream text;
  const TableWriter write(text);
  for (const auto& [part, record] : records) {
    const std::string key = record_key(part);
    text << "\n[" << key << "]\n";
    visit_record(write, record);
    if (record.estimate) {
      text << "\n[" << key << ".result]\n";
      const StoredEstimate lists = stored(*record.estimate);
      visit_estimate(write, lists);
    }
    for (const CalibrationMark& mark : record.marks) {
      text << "\n[[" << key << ".mark]]\n";
      visit_mark(write, mark);
    }
  }
  return text.str();
}

namespace {

using Parameters = std::vector<Parameter>;

/// "left.sight_x"
std::string with_axis(const std::string& name, const char* what, Eigen::Index axis)
{
  return name + what + "xyz"[axis];
}

void add_eye(Parameters& list, const std::string& name, view::Eye view::EyePair::*side)
{
  const auto eye = [side](BenchValues& v) -> view::Eye& { return v.calibration.eyes.*side; };
  constexpr double px = 20000.0;
  list.push_back({name + ".distance", "px", 10.0, 100000.0, 1.0,
                  [eye](BenchValues& v) -> double& { return eye(v).distance_px; }});
  list.push_back({name + ".pixel_aspect", "", 0.1, 10.0, 0.001,
                  [eye](BenchValues& v) -> double& { return eye(v).pixel_aspect; }});
  for (const Eigen::Index axis : {0, 1}) {
    list.push_back({with_axis(name, ".sight_", axis), "px", -px, px, 0.5,
                    [eye, axis](BenchValues& v) -> double& { return eye(v).sight_px[axis]; }});
    list.push_back({with_axis(name, ".centre_", axis), "px", -px, px, 0.5,
                    [eye, axis](BenchValues& v) -> double& { return eye(v).distortion.centre_px[axis]; }});
  }
  list.push_back({name + ".k1", "", -1.0, 1.0, 0.001,
                  [eye](BenchValues& v) -> double& { return eye(v).distortion.k1; }});
  list.push_back({name + ".k2", "", -1.0, 1.0, 0.001,
                  [eye](BenchValues& v) -> double& { return eye(v).distortion.k2; }});
  for (const Eigen::Index axis : {1, 2}) {
    list.push_back({name + (axis == 1 ? ".eye_up" : ".eye_back"), "mm", -200.0, 200.0, 0.5,
                    [eye, axis](BenchValues& v) -> double& { return eye(v).position_head_mm[axis]; }});
  }
}

template <typename At>
void add_six(Parameters& list, const std::string& name, At at)
{
  constexpr double most_mm = 10000.0, most_deg = 180.0;
  for (const Eigen::Index axis : {0, 1, 2}) {
    list.push_back({with_axis(name, ".shift_", axis), "mm", -most_mm, most_mm, 0.5,
                    [at, axis](BenchValues& v) -> double& { return at(v).shift_mm[axis]; }});
  }
  for (const Eigen::Index axis : {0, 1, 2}) {
    list.push_back({with_axis(name, ".turn_", axis), "deg", -most_deg, most_deg, 0.1,
                    [at, axis](BenchValues& v) -> double& { return at(v).turn_rad[axis]; },
                    rad_from_deg(1.0)});
  }
}

double pupillary_distance_mm(const view::EyePair& eyes)
{
  return eyes.right.position_head_mm.x() - eyes.left.position_head_mm.x();
}

/// Moves both eyes symmetrically: their midpoint does not change.
void set_pupillary_distance(BenchValues& values, double distance_mm)
{
  double &left = values.calibration.eyes.left.position_head_mm.x(),
         &right = values.calibration.eyes.right.position_head_mm.x();
  const double middle = 0.5 * (left + right);
  left = middle - 0.5 * distance_mm;
  right = middle + 0.5 * distance_mm;
}

Parameters build_list()
{
  Parameters list;
  list.push_back({"flexion", "deg", -30.0, 180.0, 1.0,
                  [](BenchValues& v) -> double& { return v.flexion_rad; }, rad_from_deg(1.0)});
  list.push_back({"varus", "deg", -30.0, 30.0, 0.5, [](BenchValues& v) -> double& { return v.varus_rad; },
                  rad_from_deg(1.0)});
  list.push_back(
      {"prediction", "ms", 0.0, 200.0, 1.0, [](BenchValues& v) -> double& { return v.prediction_ms; }});
  list.push_back({"eyes.distance_apart", "mm", 40.0, 90.0, 0.25});
  list.push_back({"image_distance", "mm", 100.0, 10000.0, 10.0,
                  [](BenchValues& v) -> double& { return v.calibration.image_distance_mm; }});
  for (const BodyRole role : {BodyRole::leg, BodyRole::femur, BodyRole::tibia})
    add_six(list, name_of(role),
            [role](BenchValues& v) -> PoseParameters& { return v.calibration.X_body_model[role]; });
  add_six(list, "eyes", [](BenchValues& v) -> PoseParameters& { return v.calibration.X_table_eyes; });
  add_six(list, "head", [](BenchValues& v) -> PoseParameters& { return v.calibration.X_headbody_eyes; });
  add_six(list, "table", [](BenchValues& v) -> PoseParameters& { return v.calibration.X_tracker_table; });
  add_eye(list, "left", &view::EyePair::left);
  add_eye(list, "right", &view::EyePair::right);
  return list;
}

const Parameters& list()
{
  static const Parameters built = build_list();
  return built;
}

}  // namespace

std::span<const Parameter> parameters()
{
  return list();
}

std::optional<std::size_t> find_parameter(const std::string& name)
{
  const Parameters& all = list();
  const auto found = std::ranges::find(all, name, &Parameter::name);
  if (found == all.end()) return std::nullopt;
  return static_cast<std::size_t>(found - all.begin());
}

bool is_used(std::size_t parameter, const BenchFile& bench)
{
  const std::string& name = parameters()[parameter].name;
  const std::string kind = name.substr(0, name.find('.'));
  const bool is_rigid = bench.leg == LegKind::rigid;
  if (kind == "flexion" || kind == "varus" || kind == "leg") return is_rigid;
  if (kind == "femur" || kind == "tibia") return !is_rigid;
  if (kind == "head") return bench.head == HeadKind::tracker;
  if (name == "eyes.distance_apart") return true;
  if (kind == "table" || kind == "eyes") return bench.head == HeadKind::stage;
  return true;
}

double value_of(const BenchValues& values, std::size_t parameter)
{
  const Parameter& stored = list().at(parameter);
  if (!stored.at) return pupillary_distance_mm(values.calibration.eyes);
  // The const_cast is safe: the value is only read.
  return stored.at(const_cast<BenchValues&>(values)) / stored.scale;
}

void set_value(BenchValues& values, std::size_t parameter, double value)
{
  const Parameter& stored = list().at(parameter);
  const double clamped = std::clamp(value, stored.minimum, stored.maximum);
  if (!stored.at) return set_pupillary_distance(values, clamped);
  stored.at(values) = clamped * stored.scale;
  // The file has one aspect ratio for both projection and distortion.
  for (view::Eye* eye : {&values.calibration.eyes.left, &values.calibration.eyes.right})
    eye->distortion.pixel_aspect = eye->pixel_aspect;
}

}  // namespace vrda::bench
