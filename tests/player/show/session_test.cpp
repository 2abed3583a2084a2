// The session without a window: events in, state and image out; the text of settings.
#include <gtest/gtest.h>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "core/document.hpp"
#include "show/session.hpp"
#include "store/motion_model.hpp"
#include "support/models.hpp"
#include "support/scratch.hpp"

namespace vrda::show::session_test {

constexpr double frame_s = 1.0 / 60.0;
constexpr int width = 800, height = 600;

/// Flexion 0 to 30 by 10, varus -1 to 1; the cell at 20 degrees, varus 1 is unsolved.
store::MotionModel small_model(double mm_deg = 0.1)
{
  test::ModelPlan plan;
  plan.flexion_deg = {0, 10, 20, 30};
  plan.varus_deg = {-1, 0, 1};
  plan.motion = [mm_deg](double flexion_deg, double) {
    return store::PoseCoordinates{0, mm_deg * flexion_deg, 0, flexion_deg};
  };
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  test::unsolve(model, 2, 2);
  test::add_smoothed(model, 1, [](int i, int) { return store::PoseCoordinates{0.0, 0.0, 0.0, 2.0 * i}; });
  return model;
}

SessionOptions small_options(const std::string& set = "raw")
{
  SessionOptions options;
  options.set = set;
  options.title = "small";
  options.width = width;
  options.height = height;
  return options;
}

view::InputEvent pointer_event(view::InputKind kind, double x_px, double y_px)
{
  return {.kind = kind, .x_px = x_px, .y_px = y_px, .button = view::MouseButton::left};
}

/// A session with the hands of a user.
class UsedSession {
 public:
  explicit UsedSession(const SessionOptions& options = small_options(),
                       const store::MotionModel& model = small_model())
      : session_(model, options)
  {
  }

  void take(const std::vector<view::InputEvent>& events)
  {
    for (const view::InputEvent& event : events) session_.take(event);
    session_.advance(frame_s);
  }
  void key(view::Key code, bool has_shift = false)
  {
    view::InputEvent event;
    event.kind = view::InputKind::key_press;
    event.key = code;
    event.has_shift = has_shift;
    view::InputEvent release = event;
    release.kind = view::InputKind::key_release;
    take({event, release});
  }
  void key(char character, bool has_shift = false) { key(view::key_of(character), has_shift); }
  void drag(const Eigen::Vector2d& from, const Eigen::Vector2d& to)
  {
    take({pointer_event(view::InputKind::press, from.x(), from.y()),
          pointer_event(view::InputKind::motion, to.x(), to.y())});
    take({pointer_event(view::InputKind::release, to.x(), to.y())});
  }
  double flexion_deg() const { return deg_from_rad(session_.pose().attitude.flexion_rad); }
  Eigen::Matrix4d camera() const { return session_.orbit_camera().camera.X_world_camera.matrix(); }

  Session session_;
};

class AtWindow : public UsedSession, public testing::Test {};

TEST_F(AtWindow, QuestionMark)
{
  key('/');
  EXPECT_FALSE(session_.state().shows_help);
  key('/', true);
  EXPECT_TRUE(session_.state().shows_help);
}

TEST_F(AtWindow, HeldKey)
{
  view::InputEvent held;
  held.kind = view::InputKind::key_press;
  held.key = view::Key::right;
  take({held, held, held});
  EXPECT_NEAR(flexion_deg(), 3.0, 1e-9);
  held.key = view::key_of(' ');
  take({held, held});
  EXPECT_TRUE(session_.state().timeline.is_playing);
  view::InputEvent release = held;
  release.kind = view::InputKind::key_release;
  take({release, held});
  EXPECT_FALSE(session_.state().timeline.is_playing);
}

TEST_F(AtWindow, PosesOfEachSet)
{
  const store::MotionModel model = small_model();
  for (const std::string& name : store::all_set_names(model)) {
    Session session(small_model(), small_options(name));
    session.press_key({view::Key::right, true, false});
    session.advance(frame_s);
    const store::Motion motion(model, name);
    const double flexion_rad = rad_from_deg(10.0);
    const store::JointPose expected = motion.at({flexion_rad, motion.balanced_varus_rad(flexion_rad)});
    EXPECT_EQ(session.pose().X_world_moving.matrix(), expected.X_world_moving.matrix()) << name;
  }
}

// Without a pose only the fixed object is drawn and the text says so.
TEST_F(AtWindow, MissingPose)
{
  key(view::Key::up);
  key(view::Key::right, true);
  EXPECT_TRUE(session_.scene().drawables[0].is_shown && session_.scene().drawables[1].is_shown);
  key(view::Key::right, true);
  EXPECT_EQ(session_.pose().status, store::PoseStatus::unsolved_cell);
  EXPECT_FALSE(session_.scene().drawables[0].is_shown);
  EXPECT_TRUE(session_.scene().drawables[1].is_shown);
  EXPECT_STREQ(session_.doubt(),
               "no pose at 20 degrees: a neighbouring attitude is unsolved; only the tibia is drawn");
  key('O');
  session_.advance(frame_s);
  EXPECT_TRUE(session_.scene().drawables[0].is_shown);
  EXPECT_FALSE(session_.scene().drawables[1].is_shown);
  key(view::Key::down);
  EXPECT_EQ(session_.pose().status, store::PoseStatus::solved);
  EXPECT_TRUE(session_.scene().drawables[1].is_shown);
  EXPECT_STREQ(session_.doubt(), "");
}

// Text and controls are those of the monitor that the window is on.
TEST_F(AtWindow, ScaleOfTheMonitor)
{
  const std::unique_ptr<view::Renderer> renderer = view::make_offscreen_renderer({width, height});
  const int panel_px = width - session_.shots()[0].viewport.width;
  session_.set_scale(2.0, *renderer);
  session_.advance(frame_s);
  EXPECT_EQ(width - session_.shots()[0].viewport.width, 2 * panel_px);
}

TEST_F(AtWindow, DragFromThePanel)
{
  const Eigen::Matrix4d at_first = camera();
  drag({700, 590}, {300, 300});
  EXPECT_EQ(camera(), at_first);
  drag({300, 300}, {700, 300});
  EXPECT_NE(camera(), at_first);
}

TEST_F(AtWindow, Wheel)
{
  const double before_mm = view::depth_mm(session_.orbit_camera());
  view::InputEvent wheel = pointer_event(view::InputKind::wheel, 700, 300);
  wheel.wheel = 2.0;
  take({wheel});
  EXPECT_EQ(view::depth_mm(session_.orbit_camera()), before_mm);
  wheel.x_px = 300;
  take({wheel});
  EXPECT_NEAR(view::depth_mm(session_.orbit_camera()), 0.81 * before_mm, 1e-9);
}

TEST_F(AtWindow, DoubleClick)
{
  // The joint covers the middle of the free area and the point 40 pixels to its right.
  const view::Viewport free = session_.shots()[0].viewport;
  const Eigen::Vector2d beside(free.x + 0.5 * free.width + 40.0, free.y + 0.5 * free.height);
  const std::optional<Eigen::Vector3d> point =
      view::point_under(session_.scene(), session_.orbit_camera().camera, free, beside);
  ASSERT_TRUE(point.has_value());
  view::InputEvent click = pointer_event(view::InputKind::press, beside.x(), beside.y());
  click.n_clicks = 2;
  take({click, pointer_event(view::InputKind::release, beside.x(), beside.y())});
  EXPECT_LE((session_.orbit_camera().pivot_world_mm - *point).norm(), 1e-9);
  const Eigen::Vector3d seen = session_.orbit_camera().camera.X_world_camera.inverse() * *point;
  EXPECT_NEAR(seen.x(), 0.0, 1e-9);
  EXPECT_NEAR(seen.y(), 0.0, 1e-9);
}

// A click highlights what is there, a second one no longer; a drag does not; keys change what is shown.
TEST_F(AtWindow, TouchedStructure)
{
  const view::Viewport free = session_.shots()[0].viewport;
  const Eigen::Vector2d middle(free.x + 0.5 * free.width, free.y + 0.5 * free.height);
  const auto click = [&] {
    take({pointer_event(view::InputKind::press, middle.x(), middle.y()),
          pointer_event(view::InputKind::release, middle.x(), middle.y())});
  };
  const auto highlighted = [&] { return session_.view_state().highlighted; };
  drag(middle, middle + Eigen::Vector2d(30, 0));
  EXPECT_EQ(highlighted(), "");
  key('6');
  click();
  EXPECT_EQ(highlighted(), "bodies/reference/ball");
  click();
  EXPECT_EQ(highlighted(), "");
  click();
  key('Z');
  ASSERT_EQ(session_.view_state().structures.size(), 1U);
  EXPECT_EQ(session_.view_state().structures[0].first, "bodies/reference/ball");
  EXPECT_FALSE(session_.view_state().structures[0].second.is_visible);
  click();
  EXPECT_NE(highlighted(), "bodies/reference/ball") << "what is behind it";
  key('Z', true);
  EXPECT_TRUE(session_.view_state().structures.empty());
}

// The second joint minus the first: varus by the given angle, bands of both models about no difference.
TEST(Comparison, Differences)
{
  store::MotionModel model = small_model();
  const store::Motion motion(model, "raw");
  const std::size_t n = model.flexion_deg.size();
  store::UncertainMotion& bands = model.uncertainty.emplace();
  bands.rotation_band_deg.assign(5 * n * 3, 0.0);
  bands.translation_band_mm.assign(5 * n * 3, 0.0);
  const auto numbers = [&](std::size_t i, double varus_deg) {
    const store::JointPose pose = motion.at({rad_from_deg(model.flexion_deg[i]), rad_from_deg(varus_deg)});
    return clinical_coordinates(pose.X_reference_moving, Side::right, model.rotation_centre_mm);
  };
  for (std::size_t i = 0; i < n; ++i) {
    bands.rotation_band_deg[3 * (1 * n + i) + 1] = deg_from_rad(numbers(i, 0.0).varus_rad) - 3.0;
    bands.rotation_band_deg[3 * (3 * n + i) + 1] = deg_from_rad(numbers(i, 0.0).varus_rad) + 4.0;
  }
  ComparisonOptions options;
  options.set = "raw";
  options.varus_deg = 0.0;
  Comparison same(model, options, {}, view::Backdrop::studio);
  const view::CurveLine& varus = same.differences(motion, 0.0).plots[0].lines[0];
  EXPECT_EQ(varus.values.front(), 0.0F);
  EXPECT_NEAR(varus.low.front(), -3.0 * std::sqrt(2.0), 1e-5);
  EXPECT_NEAR(varus.high.front(), 4.0 * std::sqrt(2.0), 1e-5);
  options.varus_deg = -1.0;
  Comparison other(model, options, {}, view::Backdrop::studio);
  const view::Differences& found = other.differences(motion, 0.0);
  for (const auto& [k, i] : {std::pair<std::size_t, std::size_t>{0, 0}, {60, n - 1}}) {
    const ClinicalCoordinates own = numbers(i, -1.0), first = numbers(i, 0.0);
    EXPECT_NEAR(found.plots[0].lines[0].values[k], deg_from_rad(own.varus_rad - first.varus_rad), 1e-4);
    EXPECT_NEAR(found.plots[1].lines[0].values[k], own.anterior_mm - first.anterior_mm, 1e-4);
  }
  // A second model, which moves up by 0.2 mm more at each degree.
  ComparisonOptions of_file;
  of_file.set = "raw";
  of_file.file = "second.h5";
  of_file.model = std::make_shared<const store::MotionModel>(small_model(0.3));
  Comparison with_file(model, of_file, {}, view::Backdrop::studio);
  const std::vector<view::CurveLine>& moved = with_file.differences(motion, 0.0).plots[1].lines;
  EXPECT_NEAR(Eigen::Vector3f(moved[0].values[60], moved[1].values[60], moved[2].values[60]).norm(), 6.0,
              1e-4);
  EXPECT_EQ(found.plots[0].lines[0].name, "varus");
  EXPECT_EQ(found.plots[1].lines[0].name, "anterior");
}

// Of two joints that differ by 6 mm at the last flexion, each has its own names.
TEST(Comparison, Names)
{
  const store::MotionModel model = small_model();
  const store::Motion motion(model, "raw");
  ComparisonOptions options;
  options.set = "raw";
  options.file = "second.h5";
  options.model = std::make_shared<const store::MotionModel>(small_model(0.3));
  JointView first(model, {}, view::Backdrop::studio);
  Comparison other(model, options, {}, view::Backdrop::studio);
  const store::JointPose pose = motion.at({rad_from_deg(model.flexion_deg.back()), 0.0});
  view::CameraFit fit(view::view_rotation(view::View::oblique, Side::right));
  fit.include(first.framed_points(pose, view::Framing::all));
  const view::LayerSet layers = view::parsed_layers("labels");
  first.show(motion, pose, layers);
  other.show(first, pose, 0.0, layers);
  std::vector<view::Shot> shots;
  other.add_shots(shots, fit.camera(), {0, 0, 800, 600});
  const std::span<const view::ScreenLabel> labels = other.labels(first, shots);
  const std::size_t n = labels.size() / 2;
  double most_mm = 0.0;
  for (std::size_t k = 0; k < n; ++k) {
    EXPECT_EQ(labels[k].text, labels[n + k].text);
    EXPECT_EQ(labels[n + k].picture, shots[1].viewport);
    if (labels[k].is_shown && labels[n + k].is_shown)
      most_mm = std::max(most_mm, (labels[n + k].anchor_world_mm - labels[k].anchor_world_mm).norm());
  }
  EXPECT_GT(most_mm, 3.0);
}

// In two halves with one camera, of which the right one has the second joint; a touch there counts.
TEST(Comparison, InTheWindow)
{
  SessionOptions options = small_options();
  options.other.varus_deg = 0.5;
  UsedSession used(options);
  const std::span<const view::Shot> shots = used.session_.shots();
  ASSERT_EQ(shots.size(), 2U);
  EXPECT_EQ(shots[0].viewport.width, shots[1].viewport.width);
  EXPECT_EQ(shots[0].camera.X_world_camera.matrix(), shots[1].camera.X_world_camera.matrix());
  EXPECT_TRUE(shots[0].has_own && !shots[0].has_other && !shots[1].has_own && shots[1].has_other);
  ASSERT_NE(used.session_.scene().other, nullptr);
  EXPECT_NE(used.session_.scene().other->drawables[0].X_world_mesh.matrix(),
            used.session_.scene().drawables[0].X_world_mesh.matrix());
  const view::Viewport right = shots[1].viewport;
  const Eigen::Vector2d middle(right.x + 0.5 * right.width, right.y + 0.5 * right.height);
  used.key('6');
  used.take({pointer_event(view::InputKind::press, middle.x(), middle.y()),
             pointer_event(view::InputKind::release, middle.x(), middle.y())});
  EXPECT_EQ(used.session_.view_state().highlighted, "bodies/reference/ball");
}

// What one window writes another reads, and an address of the page has the same.
TEST_F(AtWindow, StateOfTheView)
{
  key(view::Key::right, true);
  key('O');
  key('W');
  key('9');
  key('.');
  key('.');
  key('7');
  key('D');
  drag({200, 200}, {260, 230});
  const std::string text = view_state_text(session_.view_state());
  const ViewState read = read_view_state(text);
  EXPECT_EQ(view_state_text(read), text);
  EXPECT_EQ(read.section.kind, view::SectionKind::sagittal);
  EXPECT_EQ(read.section.at_mm, 1.0);
  ASSERT_TRUE(read.place.has_value());
  SessionOptions options = small_options();
  options.state = read;
  options.section = read.section;
  options.fixed_object = read.fixed;
  options.flexion_rad = rad_from_deg(read.flexion_deg);
  options.appearance.layers = "ligaments,labels";
  UsedSession other(options);
  EXPECT_EQ(view_state_text(other.session_.view_state()), text);
  EXPECT_GT(std::abs(read.place->roll_deg), 5.0);
  EXPECT_LT((other.camera() - camera()).cwiseAbs().maxCoeff(), 1e-3) << "mm, as rounded in the file";
  std::string address = "http://127.0.0.1/#step=2&view=";
  for (const char c : text) {
    char escaped[4];
    std::snprintf(escaped, sizeof escaped, "%%%02X", static_cast<unsigned>(static_cast<unsigned char>(c)));
    address += c == ' ' ? "+" : escaped;
  }
  EXPECT_EQ(view_state_text(read_view_state(address)), text);
}

// A camera at (0, 0, 100) that looks at the origin and rolls to its up; from above its right is Z.
TEST(CameraPlace, Roll)
{
  for (const double roll_deg : {0.0, 30.0, -90.0, 170.0}) {
    SCOPED_TRACE(roll_deg);
    const double c = std::cos(rad_from_deg(roll_deg)), s = std::sin(rad_from_deg(roll_deg));
    view::OrbitCamera gaze;
    gaze.camera.X_world_camera.translation() << 0, 0, 100;
    gaze.camera.X_world_camera.linear() << c, -s, 0, s, c, 0, 0, 0, 1;
    const CameraPlace front = place_of(gaze);
    EXPECT_NEAR(front.roll_deg, roll_deg, 1e-9);
    EXPECT_LT(front.target_mm.norm(), 1e-9);
    const auto error = [&] {
      return (placed({}, place_of(gaze)).X_world_camera.matrix() - gaze.camera.X_world_camera.matrix())
          .norm();
    };
    EXPECT_LT(error(), 1e-9);
    gaze.camera.X_world_camera.translation() << 0, 100, 0;
    gaze.camera.X_world_camera.linear() << s, c, 0, 0, 0, 1, c, -s, 0;
    EXPECT_NEAR(place_of(gaze).roll_deg, roll_deg, 1e-9);
    EXPECT_LT(error(), 1e-9);
  }
}

TEST_F(AtWindow, ALostFocusEndsADrag)
{
  take({pointer_event(view::InputKind::press, 200, 200)});
  view::InputEvent lost;
  lost.kind = view::InputKind::focus_lost;
  take({lost});
  const Eigen::Matrix4d before = camera();
  take({pointer_event(view::InputKind::motion, 300, 300)});
  EXPECT_EQ(camera(), before);
}

// Screenshot full screen and quit are requested once.
TEST_F(AtWindow, Requests)
{
  EXPECT_FALSE(session_.consume_screenshot_request());
  key('P');
  EXPECT_TRUE(session_.consume_screenshot_request());
  EXPECT_FALSE(session_.consume_screenshot_request());
  key(view::Key::f11);
  EXPECT_TRUE(session_.consume_full_screen_request(false));
  EXPECT_TRUE(session_.consume_full_screen_request(true));
  key(view::Key::f11);
  EXPECT_FALSE(session_.consume_full_screen_request(true));
  EXPECT_FALSE(session_.state().is_done);
  key('Q');
  EXPECT_TRUE(session_.state().is_done);
}

// Escape closes what is open, one at a time: an open menu, the help page, then full screen; never the window.
TEST_F(AtWindow, EscapeClosesWhatIsOpen)
{
  EXPECT_TRUE(session_.consume_full_screen_request(true));
  key(view::Key::escape);
  EXPECT_FALSE(session_.consume_full_screen_request(true));
  key('H');
  EXPECT_TRUE(session_.state().shows_help);
  key(view::Key::escape);
  EXPECT_FALSE(session_.state().shows_help);
  EXPECT_TRUE(session_.consume_full_screen_request(true));
  key(view::Key::escape);
  EXPECT_FALSE(session_.consume_full_screen_request(false));
  EXPECT_FALSE(session_.state().is_done);
}

TEST_F(AtWindow, Idle)
{
  key(view::Key::right);
  EXPECT_FALSE(session_.is_idle());
  for (int i = 0; i < 4; ++i) session_.advance(frame_s);
  EXPECT_TRUE(session_.is_idle());
  session_.show_message("for a while");
  EXPECT_FALSE(session_.is_idle());
  session_.advance(10.0);
  EXPECT_TRUE(session_.is_idle());
  key(' ');
  for (int i = 0; i < 10; ++i) session_.advance(frame_s);
  EXPECT_FALSE(session_.is_idle());
}

// Another size changes the aspect and not the view.
TEST_F(AtWindow, Resize)
{
  const Eigen::Matrix4d before = camera();
  session_.resize(1280, 500);
  session_.advance(frame_s);
  const view::Shot& shot = session_.shots()[0];
  EXPECT_EQ(camera(), before);
  EXPECT_EQ(shot.camera.aspect, static_cast<double>(shot.viewport.width) / shot.viewport.height);
  session_.resize(1, 1);
  session_.advance(frame_s);
  EXPECT_EQ(session_.shots()[0].viewport.width, 1);
}

// Files dropped on the window: a valid one is opened, otherwise one message is shown and the model stays.

store::MotionModel titled(const std::string& title)
{
  store::MotionModel model = test::model_of({});
  model.title = title;
  test::add_bodies(model);
  return model;
}

class Dropped : public testing::Test {
 protected:
  static SessionOptions small()
  {
    SessionOptions options;
    options.set = "raw";
    return options;
  }
  test::Scratch scratch_;
  std::unique_ptr<view::Renderer> renderer_ = view::make_offscreen_renderer({320, 240, 1});
  ShownModel shown_{"first.h5", titled("first"), small(), *renderer_};
};

TEST_F(Dropped, AMotionModelIsShown)
{
  const std::string file = (scratch_.path() / "second.h5").string();
  store::MotionModel second = titled("second");
  test::add_smoothed(second, 1, [](int i, int) { return store::PoseCoordinates{0.0, 0.0, 0.0, 2.0 * i}; });
  store::write_motion_model(file, second);
  EXPECT_TRUE(shown_.open(file));
  EXPECT_EQ(shown_.title(), "second");
  EXPECT_EQ(shown_.file(), file);
  shown_.session().advance(frame_s);
  renderer_->present(shown_.session().scene(), shown_.session().shots(), &shown_.session().overlay());
  EXPECT_EQ(shown_.session().pose().status, store::PoseStatus::solved);
}

// Anything else is one message and the joint stays.
TEST_F(Dropped, OtherFiles)
{
  const Session* before = &shown_.session();
  for (const std::string& file :
       {scratch_.write("notes.h5", "no motion model").string(), scratch_.write("empty.h5", "").string(),
        (scratch_.path() / "absent.h5").string(), scratch_.path().string()}) {
    SCOPED_TRACE(file);
    EXPECT_FALSE(shown_.open(file));
    EXPECT_EQ(&shown_.session(), before);
    EXPECT_FALSE(shown_.session().is_idle());  // the message is displayed for some seconds
  }
  EXPECT_EQ(shown_.title(), "first");
  EXPECT_EQ(shown_.file(), "first.h5");
}

TEST(ShownAttitude, OutsideTheRange)
{
  const std::unique_ptr<view::Renderer> renderer = view::make_offscreen_renderer({320, 240, 1});
  struct Row {
    std::optional<double> flexion_deg, varus_deg;
    bool names_flexion, names_varus;
  };
  const double within_deg = 1.0, beyond_deg = 170.0;
  for (const Row& row :
       {Row{{}, {}, false, false}, Row{within_deg, 0.0, false, false}, Row{beyond_deg, 0.0, true, false},
        Row{within_deg, beyond_deg, false, true}, Row{beyond_deg, -beyond_deg, true, true}}) {
    SessionOptions options;
    options.set = "raw";
    if (row.flexion_deg) options.flexion_rad = rad_from_deg(*row.flexion_deg);
    if (row.varus_deg) options.varus_rad = rad_from_deg(*row.varus_deg);
    ShownModel shown("first.h5", titled("first"), options, *renderer);
    const std::string& message = shown.session().last_message();
    EXPECT_EQ(message.empty(), !row.names_flexion && !row.names_varus) << message;
    EXPECT_EQ(message.find("flexion") != std::string::npos, row.names_flexion) << message;
    EXPECT_EQ(message.find("varus") != std::string::npos, row.names_varus) << message;
  }
}

TEST(SessionOfFrames, Timeline)
{
  SessionOptions options = small_options();
  options.key = 0.5;
  UsedSession used(options, test::small_sequence());
  EXPECT_EQ(used.session_.pose().key, 0.5);
  EXPECT_NEAR(used.flexion_deg(), 0.0, 1e-9);
  used.key(view::Key::right);
  EXPECT_EQ(used.session_.pose().key, 1.0);
  EXPECT_NEAR(used.flexion_deg(), 30.0, 1e-9);
  used.key(view::Key::right);
  used.key(view::Key::right);
  EXPECT_EQ(used.session_.pose().key, 2.0);
  EXPECT_NEAR(used.flexion_deg(), 10.0, 1e-9);
  EXPECT_EQ(used.session_.state().timeline.last, 3.0);
}

// Starts and resets with the jobs view until one is chosen.
TEST(Session, JobView)
{
  SessionOptions options = small_options();
  const Session plain(small_model(), options);
  options.job_view =
      view::turned_view("view 2", {0.0, rad_from_deg(90.0), 0.0}, {10.0, 0.0, 0.0}, Side::right);
  options.zoom = 2.0;
  UsedSession used(options);
  const auto tangent = [](const Session& session) {
    return session.orbit_camera().camera.half_height_tangent;
  };
  const Eigen::Matrix4d start = used.camera();
  const double zoomed = tangent(used.session_);
  EXPECT_TRUE(Eigen::Matrix3d(start.topLeftCorner<3, 3>()).isApprox(options.job_view->R_world_camera, 1e-12));
  used.drag({300.0, 300.0}, {360.0, 300.0});
  EXPECT_FALSE(used.camera().isApprox(start, 1e-6));
  used.key('R');
  EXPECT_TRUE(used.camera().isApprox(start, 1e-12));
  EXPECT_EQ(tangent(used.session_), zoomed);
  used.key('1');
  const Eigen::Matrix4d front = used.camera();
  EXPECT_FALSE(front.isApprox(start, 1e-6));
  used.key('R');
  EXPECT_TRUE(used.camera().isApprox(front, 1e-12)) << "the chosen view";
  EXPECT_NEAR(tangent(used.session_), tangent(plain), 1e-12);
}

TEST(Session, PlainWhileMoving)
{
  SessionOptions options = small_options();
  for (const bool is_plain : {true, false}) {
    options.is_plain_while_moving = is_plain;
    Session session(small_model(), options);
    session.advance(settle_s);
    const double at_rest_mm = session.scene().occlusion_radius_mm;
    EXPECT_GT(at_rest_mm, 0.0);
    session.take(pointer_event(view::InputKind::press, 300.0, 300.0));
    session.take(pointer_event(view::InputKind::motion, 320.0, 300.0));
    session.advance(frame_s);
    EXPECT_EQ(session.is_plain(), is_plain);
    EXPECT_EQ(session.scene().occlusion_radius_mm, is_plain ? 0.0 : at_rest_mm);
    EXPECT_EQ(session.scene().has_vertex_lighting, is_plain);
    session.take(pointer_event(view::InputKind::release, 320.0, 300.0));
    session.advance(frame_s);
    EXPECT_FALSE(session.is_idle()) << "the picture at rest is due";
    session.advance(settle_s);
    EXPECT_FALSE(session.is_plain());
    EXPECT_EQ(session.scene().occlusion_radius_mm, at_rest_mm) << "in the first frame at rest";
    EXPECT_FALSE(session.scene().has_vertex_lighting);
    EXPECT_FALSE(session.is_idle()) << "which is drawn";
  }
}

TEST(Session, SamePicture)
{
  SessionOptions options = small_options();
  options.is_plain_while_moving = true;
  Session session(small_model(), options);
  const auto advance = [&](double elapsed_s) {
    session.advance(elapsed_s);
    return session.has_same_picture();
  };
  EXPECT_FALSE(advance(settle_s)) << "the first in full quality";
  EXPECT_TRUE(advance(frame_s));
  session.take(pointer_event(view::InputKind::motion, 320.0, 300.0));
  EXPECT_TRUE(advance(frame_s));
  session.take({.kind = view::InputKind::key_press, .key = view::Key::right});
  EXPECT_FALSE(advance(10.0)) << "after a wait for the key";
  EXPECT_TRUE(session.is_plain());
  EXPECT_FALSE(advance(settle_s));
  EXPECT_FALSE(session.is_plain());
  EXPECT_TRUE(advance(frame_s));
  session.resize(width + 10, height);
  EXPECT_FALSE(advance(frame_s));
}

constexpr double largest = std::numeric_limits<double>::max();

core::DocumentValue value_in(const std::string& text)
{
  return core::value_at(core::parse_toml("v = " + text, "a"), "v");
}

TEST(SettingsText, Numbers)
{
  std::mt19937_64 random(81);
  std::uniform_real_distribution<double> mantissa(-1.0, 1.0);
  std::uniform_int_distribution<int> exponent(-1074, 1023);
  std::vector<double> values{0.0, -0.0, 1.0, -3.0, 1e22, 1e300, 5e-324, 0.1, 1.0 / 3.0, largest, -largest};
  while (values.size() < 500) values.push_back(std::ldexp(mantissa(random), exponent(random)));
  for (const double value : values) {
    EXPECT_EQ(core::number_at(value_in(number_text(value)), ""), value) << number_text(value);
  }
  EXPECT_EQ(core::numbers_of(value_in(list_text(values))), values);
}

TEST(SettingsText, QuotedWordsReadBack)
{
  for (const std::string text : {"plain", "with \"quotes\" in it", "C:\\bench\\new",
                                 "knie gr\xc3\xbc\xc3\x9f", "# no comment", "'single'", "\\u0041", "]["}) {
    EXPECT_EQ(core::text_at(value_in(quoted_text(text)), ""), text);
  }
  // Escaped control characters are valid TOML, but rejected as settings.
  EXPECT_EQ(quoted_text("a\nb\x7f"), "\"a\\u000Ab\\u007F\"");
}

}  // namespace vrda::show::session_test
