#include "setup/calibration_settings.hpp"

#include <set>

#include "core/text.hpp"
#include "documents/document.hpp"
#include "setup/tool_name.hpp"

namespace vrda {
namespace {

std::vector<CalibrationRectangle> rectangles_of(const Document& document)
{
  std::vector<CalibrationRectangle> rectangles;
  std::set<double> depths_mm;
  for (const std::vector<double>& row : rows_at(document.root, "calibration.rectangles")) {
    rectangles.push_back({row[0], row[1]});
    depths_mm.insert(row[1]);
  }
  if (depths_mm.size() < 2) {
    document.refuse("calibration.rectangles", "one depth, " + shortest(*depths_mm.begin()) + " mm",
                    "two depths or more; one depth does not determine the distance of the eye");
  }
  return rectangles;
}

/// Converts a list of tables with unique names by `item_of`.
template <typename Item, typename ItemOf>
std::vector<Item> named_items(const Document& document, const std::string& key, ItemOf item_of)
{
  std::vector<Item> items;
  std::set<std::string> names;
  for (const DocumentValue& value : list_or_empty(document.root, key)) {
    const std::string& name = text_at(value, "name");
    if (!names.insert(name).second) {
      document.refuse(key + "." + std::to_string(items.size()) + ".name", "'" + name + "' twice",
                      "a unique name");
    }
    items.push_back(item_of(value, name));
  }
  return items;
}

std::vector<CalibrationPoint> points_of(const Document& document, const std::string& key)
{
  return named_items<CalibrationPoint>(
      document, key, [](const DocumentValue& value, const std::string& name) {
        return CalibrationPoint{name, vector3_at(value, "mm"), flag_at(value, "target")};
      });
}

std::vector<CalibrationLandmarks> landmarks_of(const Document& document)
{
  return named_items<CalibrationLandmarks>(document, "calibration.landmarks",
                                           [](const DocumentValue& value, const std::string& name) {
                                             return CalibrationLandmarks{name, number_at(value, "model_mm")};
                                           });
}

int whole_at(const DocumentValue& table, const char* key)
{
  return static_cast<int>(integer_at(table, key));
}

}  // namespace

CalibrationSettings calibration_settings_of(const Document& document)
{
  CalibrationSettings settings;
  const DocumentValue* table = document.root.find("calibration");
  if (table == nullptr) return settings;
  const std::vector<double> grid = numbers_at(*table, "grid");
  settings.is_present = true;
  settings.edge_repeats = whole_at(*table, "edge_repeats");
  settings.screen_sd_mm = number_at(*table, "screen_sd_mm");
  settings.is_grid_adjusted = text_at(*table, "distortion") == "adjust";
  settings.grid_columns = static_cast<int>(grid[0]);
  settings.grid_rows = static_cast<int>(grid[1]);
  settings.grid_repeats = whole_at(*table, "grid_repeats");
  settings.rectangle_repeats = whole_at(*table, "rectangle_repeats");
  settings.alignment_sd_deg = number_at(*table, "alignment_sd_deg");
  settings.sight_sd_px = number_at(*table, "sight_sd_px");
  settings.has_pupillometer = flag_at(*table, "pupillometer");
  settings.pupillometer_sd_mm = number_at(*table, "pupillometer_sd_mm");
  settings.eye_height_sd_mm = number_at(*table, "eye_height_sd_mm");
  settings.rail_samples = whole_at(*table, "rail_samples");
  settings.pivot_samples = whole_at(*table, "pivot_samples");
  settings.hold_samples = whole_at(*table, "hold_samples");
  settings.bullseyes = whole_at(*table, "bullseyes");
  settings.is_model_adjusted = text_at(*table, "model") == "adjust";
  settings.model_repeats = whole_at(*table, "model_repeats");
  settings.rectangles = rectangles_of(document);
  settings.probe = tool_name(document, "calibration.probe");
  settings.marker = tool_name(document, "calibration.marker");
  settings.points = points_of(document, "calibration.point");
  settings.tibia_points = points_of(document, "calibration.tibia_point");
  settings.landmarks = landmarks_of(document);
  return settings;
}

}  // namespace vrda
