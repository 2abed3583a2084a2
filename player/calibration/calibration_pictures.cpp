#include "calibration/calibration_pictures.hpp"

#include <algorithm>
#include <filesystem>

#include "calibration/calibration_panel.hpp"
#include "calibration/marks.hpp"
#include "view/arguments.hpp"
#include "view/viewport.hpp"
#include "view/image.hpp"
#include "show/settings_text.hpp"
#include "store/motion_model_file.hpp"
#include "calibration/statistics.hpp"

namespace vrda::calibration {
namespace {

constexpr int samples_of_sheet = 1;  // lines are anti-aliased by the overlay

Eigen::Vector2d placed(const SheetFrame& frame, const Eigen::Vector2d& p_px)
{
  return frame.at_px + frame.scale * (p_px - frame.source.low_px);
}

}  // namespace

Sheet::Sheet(int width, int height)
    : renderer_(view::make_offscreen_renderer({width, height, samples_of_sheet, 0.0})),
      text_(view::panel_text_px)
{
  nothing_.background = view::background_of(view::Backdrop::black);
  renderer_->load(nothing_);
  renderer_->load(text_.font());
  view::clear_overlay(overlay_, width, height);
}

view::OverlayBox Sheet::clip_of(const SheetFrame& frame) const
{
  // Room for an outline on the border.
  constexpr float rim_px = 2.0F;
  const Eigen::Vector2f low = placed(frame, frame.source.low_px).cast<float>();
  const Eigen::Vector2f high = placed(frame, frame.source.high_px).cast<float>();
  return {low.x() - rim_px, low.y() - rim_px, high.x() + rim_px, high.y() + rim_px};
}

void Sheet::add_lines(const SheetFrame& frame, std::span<const DrawnLine> lines)
{
  view::clip_overlay(overlay_, clip_of(frame));
  for (DrawnLine line : lines) {
    for (Eigen::Vector2d& p : line.points_px) p = placed(frame, p);
    line.is_smooth = true;
    add_drawn_line(overlay_, text_, line);
  }
}

void Sheet::add_area(const SheetFrame& frame, const view::ShownBox& box, const view::VertexColour& colour)
{
  view::clip_overlay(overlay_, clip_of(frame));
  const Eigen::Vector2f low = placed(frame, box.low_px).cast<float>();
  const Eigen::Vector2f high = placed(frame, box.high_px).cast<float>();
  text_.add_area(overlay_, {low.x(), low.y(), high.x(), high.y()}, colour);
}

void Sheet::add_words(const Eigen::Vector2d& at_px, const std::string& words,
                      const view::VertexColour& colour)
{
  view::clip_overlay(overlay_, {0.0F, 0.0F, static_cast<float>(renderer_->width()),
                               static_cast<float>(renderer_->height())});
  const Eigen::Vector2f at = at_px.cast<float>();
  text_.add_text(overlay_, at.x(), at.y(), words, colour);
}

const view::Image& Sheet::image()
{
  view::finish_overlay(overlay_);
  return renderer_->draw(nothing_, {}, &overlay_);
}

DrawnLine outline_of(const view::ShownBox& box, const std::array<float, 3>& colour, double width_px)
{
  const Eigen::Vector2d &low = box.low_px, &high = box.high_px;
  DrawnLine line;
  line.points_px = {low, {high.x(), low.y()}, high, {low.x(), high.y()}, low};
  line.width_px = width_px;
  line.colour = colour;
  return line;
}

namespace {

using Colour = std::array<float, 3>;
constexpr view::VertexColour window_area{30, 34, 40, 255}, visible_area{24, 56, 40, 255};
constexpr Colour grey{0.45F, 0.48F, 0.52F}, green{0.38F, 0.85F, 0.5F}, amber{1.0F, 0.69F, 0.18F},
    white{0.9F, 0.92F, 0.95F}, blue{0.4F, 0.65F, 1.0F};
constexpr double line_px = 1.5;
constexpr double words_px = 24.0, gap_px = 16.0;  // line height of text; gap between frames

std::vector<DrawnLine> cross_at(const Eigen::Vector2d& p, double arm_px, const Colour& colour, bool is_right)
{
  DrawnLine level, upright;
  level.points_px = {{p.x() - arm_px, p.y()}, {p.x() + arm_px, p.y()}};
  upright.points_px = {{p.x(), p.y() - arm_px}, {p.x(), p.y() + arm_px}};
  for (DrawnLine* line : {&level, &upright}) {
    line->width_px = line_px;
    line->colour = colour;
    line->is_right = is_right;
  }
  return {level, upright};
}

void recolour(std::vector<DrawnLine>& lines, const Colour& colour)
{
  for (DrawnLine& line : lines) line.colour = colour;
}

std::string size_text(const view::Viewport& v)
{
  return std::to_string(v.width) + " x " + std::to_string(v.height) + " px";
}

std::string written(Sheet& sheet, const std::string& folder, const char* name)
{
  const std::string path = folder + "/" + name;
  view::write_png(sheet.image(), path);
  return path;
}

/// Figure 22.
std::string write_viewport(const PictureRequest& request, const std::string& folder)
{
  const bench::DisplaySettings& display = request.bench.display;
  constexpr double scale = 0.7;
  const view::ShownBox all{{0.0, 0.0}, {display.width, display.height}};
  const SheetFrame frame{all, {gap_px, gap_px}, scale};
  Sheet sheet(static_cast<int>(scale * display.width + 2.0 * gap_px),
              static_cast<int>(scale * display.height + 2.0 * gap_px));
  sheet.add_lines(frame, std::array{outline_of(all, grey)});
  for (const bool is_right : {false, true}) {
    const view::Eye& eye = view::side_of(request.found.eyes, is_right);
    const view::Viewport& seen = eye.visible;
    sheet.add_area(frame, view::box_of(eye.window), window_area);
    sheet.add_area(frame, view::box_of(seen), visible_area);
    sheet.add_lines(frame, std::array{outline_of(view::box_of(eye.window), grey),
                                      outline_of(view::box_of(seen), green)});
    const Eigen::Vector2d centre = view::middle_px(seen);
    sheet.add_lines(frame, cross_at(centre, 12.0, white, is_right));
    sheet.add_lines(frame, cross_at(view::middle_px(eye.window), 6.0, grey, is_right));
    const Eigen::Vector2d corner = frame.at_px + scale * Eigen::Vector2d(seen.x, seen.y);
    sheet.add_words(corner + Eigen::Vector2d(8.0, 6.0),
                    std::string(is_right ? "right" : "left") + " eye: visible " + size_text(seen), ink);
    sheet.add_words(
        corner + Eigen::Vector2d(8.0, 26.0),
        "centre " + show::rounded_text(centre.x(), 1) + ", " + show::rounded_text(centre.y(), 1),
        ink);
  }
  const view::Viewport& left = request.found.eyes.left.visible;
  const view::Viewport& window = request.found.eyes.left.window;
  DrawnLine scan;
  scan.points_px = {{left.x + 0.5, window.y}, {left.x + 0.5, window.y + window.height}};
  scan.width_px = 2.0;
  scan.colour = amber;
  sheet.add_lines(frame, std::array{scan});
  const std::string words = "scan line at column " + std::to_string(left.x);
  sheet.add_words(frame.at_px + scale * Eigen::Vector2d(window.x, window.y + 0.5 * window.height) -
                      Eigen::Vector2d(sheet.width_px(words) + 8.0, 8.0),
                  words, {255, 176, 46, 255});
  sheet.add_words({frame.at_px.x() + 12.0, frame.at_px.y() + 10.0},
                  "frame buffer " + std::to_string(display.width) + " x " + std::to_string(display.height),
                  faint);
  return written(sheet, folder, "viewport.png");
}

/// Horizontal and vertical lines over a box, with a point every 4 px.
std::vector<DrawnLine> straight_grid(const view::ShownBox& box, double spacing_px)
{
  constexpr double piece_px = 4.0;
  std::vector<DrawnLine> lines;
  const Eigen::Vector2d middle = 0.5 * (box.low_px + box.high_px);
  for (const Eigen::Index along : {0, 1}) {
    const Eigen::Index across = 1 - along;
    const double half_px = 0.5 * (box.high_px - box.low_px)[across];
    const int n = static_cast<int>(half_px / spacing_px);
    for (int k = -n; k <= n; ++k) {
      DrawnLine line;
      line.width_px = line_px;
      line.colour = white;
      for (double at = box.low_px[along]; at <= box.high_px[along]; at += piece_px) {
        Eigen::Vector2d p;
        p[along] = at;
        p[across] = middle[across] + k * spacing_px;
        line.points_px.push_back(p);
      }
      lines.push_back(std::move(line));
    }
  }
  return lines;
}

/// Figure 23.
std::string write_distortion(const PictureRequest& request, const std::string& folder)
{
  constexpr double scale = 0.62, spacing_px = 60.0;
  const view::Eye& eye = request.truth.calibration.eyes.left;
  const view::ShownBox box = view::shown_box(eye);
  const Eigen::Vector2d size = scale * (box.high_px - box.low_px);
  const std::vector<DrawnLine> plain = straight_grid(box, spacing_px);
  std::vector<DrawnLine> bent = plain;
  for (DrawnLine& line : bent)
    for (Eigen::Vector2d& p : line.points_px) p = view::drawn_px(request.found.eyes.left.distortion, p);
  const std::vector<DrawnLine> corrected = calibration::seen_lines(bent, request.truth);
  const std::vector<DrawnLine> distorted = calibration::seen_lines(plain, request.truth);
  Sheet sheet(static_cast<int>(3.0 * size.x() + 4.0 * gap_px),
              static_cast<int>(size.y() + words_px + 2.0 * gap_px));
  const auto add = [&](int k, const char* words, const std::vector<DrawnLine>& lines) {
    const Eigen::Vector2d at(gap_px + k * (size.x() + gap_px), gap_px + words_px);
    sheet.add_words(at - Eigen::Vector2d(0.0, words_px), words, ink);
    sheet.add_lines({box, at, scale}, lines);
    sheet.add_lines({box, at, scale}, std::array{outline_of(box, grey)});
  };
  add(0, "undistorted, seen through the optics", distorted);
  add(1, "pre-distorted, as drawn", bent);
  add(2, "pre-distorted, seen through the optics", corrected);
  return written(sheet, folder, "distortion.png");
}

/// Dial values with which a task was finished.
std::vector<double> dials_of(const Task& task, const CalibrationMark& mark, const Calibration& found)
{
  const view::Eye& eye = view::side_of(found.eyes, task.is_right);
  const std::vector<double>& row = mark.rows.front();
  const auto shown = [&](std::size_t k) { return view::shown_px(eye.distortion, {row[k], row[k + 1]}); };
  if (task.kind == TaskKind::rectangle_sides) return {shown(0).x(), shown(2).x()};
  const Eigen::Vector2d p = shown(0);
  return {p.x(), p.y()};
}

struct AlignedTask {
  const Task* task;
  const CalibrationMark* mark;
};

/// The left eye's first task of each index.
std::vector<AlignedTask> aligned_tasks(const PictureRequest& request, TaskKind kind, CalibrationPart part)
{
  std::vector<AlignedTask> found;
  for (const Task& task : request.tasks) {
    const auto is_same = [&](const AlignedTask& other) { return other.task->index == task.index; };
    if (task.kind != kind || task.is_right || std::ranges::any_of(found, is_same)) continue;
    const CalibrationRecord* record = calibration::find_record(request.found, part);
    const CalibrationMark* mark =
        record == nullptr ? nullptr : calibration::find_mark(*record, task.name);
    if (mark != nullptr) found.push_back({&task, mark});
  }
  return found;
}

struct AlignedSheet {
  const char* name;
  TaskKind kind;
  CalibrationPart part;
  std::size_t most;
  std::string title;
};

/// Real objects and drawn lines as seen by the left eye, before (row 0) and after (row 1) the alignment.
std::vector<std::string> write_aligned(const PictureRequest& request, const std::string& folder,
                                       const AlignedSheet& plan)
{
  constexpr double scale = 0.42;
  std::vector<AlignedTask> tasks = aligned_tasks(request, plan.kind, plan.part);
  if (tasks.empty()) return {};
  tasks.resize(std::min(tasks.size(), plan.most));
  const view::ShownBox box = view::shown_box(request.truth.calibration.eyes.left);
  const Eigen::Vector2d size = scale * (box.high_px - box.low_px);
  const auto n = static_cast<double>(tasks.size());
  Sheet sheet(static_cast<int>(n * size.x() + (n + 1.0) * gap_px),
              static_cast<int>(2.0 * (size.y() + words_px + gap_px) + gap_px));
  for (std::size_t k = 0; k < tasks.size(); ++k) {
    const Task& task = *tasks[k].task;
    std::vector<double> begun;
    for (const Dial& dial : task.dials) begun.push_back(dial.value);
    const std::array<std::vector<double>, 2> moments{begun, dials_of(task, *tasks[k].mark, request.found)};
    std::vector<DrawnLine> real = calibration::physical_outlines(task, request.bench, request.truth);
    recolour(real, blue);
    for (std::size_t row = 0; row < moments.size(); ++row) {
      std::vector<DrawnLine> lines = calibration::seen_lines(
          calibration::task_lines(task, moments[row], request.found), request.truth);
      recolour(lines, row == 0 ? amber : green);
      const Eigen::Vector2d at(gap_px + static_cast<double>(k) * (size.x() + gap_px),
                               gap_px + words_px + static_cast<double>(row) * (size.y() + words_px + gap_px));
      const SheetFrame frame{box, at, scale};
      sheet.add_words(
          at - Eigen::Vector2d(0.0, words_px),
          plan.title + " " + std::to_string(task.index + 1) + (row == 0 ? ": start" : ": aligned"), ink);
      sheet.add_lines(frame, real);
      sheet.add_lines(frame, lines);
      sheet.add_lines(frame, std::array{outline_of(box, grey)});
    }
  }
  return {written(sheet, folder, plan.name)};
}

void copy_into(view::Image& all, const view::Image& part, int x, int y)
{
  for (int row = 0; row < std::min(part.height, all.height - y); ++row) {
    const std::ptrdiff_t n = 4 * static_cast<std::ptrdiff_t>(std::min(part.width, all.width - x));
    const auto from = part.rgba.begin() + 4 * static_cast<std::ptrdiff_t>(row) * part.width;
    std::copy_n(from, n, all.rgba.begin() + 4 * (static_cast<std::ptrdiff_t>(y + row) * all.width + x));
  }
}

/// Figure 26.
std::string write_overlay(const PictureRequest& request, const CalibrateOptions& options)
{
  const store::MotionModel model = store::read_motion_model(options.model);
  store::require_grid(model, options.model, "a calibration");
  const OverlayPictureOptions plan{store::chosen_set(model, options.model, options.set), 560};
  const view::Image before = overlay_picture(
      request.bench, request.truth, calibration::uncalibrated(request.bench, request.truth), model, plan);
  const view::Image after = overlay_picture(request.bench, request.truth, request.found, model, plan);
  const int gap = static_cast<int>(gap_px), words = static_cast<int>(words_px);
  Sheet sheet(before.width + after.width + 3 * gap, before.height + 2 * gap + words);
  const int second = 2 * gap + before.width;
  sheet.add_words({gap_px, gap_px}, "before: nominal eyes; grey: the real leg", ink);
  sheet.add_words({static_cast<double>(second), gap_px}, "after: calibrated", ink);
  view::Image both = sheet.image();
  copy_into(both, before, gap, gap + words);
  copy_into(both, after, second, gap + words);
  const std::string path = options.pictures + "/overlay.png";
  view::write_png(both, path);
  return path;
}

}  // namespace

std::vector<std::string> write_calibration_pictures(const PictureRequest& request,
                                                    const CalibrateOptions& options)
{
  std::filesystem::create_directories(options.pictures);
  std::vector<std::string> paths{write_viewport(request, options.pictures),
                                 write_distortion(request, options.pictures)};
  const auto add = [&](const AlignedSheet& plan) {
    for (std::string& path : write_aligned(request, options.pictures, plan)) paths.push_back(std::move(path));
  };
  add({"rectangles.png", TaskKind::rectangle_sides, CalibrationPart::eyepoints, 4, "rectangle"});
  const CalibrationPart eyes =
      request.bench.head == HeadKind::tracker ? CalibrationPart::head : CalibrationPart::bullseye;
  add({"bullseye.png", TaskKind::bullseye, eyes, 3, "marker position"});
  if (!options.model.empty()) paths.push_back(write_overlay(request, options));
  return paths;
}

}  // namespace vrda::calibration
