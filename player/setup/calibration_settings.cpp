#include "setup/calibration_settings.hpp"

#include <set>

#include "core/text.hpp"
#include "settings/settings_table.hpp"
#include "setup/tool_name.hpp"

namespace vrda {
namespace {

constexpr double largest_target_mm = 1e4;
constexpr std::size_t most_rectangles = 20, most_points = 100;
/// Enough for every fit, and a file that stays small.
constexpr double most_repeats = 20, most_samples = 2000;

std::vector<CalibrationRectangle> rectangles_of(const SettingsTable& table)
{
  std::vector<CalibrationRectangle> rectangles;
  std::set<double> depths_mm;
  for (const std::vector<double>& row :
       table.rows("rectangles", 2, {-largest_target_mm, largest_target_mm})) {
    if (!(row[0] >= 1.0)) {
      table.refuse("rectangles", "a width of " + shortest(row[0]) + " mm",
                   "rows of width and depth; widths of at least 1 mm");
    }
    rectangles.push_back({row[0], row[1]});
    depths_mm.insert(row[1]);
  }
  if (rectangles.size() > most_rectangles) {
    table.refuse("rectangles", std::to_string(rectangles.size()) + " rectangles",
                 "at most " + std::to_string(most_rectangles));
  }
  if (depths_mm.size() < 2) {
    table.refuse("rectangles", "one depth only, " + shortest(*depths_mm.begin()) + " mm",
                 "two depths or more: of one alone nobody can tell how far the eye is");
  }
  return rectangles;
}

template <typename Item>
void require_one_name(const SettingsTable& table, const std::vector<Item>& items, const std::string& name)
{
  for (const Item& item : items) {
    if (item.name == name) table.refuse("name", "'" + name + "' a second time", "a name of its own");
  }
}

std::vector<CalibrationPoint> points_of(const SettingsTable& table, const char* key)
{
  std::vector<CalibrationPoint> points;
  for (const SettingsTable& item : table.tables(key, most_points)) {
    item.require_known({"name", "mm", "target"});
    CalibrationPoint point;
    point.name = item.text("name");
    require_one_name(item, points, point.name);
    const std::vector<double> v = item.numbers("mm", 3, {-largest_target_mm, largest_target_mm});
    point.p_model_mm = {v[0], v[1], v[2]};
    point.is_target = item.flag_or("target", false);
    points.push_back(point);
  }
  return points;
}

std::vector<CalibrationLandmarks> landmarks_of(const SettingsTable& table)
{
  std::vector<CalibrationLandmarks> landmarks;
  for (const SettingsTable& item : table.tables("landmarks", most_points)) {
    item.require_known({"name", "model_mm"});
    CalibrationLandmarks pair{item.text("name"), item.number("model_mm", {1.0, largest_target_mm})};
    require_one_name(item, landmarks, pair.name);
    landmarks.push_back(pair);
  }
  return landmarks;
}

void add_optics(const SettingsTable& table, CalibrationSettings& settings)
{
  settings.edge_repeats = table.whole_or("edge_repeats", settings.edge_repeats, {2, most_repeats});
  settings.screen_sd_mm = table.number_or("screen_sd_mm", settings.screen_sd_mm, {1e-6, 100.0});
  if (table.has("distortion")) settings.is_grid_adjusted = table.word("distortion", {"marks", "adjust"}) == 1;
  if (table.has("grid")) {
    const std::vector<double> grid = table.numbers("grid", 2, {3, 50});
    settings.grid_columns = static_cast<int>(grid[0]);
    settings.grid_rows = static_cast<int>(grid[1]);
    if (settings.grid_columns != grid[0] || settings.grid_rows != grid[1])
      table.refuse("grid", shortest(grid[0]) + " and " + shortest(grid[1]),
                   "columns and rows, whole numbers");
  }
  settings.grid_repeats = table.whole_or("grid_repeats", settings.grid_repeats, {2, most_repeats});
}

void add_person(const SettingsTable& table, CalibrationSettings& settings)
{
  if (table.has("rectangles")) settings.rectangles = rectangles_of(table);
  settings.rectangle_repeats =
      table.whole_or("rectangle_repeats", settings.rectangle_repeats, {1, most_repeats});
  settings.alignment_sd_deg = table.number_or("alignment_sd_deg", settings.alignment_sd_deg, {0.0, 10.0});
  settings.sight_sd_px = table.number_or("sight_sd_px", settings.sight_sd_px, {1e-6, 1000.0});
  settings.has_pupillometer = table.flag_or("pupillometer", settings.has_pupillometer);
  settings.pupillometer_sd_mm =
      table.number_or("pupillometer_sd_mm", settings.pupillometer_sd_mm, {1e-6, 10.0});
  settings.eye_height_sd_mm = table.number_or("eye_height_sd_mm", settings.eye_height_sd_mm, {1e-6, 10.0});
}

void add_tracking(const SettingsTable& table, CalibrationSettings& settings)
{
  settings.probe = tool_name_or(table, "probe", settings.probe);
  settings.marker = tool_name_or(table, "marker", settings.marker);
  settings.rail_samples = table.whole_or("rail_samples", settings.rail_samples, {10, most_samples});
  settings.pivot_samples = table.whole_or("pivot_samples", settings.pivot_samples, {20, most_samples});
  settings.hold_samples = table.whole_or("hold_samples", settings.hold_samples, {2, 200});
  settings.bullseyes = table.whole_or("bullseyes", settings.bullseyes, {6, 27});
  if (table.has("model")) settings.is_model_adjusted = table.word("model", {"fiducials", "adjust"}) == 1;
  settings.model_repeats = table.whole_or("model_repeats", settings.model_repeats, {2, most_repeats});
  settings.points = points_of(table, "point");
  settings.tibia_points = points_of(table, "tibia_point");
  settings.landmarks = landmarks_of(table);
}

}  // namespace

CalibrationSettings calibration_settings_of(const SettingsTable& root)
{
  CalibrationSettings settings;
  if (!root.has("calibration")) return settings;
  settings.is_present = true;
  const SettingsTable table = root.table("calibration");
  table.require_known({"edge_repeats",
                       "screen_sd_mm",
                       "distortion",
                       "grid",
                       "grid_repeats",
                       "rectangles",
                       "rectangle_repeats",
                       "alignment_sd_deg",
                       "sight_sd_px",
                       "pupillometer",
                       "pupillometer_sd_mm",
                       "eye_height_sd_mm",
                       "probe",
                       "marker",
                       "rail_samples",
                       "pivot_samples",
                       "hold_samples",
                       "bullseyes",
                       "model",
                       "model_repeats",
                       "point",
                       "tibia_point",
                       "landmarks"});
  add_optics(table, settings);
  add_person(table, settings);
  add_tracking(table, settings);
  return settings;
}

}  // namespace vrda
