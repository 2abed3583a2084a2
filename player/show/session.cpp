#include "show/session.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <limits>
#include <utility>

#include "core/text.hpp"
#include "model/frames.hpp"
#include "show/loop.hpp"
#include "show/show.hpp"
#include "view/image.hpp"

namespace vrda::show {
namespace {

constexpr int n_framed_poses = 7;          // samples of the motion for framing; its outline changes slowly
constexpr int frames_after_input = 3;      // the interface library needs two frames to react to a button
constexpr double session_message_s = 4.0;  // long enough to read a path
constexpr double most_elapsed_s = 0.25;    // a suspended program resumes where it stopped

std::vector<PlayedSet> played_sets(const store::MotionModel& model)
{
  std::vector<PlayedSet> sets;
  for (const std::string& name : store::all_set_names(model)) sets.emplace_back(model, name);
  return sets;
}

std::size_t row_of(const store::MotionModel& model, const std::string& set)
{
  const std::vector<std::string> names = store::all_set_names(model);
  const auto found = std::ranges::find(names, set);
  check(found != names.end(), "the session's set is in the model");
  return static_cast<std::size_t>(found - names.begin());
}

/// The points to be framed over the whole motion of both joints, world.
std::vector<Eigen::Vector3d> points_over(JointView& joint, std::optional<Comparison>& other,
                                         const store::Motion& motion, view::Framing framing)
{
  std::vector<Eigen::Vector3d> all;
  const view::Timeline range = view::timeline_over(motion);
  for (int i = 0; i < n_framed_poses; ++i) {
    const double part = static_cast<double>(i) / (n_framed_poses - 1);
    const double position = range.first + part * (range.last - range.first);
    const double varus_rad = motion.is_sequence() ? 0.0 : motion.balanced_varus_rad(position);
    const store::JointPose pose = view::pose_at(motion, position, varus_rad);
    if (pose.status != store::PoseStatus::solved) continue;
    const std::vector<Eigen::Vector3d> points = joint.framed_points(pose, framing);
    all.insert(all.end(), points.begin(), points.end());
    if (!other) continue;
    const auto more = other->framed_points(pose, std::nullopt, joint.fixed_object, framing);
    all.insert(all.end(), more.begin(), more.end());
  }
  return all.empty() ? view::framed_points(joint.scene(), view::Framing::joint) : all;
}

view::Timeline timeline_of(const store::Motion& motion, const SessionOptions& options)
{
  const view::Timeline timeline = view::timeline_over(motion);
  if (motion.is_sequence())
    return options.key ? view::moved_to(timeline, motion.position_of(*options.key)) : timeline;
  return view::moved_to(timeline, options.flexion_rad.value_or(timeline.first));
}

}  // namespace

Session::Session(store::MotionModel model, const SessionOptions& options)
    : model_(std::move(model)),
      sets_(played_sets(model_)),
      joint_(model_, options.appearance, options.backdrop),
      side_(side_named(model_.side)),
      gui_({options.title, store::all_set_names(model_), options.scale,
            store::displayed_name(model_, BodyIndex::reference),
            store::displayed_name(model_, BodyIndex::moving), model_.joint, view::model_warnings(model_),
            view::has_doubtful_poses(model_), options.other.is_wanted(),
            view::verdict_sentences(model_, store::all_set_names(model_)),
            view::rotation_plots(model_, store::all_set_names(model_)),
            view::default_motion_remark(model_, store::default_motion(model_).set),
            row_of(model_, store::default_motion(model_).set)}),
      view_(options.view),
      width_(options.width),
      height_(options.height)
{
  if (options.other.is_wanted()) other_.emplace(model_, options.other, options.appearance, options.backdrop);
  state_.set = row_of(model_, options.set);
  state_.timeline = timeline_of(sets_[state_.set].motion, options);
  state_.varus_rad = options.varus_rad;
  state_.backdrop = options.backdrop;
  state_.fixed_object = options.fixed_object;
  state_.mode = options.appearance.mode;
  state_.layers = view::parsed_layers(options.appearance.layers);
  occlusion_radius_mm_ = joint_.scene().occlusion_radius_mm;
  is_plain_while_moving_ = options.is_plain_while_moving;
  backdrop_ = options.backdrop;
  framing_ = options.framing;
  range_ = range_now();
  job_view_ = options.job_view;
  zoom_ = options.zoom;
  state_.section = options.section;
  list_.section_range_mm = 60.0 * view::marker_scale(model_);
  if (options.state) joint_.use(*options.state);
  frame_fixed_object();
  if (options.state && options.state->place) {
    gaze_.camera = placed(gaze_.camera, *options.state->place);
    gaze_.pivot_world_mm = options.state->place->target_mm;
  }
  shots_.resize(1);  // names are placed by the shots of the frame before
  advance(0.0);
}

void Session::frame_fixed_object()
{
  joint_.fixed_object = state_.fixed_object;
  framed_points_ = points_over(joint_, other_, motion(), framing_);
  frame_joint();
}

view::Viewport Session::pane(const std::optional<Eigen::Vector2d>& pointer_px) const
{
  const view::Viewport whole = area();
  if (!other_ || !other_->is_beside()) return whole;
  const bool is_second = pointer_px && pointer_px->x() >= whole.x + whole.width / 2;
  return column(whole, is_second ? 1 : 0, 2);
}

void Session::load_into(view::Renderer& renderer) const
{
  renderer.load(scene());
  renderer.load(gui_.font());
}

view::PlayerRange Session::range_now() const
{
  view::PlayerRange range;
  range.n_sets = sets_.size();
  range.first_varus_rad = motion().first_varus_rad();
  range.last_varus_rad = motion().last_varus_rad();
  range.is_varus_free = motion().is_varus_free();
  if (motion().is_sequence()) {
    range.key_name = motion().key_name().c_str();
  } else {
    range.balanced_varus_rad = motion().balanced_varus_rad(state_.timeline.position);
  }
  range.available = joint_.layers().available();
  return range;
}

bool Session::is_over_picture(const Eigen::Vector2d& pointer_px) const
{
  const view::Viewport free = area();
  const bool is_inside = pointer_px.x() >= free.x && pointer_px.x() < free.x + free.width &&
                         pointer_px.y() >= free.y && pointer_px.y() < free.y + free.height;
  return is_inside && !state_.shows_help;
}

void Session::resize(int width, int height)
{
  if (width == width_ && height == height_) return;
  width_ = std::max(width, 1);
  height_ = std::max(height, 1);
  navigation_.stop();
  is_disturbed_ = true;
}

void Session::set_scale(double scale, view::Renderer& renderer)
{
  if (!gui_.set_scale(scale)) return;
  renderer.load(gui_.font());
  is_disturbed_ = true;
  n_frames_due_ = frames_after_input;
}

void Session::do_action(view::Action action)
{
  if (action == view::Action::screenshot) takes_picture_ = true;
  if (action == view::Action::full_screen) toggles_full_screen_ = true;
  if (action == view::Action::leave && !state_.shows_help) leaves_full_screen_ = !gui_.close_menu();
  if (action == view::Action::reset_view) frame_joint();
  if (const std::optional<view::View> view = view::view_of(action)) set_view(*view);
  do_structure_action(action);
  const view::SectionKind section = state_.section.kind;
  state_ = view::apply_action(state_, action, range_);
  update_section(section);
}

/// A new free plane faces the camera, through the middle of the joint.
void Session::update_section(view::SectionKind before)
{
  view::Section& section = state_.section;
  if (section.kind == before) return;
  const bool is_free = section.kind == view::SectionKind::free;
  if (is_free) section.normal = gaze_.camera.X_world_camera.linear().col(2);
  section.at_mm = is_free ? section.normal.dot(gaze_.pivot_world_mm) : 0.0;
}

void Session::do_structure_action(view::Action action)
{
  using view::Action;
  view::Looks& looks = joint_.looks();
  const std::size_t n = joint_.structures().size();
  const auto change = [&](view::LookChange how) { view::change(looks, joint_.structures(), how); };
  if (action == Action::save_view) saves_view_ = true;
  if (action == Action::show_all_structures) change(view::LookChange::show_all);
  if (action == Action::isolate_structure) change(view::LookChange::isolate);
  if (action == Action::fade_other_structures) change(view::LookChange::fade_others);
  if (action == Action::next_structure)
    looks.highlighted = looks.highlighted ? (*looks.highlighted + 1) % n : 0;
  if (action == Action::previous_structure) looks.highlighted = (looks.highlighted.value_or(0) + n - 1) % n;
  const bool is_chosen = action == Action::next_structure || action == Action::previous_structure;
  if (is_chosen) state_.shows_structures = true;
  if (!looks.highlighted) return;
  view::StructureLook& look = looks.of[*looks.highlighted];
  const view::Layer layer = view::layer_of(joint_.structures()[*looks.highlighted]);
  if (action == Action::switch_structure) {
    look.is_visible = !look.is_visible;
    if (layer != view::Layer::bodies && layer != view::Layer::ligaments)
      state_.layers.set(layer, !state_.layers.has(layer));
  }
  constexpr float opacity_step = 0.1F;
  const float by = action == Action::less_opaque   ? -opacity_step
                   : action == Action::more_opaque ? opacity_step
                                                   : 0.0F;
  look.opacity = std::clamp(look.opacity + by, view::least_opacity, 1.0F);
}

/// Highlights what is there; of a highlighted structure, no longer.
void Session::touch(const Eigen::Vector2d& pointer_px)
{
  constexpr double reach_px = 4.0;  // as on the page
  view::Looks& looks = joint_.looks();
  const view::Viewport shown = pane(pointer_px);
  const view::Scene& there = shown.x == area().x ? scene() : other_->joint().scene();
  const auto pick = view::picked(there, shots_[0].camera, shown, pointer_px, reach_px);
  const auto row = pick ? joint_.structure_row(there.drawables[pick->drawable].structure) : std::nullopt;
  looks.highlighted = row == looks.highlighted ? std::nullopt : row;
  if (looks.highlighted) state_.shows_structures = true;
}

/// The curve when structure, set or varus changes; the numbers at every frame.
void Session::update_card()
{
  constexpr std::size_t n_curve = 61;
  const std::optional<std::size_t> row = joint_.looks().highlighted;
  view::StructureCard& card = list_.card;
  card.reading[0] = 0;
  card.strain = {};
  if (!row || joint_.structures()[*row].group != view::StructureGroup::ligaments) {
    card_row_ = row;
    return;
  }
  const std::string& id = joint_.structures()[*row].id;
  const view::Timeline& timeline = state_.timeline;
  const double span = timeline.last - timeline.first;
  if (row != card_row_ || card_set_ != state_.set || card_varus_rad_ != state_.varus_rad) {
    card_row_ = row;
    card_set_ = state_.set;
    card_varus_rad_ = state_.varus_rad;
    strain_.values.clear();
    double highest = -std::numeric_limits<double>::infinity();
    for (std::size_t k = 0; k < n_curve; ++k) {
      const double at = timeline.first + span * static_cast<double>(k) / (n_curve - 1);
      const double varus_rad =
          motion().is_sequence() ? 0.0 : state_.varus_rad.value_or(motion().balanced_varus_rad(at));
      const auto reading = joint_.bundles().at(id, view::pose_at(motion(), at, varus_rad));
      const double strain = reading && !reading->is_line ? 100.0 * reading->strain : std::nan("");
      strain_.values.push_back(static_cast<float>(strain));
      if (strain <= highest) continue;
      if (std::isfinite(strain)) highest = strain, tightest_ = at;
    }
  }
  const auto now = joint_.bundles().at(id, readout_.pose);
  const auto tightest = std::ranges::max_element(
      strain_.values, {}, [](float value) { return std::isnan(value) ? -1e9F : value; });
  const auto shown_position = [&](double position) {
    return view::steps_of_position(timeline.axis, position);
  };
  if (!now) {
    std::snprintf(card.reading.data(), card.reading.size(), "no pose here");
  } else if (now->is_line) {
    std::snprintf(card.reading.data(), card.reading.size(), "pulls with %.0f N at every angle",
                  now->tension_n);
  } else {
    const char* unit = motion().is_sequence() ? "" : "°";
    std::snprintf(card.reading.data(), card.reading.size(), "%s %.1f %%, %.0f N; %s at %.0f%s",
                  now->strain > 0.0 ? "strain" : "slack", 100.0 * now->strain, now->tension_n,
                  *tightest > 0.0F ? "tightest" : "never taut, least slack", shown_position(tightest_), unit);
  }
  if (!std::isnan(*tightest)) card.strain = {&strain_, 1};
  card.now = span > 0.0 ? (timeline.position - timeline.first) / span : 0.0;
}

void Session::set_view(view::View view)
{
  view_ = view;
  job_view_.reset();
  zoom_ = 1.0;
  frame_joint();
}

/// In the job's view, else the chosen one.
void Session::frame_joint()
{
  navigation_.stop();
  const view::Viewport free = pane();
  view::FrameOptions options;
  options.aspect = static_cast<double>(free.width) / free.height;
  const view::CameraView view = job_view_.value_or(view::named_view("", view_, side_));
  view::CameraFit fit(view.R_world_camera, options);
  fit.include(framed_points_);
  gaze_.camera = view::placed_camera(fit, view, zoom_);
  X_world_framed_ = job_view_ ? Pose::Identity() : gaze_.camera.X_world_camera;
  gaze_.pivot_world_mm = view::joint_sphere(scene()).centre_world_mm;
}

void Session::place_joint()
{
  range_ = range_now();
  const store::JointPose pose =
      view::pose_at(motion(), state_.timeline.position, view::wanted_varus_rad(state_, range_));
  joint_.scene().section = view::plane_of(state_.section);
  joint_.show(motion(), pose, state_.layers);
  if (other_) other_->show(joint_, pose, state_.varus_rad, state_.layers);
  readout_ = joint_.readout(sets_[state_.set], pose, doubts_.at(pose));
  readout_.is_varus_balanced = !state_.varus_rad.has_value();
  joint_.scene().mode = state_.mode;
  if (state_.backdrop != backdrop_) joint_.scene().background = view::background_of(state_.backdrop);
  backdrop_ = state_.backdrop;
}

/// Computed when the set or the varus changes.
void Session::update_marks()
{
  if (marked_set_ == state_.set && marked_varus_rad_ == state_.varus_rad) return;
  marked_set_ = state_.set;
  marked_varus_rad_ = state_.varus_rad;
  marks_ = doubts_.marks(motion(), state_.varus_rad);
}

/// What the interface shows besides controls.
view::GuiFrame Session::frame_of(int width, int height)
{
  view::GuiFrame frame;
  frame.width = width;
  frame.height = height;
  frame.key = view::colour_key(joint_.layers(), state_.layers);
  if (state_.layers.has(view::Layer::labels))
    frame.labels = other_ ? other_->labels(joint_, shots()) : joint_.labels(shots());
  if (other_) frame.differences = &other_->differences(motion(), state_.varus_rad);
  return frame;
}

void Session::draw_interface(double elapsed_s)
{
  view::GuiFrame frame = frame_of(width_, height_);
  frame.elapsed_s = elapsed_s;
  frame.pointer = pointer_;
  frame.pointer.is_left_down |= was_left_pressed_;
  if (navigation_.is_dragging()) frame.pointer.is_left_down = false;
  update_marks();
  frame.marks = marks_;
  message_left_s_ -= elapsed_s;
  readout_.message = message_left_s_ > 0.0 ? message_.c_str() : nullptr;
  update_card();
  frame.list = &list_;
  const view::SectionKind section = state_.section.kind;
  const view::GuiResult answer = gui_.frame(frame, state_, range_, readout_);
  pointer_.wheel = 0.0;
  was_left_pressed_ = false;
  state_ = answer.state;
  update_section(section);
  do_action(answer.action);
}

void Session::aim(const view::Viewport& viewport)
{
  shots_.clear();
  if (other_)
    other_->add_shots(shots_, gaze_.camera, viewport);
  else
    shots_.push_back({gaze_.camera, viewport});
  gaze_.camera.aspect = static_cast<double>(shots_[0].viewport.width) / shots_[0].viewport.height;
  for (view::Shot& shot : shots_) shot.camera = view::with_depth_range(gaze_.camera, scene());
}

void Session::advance(double elapsed_s)
{
  --n_frames_due_;
  const bool is_moving = state_.timeline.is_playing || navigation_.is_dragging();
  if (was_moving_ && !is_moving) n_frames_due_ = std::max(n_frames_due_, 1);
  was_moving_ = is_moving;
  const bool was_at_rest = still_s_ >= settle_s;
  still_s_ = is_moving || is_disturbed_ ? 0.0 : still_s_ + elapsed_s;
  has_same_picture_ = was_at_rest && still_s_ >= settle_s;
  is_disturbed_ = false;
  joint_.scene().occlusion_radius_mm = is_plain() ? 0.0 : occlusion_radius_mm_;
  joint_.scene().has_vertex_lighting = is_plain();
  state_.timeline = view::advanced(state_.timeline, std::min(elapsed_s, most_elapsed_s));
  if (joint_.fixed_object != state_.fixed_object) frame_fixed_object();
  place_joint();
  draw_interface(elapsed_s);
  aim(area());
}

bool Session::is_idle() const
{
  return !state_.timeline.is_playing && !navigation_.is_dragging() && n_frames_due_ <= 0 &&
         message_left_s_ <= 0.0 && !is_plain();
}

bool Session::consume_screenshot_request()
{
  return std::exchange(takes_picture_, false);
}

bool Session::consume_full_screen_request(bool is_full)
{
  const bool leaves = std::exchange(leaves_full_screen_, false);
  return std::exchange(toggles_full_screen_, false) ? !is_full : is_full && !leaves;
}

const view::Image& Session::draw_screenshot(view::Renderer& renderer)
{
  aim(gui_.free_area(renderer.width(), renderer.height(), state_, false));
  joint_.scene().occlusion_radius_mm = occlusion_radius_mm_;  // until the next frame
  joint_.scene().has_vertex_lighting = false;
  if (!state_.shows_numbers && !state_.layers.has(view::Layer::labels) && shots_[0].viewport.y == 0 &&
      !other_)
    return renderer.draw(scene(), shots(), nullptr);
  const view::GuiFrame frame = frame_of(renderer.width(), renderer.height());
  view::Readout readout = readout_;
  readout.message = nullptr;
  return renderer.draw(scene(), shots(), &gui_.static_overlay(frame, state_, range_, readout));
}

ViewState Session::view_state() const
{
  ViewState state;
  state.set = store::all_set_names(model_)[state_.set];
  state.flexion_deg = deg_from_rad(readout_.pose.attitude.flexion_rad);
  if (state_.varus_rad) state.varus_deg = deg_from_rad(*state_.varus_rad);
  state.fixed = state_.fixed_object;
  const std::string name = view::view_names()[static_cast<std::size_t>(view_)];
  const bool is_named = gaze_.camera.X_world_camera.matrix() == X_world_framed_.matrix() &&
                        view_ != view::View::left && view_ != view::View::right &&
                        view_ != view::View::inverted;
  state.view = name;
  if (!is_named) state.place = place_of(gaze_);
  state.whole = framing_ == view::Framing::all;
  state.labels = state_.layers.has(view::Layer::labels);
  state.band = state_.layers.has(view::Layer::band);
  state.section = state_.section;
  const view::Looks& looks = joint_.looks();
  for (std::size_t k = 0; k < looks.of.size(); ++k) {
    const view::Structure& structure = joint_.structures()[k];
    const view::Layer layer = view::layer_of(structure);
    view::StructureLook look = looks.of[k];
    const bool is_contact = structure.group == view::StructureGroup::contact;
    look.is_visible = layer == view::Layer::bodies
                          ? look.is_visible
                          : (is_contact || look.is_visible) && state_.layers.has(layer);
    if (look != view::StructureLook{!is_contact, 1.0F}) state.structures.emplace_back(structure.id, look);
  }
  if (looks.highlighted) state.highlighted = joint_.structures()[*looks.highlighted].id;
  return state;
}

void Session::show_message(const std::string& message)
{
  message_ = message;
  message_left_s_ = session_message_s;
}

void Session::take_key(const view::InputEvent& event)
{
  const std::optional<view::KeyPress> press = key_press_of(event);
  const bool is_held = event.key == held_key_;
  held_key_ = event.key;
  if (press && (!is_held || view::repeats_while_held(view::action_of(*press)))) press_key(*press);
}

void Session::take(const view::InputEvent& event)
{
  const Eigen::Vector2d pointer_px(event.x_px, event.y_px);
  const bool is_left = event.button == view::MouseButton::left;
  n_frames_due_ = frames_after_input;
  // A pointer that moves without a button, and a new focus, change the interface at most.
  const bool is_pointer_free =
      event.kind == view::InputKind::motion && !pointer_.is_left_down && !navigation_.is_dragging();
  const bool is_focus = event.kind == view::InputKind::redraw || event.kind == view::InputKind::focus_lost;
  if (!is_pointer_free && !is_focus) is_disturbed_ = true;
  switch (event.kind) {
    case view::InputKind::motion:
      break;
    case view::InputKind::press:
      if (is_left) pointer_.is_left_down = was_left_pressed_ = true;
      break;
    case view::InputKind::release:
      if (is_left) pointer_.is_left_down = false;
      break;
    case view::InputKind::wheel:
      if (!is_over_picture(pointer_px)) pointer_.wheel += event.wheel;
      break;
    case view::InputKind::focus_lost:
      held_key_ = view::Key::none;
      pointer_.is_left_down = false;
      break;
    case view::InputKind::key_press:
      return take_key(event);
    case view::InputKind::key_release:
      if (event.key == held_key_) held_key_ = view::Key::none;
      return;
    default:
      return;
  }
  pointer_.x_px = pointer_px.x();
  pointer_.y_px = pointer_px.y();
  // A press that is released where it began is a touch; one that moves turns the joint.
  constexpr double still_px = 5.0;
  if (press_px_ && (pointer_px - *press_px_).norm() > still_px) press_px_.reset();
  if (event.kind == view::InputKind::press)
    press_px_ = is_left && event.n_clicks == 1 && is_over_picture(pointer_px) ? std::optional(pointer_px)
                                                                              : std::nullopt;
  if (event.kind == view::InputKind::release && is_left && press_px_) {
    press_px_.reset();
    touch(pointer_px);
  }
  // The wheel acts where the pointer is, a drag also beyond the picture.
  const bool is_dragging = navigation_.is_dragging() && event.kind != view::InputKind::wheel;
  if (is_dragging || is_over_picture(pointer_px))
    gaze_ = navigation_.after(event, gaze_, scene(), pane(pointer_px));
}

namespace {

bool is_reached(double wanted_rad, double shown_rad)
{
  constexpr double rounding_rad = 1e-9;
  return std::abs(wanted_rad - shown_rad) < rounding_rad;
}

/// Message that names the requested angles that were clamped; empty if none was.
std::string clamping_message(const SessionOptions& requested, const Session& session)
{
  const view::Timeline& timeline = session.state().timeline;
  const bool is_flexion_shown = !requested.flexion_rad || timeline.axis == view::TimelineAxis::frames ||
                                is_reached(*requested.flexion_rad, timeline.position);
  const bool is_varus_shown =
      !requested.varus_rad || is_reached(*requested.varus_rad, session.pose().attitude.varus_rad);
  if (is_flexion_shown && is_varus_shown) return {};
  if (!is_varus_shown && session.is_varus_free()) return "varus was free: the solved varus is shown";
  const std::string which = is_varus_shown ? "flexion" : is_flexion_shown ? "varus" : "flexion and varus";
  return "the requested " + which + (is_varus_shown || is_flexion_shown ? " is" : " are") +
         " outside the grid's range";
}

}  // namespace

ShownModel::ShownModel(const std::string& file, store::MotionModel model, const SessionOptions& options,
                       view::Renderer& renderer)
    : options_(options), renderer_(renderer), file_(file)
{
  show(std::move(model), options);
}

void ShownModel::show(store::MotionModel model, const SessionOptions& options)
{
  SessionOptions own = options;
  own.title = model.title;
  own.width = renderer_.width();
  own.height = renderer_.height();
  auto made = std::make_unique<Session>(std::move(model), own);
  made->load_into(renderer_);
  session_ = std::move(made);
  title_ = own.title;
  const std::string remark = clamping_message(own, *session_);
  if (!remark.empty()) session_->show_message(remark);
}

bool ShownModel::open(const std::string& file)
{
  const auto refused = catch_input_error([&] {
    store::MotionModel model = store::read_motion_model(file);
    SessionOptions own = options_;
    const std::vector<std::string> names = store::all_set_names(model);
    if (std::ranges::find(names, own.set) == names.end()) own.set = store::default_motion(model).set;
    show(std::move(model), own);
    file_ = file;
  });
  if (refused) session_->show_message(refused->what());
  return !refused;
}

std::string number_text(double value)
{
  std::string text = shortest_decimal(value);
  if (text.find_first_of(".ein") == std::string::npos) text += ".0";
  return text;
}

std::string list_text(std::span<const double> values)
{
  std::string text = "[";
  for (const double value : values) text += (text.size() > 1 ? ", " : "") + number_text(value);
  return text + "]";
}

// The mode `show` in a window.

namespace {

constexpr double paused_wait_s = 0.25;         // saves work while nothing changes
constexpr double least_frame_s = 1.0 / 120.0;  // limit without vertical synchronisation

void require_window_options(const ShowOptions& options)
{
  if (!options.trace.empty()) {
    throw InputError(
        {"--trace", "", "no --offscreen and no --video", "either of them: a window cannot show a trace"});
  }
  if (!options.views.empty() && view::parsed_views(options.views).size() > 1)
    throw InputError({"--views", "", options.views, "one view: the window starts with it"});
}

SessionOptions session_options(const ShowOptions& options, const store::MotionModel& model,
                               const std::string& set)
{
  const ResolvedPictures look = resolved_pictures(options, model);
  SessionOptions session;
  session.set = set;
  if (const std::optional<view::View> view = view::view_named(look.views.front().name)) {
    session.view = *view;
  } else {
    session.job_view = look.views.front();
  }
  session.zoom = look.zoom;
  if (options.flexion)
    session.flexion_rad = rad_from_deg(view::parsed_angles("--flexion", *options.flexion).first_deg);
  if (options.frame) session.key = view::parsed_angles("--key", *options.frame).first_deg;
  if (options.varus_deg) session.varus_rad = rad_from_deg(*options.varus_deg);
  session.backdrop = options.backdrop;
  session.fixed_object = options.fixed_object;
  session.appearance = look.appearance;
  session.section = options.section;
  session.state = options.state;
  session.other = options.other;
  session.framing = options.framing;
  session.width = look.size.width;
  session.height = look.size.height;
  return session;
}

/// In the current folder: knee_flexion_040.png, then knee_flexion_040_2.png.
std::string picture_name(const std::string& file, double flexion_rad, std::size_t number)
{
  const std::string stem = std::filesystem::path(file).stem().string() + "_flexion_" +
                           view::angle_label(std::round(deg_from_rad(flexion_rad)), {});
  return stem + (number == 1 ? "" : "_" + std::to_string(number)) + ".png";
}

view::WindowOptions window_options(const ShowOptions& options, const SessionOptions& session)
{
  view::WindowOptions window;
  window.width = session.width;
  window.height = session.height;
  window.samples = options.samples;
  return window;
}

/// Of the monitor that the window is on.
double text_scale(const view::Window& window)
{
  return std::clamp(window.content_scale(), 1.0, 4.0);
}

/// Runs a session in a window and opens dropped files.
class ShowMode final : public Mode {
 public:
  ShowMode(const ShowOptions& options, store::MotionModel model, const SessionOptions& session, Sink& sink)
      : sink_(sink),
        shown_(options.file, std::move(model), session, sink.renderer()),
        has_moving_quality_(options.samples == 0 && session.is_plain_while_moving)
  {
    set_title();
  }

  bool is_over() const override { return shown_.session().state().is_done; }

  RoundTime round_time() const override
  {
    return {sink_.is_hidden() || shown_.session().is_idle() ? paused_wait_s : least_frame_s};
  }

  void take(const view::InputEvent& event) override
  {
    shown_.session().take(event);
    const std::vector<std::string>& dropped = sink_.window()->dropped_files();
    // Only the first of several dropped files is opened.
    if (event.kind == view::InputKind::drop && !dropped.empty() && shown_.open(dropped.front())) set_title();
  }

  void advance(double elapsed_s) override
  {
    Session& session = shown_.session();
    session.set_scale(text_scale(*sink_.window()), sink_.renderer());
    session.resize(sink_.renderer().width(), sink_.renderer().height());
    session.advance(elapsed_s);
    if (session.consume_screenshot_request()) save_picture();
    if (session.consume_save_request()) save_view();
    view::Window& window = *sink_.window();
    if (const bool is_full = window.is_full_screen(); session.consume_full_screen_request(is_full) != is_full)
      window.toggle_full_screen();
  }

  void draw() override
  {
    const Session& session = shown_.session();
    if (has_moving_quality_) sink_.renderer().set_samples(session.is_plain() ? 1 : samples_at_rest);
    if (session.has_same_picture() && sink_.show_again(&session.overlay())) return;
    sink_.show({session.scene(), session.shots(), &session.overlay()});
  }

 private:
  void set_title()
  {
    sink_.window()->set_title((shown_.title().empty() ? shown_.file() : shown_.title()) + " - vrda-player");
  }

  void save_picture()
  {
    Session& session = shown_.session();
    if (has_moving_quality_) sink_.renderer().set_samples(samples_at_rest);
    std::string name;
    const auto refused = catch_input_error([&] {
      const view::Image& image = session.draw_screenshot(sink_.renderer());
      const double flexion_rad = session.pose().attitude.flexion_rad;
      name = write_with_free_name(
          [&](std::size_t number) { return picture_name(shown_.file(), flexion_rad, number); },
          [&](const std::string& free) { view::write_png(image, free); });
    });
    session.show_message(refused ? refused->what() : "image written: " + name);
  }

  void save_view()
  {
    Session& session = shown_.session();
    std::string name;
    const auto refused = catch_input_error([&] {
      const std::string stem = std::filesystem::path(shown_.file()).stem().string() + "_view";
      name = write_with_free_name(
          [&](std::size_t number) {
            return stem + (number == 1 ? "" : "_" + std::to_string(number)) + ".json";
          },
          [&](const std::string& free) { write_atomically(free, {view_state_text(session.view_state())}); });
    });
    session.show_message(refused ? refused->what() : "state of the view written: " + name);
  }

  Sink& sink_;
  ShownModel shown_;
  bool has_moving_quality_;  ///< one sample per pixel while something moves, else samples_at_rest
};

}  // namespace

void show_in_window(const ShowOptions& options, store::MotionModel model, const std::string& set)
{
  require_window_options(options);
  SessionOptions chosen = session_options(options, model, set);
  Sink sink(window_options(options, chosen));
  chosen.is_plain_while_moving = sink.window()->is_software_rendered();
  chosen.scale = text_scale(*sink.window());
  ShowMode mode(options, std::move(model), chosen, sink);
  StopSignals stop;
  run_loop(mode, sink, stop);
}

}  // namespace vrda::show
