#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <vector>

#include "app/arguments.hpp"
#include "app/follow.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "follow/job_views.hpp"
#include "scene/layer_set.hpp"

namespace vrda {
namespace {

constexpr std::size_t most_views = 16;  // smaller tiles show nothing

std::vector<std::string> parts_of(const std::string& text, char separator)
{
  std::vector<std::string> parts(1);
  for (const char c : text) {
    if (c == separator) {
      parts.emplace_back();
    } else {
      parts.back() += c;
    }
  }
  return parts;
}

std::vector<Eigen::Vector3d> triples_of(const std::string& option, const std::string& text)
{
  std::vector<Eigen::Vector3d> triples;
  if (text.empty()) return triples;
  for (const std::string& part : parts_of(text, ';')) {
    const std::vector<std::string> numbers = parts_of(part, ',');
    Eigen::Vector3d triple = Eigen::Vector3d::Zero();
    bool is_sound = numbers.size() == 3;
    for (std::size_t i = 0; is_sound && i < 3; ++i) {
      double& value = triple[static_cast<Eigen::Index>(i)];
      const char* const end = numbers[i].data() + numbers[i].size();
      const auto read = std::from_chars(numbers[i].data(), end, value);
      is_sound = read.ec == std::errc() && read.ptr == end && std::isfinite(value);
    }
    if (!is_sound) throw InputError({option, "", "\"" + part + "\"", "X,Y,Z;X,Y,Z;... a triple a view"});
    triples.push_back(triple);
  }
  return triples;
}

/// As ORIENTATION_MODEL and SHIFT_MODEL; what one of them leaves out is zero.
std::vector<RunView> turned_views(const FollowOptions& options, Side side)
{
  std::vector<Eigen::Vector3d> turns_deg = triples_of("--orient", options.orient);
  std::vector<Eigen::Vector3d> shifts_mm = triples_of("--shift", options.shift);
  const std::size_t n = std::max(turns_deg.size(), shifts_mm.size());
  turns_deg.resize(n, Eigen::Vector3d::Zero());
  shifts_mm.resize(n, Eigen::Vector3d::Zero());
  std::vector<RunView> views;
  for (std::size_t k = 0; k < n; ++k) {
    const Eigen::Vector3d turn_rad = turns_deg[k] * rad_from_deg(1.0);
    views.push_back(turned_view("view " + std::to_string(k + 1), turn_rad, shifts_mm[k], side));
  }
  return views;
}

std::vector<RunView> views_of(const FollowOptions& options, const JobViews& job, Side side)
{
  const bool is_turned = !options.orient.empty() || !options.shift.empty();
  if (is_turned && !options.views.empty()) {
    throw InputError(
        {"--views", "", options.views + " with --orient or --shift", "one way to name the views"});
  }
  if (is_turned) return turned_views(options, side);
  std::vector<RunView> views;
  if (options.views.empty()) {
    for (const JobView& view : job.views) {
      views.push_back(turned_view("view " + std::to_string(view.number),
                                  view.orientation_deg * rad_from_deg(1.0), view.shift_mm, side));
    }
    if (!views.empty()) return views;
  }
  for (const std::string& name : parsed_views(options.views.empty() ? "front,lateral" : options.views))
    views.push_back(named_view(name, *view_named(name), side));
  return views;
}

DrawMode mode_of(const std::string& name)
{
  static const std::array<std::pair<const char*, DrawMode>, 6> modes{{{"wire", DrawMode::wire},
                                                                      {"hidden-line", DrawMode::hidden_line},
                                                                      {"flat", DrawMode::flat},
                                                                      {"fill", DrawMode::smooth},
                                                                      {"smooth", DrawMode::smooth},
                                                                      {"textured", DrawMode::textured}}};
  std::string known;
  for (const auto& [word, mode] : modes) {
    if (name == word) return mode;
    known += (known.empty() ? "" : ", ") + std::string(word);
  }
  throw InputError({"--mode", "", "\"" + name + "\"", known});
}

RunSceneOptions scene_options(const FollowOptions& options, const JobViews& job)
{
  RunSceneOptions scene;
  const std::string mode = options.mode.empty() ? job.render : options.mode;
  if (!mode.empty()) scene.mode = mode_of(mode);
  scene.backdrop = options.backdrop;
  scene.has_contacts = scene.has_normals = scene.has_axes = false;
  if (options.layers.empty() || options.layers == "none") return scene;
  for (const std::string& name : parts_of(options.layers, ',')) {
    bool* const wanted = name == "contacts"  ? &scene.has_contacts
                         : name == "normals" ? &scene.has_normals
                         : name == "axes"    ? &scene.has_axes
                                             : nullptr;
    if (wanted == nullptr)
      throw InputError({"--layers", "", "\"" + name + "\"", "some of contacts, normals, axes; or none"});
    *wanted = true;
  }
  return scene;
}

}  // namespace

RunScreenOptions screen_options(const FollowOptions& options, const MotionModel& model)
{
  const JobViews job = job_views(model.job.resolved);
  RunScreenOptions screen;
  const PictureSize size = parsed_size(options.size);
  screen.width = size.width;
  screen.height = size.height;
  screen.scene = scene_options(options, job);
  screen.views = views_of(options, job, model.side == "left" ? Side::left : Side::right);
  screen.zoom = job.zoom;
  if (screen.views.size() > most_views) {
    throw InputError(
        {"views", "", std::to_string(screen.views.size()), "at most " + std::to_string(most_views)});
  }
  return screen;
}

}  // namespace vrda
