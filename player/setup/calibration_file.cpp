#include <cmath>
#include <sstream>

#include "core/error.hpp"
#include "core/units.hpp"
#include "settings/settings_table.hpp"
#include "settings/settings_text.hpp"
#include "setup/calibration.hpp"
#include "setup/record_text.hpp"

namespace vrda {
namespace {

constexpr int version = 1;
constexpr double largest_px = 1e6, full_turn_deg = 360.0;
/// A direction of the file is this near to a unit vector, or was no direction.
constexpr double unit_tolerance = 1e-3;

Eigen::Vector3d three(const SettingsTable& table, const char* name, double largest)
{
  const std::vector<double> v = table.numbers(name, 3, {-largest, largest});
  return {v[0], v[1], v[2]};
}

Eigen::Vector2d two(const SettingsTable& table, const char* name)
{
  const std::vector<double> v = table.numbers(name, 2, {-largest_px, largest_px});
  return {v[0], v[1]};
}

SixNumbers six_in(const SettingsTable& root, const char* name)
{
  const SettingsTable table = root.table(name);
  table.require_known({"shift_mm", "turn_deg"});
  SixNumbers six;
  six.shift_mm = three(table, "shift_mm", largest_mm);
  six.turn_rad = three(table, "turn_deg", full_turn_deg) * rad_from_deg(1.0);
  return six;
}

Eye eye_in(const SettingsTable& root, const char* name, const Viewport& window)
{
  const SettingsTable table = root.table(name);
  table.require_known({"visible", "distance_px", "pixel_aspect", "sight_px", "eyepoint_mm", "k1", "k2",
                       "distortion_centre_px", "distortion_unit_px"});
  Eye eye;
  eye.window = window;
  const std::vector<double> visible = table.numbers("visible", 4, {0.0, largest_px});
  for (const double v : visible) {
    if (v != std::floor(v)) table.refuse("visible", "parts of pixels", "x, y, width, height in whole pixels");
  }
  eye.visible = {static_cast<int>(visible[0]), static_cast<int>(visible[1]), static_cast<int>(visible[2]),
                 static_cast<int>(visible[3])};
  eye.distance_px = table.number("distance_px", {1.0, largest_px});
  eye.pixel_aspect = table.number("pixel_aspect", {0.1, 10.0});
  eye.sight_px = two(table, "sight_px");
  eye.position_head_mm = three(table, "eyepoint_mm", largest_mm);
  eye.distortion.k1 = table.number("k1", {-10.0, 10.0});
  eye.distortion.k2 = table.number("k2", {-10.0, 10.0});
  eye.distortion.centre_px = two(table, "distortion_centre_px");
  eye.distortion.unit_px = table.number("distortion_unit_px", {1.0, largest_px});
  eye.distortion.pixel_aspect = eye.pixel_aspect;
  return eye;
}

std::string display_text(const DisplaySettings& display)
{
  return std::to_string(display.width) + " x " + std::to_string(display.height) + ", " +
         layout_names()[static_cast<std::size_t>(display.layout)];
}

std::vector<double> numbers_of(const Viewport& v)
{
  return {static_cast<double>(v.x), static_cast<double>(v.y), static_cast<double>(v.width),
          static_cast<double>(v.height)};
}

/// Marks and coefficients are in pixels of the eye's window: of another one they mean something else. A file
/// that does not tell its windows is taken as it is.
void require_window(const SettingsTable& display, const char* name, const Viewport& window)
{
  if (!display.has(name)) return;
  const std::vector<double> made_for = display.numbers(name, 4, {0.0, largest_px}),
                            wanted = numbers_of(window);
  if (made_for == wanted) return;
  display.refuse(name, "a calibration of the window " + list_text(made_for),
                 "one of this bench's window, " + list_text(wanted) + ": calibrate anew");
}

void require_display(const SettingsTable& root, const BenchFile& bench)
{
  const SettingsTable table = root.table("display");
  table.require_known({"width", "height", "layout", "left_window", "right_window"});
  DisplaySettings made_for;
  made_for.width = table.whole("width", {16, 16384});
  made_for.height = table.whole("height", {16, 16384});
  made_for.layout = static_cast<Layout>(table.word("layout", layout_names()));
  if (display_text(made_for) != display_text(bench.display)) {
    root.refuse("display", "a calibration of " + display_text(made_for),
                "one of this bench's display, " + display_text(bench.display) + ": calibrate anew");
  }
  require_window(table, "left_window", bench.display.windows.left);
  require_window(table, "right_window", bench.display.windows.right);
}

Calibration calibration_in(const SettingsTable& root, const BenchFile& bench)
{
  root.require_known({"version", "bench", "display", "left", "right", "image_distance_mm", "table", "eyes",
                      "stage_direction", "head", "leg", "femur", "tibia", "subject_scale", "per_bench",
                      "per_person"});
  root.whole("version", {version, version});
  if (const std::string title = root.text("bench"); title != bench.title)
    root.refuse("bench", "'" + title + "'", "'" + bench.title + "', the title of " + bench.path);
  require_display(root, bench);
  Calibration calibration;
  calibration.eyes.left = eye_in(root, "left", bench.display.windows.left);
  calibration.eyes.right = eye_in(root, "right", bench.display.windows.right);
  calibration.image_distance_mm = root.number("image_distance_mm", {1.0, largest_mm});
  calibration.X_tracker_table = six_in(root, "table");
  calibration.X_table_eyes = six_in(root, "eyes");
  calibration.stage_direction_table = three(root, "stage_direction", 1.0 + unit_tolerance);
  if (!(std::abs(calibration.stage_direction_table.norm() - 1.0) < unit_tolerance))
    root.refuse("stage_direction", "a vector that is no unit vector", "a direction of length 1");
  calibration.X_headbody_eyes = six_in(root, "head");
  for (const BodyRole role : {BodyRole::leg, BodyRole::femur, BodyRole::tibia})
    calibration.X_body_model[static_cast<std::size_t>(role)] = six_in(root, name_of(role));
  calibration.subject_scale = root.number_or("subject_scale", 1.0, {0.1, 10.0});
  calibration.records = records_in(root);
  require_usable(calibration.eyes, root.file());
  return calibration;
}

template <int n>
std::string list_of(const Eigen::Matrix<double, n, 1>& v)
{
  return list_text({v.data(), static_cast<std::size_t>(n)});
}

void add_six(std::ostream& text, const char* name, const char* comment, const SixNumbers& six)
{
  text << "\n[" << name << "]  # " << comment << "\nshift_mm = " << list_of(six.shift_mm)
       << "\nturn_deg = " << list_of(Eigen::Vector3d(six.turn_rad / rad_from_deg(1.0))) << "\n";
}

void add_eye(std::ostream& text, const char* name, const Eye& eye)
{
  const Viewport& v = eye.visible;
  text << "\n[" << name << "]\nvisible = [" << v.x << ", " << v.y << ", " << v.width << ", " << v.height
       << "]  # px: x, y, width, height\ndistance_px = " << number_text(eye.distance_px)
       << "\npixel_aspect = " << number_text(eye.pixel_aspect) << "\nsight_px = " << list_of(eye.sight_px)
       << "\neyepoint_mm = " << list_of(eye.position_head_mm) << "\nk1 = " << number_text(eye.distortion.k1)
       << "\nk2 = " << number_text(eye.distortion.k2)
       << "\ndistortion_centre_px = " << list_of(eye.distortion.centre_px)
       << "\ndistortion_unit_px = " << number_text(eye.distortion.unit_px) << "\n";
}

}  // namespace

Calibration parsed_calibration(const std::string& text, const std::string& path, const BenchFile& bench)
{
  return calibration_in(SettingsTable::parsed(text, path), bench);
}

Calibration read_calibration(const std::string& path, const BenchFile& bench)
{
  return calibration_in(SettingsTable::read(path, "a calibration file (schemas/calibration.md)"), bench);
}

std::string calibration_text(const Calibration& calibration, const BenchFile& bench)
{
  std::ostringstream text;
  text << "# schemas/calibration.md says what everything means.\nversion = " << version
       << "\nbench = " << quoted_text(bench.title)
       << "\nimage_distance_mm = " << number_text(calibration.image_distance_mm)
       << "\nstage_direction = " << list_of(calibration.stage_direction_table)
       << "  # of the table, a unit vector\nsubject_scale = " << number_text(calibration.subject_scale)
       << "  # of the model's lengths\n\n[display]\nwidth = " << bench.display.width
       << "\nheight = " << bench.display.height
       << "\nlayout = " << quoted_text(layout_names()[static_cast<std::size_t>(bench.display.layout)])
       << "\nleft_window = " << list_text(numbers_of(bench.display.windows.left))
       << "  # px: x, y, width, height\nright_window = " << list_text(numbers_of(bench.display.windows.right))
       << "\n";
  add_eye(text, "left", calibration.eyes.left);
  add_eye(text, "right", calibration.eyes.right);
  add_six(text, "table", "the table in the tracker's frame", calibration.X_tracker_table);
  add_six(text, "eyes", "the middle between the eyes on the table, with the stage at zero",
          calibration.X_table_eyes);
  add_six(text, "head", "the middle between the eyes on the display's body", calibration.X_headbody_eyes);
  add_six(text, "leg", "the knee model on the leg's body", calibration.X_body_model[0]);
  add_six(text, "femur", "the femur's model on its body", calibration.X_body_model[1]);
  add_six(text, "tibia", "the tibia's model on its body", calibration.X_body_model[2]);
  return text.str() + records_text(calibration.records);
}

}  // namespace vrda
