#include "bench/document_parts.hpp"

#include <set>

#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::bench {
namespace {

/// Throws InputError if the rectangles do not determine an eyepoint.
std::vector<CalibrationRectangle> rectangles_of(const core::Document& document, int repeats)
{
  std::vector<CalibrationRectangle> rectangles;
  std::set<double> depths_mm;
  for (const std::vector<double>& row : core::rows_at(document.root, "calibration.rectangles")) {
    rectangles.push_back({row[0], row[1]});
    depths_mm.insert(row[1]);
  }
  if (*depths_mm.rbegin() - *depths_mm.begin() < least_depth_range_mm) {
    document.refuse("calibration.rectangles", "one depth, " + shortest_decimal(*depths_mm.begin()) + " mm",
                    "two depths or more, " + shortest_decimal(least_depth_range_mm) +
                        " mm apart; one depth does not determine the distance of the eye");
  }
  const std::size_t n_marks = rectangles.size() * static_cast<std::size_t>(repeats);
  if (n_marks < least_rectangle_marks) {
    document.refuse(
        "calibration.rectangle_repeats",
        std::to_string(n_marks) + " alignments of " + std::to_string(rectangles.size()) + " rectangles",
        std::to_string(least_rectangle_marks) +
            " alignments or more for each eye; add repeats or rectangles");
  }
  return rectangles;
}

/// Throws InputError if the nodes of a grid are too few for the marks of a distortion.
void require_nodes(const core::Document& document, const CalibrationSettings& settings)
{
  const int n_nodes = settings.grid_columns * settings.grid_rows;
  if (settings.is_grid_adjusted || n_nodes >= static_cast<int>(least_grid_marks)) return;
  document.refuse(
      "calibration.grid",
      std::to_string(settings.grid_columns) + " by " + std::to_string(settings.grid_rows) + " nodes",
      std::to_string(least_grid_marks) + " nodes or more");
}

/// Converts a list of tables with unique names by `item_of`.
template <typename Item, typename ItemOf>
std::vector<Item> named_items(const core::Document& document, const std::string& key, ItemOf item_of)
{
  std::vector<Item> items;
  std::set<std::string> names;
  for (const core::DocumentValue& value : core::list_or_empty(document.root, key)) {
    const std::string& name = core::text_at(value, "name");
    if (!names.insert(name).second) {
      document.refuse(key + "." + std::to_string(items.size()) + ".name", "'" + name + "' twice",
                      "a unique name");
    }
    items.push_back(item_of(value, name));
  }
  return items;
}

std::vector<CalibrationPoint> points_of(const core::Document& document, const std::string& key)
{
  return named_items<
      CalibrationPoint>(document, key, [](const core::DocumentValue& value, const std::string& name) {
    return CalibrationPoint{name, core::vector3_at(value, "mm"), core::flag_at(value, "target")};
  });
}

std::vector<CalibrationLandmarks> landmarks_of(const core::Document& document)
{
  return named_items<CalibrationLandmarks>(
      document, "calibration.landmarks", [](const core::DocumentValue& value, const std::string& name) {
        return CalibrationLandmarks{name, core::number_at(value, "model_mm")};
      });
}

int whole_at(const core::DocumentValue& table, const char* key)
{
  return static_cast<int>(core::integer_at(table, key));
}

const std::string& required_short(const core::Document& document, const std::string& key,
                                  const std::string& name)
{
  if (name.size() > longest_tool_name) {
    document.refuse(
        key, "'" + name + "' of " + std::to_string(name.size()) + " bytes",
        "at most " + std::to_string(longest_tool_name) + " bytes (OpenIGTLink truncates longer names)");
  }
  return name;
}

}  // namespace

std::string tool_name(const core::Document& document, const std::string& key)
{
  return required_short(document, key, core::text_at(document.root, key));
}

std::vector<std::string> tool_names(const core::Document& document, const std::string& key)
{
  std::vector<std::string> names = core::texts_at(document.root, key);
  for (const std::string& one : names) required_short(document, key, one);
  return names;
}

CalibrationSettings calibration_settings_of(const core::Document& document)
{
  CalibrationSettings settings;
  const core::DocumentValue* table = document.root.find("calibration");
  if (table == nullptr) return settings;
  const std::vector<double> grid = core::numbers_at(*table, "grid");
  settings.is_present = true;
  settings.edge_repeats = whole_at(*table, "edge_repeats");
  settings.screen_sd_mm = core::number_at(*table, "screen_sd_mm");
  settings.is_grid_adjusted = core::text_at(*table, "distortion") == "adjust";
  settings.grid_columns = static_cast<int>(grid[0]);
  settings.grid_rows = static_cast<int>(grid[1]);
  require_nodes(document, settings);
  settings.grid_repeats = whole_at(*table, "grid_repeats");
  settings.rectangle_repeats = whole_at(*table, "rectangle_repeats");
  settings.alignment_sd_rad = rad_from_deg(core::number_at(*table, "alignment_sd_deg"));
  settings.sight_sd_px = core::number_at(*table, "sight_sd_px");
  settings.has_pupillometer = core::flag_at(*table, "pupillometer");
  settings.pupillometer_sd_mm = core::number_at(*table, "pupillometer_sd_mm");
  settings.eye_height_sd_mm = core::number_at(*table, "eye_height_sd_mm");
  settings.rail_samples = whole_at(*table, "rail_samples");
  settings.pivot_samples = whole_at(*table, "pivot_samples");
  settings.hold_samples = whole_at(*table, "hold_samples");
  settings.bullseyes = whole_at(*table, "bullseyes");
  settings.is_model_adjusted = core::text_at(*table, "model") == "adjust";
  settings.model_repeats = whole_at(*table, "model_repeats");
  settings.rectangles = rectangles_of(document, settings.rectangle_repeats);
  settings.probe = tool_name(document, "calibration.probe");
  settings.marker = tool_name(document, "calibration.marker");
  settings.points = points_of(document, "calibration.point");
  settings.tibia_points = points_of(document, "calibration.tibia_point");
  settings.landmarks = landmarks_of(document);
  settings.bends = whole_at(*table, "bends");
  settings.bend_samples = whole_at(*table, "bend_samples");
  settings.functional = {core::number_at(*table, "tracker_sd_mm"),
                         rad_from_deg(core::number_at(*table, "tracker_sd_deg")),
                         core::number_at(*table, "model_sd_mm"),
                         rad_from_deg(core::number_at(*table, "model_sd_deg"))};
  return settings;
}

}  // namespace vrda::bench
