// Appearance and options of the screen that follows a running job.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <vector>

#include "core/error.hpp"
#include "model/side.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "show/follow.hpp"
#include "show/run_views.hpp"
#include "view/arguments.hpp"
#include "view/joint_layers.hpp"

namespace vrda::show {
namespace {

constexpr std::size_t most_views = 16;                        // smaller tiles are unreadable
constexpr double most_turn_deg = 360.0, most_shift_mm = 1e4;  // larger values are typing errors

/// Parses triples of numbers from -most to most.
std::vector<Eigen::Vector3d> triples_of(const std::string& option, const std::string& text, double most)
{
  std::vector<Eigen::Vector3d> triples;
  if (text.empty()) return triples;
  for (const std::string& part : view::split(text, ';')) {
    const std::vector<std::string> numbers = view::split(part, ',');
    Eigen::Vector3d triple = Eigen::Vector3d::Zero();
    bool is_valid = numbers.size() == 3;
    for (std::size_t i = 0; is_valid && i < 3; ++i) {
      double& value = triple[static_cast<Eigen::Index>(i)];
      const char* const end = numbers[i].data() + numbers[i].size();
      const auto read = std::from_chars(numbers[i].data(), end, value);
      is_valid = read.ec == std::errc() && read.ptr == end && std::abs(value) <= most;
    }
    if (!is_valid) {
      throw InputError({option, "", "\"" + part + "\"",
                        "X,Y,Z;X,Y,Z;... one triple per view, numbers from -" + shortest_decimal(most) +
                            " to " + shortest_decimal(most)});
    }
    triples.push_back(triple);
  }
  return triples;
}

/// The views of --orient and --shift; missing triples of the shorter list are zero.
std::vector<CameraView> turned_views(const FollowOptions& options, Side side)
{
  std::vector<Eigen::Vector3d> turns_deg = triples_of("--orient", options.orient, most_turn_deg);
  std::vector<Eigen::Vector3d> shifts_mm = triples_of("--shift", options.shift, most_shift_mm);
  const std::size_t n = std::max(turns_deg.size(), shifts_mm.size());
  turns_deg.resize(n, Eigen::Vector3d::Zero());
  shifts_mm.resize(n, Eigen::Vector3d::Zero());
  std::vector<CameraView> views;
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Vector3d turn_rad = turns_deg[k] * rad_from_deg(1.0);
    const auto degrees = [&](Eigen::Index i) { return shortest_decimal(turns_deg[k][i]); };
    views.push_back(view::turned_view("rotated " + degrees(0) + ", " + degrees(1) + ", " + degrees(2), turn_rad,
                                shifts_mm[k], side));
  }
  return views;
}

std::vector<CameraView> views_of(const FollowOptions& options, const view::JobViews& job, Side side)
{
  const bool is_turned = !options.orient.empty() || !options.shift.empty();
  if (is_turned && !options.views.empty()) {
    throw InputError(
        {"--views", "", options.views + " with --orient or --shift", "either --views or --orient/--shift"});
  }
  if (is_turned) return turned_views(options, side);
  std::vector<CameraView> views;
  if (options.views.empty()) {
    views = view::camera_views(job, side);
    if (!views.empty()) return views;
  }
  for (const std::string& name :
       view::parsed_views(options.views.empty() ? "front,lateral" : options.views))
    views.push_back(view::named_view(name, *view::view_named(name), side));
  return views;
}

/// True if opaque bodies hide the contact layers; wire frames do not.
bool hides_contacts(const view::AppearanceOptions& look, const view::LayerSet& layers)
{
  return look.mode != view::DrawMode::wire &&
         (layers.has(view::Layer::contacts) || layers.has(view::Layer::normals));
}

RunSceneOptions scene_options(const FollowOptions& options, const view::JobViews& job)
{
  view::AppearanceOptions look = options.appearance;
  if (!options.has_mode && job.render == "wire") look.mode = view::DrawMode::wire;
  RunSceneOptions scene;
  scene.layers = view::parsed_layers(look.layers);
  scene.backdrop = options.backdrop;
  if (look.see_through.empty() && !options.is_opaque && hides_contacts(look, scene.layers))
    look.see_through = "reference";
  scene.apply_appearance = [look](view::Scene& bare) { view::apply_appearance(bare, look); };
  return scene;
}

/// The size of the options, else the job's.
view::PictureSize size_of(const FollowOptions& options, const view::JobViews& job)
{
  if (options.size.empty() && view::has_usable_size(job)) return {job.width_px, job.height_px};
  return view::parsed_size(options.size.empty() ? "1280x960" : options.size);
}

}  // namespace

view::AppearanceOptions follow_appearance()
{
  view::AppearanceOptions look;
  look.layers = "contacts,normals";
  return look;
}

RunScreenOptions screen_options(const FollowOptions& options, const store::MotionModel& model)
{
  const view::JobViews job = view::job_views(model.job.resolved);
  RunScreenOptions screen;
  const view::PictureSize size = size_of(options, job);
  screen.width = size.width;
  screen.height = size.height;
  screen.scene = scene_options(options, job);
  screen.views = views_of(options, job, side_named(model.side));
  screen.zoom = job.zoom;
  if (screen.views.size() > most_views) {
    throw InputError(
        {"views", "", std::to_string(screen.views.size()), "at most " + std::to_string(most_views)});
  }
  return screen;
}

}  // namespace vrda::show
