#include "player/bench/bench_samples.hpp"

#include <random>

#include "core/framed_file.hpp"
#include "player/bench/bench_texts.hpp"
#include "store/solved_cells.hpp"
#include "support/models.hpp"

namespace vrda::test {
namespace {

bench::PoseParameters some_six(int number)
{
  return {{3.0 * number, 5.0 - number, 1.5 * number}, {0.1 * number, 0.02 * number, -0.07 * number}};
}

bench::Calibration calibration_of(const bench::BenchFile& bench)
{
  bench::Calibration c = bench::nominal_calibration(bench);
  for (std::size_t role = 0; role < bench::n_body_roles; ++role)
    c.X_body_model[role] = some_six(static_cast<int>(role) + 1);
  c.X_headbody_eyes = some_six(6);
  c.X_tracker_table = some_six(7);
  c.X_table_eyes.turn_rad = some_six(8).turn_rad;
  c.stage_direction_table = Eigen::Vector3d(3.0, 0.0, 4.0) / 5.0;
  return c;
}

}  // namespace

bench::Sample place_sample(std::uint16_t tool, const Pose& X_tracker_tool, std::int64_t device_ns,
                           std::int64_t arrival_ns)
{
  bench::Sample sample;
  sample.kind = bench::SampleKind::tool_pose;
  sample.state = static_cast<std::uint8_t>(bench::ToolVisibility::seen);
  sample.source = tool;
  sample.tool_pose = bench::place_of(X_tracker_tool);
  sample.device_ns = device_ns;
  sample.arrival_ns = arrival_ns;
  return sample;
}

bench::Sample hidden_sample(std::uint16_t tool, std::int64_t arrival_ns)
{
  bench::Sample sample = place_sample(tool, Pose::Identity(), 0, arrival_ns);
  sample.state = static_cast<std::uint8_t>(bench::ToolVisibility::missing);
  return sample;
}

bench::Sample potentiometer_sample(int count, std::int64_t arrival_ns)
{
  bench::Sample sample;
  sample.kind = bench::SampleKind::potentiometer;
  sample.count = count;
  sample.arrival_ns = arrival_ns;
  return sample;
}

bench::Sample stage_sample(int count, std::int64_t arrival_ns, std::uint8_t flags)
{
  bench::Sample sample = potentiometer_sample(count, arrival_ns);
  sample.kind = bench::SampleKind::stage;
  sample.state = flags;
  return sample;
}

bench::Sample link_sample(bench::DeviceId device, bench::LinkState state, std::int64_t arrival_ns)
{
  bench::Sample sample;
  sample.kind = bench::SampleKind::link;
  sample.source = static_cast<std::uint16_t>(device);
  sample.state = static_cast<std::uint8_t>(state);
  sample.arrival_ns = arrival_ns;
  return sample;
}

store::MotionModel bench_model(const std::string& side)
{
  ModelPlan plan;
  plan.side = side;
  plan.motion = [](double flexion_deg, double varus_deg) {
    return store::PoseCoordinates{0.02 * flexion_deg, -0.1 * varus_deg, 0.5, 0.1 * flexion_deg};
  };
  return model_of(plan);
}

SmallBench::SmallBench(const std::string& text, const std::string& side)
    : model(bench_model(side)),
      motion(model, "raw"),
      frame(store::solver_frame(model, 0)),
      bench(bench_of(text)),
      calibration(calibration_of(bench)),
      state(bench, calibration, motion, frame)
{
}

Pose SmallBench::X_body_model(bench::BodyRole role) const
{
  return bench::pose_of(calibration.X_body_model[static_cast<std::size_t>(role)]);
}

Pose SmallBench::X_tracker_shank(const Pose& X_tracker_thigh, const bench::LegAngles& angles) const
{
  return X_tracker_thigh * X_body_model(bench::BodyRole::femur) *
         bench::X_femur_tibia(angles, frame, {1, 2, 3}) * X_body_model(bench::BodyRole::tibia).inverse();
}

void SmallBench::take_leg(const Pose& X_tracker_thigh, const bench::LegAngles& angles, std::int64_t device_ns,
                          std::int64_t arrival_ns)
{
  state.take(place_sample(0, X_tracker_thigh, device_ns, arrival_ns));
  state.take(place_sample(1, X_tracker_shank(X_tracker_thigh, angles), device_ns, arrival_ns));
}

std::string two_bodies_text(const std::string& head)
{
  const std::string head_table = "[body.head]\ntool = \"head\"\n";
  return bench_head("two-bodies", head) + display_table + tracker_table + two_bodies +
         (head == "tracker" ? head_table : "") + board_table + "[filter]\non = false\n";
}

std::string rigid_text(const std::string& potentiometer)
{
  return bench_head("rigid") + display_table + tracker_table + "[body.leg]\ntool = \"leg\"\n" +
         "[board]\nport = \"/tmp/board\"\npotentiometer = \"" + potentiometer + "\"\n";
}

Pose some_pose(int number)
{
  bench::PoseParameters six = some_six(number);
  six.shift_mm.z() -= 1000.0;
  six.turn_rad *= 3.0;
  return bench::pose_of(six);
}

Pose moved(const Pose& start, const bench::Screw& a_second, double time_s)
{
  return start * bench::pose_of(bench::scaled(a_second, time_s));
}

double distance_of(const Pose& a, const Pose& b)
{
  return (a.matrix() - b.matrix()).norm();
}

namespace {

bench::Sample sample_of(std::mt19937_64& random, std::int64_t now_ns)
{
  std::uniform_real_distribution<double> mm(-2000.0, 2000.0);
  const Eigen::Quaterniond q =
      Eigen::Quaterniond(Eigen::Vector4d(mm(random), mm(random), mm(random), mm(random))).normalized();
  bench::Sample sample;
  sample.arrival_ns = now_ns - 1'000'000;
  sample.device_ns = now_ns + 1'000'000'000'000;
  sample.kind = static_cast<bench::SampleKind>(random() % 5);
  sample.state = static_cast<std::uint8_t>(random() % 3);
  sample.source = static_cast<std::uint16_t>(random() % 2);
  sample.count = static_cast<std::int32_t>(random() % 2001) - 1000;
  sample.tool_pose = {{mm(random), mm(random), mm(random)}, {q.w(), q.x(), q.y(), q.z()}};
  return sample;
}

}  // namespace

bench::RecordingFacts sample_facts()
{
  return {"bench.toml", "title = \"Desk\"\n", "anna.toml", std::string("version = 1\n\0x", 14),
          "knee.h5",    "1234 00ff",          "degree_6"};
}

std::vector<bench::RecordedFrame> sample_pictures(int n)
{
  std::mt19937_64 random(85);
  std::vector<bench::RecordedFrame> pictures;
  for (int k = 0; k < n; ++k) {
    bench::RecordedFrame& picture = pictures.emplace_back();
    picture.now_ns = k * 16'666'667LL;
    for (int key = 0; key < k % 3; ++key)
      picture.keys.push_back({key == 0 ? view::Key::left : view::key_of('P'), k % 2 == 0, k % 4 == 1});
    for (int s = 0; s < k % 5; ++s) picture.samples.push_back(sample_of(random, picture.now_ns));
  }
  return pictures;
}

std::string recording_bytes(const bench::RecordingFacts& facts,
                            const std::vector<bench::RecordedFrame>& pictures)
{
  std::string bytes = core::header_bytes("bench recording", {"VRDABREC", 1, 1U << 24, "frame"});
  bytes += core::frame_of(bench::bytes_of(facts));
  for (const bench::RecordedFrame& picture : pictures)
    bytes += core::frame_of(bench::bytes_of(picture.now_ns, picture.keys, picture.samples));
  return bytes;
}

bench::RecordingReader reader_of(const std::string& bytes, std::size_t* n_read)
{
  return {"a.log", bytes.size(), [&bytes, n_read](std::uint64_t at, std::size_t n) {
            if (n_read != nullptr) *n_read += n;
            return bytes.substr(static_cast<std::size_t>(at), n);
          }};
}

std::vector<bench::RecordedFrame> frames_of(bench::RecordingReader reader)
{
  std::vector<bench::RecordedFrame> frames;
  for (std::size_t k = 0; k < reader.n_frames(); ++k) frames.push_back(reader.frame(k));
  return frames;
}

bool is_same(const bench::RecordedFrame& a, const bench::RecordedFrame& b)
{
  return bench::bytes_of(a.now_ns, a.keys, a.samples) == bench::bytes_of(b.now_ns, b.keys, b.samples);
}

}  // namespace vrda::test
