#include "calibration/calibration_pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <utility>

#include "bench/window_check.hpp"
#include "calibration/calibrate.hpp"
#include "calibration/calibration_mode.hpp"
#include "calibration/eyepoint_fit.hpp"
#include "calibration/marks.hpp"
#include "calibration/parts.hpp"
#include "calibration/statistics.hpp"
#include "core/units.hpp"
#include "show/session.hpp"
#include "store/motion_model.hpp"
#include "view/eye.hpp"
#include "view/image.hpp"
#include "view/keys.hpp"

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
    sheet.add_lines(
        frame, std::array{outline_of(view::box_of(eye.window), grey), outline_of(view::box_of(seen), green)});
    const Eigen::Vector2d centre = view::middle_px(seen);
    sheet.add_lines(frame, cross_at(centre, 12.0, white, is_right));
    sheet.add_lines(frame, cross_at(view::middle_px(eye.window), 6.0, grey, is_right));
    const Eigen::Vector2d corner = frame.at_px + scale * Eigen::Vector2d(seen.x, seen.y);
    sheet.add_words(corner + Eigen::Vector2d(8.0, 6.0),
                    std::string(is_right ? "right" : "left") + " eye: visible " + size_text(seen), ink);
    sheet.add_words(corner + Eigen::Vector2d(8.0, 26.0),
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
    const CalibrationMark* mark = record == nullptr ? nullptr : calibration::find_mark(*record, task.name);
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
      std::vector<DrawnLine> lines =
          calibration::seen_lines(calibration::task_lines(task, moments[row], request.found), request.truth);
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

// An image of the drawn model over the real leg as one eye sees them, for calibrations of a virtual bench.

namespace {

constexpr int smoothing_samples = 4;

/// Sends the true body poses as noise-free tracker samples.
void send_truth(bench::BenchState& state, const BenchFile& bench, const VirtualTruth& truth)
{
  const std::array<Pose, bench::n_body_roles> X_tracker_body{truth.X_tracker_leg, truth.X_tracker_leg,
                                                             truth.X_tracker_shank, truth.X_tracker_headbody};
  for (std::size_t role = 0; role < bench::n_body_roles; ++role) {
    if (!bench.bodies[role]) continue;
    const bench::BodySettings& body = *bench.bodies[role];
    const std::size_t first = bench::first_tool_index(bench, static_cast<BodyRole>(role));
    for (std::size_t k = 0; k < bench::n_tools(body); ++k) {
      Pose X = X_tracker_body[role];
      if (body.tool.empty()) X.translation() = X_tracker_body[role] * body.markers_body_mm[k];
      bench::Sample sample;
      sample.kind = bench::SampleKind::tool_pose;
      sample.state = static_cast<std::uint8_t>(bench::ToolVisibility::seen);
      sample.source = static_cast<std::uint16_t>(first + k);
      sample.tool_pose = bench::place_of(X);
      state.take(sample);
    }
  }
}

/// Moves the stage until the midpoint of the eyes is in front of the origin of the leg's model.
void send_stage(bench::BenchState& state, const BenchFile& bench, const VirtualTruth& truth)
{
  const Calibration& c = truth.calibration;
  const BodyRole role = bench.leg == LegKind::rigid ? BodyRole::leg : BodyRole::femur;
  const Pose X_tracker_model =
      truth.X_tracker_leg * bench::pose_of(c.X_body_model[static_cast<std::size_t>(role)]);
  const Eigen::Vector3d p_table_mm =
      bench::pose_of(c.X_tracker_table).inverse() * X_tracker_model.translation();
  const double stage_mm =
      (p_table_mm - bench::pose_of(c.X_table_eyes).translation()).dot(c.stage_direction_table);
  bench::Sample sample;
  sample.kind = bench::SampleKind::stage;
  sample.state = bench::stage_zeroed;
  sample.count = static_cast<std::int32_t>(std::lround(stage_mm / bench.stage_mm_per_count));
  state.take(sample);
}

bool is_skin(const Component& component)
{
  return component.material == "skin";
}

/// The body as the bench draws it: without components of material "skin", which are the real leg's surface.
Body without_skin(Body body)
{
  Part& part = body.visual;
  std::vector<Eigen::Index> kept;
  std::vector<std::int32_t> component;
  for (std::size_t k = 0; k < part.component.size(); ++k) {
    if (is_skin(body.components[static_cast<std::size_t>(part.component[k])])) continue;
    kept.push_back(static_cast<Eigen::Index>(k));
    component.push_back(part.component[k]);
  }
  part = {select_triangles(part.mesh, kept), component};
  return body;
}

/// Hides everything but the leg's surface, if the model has one.
void show_skin(view::Scene& scene, const store::MotionModel& model)
{
  const auto is_of_skin = [&](const view::Drawable& drawable) {
    const Body& body = drawable.parent == view::ParentFrame::reference ? model.reference : model.moving;
    return std::any_of(body.components.begin(), body.components.end(),
                       [&](const Component& c) { return is_skin(c) && c.name == drawable.name; });
  };
  if (std::none_of(scene.drawables.begin(), scene.drawables.end(), is_of_skin)) return;
  for (view::Drawable& drawable : scene.drawables) drawable.is_shown = is_of_skin(drawable);
}

/// Paints all parts in one grey, as a leg.
void paint_grey(view::Scene& scene)
{
  const Eigen::Vector3f shade(0.10F, 0.115F, 0.14F);
  for (view::Drawable& drawable : scene.drawables) {
    drawable.material.colour = shade;
    drawable.material.opacity = 1.0F;
    drawable.material.specular = 0.02F;
    drawable.material.mottling = 0.0F;
    drawable.colours.clear();
  }
}

/// Bounding box of the leg in the undistorted image, with a margin.
view::ShownBox box_of_leg(ModelOnBench& joint, const view::Eye& eye)
{
  constexpr double border_px = 40.0;
  const bench::BenchFrame& frame = joint.state.frame(0);
  joint.view.place(frame, joint.state.values().calibration);
  const Pose X_eyes_tracker = frame.X_tracker_eyes.inverse();
  view::ShownBox box{Eigen::Vector2d::Constant(1e9), Eigen::Vector2d::Constant(-1e9)};
  for (const view::Drawable& drawable : joint.view.scene().drawables) {
    for (int corner = 0; corner < 8; ++corner) {
      const Eigen::Vector3d p_mesh_mm =
          drawable.box_mm.corner(static_cast<Eigen::AlignedBox3d::CornerType>(corner));
      const Eigen::Vector2d p = view::shown_px(eye, X_eyes_tracker * drawable.X_world_mesh * p_mesh_mm);
      box = {box.low_px.cwiseMin(p), box.high_px.cwiseMax(p)};
    }
  }
  return {(box.low_px.array() - border_px).floor(), (box.high_px.array() + border_px).ceil()};
}

view::Image real_leg(ModelOnBench& joint, const store::MotionModel& model, const view::Eye& eye,
                     const view::ShownBox& box, double scale)
{
  const bench::BenchFrame& frame = joint.state.frame(0);
  joint.view.place(frame, joint.state.values().calibration);
  view::Scene scene = joint.view.scene();
  paint_grey(scene);
  show_skin(scene, model);
  const Eigen::Vector2i size = (scale * (box.high_px - box.low_px)).array().round().cast<int>();
  const std::unique_ptr<view::Renderer> renderer =
      view::make_offscreen_renderer({size.x(), size.y(), smoothing_samples, 0.0});
  renderer->load(scene);
  return renderer->draw(scene,
                        view::with_depth_range(view::camera_of(eye, frame.X_tracker_eyes, box), scene));
}

view::Image drawn_by_bench(ModelOnBench& joint, const BenchFile& bench)
{
  const show::Sink memory = bench::bench_memory(bench, smoothing_samples);
  joint.view.load_into(memory.renderer());
  joint.view.place(joint.state.frame(0), joint.state.values().calibration);
  return memory.renderer().draw(joint.view.scene(), joint.view.shots(), nullptr);
}

std::uint8_t code_of(double light)
{
  return static_cast<std::uint8_t>(std::lround(255.0 * view::srgb_of(std::clamp(light, 0.0, 1.0))));
}

/// Bilinear interpolation of the linear light of a channel; 0 outside the image.
double light_at(const view::Image& image, const Eigen::Vector2d& p_px, int channel)
{
  const double x = p_px.x() - 0.5, y = p_px.y() - 0.5;
  const int left = static_cast<int>(std::floor(x)), top = static_cast<int>(std::floor(y));
  double sum = 0.0;
  for (const int dy : {0, 1}) {
    for (const int dx : {0, 1}) {
      const int column = left + dx, row = top + dy;
      if (column < 0 || row < 0 || column >= image.width || row >= image.height) continue;
      const double weight = (1.0 - std::abs(x - column)) * (1.0 - std::abs(y - row));
      const auto at = 4 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(image.width) +
                           static_cast<std::size_t>(column));
      sum += weight * view::linear_of(image.rgba[at + static_cast<std::size_t>(channel)] / 255.0);
    }
  }
  return sum;
}

bool is_within(const view::Viewport& part, const Eigen::Vector2d& p_px)
{
  return p_px.x() >= part.x && p_px.x() <= part.x + part.width && p_px.y() >= part.y &&
         p_px.y() <= part.y + part.height;
}

/// Adds the frame buffer as displayed by the eye's optics to `seen`, a picture of `box`.
void add_display(view::Image& seen, const view::ShownBox& box, const view::Image& frame_buffer,
                 const view::Eye& eye)
{
  const Eigen::Vector2d step_px =
      (box.high_px - box.low_px).cwiseQuotient(Eigen::Vector2d(seen.width, seen.height));
  for (int row = 0; row < seen.height; ++row) {
    for (int column = 0; column < seen.width; ++column) {
      const Eigen::Vector2d shown =
          box.low_px + step_px.cwiseProduct(Eigen::Vector2d(column + 0.5, row + 0.5));
      const Eigen::Vector2d drawn = view::drawn_px(eye.distortion, shown);
      if (!is_within(eye.visible, drawn)) continue;
      const auto at = 4 * (static_cast<std::size_t>(row) * static_cast<std::size_t>(seen.width) +
                           static_cast<std::size_t>(column));
      for (int channel = 0; channel < 3; ++channel) {
        std::uint8_t& code = seen.rgba[at + static_cast<std::size_t>(channel)];
        code = code_of(view::linear_of(code / 255.0) + light_at(frame_buffer, drawn, channel));
      }
    }
  }
}

}  // namespace

view::Image overlay_picture(const BenchFile& bench, const VirtualTruth& truth, const Calibration& calibration,
                            const store::MotionModel& model, const OverlayPictureOptions& options)
{
  const auto on_bench = [&](const store::MotionModel& shown, const Calibration& known) {
    auto joint = std::make_unique<ModelOnBench>(bench, known, store::scaled_model(shown, known.subject_scale),
                                                options.set);
    send_truth(joint->state, bench, truth);
    if (bench.head == HeadKind::stage) send_stage(joint->state, bench, truth);
    return joint;
  };
  const view::Eye& eye = truth.calibration.eyes.left;
  const std::unique_ptr<ModelOnBench> real = on_bench(model, truth.calibration);
  const view::ShownBox box = box_of_leg(*real, eye);
  const double scale = options.height / (box.high_px.y() - box.low_px.y());
  view::Image seen = real_leg(*real, model, eye, box, scale);
  store::MotionModel bones = model;
  for (Body* body : {&bones.reference, &bones.moving}) *body = without_skin(std::move(*body));
  add_display(seen, box, drawn_by_bench(*on_bench(bones, calibration), bench), eye);
  return seen;
}

namespace {

using Point = Eigen::Vector2d;
using Stroke = std::vector<Point>;
using enum DiagramInk;

class Sketch {
 public:
  void line(DiagramInk ink, Stroke points) { drawn.lines.push_back({std::move(points), ink}); }
  void box(DiagramInk ink, const Point& low, const Point& high)
  {
    line(ink, {low, {high.x(), low.y()}, high, {low.x(), high.y()}, low});
  }
  void circle(DiagramInk ink, const Point& middle, double radius)
  {
    constexpr int n = 24;
    Stroke points;
    for (int k = 0; k <= n; ++k)
      points.emplace_back(middle + radius * Point(std::cos(2.0 * pi * k / n), std::sin(2.0 * pi * k / n)));
    line(ink, std::move(points));
  }
  void arrow(DiagramInk ink, const Point& from, const Point& to)
  {
    const Point along = 0.03 * (to - from).normalized(), across(-along.y(), along.x());
    line(ink, {from, to});
    line(ink, {to - along + 0.6 * across, to, to - along - 0.6 * across});
  }
  void label(const Point& at, std::string text) { drawn.labels.push_back({at, std::move(text)}); }
  /// Seen from above: looks towards smaller y.
  void eye(const Point& at, DiagramInk ink = plain)
  {
    circle(ink, at, 0.025);
    circle(ink, at - Point(0.0, 0.018), 0.008);
  }

  Diagram drawn;
};

void draw_scan(Sketch& sketch, const Task& task)
{
  const Point low(0.1, 0.03), high(0.9, 0.57), seen_low(0.22, 0.09), seen_high(0.78, 0.51);
  sketch.box(plain, low, high);
  sketch.box(real, seen_low, seen_high);
  const auto edge = static_cast<calibration::Edge>(task.index);
  const bool is_first = edge == calibration::Edge::left || edge == calibration::Edge::top;
  constexpr double off = 0.09;
  if (task.is_column) {
    const double border = is_first ? seen_low.x() : seen_high.x(), at = border + (is_first ? off : -off);
    sketch.line(lit, {{at, low.y()}, {at, high.y()}});
    sketch.arrow(lit, {at, 0.3}, {border, 0.3});
  } else {
    const double border = is_first ? seen_low.y() : seen_high.y(), at = border + (is_first ? off : -off);
    sketch.line(lit, {{low.x(), at}, {high.x(), at}});
    sketch.arrow(lit, {0.5, at}, {0.5, border});
  }
}

/// Lines of the operator's grid, of which the task's node is lit.
void draw_nodes(Sketch& sketch, const Task& task, const CalibrationSettings& settings)
{
  const bool is_grid = task.kind == TaskKind::grid;
  const double spacing = std::min(0.8 / (settings.grid_columns - 1), 0.5 / (settings.grid_rows - 1));
  const Point half = 0.5 * spacing * Point(settings.grid_columns - 1, settings.grid_rows - 1);
  const Point middle(0.5, 0.3);
  const auto add_lines = [&](DiagramInk ink, double bend) {
    const auto at = [&](double x, double y) {
      const double r_sq = Point(x, y).squaredNorm() / half.squaredNorm();
      return Point(middle + (1.0 - bend * r_sq) * Point(x, y));
    };
    constexpr int n = 12;
    const auto add = [&](const Point& from, const Point& to) {
      Stroke points;
      for (int k = 0; k <= n; ++k) {
        const Point p = from + (to - from) * k / n;
        points.push_back(at(p.x(), p.y()));
      }
      sketch.line(ink, std::move(points));
    };
    for (int k = 0; k < settings.grid_columns; ++k)
      add({-half.x() + k * spacing, -half.y()}, {-half.x() + k * spacing, half.y()});
    for (int k = 0; k < settings.grid_rows; ++k)
      add({-half.x(), -half.y() + k * spacing}, {half.x(), -half.y() + k * spacing});
  };
  add_lines(real, 0.0);
  if (is_grid) return add_lines(lit, 0.08);
  const Point node = middle + spacing * Point(task.node.x(), -task.node.y());
  sketch.line(lit, {node - Point(0.03, 0.0), node + Point(0.03, 0.0)});
  sketch.line(lit, {node - Point(0.0, 0.03), node + Point(0.0, 0.03)});
  sketch.circle(lit, node, 0.02);
}

/// From above: eye, screen, rectangles behind each other.
void draw_rectangles(Sketch& sketch, const Task& task, const CalibrationSettings& settings)
{
  double deepest = 1.0, widest = 1.0;
  for (const auto& r : settings.rectangles) {
    deepest = std::max(deepest, r.depth_mm);
    widest = std::max(widest, r.width_mm);
  }
  const Point eye(task.is_right ? 0.55 : 0.45, 0.56);
  sketch.eye({0.45, 0.56}, task.is_right ? plain : lit);
  sketch.eye({0.55, 0.56}, task.is_right ? lit : plain);
  for (std::size_t k = 0; k < settings.rectangles.size(); ++k) {
    const auto& r = settings.rectangles[k];
    const double y = 0.34 - 0.28 * r.depth_mm / deepest, half = 0.3 * r.width_mm / widest;
    const bool is_it = static_cast<int>(k) == task.index;
    sketch.line(is_it ? real : plain, {{0.5 - half, y}, {0.5 + half, y}});
    if (!is_it) continue;
    sketch.line(lit, {eye, {0.5 - half, y}});
    sketch.line(lit, {eye, {0.5 + half, y}});
  }
}

void draw_pupils(Sketch& sketch, const Task& task)
{
  const Point left(0.35, 0.35), right(0.65, 0.35);
  for (const Point& eye : {left, right}) {
    sketch.circle(plain, eye, 0.08);
    sketch.circle(plain, eye, 0.025);
  }
  const auto measure = [&](double from, double to) {
    sketch.arrow(lit, {0.5 * (from + to), 0.18}, {to, 0.18});
    sketch.arrow(lit, {0.5 * (from + to), 0.18}, {from, 0.18});
  };
  if (task.index == 0) measure(left.x(), right.x());
  if (task.index == 1) measure(left.x(), 0.5);
  if (task.index == 2) measure(0.5, right.x());
  if (task.index == 3) {
    sketch.box(real, {0.35, 0.02}, {0.65, 0.12});
    sketch.arrow(lit, {0.5, 0.5}, {0.5, 0.14});
  }
}

void draw_depth_check(Sketch& sketch)
{
  sketch.eye({0.45, 0.56});
  sketch.eye({0.55, 0.56});
  sketch.box(real, {0.3, 0.06}, {0.68, 0.3});
  sketch.box(lit, {0.32, 0.08}, {0.7, 0.32});
  sketch.label({0.02, 0.12}, "both at one depth?");
}

/// From above: rails of the stage (x) and of the slide (z).
void draw_rails(Sketch& sketch, const Task& task)
{
  const bool is_x = task.name != "z rail";
  sketch.box(plain, {0.08, 0.04}, {0.92, 0.56});
  sketch.line(is_x ? real : plain, {{0.15, 0.46}, {0.85, 0.46}});
  sketch.line(is_x ? plain : real, {{0.5, 0.1}, {0.5, 0.4}});
  if (task.kind == TaskKind::stop) {
    sketch.box(real, {0.1, 0.42}, {0.14, 0.5});
    sketch.box(plain, {0.3, 0.43}, {0.4, 0.49});
    sketch.arrow(lit, {0.3, 0.46}, {0.15, 0.46});
    return;
  }
  const Point from = is_x ? Point(0.2, 0.46) : Point(0.5, 0.12),
              to = is_x ? Point(0.8, 0.46) : Point(0.5, 0.38);
  sketch.circle(real, from, 0.025);
  sketch.arrow(lit, from, to);
}

void draw_pivot(Sketch& sketch)
{
  const Point tip(0.5, 0.55);
  sketch.line(plain, {{0.1, 0.56}, {0.9, 0.56}});
  for (const double turn : {-0.35, 0.0, 0.35}) {
    const Point end = tip + 0.45 * Point(std::sin(turn), -std::cos(turn));
    sketch.line(turn == 0.0 ? real : plain, {tip, end});
  }
  sketch.arrow(lit, {0.52, 0.1}, {0.66, 0.14});
  sketch.arrow(lit, {0.48, 0.1}, {0.34, 0.14});
}

/// From the side: thigh and shank, bent and extended.
void draw_bend(Sketch& sketch)
{
  const Point hip(0.15, 0.12), knee(0.5, 0.12);
  sketch.line(real, {hip, knee});
  sketch.circle(plain, knee, 0.025);
  for (const double angle : {0.2, 0.9, 1.6})
    sketch.line(angle == 0.9 ? real : plain, {knee, knee + 0.38 * Point(std::cos(angle), std::sin(angle))});
  sketch.arrow(lit, {0.8, 0.2}, {0.62, 0.44});
  sketch.arrow(lit, {0.8, 0.2}, {0.86, 0.12});
}

/// The marker's requested position in front of the eyes, from above and, for the height, from the side.
void draw_bullseye(Sketch& sketch, const Task& task)
{
  const Eigen::Vector3d at = calibration::requested_marker_position(task.index).cast<double>();
  sketch.label({0.12, 0.0}, "from above");
  sketch.label({0.62, 0.0}, "from the side");
  sketch.eye({0.22, 0.56}, task.is_right ? plain : lit);
  sketch.eye({0.28, 0.56}, task.is_right ? lit : plain);
  sketch.box(plain, {0.07, 0.1}, {0.43, 0.42});
  const Point above(0.25 + 0.15 * at.x(), 0.26 - 0.13 * at.z());
  sketch.circle(real, above, 0.015);
  sketch.circle(lit, above, 0.03);
  sketch.circle(plain, {0.55, 0.3}, 0.025);
  sketch.box(plain, {0.62, 0.12}, {0.95, 0.48});
  const Point beside(0.785 + 0.13 * at.z(), 0.3 - 0.14 * at.y());
  sketch.circle(real, beside, 0.015);
  sketch.circle(lit, beside, 0.03);
}

/// From the front and from the side: outline of the body, and all points, with the one to be touched lit.
void draw_points(Sketch& sketch, const std::vector<CalibrationPoint>& points, int next,
                 const BodyOutline* outline)
{
  sketch.drawn.height = 1.0;
  // Both views have the same scale.
  Eigen::Vector3d low = Eigen::Vector3d::Constant(1e9), high = -low;
  for (const CalibrationPoint& point : points) {
    low = low.cwiseMin(point.p_model_mm);
    high = high.cwiseMax(point.p_model_mm);
  }
  constexpr double margin_mm = 15.0, view_width = 0.46, view_height = 0.88;
  low.array() -= margin_mm;
  high.array() += margin_mm;
  const double mm = std::min({view_width / (high.z() - low.z()), view_width / (high.x() - low.x()),
                              view_height / (high.y() - low.y())});
  for (std::size_t view = 0; view < 2; ++view) {
    const double left = view == 0 ? 0.02 : 0.52;
    sketch.label({left, 0.0}, view == 0 ? "from the front" : "from the right");
    const auto flat = [&](const Eigen::Vector3d& p) {
      return view == 0 ? Point(-p.z(), p.y()) : Point(p.x(), p.y());
    };
    const Point middle = 0.5 * (flat(low) + flat(high));
    const auto placed = [&](const Point& p) {
      return Point(left + 0.5 * view_width + mm * (p.x() - middle.x()), 0.54 - mm * (p.y() - middle.y()));
    };
    if (outline != nullptr) {
      for (const auto& [from, to] : outline->pieces[view]) {
        const Point a = placed(from), b = placed(to);
        const auto fits = [&](const Point& p) {
          return p.x() >= left && p.x() <= left + view_width && p.y() >= 0.06 && p.y() <= 1.0;
        };
        if (fits(a) && fits(b)) sketch.line(plain, {a, b});
      }
    }
    for (std::size_t k = 0; k < points.size(); ++k) {
      const Point at = placed(flat(points[k].p_model_mm));
      const bool is_next = static_cast<int>(k) == next;
      sketch.circle(is_next ? lit : real, at, is_next ? 0.008 : 0.006);
      if (!is_next) continue;
      sketch.circle(lit, at, 0.025);
      if (view == 0) sketch.label(at + Point(0.03, -0.025), points[k].name);
    }
  }
}

}  // namespace

BodyOutline outline_of(const Body& body)
{
  BodyOutline outline;
  Mesh mesh = body.contact.mesh;
  append(mesh, body.visual.mesh);
  const std::array<Eigen::Vector3d, 2> towards_viewer{Eigen::Vector3d::UnitX(), Eigen::Vector3d::UnitZ()};
  // Per edge: its faces that look to the viewer of each view, and its faces.
  struct Faces {
    std::array<int, 2> n_front{};
    int n = 0;
  };
  std::map<std::pair<std::int32_t, std::int32_t>, Faces> edges;
  for (Eigen::Index t = 0; t < mesh.triangles.rows(); ++t) {
    const Eigen::Vector3d normal = face_normal(mesh, t);
    for (Eigen::Index k = 0; k < 3; ++k) {
      const std::int32_t a = mesh.triangles(t, k), b = mesh.triangles(t, (k + 1) % 3);
      Faces& faces = edges[{std::min(a, b), std::max(a, b)}];
      ++faces.n;
      for (std::size_t view = 0; view < 2; ++view)
        if (normal.dot(towards_viewer[view]) > 0.0) ++faces.n_front[view];
    }
  }
  for (const auto& edge : edges) {
    const auto& ends = edge.first;
    const Faces& faces = edge.second;
    const Eigen::Vector3d p = mesh.vertices_mm.row(ends.first), q = mesh.vertices_mm.row(ends.second);
    const auto add = [&](std::size_t view, const Point& a, const Point& b) {
      if (faces.n_front[view] == 1) outline.pieces[view].push_back({a, b});
    };
    add(0, {-p.z(), p.y()}, {-q.z(), q.y()});
    add(1, {p.x(), p.y()}, {q.x(), q.y()});
  }
  return outline;
}

Diagram diagram_of(CalibrationPart part, const Task& task, const BenchFile& bench, const BodyOutline* outline)
{
  Sketch sketch;
  switch (task.kind) {
    case TaskKind::scan_line:
      draw_scan(sketch, task);
      break;
    case TaskKind::point:
    case TaskKind::grid:
      draw_nodes(sketch, task, bench.calibration);
      break;
    case TaskKind::rectangle_sides:
      draw_rectangles(sketch, task, bench.calibration);
      break;
    case TaskKind::number:
      if (part == CalibrationPart::ipd) {
        draw_pupils(sketch, task);
      } else if (part == CalibrationPart::viewport) {
        sketch.box(real, {0.2, 0.1}, {0.8, 0.5});
        const bool is_height = task.index == 1;
        sketch.arrow(lit, {0.5, 0.3}, is_height ? Point(0.5, 0.1) : Point(0.2, 0.3));
        sketch.arrow(lit, {0.5, 0.3}, is_height ? Point(0.5, 0.5) : Point(0.8, 0.3));
      } else {
        sketch.circle(real, {0.25, 0.3}, 0.012);
        sketch.circle(real, {0.75, 0.3}, 0.012);
        sketch.arrow(lit, {0.5, 0.3}, {0.26, 0.3});
        sketch.arrow(lit, {0.5, 0.3}, {0.74, 0.3});
        sketch.label({0.25, 0.36}, task.name);
      }
      break;
    case TaskKind::depth_check:
      draw_depth_check(sketch);
      break;
    case TaskKind::sweep:
      if (part == CalibrationPart::probe) {
        draw_pivot(sketch);
        break;
      }
      [[fallthrough]];
    case TaskKind::stop:
      draw_rails(sketch, task);
      break;
    case TaskKind::bend:
      draw_bend(sketch);
      break;
    case TaskKind::bullseye:
      draw_bullseye(sketch, task);
      break;
    case TaskKind::hold:
      draw_points(sketch, calibration::points_of(part, bench.calibration), task.index, outline);
      break;
    case TaskKind::model_pose:
      draw_points(sketch, calibration::points_of(part, bench.calibration), -1, outline);
      break;
  }
  return std::move(sketch.drawn);
}

}  // namespace vrda::calibration
