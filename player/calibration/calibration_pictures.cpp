
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "calibration/calibration_mode.hpp"
#include "calibration/marks.hpp"
#include "calibration/statistics.hpp"
#include "show/session.hpp"

namespace vrda::calibration {
namespace {

/// Placement of a part of a frame buffer on a sheet.
struct SheetFrame {
  view::ShownBox source;
  Eigen::Vector2d at_px = Eigen::Vector2d::Zero();  ///< upper left corner on the sheet
  double scale = 1.0;                               ///< sheet px per frame buffer px

  Eigen::Vector2d placed(const Eigen::Vector2d& p_px) const { return at_px + scale * (p_px - source.low_px); }
  view::OverlayBox placed(const view::ShownBox& box) const
  {
    const Eigen::Vector2f low = placed(box.low_px).cast<float>(), high = placed(box.high_px).cast<float>();
    return {low.x(), low.y(), high.x(), high.y()};
  }
};

/// An off-screen picture with frames, lines and text.
class Sheet {
 public:
  Sheet(int width, int height)
      : renderer_(view::make_offscreen_renderer({width, height, 1, 0.0})), text_(view::panel_text_px)
  {
    nothing_.background = view::background_of(view::Backdrop::black);
    renderer_->load(nothing_);
    renderer_->load(text_.font());
    view::clear_overlay(overlay_, width, height);
  }

  /// Line widths are not scaled; lines are clipped at the frame.
  void add_lines(const SheetFrame& frame, std::span<const DrawnLine> lines)
  {
    clip_at(frame);
    for (DrawnLine line : lines) {
      for (Eigen::Vector2d& p : line.points_px) p = frame.placed(p);
      line.is_smooth = true;
      add_drawn_line(overlay_, text_, line);
    }
  }
  void add_area(const SheetFrame& frame, const view::ShownBox& box, const view::VertexColour& colour)
  {
    clip_at(frame);
    text_.add_area(overlay_, frame.placed(box), colour);
  }
  /// `at_px`: on the sheet.
  void add_words(const Eigen::Vector2d& at_px, const std::string& words, const view::VertexColour& colour)
  {
    view::clip_overlay(overlay_, {0.0F, 0.0F, static_cast<float>(renderer_->width()),
                                  static_cast<float>(renderer_->height())});
    const Eigen::Vector2f at = at_px.cast<float>();
    text_.add_text(overlay_, at.x(), at.y(), words, colour);
  }
  float width_px(const std::string& words) const { return text_.width_px(words); }

  /// Valid until the next call.
  const view::Image& image()
  {
    view::finish_overlay(overlay_);
    return renderer_->draw(nothing_, {}, &overlay_);
  }

 private:
  void clip_at(const SheetFrame& frame)
  {
    constexpr float rim_px = 2.0F;  // room for an outline on the border
    const view::OverlayBox box = frame.placed(frame.source);
    view::clip_overlay(
        overlay_, {box.left_px - rim_px, box.top_px - rim_px, box.right_px + rim_px, box.bottom_px + rim_px});
  }

  std::unique_ptr<view::Renderer> renderer_;
  view::OverlayText text_;
  view::Overlay overlay_;
  view::Scene nothing_;
};

using Colour = std::array<float, 3>;
constexpr view::VertexColour window_area{30, 34, 40, 255}, visible_area{24, 56, 40, 255};
constexpr Colour grey{0.45F, 0.48F, 0.52F}, green{0.38F, 0.85F, 0.5F}, amber{1.0F, 0.69F, 0.18F},
    white{0.9F, 0.92F, 0.95F}, blue{0.4F, 0.65F, 1.0F};
constexpr double line_px = 1.5;

/// Outline of a box as a closed line.
DrawnLine outline_of(const view::ShownBox& box, const Colour& colour)
{
  return {false, rectangle_points(box.low_px, box.high_px), line_px, true, colour};
}

constexpr double words_px = 24.0, gap_px = 16.0;  // line height of text; gap between frames

std::vector<DrawnLine> cross_at(const Eigen::Vector2d& p, double arm_px, const Colour& colour, bool is_right)
{
  const Eigen::Vector2d across(arm_px, 0.0), up(0.0, arm_px);
  return {{is_right, {p - across, p + across}, line_px, true, colour},
          {is_right, {p - up, p + up}, line_px, true, colour}};
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
    sheet.add_words(corner + Eigen::Vector2d(8.0, 6.0), eye_text(is_right) + ": visible " + size_text(seen),
                    ink);
    sheet.add_words(corner + Eigen::Vector2d(8.0, 26.0),
                    "centre " + short_decimal(centre.x(), 1) + ", " + short_decimal(centre.y(), 1), ink);
  }
  const view::Viewport& left = request.found.eyes.left.visible;
  const view::Viewport& window = request.found.eyes.left.window;
  const DrawnLine scan{
      false, {{left.x + 0.5, window.y}, {left.x + 0.5, window.y + window.height}}, 2.0, true, amber};
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
  const std::vector<DrawnLine> corrected = seen_lines(bent, request.truth);
  const std::vector<DrawnLine> distorted = seen_lines(plain, request.truth);
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
  if (task.kind->traits().has_two_lines) return {shown(0).x(), shown(2).x()};
  const Eigen::Vector2d p = shown(0);
  return {p.x(), p.y()};
}

/// The left eye's first task of each index.
std::vector<MarkedTask> aligned_tasks(const PictureRequest& request, CalibrationPart part)
{
  std::vector<MarkedTask> found;
  const CalibrationRecord* record = find_record(request.found, part);
  if (record == nullptr) return found;
  for (const Task& task : request.tasks) {
    const auto is_same = [&](const MarkedTask& other) { return other.task.index == task.index; };
    const CalibrationMark* mark = find_mark(*record, task.name);
    if (mark != nullptr && !task.is_right && std::ranges::none_of(found, is_same))
      found.push_back({task, mark});
  }
  return found;
}

struct AlignedSheet {
  const char* name;
  CalibrationPart part;
  std::size_t most;
  std::string title;
};

/// Real objects and drawn lines as seen by the left eye, before (row 0) and after (row 1) the alignment.
std::vector<std::string> write_aligned(const PictureRequest& request, const std::string& folder,
                                       const AlignedSheet& plan)
{
  constexpr double scale = 0.42;
  std::vector<MarkedTask> tasks = aligned_tasks(request, plan.part);
  if (tasks.empty()) return {};
  tasks.resize(std::min(tasks.size(), plan.most));
  const view::ShownBox box = view::shown_box(request.truth.calibration.eyes.left);
  const Eigen::Vector2d size = scale * (box.high_px - box.low_px);
  const auto n = static_cast<double>(tasks.size());
  Sheet sheet(static_cast<int>(n * size.x() + (n + 1.0) * gap_px),
              static_cast<int>(2.0 * (size.y() + words_px + gap_px) + gap_px));
  for (std::size_t k = 0; k < tasks.size(); ++k) {
    const Task& task = tasks[k].task;
    std::vector<double> begun;
    for (const Dial& dial : task.dials) begun.push_back(dial.value);
    const std::array<std::vector<double>, 2> moments{begun, dials_of(task, *tasks[k].mark, request.found)};
    std::vector<DrawnLine> real = task.kind->outlines(task, request.bench, request.truth);
    recolour(real, blue);
    for (std::size_t row = 0; row < moments.size(); ++row) {
      std::vector<DrawnLine> lines =
          seen_lines(task.kind->draw(task, moments[row], request.found), request.truth);
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

// An image of the drawn model over the real leg as one eye sees them, for calibrations of a virtual bench.

constexpr int smoothing_samples = 4;

/// Sends the true poses without noise, the stage where the midpoint of the eyes is in front of the origin of
/// the leg's model.
void send_truth(bench::BenchState& state, const BenchFile& bench, const VirtualTruth& truth)
{
  const Calibration& c = truth.calibration;
  BenchPoses poses = resting_poses(truth);
  poses.X_tracker_headbody = truth.X_tracker_headbody;
  FrameFacts facts;
  facts.noise.tracker_mm = facts.noise.tracker_deg = 0.0;
  RandomSequence draws(truth.seed, bench::RandomPurpose::virtual_tracker, 0);
  for (const bench::Sample& sample : tracker_frame(bench, truth, poses, facts, draws)) {
    if (sample.is(bench::ToolVisibility::seen)) state.take(sample);
  }
  if (bench.head != HeadKind::stage) return;
  const BodyRole role = bench.leg == LegKind::rigid ? BodyRole::leg : BodyRole::femur;
  const Pose X_tracker_model = truth.X_tracker_leg * X_body_model(c, role);
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
  model::Part& part = body.visual;
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
    const Body& body = part_of(model, drawable.parent);
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

/// Simulated view of the left eye through its true optics, with the stage in front of the leg: the real leg
/// in grey (the model in the subject's true size) plus the picture that a bench with `calibration` draws;
/// black is transparent.
view::Image overlay_picture(const BenchFile& bench, const VirtualTruth& truth, const Calibration& calibration,
                            const store::MotionModel& model, const std::string& set)
{
  const auto on_bench = [&](const store::MotionModel& shown, const Calibration& known) {
    auto joint =
        std::make_unique<ModelOnBench>(bench, known, store::scaled_model(shown, known.subject_scale), set);
    send_truth(joint->state, bench, truth);
    return joint;
  };
  const view::Eye& eye = truth.calibration.eyes.left;
  const std::unique_ptr<ModelOnBench> real = on_bench(model, truth.calibration);
  const view::ShownBox box = box_of_leg(*real, eye);
  constexpr double height_px = 560.0;  // filled by the leg
  const double scale = height_px / (box.high_px.y() - box.low_px.y());
  view::Image seen = real_leg(*real, model, eye, box, scale);
  store::MotionModel bones = model;
  for (Body* body : {&bones.reference, &bones.moving}) *body = without_skin(std::move(*body));
  add_display(seen, box, drawn_by_bench(*on_bench(bones, calibration), bench), eye);
  return seen;
}

/// Figure 26.
std::string write_overlay(const PictureRequest& request, const CalibrateOptions& options)
{
  const store::MotionModel model = store::read_motion_model(options.model);
  store::require_grid(model, options.model, "a calibration");
  const std::string set = store::chosen_set(model, options.model, options.set);
  const view::Image before =
      overlay_picture(request.bench, request.truth, uncalibrated(request.bench, request.truth), model, set);
  const view::Image after = overlay_picture(request.bench, request.truth, request.found, model, set);
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
  add({"rectangles.png", CalibrationPart::eyepoints, 4, "rectangle"});
  const CalibrationPart eyes =
      request.bench.head == HeadKind::tracker ? CalibrationPart::head : CalibrationPart::bullseye;
  add({"bullseye.png", eyes, 3, "marker position"});
  if (!options.model.empty()) paths.push_back(write_overlay(request, options));
  return paths;
}

}  // namespace vrda::calibration
