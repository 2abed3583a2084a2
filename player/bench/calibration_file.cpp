// Reads and writes calibration files (TOML, schemas/calibration.schema.json); angles in degrees in the file.
#include <cmath>
#include <optional>
#include <sstream>
#include <utility>

#include "bench/calibration.hpp"
#include "bench/document_parts.hpp"
#include "core/error.hpp"
#include "core/publication.hpp"
#include "core/units.hpp"
#include "core/schema.hpp"
#include "show/settings_text.hpp"

namespace vrda::bench {

const core::DocumentSchema& calibration_schema();  // schemas/calibration.schema.json

namespace {

constexpr int version = 1;
/// Allowed deviation of the length of a stored direction from 1.
constexpr double unit_tolerance = 1e-3;

Eigen::Vector2d two(const core::DocumentValue& table, const char* key)
{
  const std::vector<double> v = core::numbers_at(table, key);
  return {v[0], v[1]};
}

bench::PoseParameters six_in(const core::DocumentValue& root, const std::string& key)
{
  return {core::vector3_at(root, key + ".shift_mm"),
          core::vector3_at(root, key + ".turn_deg") * rad_from_deg(1.0)};
}

view::Eye eye_in(const core::DocumentValue& table, const view::Viewport& window)
{
  const std::vector<double> visible = core::numbers_at(table, "visible");
  view::Eye eye;
  eye.window = window;
  eye.visible = {static_cast<int>(visible[0]), static_cast<int>(visible[1]), static_cast<int>(visible[2]),
                 static_cast<int>(visible[3])};
  eye.distance_px = core::number_at(table, "distance_px");
  eye.pixel_aspect = core::number_at(table, "pixel_aspect");
  eye.sight_px = two(table, "sight_px");
  eye.position_head_mm = core::vector3_at(table, "eyepoint_mm");
  eye.distortion = {core::number_at(table, "k1"), core::number_at(table, "k2"),
                    two(table, "distortion_centre_px"), core::number_at(table, "distortion_unit_px"),
                    eye.pixel_aspect};
  return eye;
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
void require_window(const core::Document& document, const std::string& key,
                    const view::Viewport& window)
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
  made_for.width = static_cast<int>(core::integer_at(root, "display.width"));
  made_for.height = static_cast<int>(core::integer_at(root, "display.height"));
  made_for.layout = view::layout_named(core::text_at(root, "display.layout")).value();
  if (display_text(made_for) != display_text(bench.display)) {
    document.refuse("display", "a calibration of " + display_text(made_for),
                    "this bench's display, " + display_text(bench.display) + "; calibrate again");
  }
  require_window(document, "display.left_window", bench.display.windows.left);
  require_window(document, "display.right_window", bench.display.windows.right);
}

Calibration calibration_in(const core::Document& document, const BenchFile& bench)
{
  const core::DocumentValue& root = document.root;
  require_bench(document, bench);
  Calibration calibration;
  calibration.eyes.left = eye_in(core::value_at(root, "left"), bench.display.windows.left);
  calibration.eyes.right = eye_in(core::value_at(root, "right"), bench.display.windows.right);
  calibration.image_distance_mm = core::number_at(root, "image_distance_mm");
  calibration.X_tracker_table = six_in(root, "table");
  calibration.X_table_eyes = six_in(root, "eyes");
  calibration.stage_direction_table = core::vector3_at(root, "stage_direction");
  if (!(std::abs(calibration.stage_direction_table.norm() - 1.0) < unit_tolerance))
    document.refuse("stage_direction", "a vector whose length is not 1", "a unit vector");
  calibration.X_headbody_eyes = six_in(root, "head");
  for (const BodyRole role : {BodyRole::leg, BodyRole::femur, BodyRole::tibia})
    calibration.X_body_model[static_cast<std::size_t>(role)] = six_in(root, name_of(role));
  calibration.subject_scale = core::number_at(root, "subject_scale");
  calibration.records = read_calibration_records(document);
  view::require_usable(calibration.eyes, document.file);
  return calibration;
}

template <int n>
std::string list_of(const Eigen::Matrix<double, n, 1>& v)
{
  return show::list_text({v.data(), static_cast<std::size_t>(n)});
}

void add_six(std::ostream& text, const char* name, const char* comment, const bench::PoseParameters& six)
{
  text << "\n[" << name << "]  # " << comment << "\nshift_mm = " << list_of(six.shift_mm)
       << "\nturn_deg = " << list_of(Eigen::Vector3d(six.turn_rad / rad_from_deg(1.0))) << "\n";
}

void add_eye(std::ostream& text, const char* name, const view::Eye& eye)
{
  const view::Viewport& v = eye.visible;
  text << "\n[" << name << "]\nvisible = [" << v.x << ", " << v.y << ", " << v.width << ", " << v.height
       << "]  # px: x, y, width, height\ndistance_px = " << show::number_text(eye.distance_px)
       << "\npixel_aspect = " << show::number_text(eye.pixel_aspect)
       << "\nsight_px = " << list_of(eye.sight_px) << "\neyepoint_mm = " << list_of(eye.position_head_mm)
       << "\nk1 = " << show::number_text(eye.distortion.k1)
       << "\nk2 = " << show::number_text(eye.distortion.k2)
       << "\ndistortion_centre_px = " << list_of(eye.distortion.centre_px)
       << "\ndistortion_unit_px = " << show::number_text(eye.distortion.unit_px) << "\n";
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

Calibration parse_calibration(const std::string& text, const std::string& path, const BenchFile& bench)
{
  return calibration_in(calibration_schema().read(text, path), bench);
}

Calibration read_calibration(const std::string& path, const BenchFile& bench)
{
  return parse_calibration(core::read_document_text(path, "a calibration file (schemas/calibration.md)"),
                           path, bench);
}

std::string calibration_text(const Calibration& calibration, const BenchFile& bench)
{
  std::ostringstream text;
  text << "# See schemas/calibration.md.\nversion = " << version
       << "\nbench = " << show::quoted_text(bench.title)
       << "\nimage_distance_mm = " << show::number_text(calibration.image_distance_mm)
       << "\nstage_direction = " << list_of(calibration.stage_direction_table)
       << "  # unit vector in table axes\nsubject_scale = "
       << show::number_text(calibration.subject_scale)
       << "  # scale of the model's lengths\n\n[display]\nwidth = " << bench.display.width
       << "\nheight = " << bench.display.height << "\nlayout = "
       << show::quoted_text(view::layout_names()[static_cast<std::size_t>(bench.display.layout)])
       << "\nleft_window = " << show::list_text(numbers_of(bench.display.windows.left))
       << "  # px: x, y, width, height\nright_window = "
       << show::list_text(numbers_of(bench.display.windows.right)) << "\n";
  add_eye(text, "left", calibration.eyes.left);
  add_eye(text, "right", calibration.eyes.right);
  add_six(text, "table", "pose of the table in the tracker frame", calibration.X_tracker_table);
  add_six(text, "eyes", "pose of the eyes' midpoint in the table frame, stage at zero",
          calibration.X_table_eyes);
  add_six(text, "head", "pose of the eyes' midpoint in the frame of the display's body",
          calibration.X_headbody_eyes);
  add_six(text, "leg", "pose of the knee model in the frame of the leg's body", calibration.X_body_model[0]);
  add_six(text, "femur", "pose of the femur model in the frame of its body", calibration.X_body_model[1]);
  add_six(text, "tibia", "pose of the tibia model in the frame of its body", calibration.X_body_model[2]);
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

}  // namespace vrda::bench
