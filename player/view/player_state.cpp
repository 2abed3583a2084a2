#include "view/player_state.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iterator>
#include <limits>
#include <utility>

#include "core/document.hpp"
#include "core/text.hpp"
#include "store/verdict.hpp"
#include "view/image.hpp"

namespace vrda::view {
namespace {

constexpr std::array speeds_steps_s{slowest_steps_s, 2.0, 5.0, 10.0, 20.0, 30.0, 45.0, 60.0, 90.0, 180.0,
                                    fastest_steps_s};

/// The timeline after `travel` along a path that bounces between its ends.
Timeline bounced(Timeline timeline, double travel)
{
  const double length = timeline.last - timeline.first;
  const double done = timeline.position - timeline.first;
  // Unfolded: the return path follows beyond the far end.
  const double unfolded = timeline.direction > 0 ? done : 2.0 * length - done;
  const double at = std::fmod(unfolded + travel, 2.0 * length);
  timeline.direction = at < length ? 1 : -1;
  timeline.position = timeline.first + (at < length ? at : 2.0 * length - at);
  return timeline;
}

}  // namespace

const char* name_of(LoopMode mode)
{
  return std::array{"once", "loop", "to and fro"}.at(static_cast<std::size_t>(mode));
}

Timeline advanced(Timeline timeline, double elapsed_s)
{
  check(elapsed_s >= 0.0, "the elapsed time is not negative");
  const double length = timeline.last - timeline.first;
  if (!timeline.is_playing || length <= 0.0) return timeline;
  const double travel = position_of_steps(timeline.axis, timeline.speed_steps_s) * elapsed_s;
  switch (timeline.loop) {
    case LoopMode::once:
      timeline.position += travel;
      timeline.is_playing = timeline.position < timeline.last;
      break;
    case LoopMode::wrap:
      timeline.position = timeline.first + std::fmod(timeline.position - timeline.first + travel, length);
      break;
    case LoopMode::bounce:
      timeline = bounced(timeline, travel);
      break;
  }
  timeline.position = std::clamp(timeline.position, timeline.first, timeline.last);
  return timeline;
}

Timeline toggled(Timeline timeline)
{
  timeline.is_playing = !timeline.is_playing;
  if (timeline.loop != LoopMode::bounce) timeline.direction = 1;
  const bool is_over = timeline.loop == LoopMode::once && timeline.position >= timeline.last;
  if (timeline.is_playing && is_over) timeline.position = timeline.first;
  return timeline;
}

Timeline stepped(Timeline timeline, double n_steps)
{
  timeline.is_playing = false;
  return moved_to(timeline, timeline.position + position_of_steps(timeline.axis, n_steps));
}

Timeline moved_to(Timeline timeline, double position)
{
  timeline.position = std::clamp(position, timeline.first, timeline.last);
  return timeline;
}

Timeline with_range(Timeline timeline, double first, double last)
{
  check(first <= last, "the range of a timeline ascends");
  timeline.first = first;
  timeline.last = last;
  return moved_to(timeline, timeline.position);
}

Timeline faster(Timeline timeline)
{
  const auto next = std::ranges::upper_bound(speeds_steps_s, timeline.speed_steps_s);
  if (next != speeds_steps_s.end()) timeline.speed_steps_s = *next;
  return timeline;
}

Timeline slower(Timeline timeline)
{
  const auto same = std::ranges::lower_bound(speeds_steps_s, timeline.speed_steps_s);
  if (same != speeds_steps_s.begin()) timeline.speed_steps_s = *(same - 1);
  return timeline;
}

namespace {

constexpr double leap_steps = 10.0;
constexpr double varus_step_rad = rad_from_deg(1.0);

/// The next of the enum values 0 ... last, cyclically.
template <typename Enum>
Enum next_of(Enum value, Enum last)
{
  return value == last ? Enum{} : static_cast<Enum>(static_cast<int>(value) + 1);
}

BodyIndex next_held(BodyIndex held)
{
  return holdable[(held_row(held) + 1) % holdable.size()];
}

Timeline with_next_loop(Timeline timeline)
{
  timeline.loop = next_of(timeline.loop, LoopMode::bounce);
  if (timeline.loop != LoopMode::bounce) timeline.direction = 1;
  return timeline;
}

PlayerState with_varus_by(PlayerState state, double by_rad, const PlayerRange& range)
{
  if (range.is_varus_free) return state;
  const double varus_rad = state.varus_rad.value_or(range.balanced_varus_rad) + by_rad;
  state.varus_rad = std::clamp(varus_rad, range.first_varus_rad, range.last_varus_rad);
  return state;
}

/// What an action does to the state.
struct ActionRow {
  Action action;
  void (*apply)(PlayerState&, const PlayerRange&);
};

// Short, for rows of one line.
using S = PlayerState;
using R = PlayerRange;
/// Those of layers are apart.
constexpr double section_step_mm = 1.0;

constexpr ActionRow action_rows[] = {
    {Action::play_pause, [](S& s, const R&) { s.timeline = toggled(s.timeline); }},
    {Action::step_forward, [](S& s, const R&) { s.timeline = stepped(s.timeline, 1.0); }},
    {Action::step_back, [](S& s, const R&) { s.timeline = stepped(s.timeline, -1.0); }},
    {Action::leap_forward, [](S& s, const R&) { s.timeline = stepped(s.timeline, leap_steps); }},
    {Action::leap_back, [](S& s, const R&) { s.timeline = stepped(s.timeline, -leap_steps); }},
    {Action::go_to_first, [](S& s, const R&) { s.timeline = moved_to(s.timeline, s.timeline.first); }},
    {Action::go_to_last, [](S& s, const R&) { s.timeline = moved_to(s.timeline, s.timeline.last); }},
    {Action::varus_up, [](S& s, const R& range) { s = with_varus_by(s, varus_step_rad, range); }},
    {Action::varus_down, [](S& s, const R& range) { s = with_varus_by(s, -varus_step_rad, range); }},
    {Action::varus_balanced, [](S& s, const R&) { s.varus_rad.reset(); }},
    {Action::faster, [](S& s, const R&) { s.timeline = faster(s.timeline); }},
    {Action::slower, [](S& s, const R&) { s.timeline = slower(s.timeline); }},
    {Action::next_loop, [](S& s, const R&) { s.timeline = with_next_loop(s.timeline); }},
    {Action::next_set, [](S& s, const R& range) { s.set = (s.set + 1) % range.n_sets; }},
    {Action::previous_set, [](S& s, const R& range) { s.set = (s.set + range.n_sets - 1) % range.n_sets; }},
    {Action::next_mode, [](S& s, const R&) { s.mode = next_of(s.mode, DrawMode::textured); }},
    {Action::next_backdrop, [](S& s, const R&) { s.backdrop = next_of(s.backdrop, Backdrop::black); }},
    {Action::next_fixed_object, [](S& s, const R&) { s.fixed_object = next_held(s.fixed_object); }},
    {Action::next_section,
     [](S& s, const R&) { s.section.kind = next_of(s.section.kind, SectionKind::free); }},
    {Action::section_forward, [](S& s, const R&) { s.section.at_mm += section_step_mm; }},
    {Action::section_back, [](S& s, const R&) { s.section.at_mm -= section_step_mm; }},
    {Action::section_leap_forward, [](S& s, const R&) { s.section.at_mm += leap_steps * section_step_mm; }},
    {Action::section_leap_back, [](S& s, const R&) { s.section.at_mm -= leap_steps * section_step_mm; }},
    {Action::show_structures, [](S& s, const R&) { s.shows_structures = !s.shows_structures; }},
    {Action::show_panel, [](S& s, const R&) { s.shows_panel = !s.shows_panel; }},
    {Action::show_numbers, [](S& s, const R&) { s.shows_numbers = !s.shows_numbers; }},
    {Action::show_help, [](S& s, const R&) { s.shows_help = !s.shows_help; }},
    {Action::leave, [](S& s, const R&) { s.shows_help = false; }},
    {Action::quit, [](S& s, const R&) { s.is_done = true; }}};

}  // namespace

PlayerState apply_action(PlayerState state, Action action, const PlayerRange& range)
{
  const auto row = std::ranges::find(action_rows, action, &ActionRow::action);
  if (row != std::end(action_rows)) row->apply(state, range);
  if (action >= Action::show_contacts && action <= Action::show_band) {
    // In the order of Layer.
    const auto layer =
        static_cast<Layer>(1 + static_cast<int>(action) - static_cast<int>(Action::show_contacts));
    state.layers.set(layer, range.available.has(layer) && !state.layers.has(layer));
  }
  return state;
}

double wanted_varus_rad(const PlayerState& state, const PlayerRange& range)
{
  const double varus_rad =
      range.is_varus_free ? range.balanced_varus_rad : state.varus_rad.value_or(range.balanced_varus_rad);
  return std::clamp(varus_rad, range.first_varus_rad, range.last_varus_rad);
}

Timeline timeline_over(const store::Motion& motion)
{
  Timeline timeline;
  if (!motion.is_sequence())
    return with_range(timeline, motion.first_flexion_rad(), motion.last_flexion_rad());
  timeline.axis = TimelineAxis::frames;
  return with_range(timeline, 0.0, static_cast<double>(motion.keys().size() - 1));
}

store::JointPose pose_at(const store::Motion& motion, double position, double varus_rad)
{
  return motion.is_sequence() ? motion.at_frame(motion.key_at(position)) : motion.at({position, varus_rad});
}

std::optional<View> view_of(Action action)
{
  constexpr std::array views{View::front, View::back, View::medial, View::lateral, View::top, View::oblique};
  if (action < Action::view_front || action > Action::view_oblique) return std::nullopt;
  return views.at(static_cast<std::size_t>(action) - static_cast<std::size_t>(Action::view_front));
}

const char* name_of(DrawMode mode)
{
  return std::array{"wire", "hidden lines", "flat", "smooth", "textured"}.at(static_cast<std::size_t>(mode));
}

const char* name_of(Backdrop backdrop)
{
  return std::array{"studio", "night", "black"}.at(static_cast<std::size_t>(backdrop));
}

namespace {

/// Opacity of transparent bodies, of which the nearest surface alone is drawn: two of them pass about half of
/// the light of what is inside, and a bone stays visible.
constexpr float transparent_opacity = 0.3F;

constexpr double least_scale_mm = 0.1, most_scale_mm = 1000.0;

void set_texture(Scene& scene, const AppearanceOptions& look)
{
  if (look.texture.empty()) return;
  if (!(look.texture_scale_mm >= least_scale_mm && look.texture_scale_mm <= most_scale_mm)) {
    throw InputError(
        {"--texture-scale", "", std::to_string(look.texture_scale_mm) + " mm", "0.1 to 1000 mm"});
  }
  scene.texture = read_png_texture(look.texture);
  scene.texture.scale_mm = look.texture_scale_mm;
}

/// Applies `change` to the structures that `names` lists. Throws InputError naming `option`.
void change_structures(Scene& scene, const std::string& names, const char* option, void (*change)(Drawable&))
{
  if (names.empty()) return;
  for (const std::string& name : split(names, ',')) {
    bool is_found = false;
    for (Drawable& drawable : scene.drawables) {
      const std::string& id = drawable.structure;
      const bool is_body = drawable.layer == Layer::bodies;
      const bool is_of_object =
          (drawable.parent == BodyIndex::reference &&
           (name == "reference" || name == scene.reference_name)) ||
          (drawable.parent == BodyIndex::moving && (name == "moving" || name == scene.moving_name)) ||
          (model::row_of(drawable.parent) < 2 && name == "both");
      if (id.empty() || !(name == id || id.ends_with("/" + name) || (is_body && is_of_object))) continue;
      change(drawable);
      is_found = true;
    }
    if (is_found) continue;
    std::vector<std::string> known{scene.reference_name, scene.moving_name, "both"};
    for (const Drawable& drawable : scene.drawables) {
      const std::string own = drawable.structure.substr(drawable.structure.rfind('/') + 1);
      if (std::ranges::find(known, own) == known.end() && !own.empty()) known.push_back(own);
    }
    throw InputError({option, "", "\"" + name + "\"", "some of " + join_alternatives(known)});
  }
}

}  // namespace

std::vector<Eigen::Vector3d> framed_points(const Scene& scene, Framing framed)
{
  constexpr double everywhere_mm = std::numeric_limits<double>::infinity();
  return points_within(
      scene, framed == Framing::all ? Sphere{Eigen::Vector3d::Zero(), everywhere_mm} : joint_sphere(scene));
}

LayerSet parsed_layers(const std::string& text)
{
  LayerSet layers;
  if (text.empty() || text == "none") return layers;
  if (text == AppearanceOptions{}.layers) {
    layers.set(Layer::ligaments, true);
    return layers;
  }
  std::string known;
  for (const std::string& name : layer_names()) known += (known.empty() ? "" : ", ") + name;
  for (const std::string& name : split(text, ',')) {
    const std::optional<Layer> layer = layer_named(name);
    if (!layer) throw InputError({"--layers", "", "\"" + name + "\"", "some of " + known});
    if (layers.has(*layer)) throw InputError({"--layers", "", name + " twice", "every layer once"});
    layers.set(*layer, true);
  }
  return layers;
}

void apply_appearance(Scene& scene, const AppearanceOptions& look)
{
  scene.mode = look.mode;
  set_texture(scene, look);
  if (!look.lights.empty()) {
    const Lights lights = read_lights(look.lights);
    scene.lighting = lights.lighting;
    if (lights.background) scene.background = *lights.background;
  }
  change_structures(scene, look.see_through, "--see-through",
                    [](Drawable& drawable) { drawable.material.opacity *= transparent_opacity; });
  change_structures(scene, look.hidden, "--hide", [](Drawable& drawable) {
    drawable.is_hidden = true;
    drawable.is_shown = false;
  });
}

namespace {

struct Rows {
  Eigen::Index first = 0, last = 0;  ///< equal at a node
};

/// The nodes of an ascending axis around a value.
Rows rows_around(const std::vector<double>& axis, double value)
{
  constexpr double rounding = 1e-9;
  const auto above = std::upper_bound(axis.begin(), axis.end(), value + rounding);
  if (above == axis.begin()) return {};
  const Eigen::Index row = above - axis.begin() - 1;
  const bool is_node = above == axis.end() || value - *(above - 1) <= rounding;
  return {row, is_node ? row : row + 1};
}

/// Without the remedy.
int reason_length(const std::string_view meaning)
{
  return static_cast<int>(std::min(meaning.find(';'), meaning.size()));
}

std::string words_of(Plausibility plausibility)
{
  std::string words = name_of(plausibility);
  std::ranges::replace(words, '_', ' ');
  return words;
}

/// The number of cells without a pose.
Eigen::Index n_holes_of(const store::GridB& status)
{
  return (status != status_stable).count();
}

/// The first of doubtful_plausibilities in these cells of the joint or of a follower, and whether one has no
/// pose.
PoseDoubt doubt_in(const store::GridB& status, const store::GridB& plausibility, const Rows& flexion,
                   const Rows& varus)
{
  PoseDoubt doubt;
  std::size_t worst = std::size(doubtful_plausibilities);
  for (Eigen::Index i = flexion.first; i <= flexion.last; ++i) {
    for (Eigen::Index j = varus.first; j <= varus.last; ++j) {
      doubt.is_beside_hole |= status(i, j) != status_stable;
      if (plausibility.size() == 0) continue;
      const auto here = static_cast<Plausibility>(plausibility(i, j));
      const auto found = std::ranges::find(doubtful_plausibilities, here);
      worst = std::min(worst, static_cast<std::size_t>(found - std::begin(doubtful_plausibilities)));
    }
  }
  if (worst < std::size(doubtful_plausibilities)) doubt.plausibility = doubtful_plausibilities[worst];
  return doubt;
}

/// Appends the counts of implausible poses; `prefix`: of a follower.
void add_counts(std::vector<std::string>& warnings, const std::string& prefix, const store::GridB& status,
                const store::GridB& plausibility)
{
  const Eigen::Index n_poses = status.size() - n_holes_of(status);
  for (const Plausibility doubtful : doubtful_plausibilities) {
    const Eigen::Index n = (plausibility == static_cast<std::int8_t>(doubtful)).count();
    if (n > 0)
      warnings.push_back(prefix + std::to_string(n) + " of " + std::to_string(n_poses) +
                         " poses: " + words_of(doubtful) + ": " + meaning_of(doubtful));
  }
}

}  // namespace

PoseDoubt DoubtReader::at(const store::JointPose& pose) const
{
  PoseDoubt doubt;
  doubt.is_beside_hole = pose.status != store::PoseStatus::solved;
  if (model_.frames && std::isnan(pose.key)) return doubt;
  const Rows flexion = model_.frames
                           ? rows_around(model_.frames->key, pose.key)
                           : rows_around(model_.flexion_deg, deg_from_rad(pose.attitude.flexion_rad));
  const Rows varus = model_.varus_deg.size() > 1
                         ? rows_around(model_.varus_deg, deg_from_rad(pose.attitude.varus_rad))
                         : Rows{};
  doubt = doubt_in(model_.status, model_.plausibility, flexion, varus);
  doubt.is_beside_hole |= pose.status != store::PoseStatus::solved;
  for (const store::FollowerRows& follower : model_.followers) {
    if (doubt.is_any()) break;
    doubt = doubt_in(follower.status, follower.plausibility, flexion, varus);
    doubt.follower = &follower;
  }
  return doubt;
}

std::vector<MarkedSpan> DoubtReader::marks(const store::Motion& motion, std::optional<double> varus_rad) const
{
  std::vector<MarkedSpan> spans;
  const std::size_t n = motion.is_sequence() ? motion.keys().size() : model_.flexion_deg.size();
  const auto position = [&](std::size_t k) {
    return motion.is_sequence() ? static_cast<double>(k) : rad_from_deg(model_.flexion_deg[k]);
  };
  for (std::size_t k = 0; k + 1 < n; ++k) {
    const double middle = 0.5 * (position(k) + position(k + 1));
    const store::JointPose pose =
        motion.is_sequence()
            ? motion.at_frame(motion.key_at(middle))
            : motion.at({middle, varus_rad ? *varus_rad : motion.balanced_varus_rad(middle)});
    const PoseDoubt doubt = at(pose);
    if (!doubt.is_any()) continue;
    const MarkedSpan span{position(k), position(k + 1), pose.status == store::PoseStatus::solved};
    const bool continues =
        !spans.empty() && spans.back().last == span.first && spans.back().has_pose == span.has_pose;
    if (continues) {
      spans.back().last = span.last;
    } else {
      spans.push_back(span);
    }
  }
  return spans;
}

DoubtText doubt_text(const store::JointPose& pose, const PoseDoubt& doubt, const char* drawn)
{
  DoubtText text{};
  if (pose.status != store::PoseStatus::solved) {
    const bool is_frame = !std::isnan(pose.key);
    std::snprintf(text.data(), text.size(), "no pose at %s%.4g%s: %s is unsolved; only the %s is drawn",
                  is_frame ? "frame " : "",
                  is_frame ? pose.key : std::round(1e3 * deg_from_rad(pose.attitude.flexion_rad)) / 1e3 + 0.0,
                  is_frame ? "" : " degrees", is_frame ? "it or a neighbour" : "a neighbouring attitude",
                  drawn);
  } else if (is_doubtful(doubt.plausibility)) {
    const char* meaning = meaning_of(doubt.plausibility);
    const std::string_view name = name_of(doubt.plausibility);
    const std::string whose = doubt.follower ? doubt.follower->name : std::string();
    std::snprintf(text.data(), text.size(), "%.*s%s%.*s: %.*s", static_cast<int>(whose.size()), whose.data(),
                  whose.empty() ? "" : ": ", static_cast<int>(name.size()), name.data(),
                  reason_length(meaning), meaning);
    // The names end before the meaning begins.
    std::replace(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(whose.size() + name.size() + 2),
                 '_', ' ');
  } else if (doubt.is_beside_hole && doubt.follower != nullptr) {
    std::snprintf(text.data(), text.size(), "%s: no pose at or beside this attitude",
                  doubt.follower->name.c_str());
  } else if (doubt.is_beside_hole) {
    std::snprintf(text.data(), text.size(),
                  "beside an attitude without a pose: the smoothed motion is extrapolated here");
  }
  return text;
}

std::vector<std::string> model_warnings(const store::MotionModel& model)
{
  std::vector<std::string> warnings;
  add_counts(warnings, "", model.status, model.plausibility);
  const Eigen::Index n_holes = n_holes_of(model.status);
  if (n_holes > 0)
    warnings.push_back(std::to_string(n_holes) + " of " + std::to_string(model.status.size()) +
                       " attitudes have no pose");
  for (const store::FollowerRows& follower : model.followers) {
    add_counts(warnings, follower.name + ": ", follower.status, follower.plausibility);
    const Eigen::Index n_lacking = n_holes_of(follower.status) - n_holes;  // where the joint has a pose
    if (n_lacking > 0)
      warnings.push_back(follower.name + ": no pose at " + std::to_string(n_lacking) + " of " +
                         std::to_string(model.status.size() - n_holes) + " attitudes");
  }
  warnings.insert(warnings.end(), model.job.warnings.begin(), model.job.warnings.end());
  return warnings;
}

std::string default_motion_remark(const store::MotionModel& model, const std::string& set)
{
  const store::DefaultMotion shown = store::default_motion(model);
  if (shown.set != set) return "";
  const std::string solved = shown.reason.empty() ? "" : "The solved poses are shown: " + shown.reason;
  return shown.statement + (shown.statement.empty() || solved.empty() ? "" : " ") + solved;
}

std::vector<std::string> verdict_sentences(const store::MotionModel& model,
                                           const std::vector<std::string>& sets)
{
  std::vector<std::string> sentences;
  for (const std::string& set : sets) {
    const std::optional<store::Verdict> verdict = store::verdict_of(model, set);
    sentences.push_back(verdict ? verdict->sentence : "");
  }
  return sentences;
}

bool has_doubtful_poses(const store::MotionModel& model)
{
  return model_warnings(model).size() > model.job.warnings.size();
}

CameraView named_view(const std::string& name, View view, Side side)
{
  return {name, view_rotation(view, side), Eigen::Vector3d::Zero()};
}

CameraView turned_view(const std::string& name, const Eigen::Vector3d& turn_rad,
                       const Eigen::Vector3d& shift_mm, Side side)
{
  const Eigen::Matrix3d R_turn =
      rotation_z(turn_rad.z()) * rotation_y(turn_rad.y()) * rotation_x(turn_rad.x());
  // Rotating the joint equals the inverse rotation of the camera.
  return {name, view_rotation(View::front, side) * R_turn.transpose(), shift_mm};
}

Camera placed_camera(const CameraFit& fit, const CameraView& view, double zoom)
{
  Camera camera = fit.camera();
  camera.half_height_tangent /= zoom;
  camera.X_world_camera.translation() -= view.R_world_camera * view.shift_camera_mm;
  return camera;
}

std::vector<CameraView> camera_views(const JobViews& job, Side side)
{
  std::vector<CameraView> views;
  for (const JobView& view : job.views) {
    views.push_back(turned_view("view " + std::to_string(view.number),
                                view.orientation_deg * rad_from_deg(1.0), view.shift_mm, side));
  }
  return views;
}

bool has_usable_size(const JobViews& job)
{
  return std::min(job.width_px, job.height_px) >= 16 && std::max(job.width_px, job.height_px) <= 4096;
}

namespace {

/// The number or the list of n numbers of a key; all zero if it has another form.
template <int n>
Eigen::Matrix<double, n, 1> numbers_in(const core::DocumentValue& table, const char* key)
{
  const core::DocumentValue given = table.contains(key) ? table.at(key) : core::DocumentValue();
  const core::DocumentValue list = given.is_array() ? given : core::DocumentValue::array({given});
  Eigen::Matrix<double, n, 1> numbers = Eigen::Matrix<double, n, 1>::Zero();
  if (list.size() != n || !std::ranges::all_of(list, &core::DocumentValue::is_number)) return numbers;
  for (Eigen::Index i = 0; i < n; ++i) numbers[i] = core::number_at(list[static_cast<std::size_t>(i)], "");
  return numbers.allFinite() ? numbers : numbers.setZero();
}

}  // namespace

JobViews job_views(std::string_view resolved_job)
{
  JobViews job;
  core::DocumentValue root;
  bool is_refused = false;
  try {
    root = core::parse_toml(resolved_job, "job");
  } catch (const InputError&) {
    is_refused = true;
  }
  const core::DocumentValue* const player = core::find_at(root, "player");
  if (is_refused || player == nullptr) return job;
  if (const double zoom = numbers_in<1>(*player, "zoom").x(); zoom > 0.0) job.zoom = zoom;
  // Upper limit of the schema.
  const Eigen::Vector2d size = numbers_in<2>(*player, "display_px").cwiseMin(16384.0).cwiseMax(0.0);
  job.width_px = static_cast<int>(size.x());
  job.height_px = static_cast<int>(size.y());
  const core::DocumentValue* const render = core::find_at(*player, "render");
  if (render != nullptr && render->is_string()) job.render = core::text_at(*render, "");
  const core::DocumentValue* const views = core::find_at(*player, "view");
  if (views == nullptr || !views->is_array()) return job;
  for (const core::DocumentValue& view : *views) {
    job.views.push_back({static_cast<int>(numbers_in<1>(view, "number").x()), numbers_in<3>(view, "shift_mm"),
                         numbers_in<3>(view, "orientation_deg")});
  }
  return job;
}

}  // namespace vrda::view
