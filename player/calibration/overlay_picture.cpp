// An image of the drawn model over the real leg as one eye sees them, for calibrations of a virtual bench.
#include "calibration/calibration_pictures.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "bench/window_check.hpp"
#include "calibration/calibration_bench.hpp"
#include "store/motion_model.hpp"

namespace vrda::calibration {
namespace {

constexpr int smoothing_samples = 4;

/// Sends the true body poses as noise-free tracker samples.
void send_truth(bench::BenchState& state, const BenchFile& bench, const VirtualTruth& truth)
{
  const std::array<Pose, bench::n_body_roles> X_tracker_body{
      truth.X_tracker_leg, truth.X_tracker_leg, truth.X_tracker_shank, truth.X_tracker_headbody};
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

view::Image overlay_picture(const BenchFile& bench, const VirtualTruth& truth,
                              const Calibration& calibration, const store::MotionModel& model,
                              const OverlayPictureOptions& options)
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

}  // namespace vrda::calibration
