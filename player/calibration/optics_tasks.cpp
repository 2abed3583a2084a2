// Calibration tasks of the display: visible edges, distortion, eye point, inter-pupillary distance, subject.
#include "calibration/task.hpp"

#include <cmath>

#include "calibration/eyepoint_fit.hpp"
#include "show/session.hpp"
#include "view/eye.hpp"

namespace vrda::calibration {
namespace {

/// Below visual resolution, but coarse enough for keys.
constexpr double dial_step_px = 0.25, dial_step_mm = 0.05;

Dial dial(const char* name, const char* unit, double value, double least, double most, double step)
{
  return {.name = name, .unit = unit, .value = value, .minimum = least, .maximum = most, .step = step};
}

Dial within(Dial dial, double least_plausible, double most_plausible)
{
  dial.least_plausible = least_plausible;
  dial.most_plausible = most_plausible;
  return dial;
}

/// Name with a number counted from 1.
std::string nth(const std::string& name, int k)
{
  return name + ", " + std::to_string(k + 1);
}

Task scan_task(const view::Viewport& window, bool is_right, calibration::Edge edge, int repeat)
{
  Task task;
  task.kind = TaskKind::scan_line;
  task.is_right = is_right;
  task.is_column = edge == calibration::Edge::left || edge == calibration::Edge::right;
  task.index = static_cast<int>(edge);
  const std::string side = calibration::name_of(edge);
  task.name = nth(eye_text(is_right) + ", " + side + " edge", repeat);
  const bool is_first = edge == calibration::Edge::left || edge == calibration::Edge::top;
  const double least = task.is_column ? window.x : window.y;
  const double most = least + (task.is_column ? window.width : window.height) - 1.0;
  task.instruction = "Use only the " + eye_text(is_right) + ". Move the line to the " + side +
                     " edge of the visible part:\nthe " + (is_first ? "first" : "last") +
                     (task.is_column ? " column" : " row") +
                     " of which at least half is visible. Approach from alternating sides.";
  // The window's border is hidden: the line starts a quarter of the window inside it, where it is seen.
  const double inside = std::floor(0.25 * (most - least));
  // Less than a third of an image is hidden at one side, or the display is unusable.
  const double third = (most - least) / 3.0;
  task.dials = {within(dial(task.is_column ? "column" : "row", "px",
                            is_first ? least + inside : most - inside, least, most, 1.0),
                       is_first ? least : std::ceil(most - third),
                       is_first ? std::floor(least + third) : most)};
  return task;
}

Task screen_task(const view::Viewport& window, bool is_right, bool is_height)
{
  // Start value for a typical pixel size.
  constexpr double usual_pixel_mm = 0.1, most_mm = 5000.0;
  Task task;
  task.kind = TaskKind::number;
  task.is_right = is_right;
  task.index = is_height ? 1 : 0;
  const char* what = is_height ? "height" : "width";
  task.name = eye_text(is_right) + ", " + what;
  task.instruction = "Measure with a ruler on the screen of the " + eye_text(is_right) + " the " + what +
                     "\nof the visible part, from edge to edge.";
  const double begin_mm = usual_pixel_mm * (is_height ? window.height : window.width);
  // Pixels of 0.02 mm (head-mounted) to 1 mm (projected).
  task.dials = {
      within(dial(what, "mm", begin_mm, 1.0, most_mm, dial_step_mm), 0.2 * begin_mm, 10.0 * begin_mm)};
  return task;
}

/// Start value of the spacing: the grid fills 70 % of the visible part.
double likely_spacing_px(const view::Eye& eye, const CalibrationSettings& settings)
{
  constexpr double share = 0.7;
  return share * std::min(eye.visible.width / (settings.grid_columns - 1.0),
                          eye.visible.height / (settings.grid_rows - 1.0));
}

Task node_task(const view::Eye& eye, const CalibrationSettings& settings, bool is_right, int column, int row)
{
  Task task;
  task.kind = TaskKind::point;
  task.is_right = is_right;
  task.node = {column - 0.5 * (settings.grid_columns - 1), row - 0.5 * (settings.grid_rows - 1)};
  const std::string place =
      show::rounded_text(task.node.x(), 1) + ", " + show::rounded_text(task.node.y(), 1);
  task.name = eye_text(is_right) + ", node " + place;
  task.instruction = "Look at the grid with the " + eye_text(is_right) + ". Move the cross to node " + place +
                     "\n(columns to the right of the centre, rows above it).";
  const Eigen::Vector2d up(1.0, -1.0);
  const Eigen::Vector2d begin =
      view::middle_px(eye.visible) + likely_spacing_px(eye, settings) * task.node.cwiseProduct(up);
  const view::Viewport& w = eye.window;
  task.dials = {dial("x", "px", begin.x(), w.x, w.x + w.width, dial_step_px),
                dial("y", "px", begin.y(), w.y, w.y + w.height, dial_step_px)};
  return task;
}

Task grid_task(const view::Eye& eye, const CalibrationSettings& settings, bool is_right, int repeat)
{
  Task task;
  task.kind = TaskKind::grid;
  task.is_right = is_right;
  task.index = repeat;
  task.node = {settings.grid_columns, settings.grid_rows};
  task.name = eye_text(is_right) + ", grid " + std::to_string(repeat + 1);
  task.instruction =
      "Use only the " + eye_text(is_right) +
      ". Adjust the drawn grid until it covers the real one:\nfirst position and spacing at the centre, "
      "then k1 for the edges, k2 for the corners.";
  const Eigen::Vector2d middle = view::middle_px(eye.visible);
  constexpr double most_k = 1.0, step_k = 0.001, step_deg = 0.02, step_spacing_px = 0.05;
  const view::Viewport& w = eye.window;
  const auto across = [&](const char* name, double value) {
    return dial(name, "px", value, w.x, w.x + w.width, dial_step_px);
  };
  const auto down = [&](const char* name, double value) {
    return dial(name, "px", value, w.y, w.y + w.height, dial_step_px);
  };
  task.dials = {dial("k1", "", 0.0, -most_k, most_k, step_k),
                dial("k2", "", 0.0, -most_k, most_k, step_k),
                across("centre x", middle.x()),
                down("centre y", middle.y()),
                across("grid x", middle.x()),
                down("grid y", middle.y()),
                dial("spacing", "px", likely_spacing_px(eye, settings), 1.0, w.width, step_spacing_px),
                dial("turn", "deg", 0.0, -45.0, 45.0, step_deg)};
  return task;
}

Task sides_task(const Calibration& calibration, const CalibrationSettings& settings, bool is_right,
                std::size_t rectangle, int repeat)
{
  const view::Eye& eye = view::side_of(calibration.eyes, is_right);
  const CalibrationRectangle& r = settings.rectangles[rectangle];
  Task task;
  task.kind = TaskKind::rectangle_sides;
  task.is_right = is_right;
  task.index = static_cast<int>(rectangle);
  task.name = nth(eye_text(is_right) + ", rectangle " + std::to_string(rectangle + 1), repeat);
  task.instruction = "Place the rectangle " + show::rounded_text(r.width_mm, 1) + " mm wide " +
                     show::rounded_text(r.depth_mm, 1) + " mm behind the plane of the first one.\nWith the " +
                     eye_text(is_right) +
                     ", align one line with each vertical side: Left and Right move the left line, Up and "
                     "Down the right one.";
  // Start value for a nominal eye at a nominal position.
  const view::Eye usual;
  const double half_px =
      0.5 * r.width_mm * usual.distance_px / std::max(100.0, calibration.image_distance_mm + r.depth_mm);
  const view::ShownBox box = view::shown_box(eye);
  const auto side = [&](const char* name, double x) {
    return dial(name, "px", std::clamp(x, box.low_px.x(), box.high_px.x()), box.low_px.x(), box.high_px.x(),
                dial_step_px);
  };
  task.dials = {side("left side", eye.sight_px.x() - half_px),
                side("right side", eye.sight_px.x() + half_px)};
  return task;
}

Task number_task(const char* name, int index, const std::string& instruction, const Dial& dial)
{
  Task task;
  task.kind = TaskKind::number;
  task.name = name;
  task.index = index;
  task.instruction = instruction;
  task.dials = {dial};
  return task;
}

}  // namespace

std::string eye_text(bool is_right)
{
  return is_right ? "right eye" : "left eye";
}

std::vector<Task> viewport_tasks(const BenchFile& bench)
{
  std::vector<Task> tasks;
  for (const bool is_right : {false, true}) {
    const view::Viewport& window = view::side_of(bench.display.windows, is_right);
    for (int repeat = 0; repeat < bench.calibration.edge_repeats; ++repeat) {
      for (std::size_t edge = 0; edge < calibration::n_edges; ++edge)
        tasks.push_back(scan_task(window, is_right, static_cast<calibration::Edge>(edge), repeat));
    }
    for (const bool is_height : {false, true}) tasks.push_back(screen_task(window, is_right, is_height));
  }
  return tasks;
}

std::vector<Task> distortion_tasks(const BenchFile& bench, const Calibration& calibration)
{
  const CalibrationSettings& settings = bench.calibration;
  std::vector<Task> tasks;
  for (const bool is_right : {false, true}) {
    const view::Eye& eye = view::side_of(calibration.eyes, is_right);
    if (settings.is_grid_adjusted) {
      for (int repeat = 0; repeat < settings.grid_repeats; ++repeat)
        tasks.push_back(grid_task(eye, settings, is_right, repeat));
      continue;
    }
    for (int row = settings.grid_rows - 1; row >= 0; --row) {
      for (int column = 0; column < settings.grid_columns; ++column)
        tasks.push_back(node_task(eye, settings, is_right, column, row));
    }
  }
  return tasks;
}

std::vector<Task> eyepoint_tasks(const BenchFile& bench, const Calibration& calibration)
{
  const CalibrationSettings& settings = bench.calibration;
  std::vector<Task> tasks;
  for (const bool is_right : {false, true}) {
    for (int repeat = 0; repeat < settings.rectangle_repeats; ++repeat) {
      for (std::size_t k = 0; k < settings.rectangles.size(); ++k)
        tasks.push_back(sides_task(calibration, settings, is_right, k, repeat));
    }
  }
  return tasks;
}

std::vector<Task> ipd_tasks(const BenchFile& bench)
{
  // Adults: 45 to 80 mm (Dodgson 2004, Proc SPIE 5291); arms that are set a little beyond.
  constexpr double usual_ipd_mm = 64.0, least_ipd_mm = 40.0, most_ipd_mm = 90.0;
  constexpr double least_adult_mm = 45.0, most_adult_mm = 80.0;
  constexpr double usual_image_mm = 800.0, most_image_mm = 10000.0;
  std::vector<Task> tasks;
  if (bench.calibration.has_pupillometer) {
    tasks.push_back(
        number_task("pupillary distance", 0,
                    "Measure the distance between the pupils with the pupillometer, set to the image "
                    "distance.",
                    within(dial("distance", "mm", usual_ipd_mm, least_ipd_mm, most_ipd_mm, dial_step_mm),
                           least_adult_mm, most_adult_mm)));
  }
  const auto arm = [&](const char* name, int index, const char* side) {
    return number_task(
        name, index,
        std::string("Move the ") + side +
            " arm until its optical axis is in front of the pupil:\nhalf the pupillary distance "
            "from the middle. Read its scale.",
        within(dial("from the middle", "mm", 0.5 * usual_ipd_mm, 0.0, most_ipd_mm, dial_step_mm),
               0.5 * least_adult_mm, 0.5 * most_adult_mm));
  };
  tasks.push_back(arm("left arm", 1, "left"));
  tasks.push_back(arm("right arm", 2, "right"));
  tasks.push_back(
      number_task("image distance", 3, "Set the distance of the virtual image. Nominal: 800 mm.",
                  within(dial("distance", "mm", usual_image_mm, 100.0, most_image_mm, 1.0), 200.0, 5000.0)));
  tasks.back().is_start_valid = true;
  Task look;
  look.kind = TaskKind::depth_check;
  look.name = "look";
  look.instruction =
      "With both eyes: a frame 100 mm wide is drawn at the image distance. Hold a real one of that size\n"
      "there. If both appear at the same depth, press Enter; otherwise press R to measure again.";
  tasks.push_back(look);
  return tasks;
}

std::vector<Task> subject_tasks(const BenchFile& bench)
{
  std::vector<Task> tasks;
  const std::vector<CalibrationLandmarks>& landmarks = bench.calibration.landmarks;
  for (std::size_t k = 0; k < landmarks.size(); ++k) {
    Task task = number_task(
        landmarks[k].name.c_str(), static_cast<int>(k),
        "Measure on the subject: " + landmarks[k].name +
            ".\nDistance in the model: " + show::rounded_text(landmarks[k].model_mm, 1) + " mm.",
        within(dial("distance", "mm", landmarks[k].model_mm, 0.1, 10.0 * landmarks[k].model_mm, dial_step_mm),
               0.5 * landmarks[k].model_mm, 2.0 * landmarks[k].model_mm));
    tasks.push_back(task);
  }
  return tasks;
}

}  // namespace vrda::calibration
