// The joint sent by OpenIGTLink, read by a program of its own (read_igtl.py, written from the protocol's
// specification) and by Debian's example clients.
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdlib>
#include <memory>
#include <nlohmann/json.hpp>
#include <thread>

#include "core/units.hpp"
#include "player/app/player_programs.hpp"
#include "store/motion.hpp"

namespace vrda::serve_test {

using nlohmann::json;
using testing::HasSubstr;

/// float32 of coordinates below 1000 mm.
constexpr double sent_mm = 1e-4;
constexpr auto longest = std::chrono::seconds(60);

store::MotionModel moving_model()
{
  test::ModelPlan plan;
  plan.motion = [](double flexion_deg, double varus_deg) {
    return store::PoseCoordinates{0.1 * flexion_deg, -30.0 + 0.05 * flexion_deg, 2.0 * varus_deg,
                                  0.1 * flexion_deg};
  };
  store::MotionModel model = test::model_of(plan);
  test::add_bodies(model);
  model.reference.name = "distal_femur";
  model.moving.name = "tibmen";
  return model;
}

class Serve : public test::PlayerPrograms {
 protected:
  void SetUp() override { store::write_motion_model(file_, joint_); }

  /// Starts `vrda-player` and waits for the line "igtl ADDRESS" of one of its streams.
  void start(std::vector<std::string> arguments)
  {
    const std::filesystem::path out = scratch_.path() / "address";
    std::filesystem::remove(out);  // of an earlier start
    std::string line = "exec \"$0\" \"$@\" > \"" + out.string() + "\" 2>&1";
    arguments.insert(arguments.begin(), {"-c", line, VRDA_PLAYER_PROGRAM});
    program_ = std::make_unique<test::Process>(test::Command{"/bin/sh", arguments, {}, scratch_.path()});
    const auto end = std::chrono::steady_clock::now() + longest;
    for (std::size_t at = std::string::npos; at == std::string::npos;) {
      ASSERT_LT(std::chrono::steady_clock::now(), end) << said();
      ASSERT_TRUE(program_->is_running()) << said();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
      const std::string text = said();
      at = text.find("127.0.0.1:");
      const std::size_t line_end = at == std::string::npos ? at : text.find('\n', at);
      if (line_end == std::string::npos) at = line_end;
      if (at != std::string::npos) address_ = text.substr(at, line_end - at);
    }
  }

  std::string said() const
  {
    const std::filesystem::path out = scratch_.path() / "address";
    return std::filesystem::exists(out) ? test::read_bytes(out) : "";
  }

  json read(double seconds) const
  {
    const test::Ended ended = test::run(
        {"/usr/bin/python3", {VRDA_READ_IGTL, address_, "--seconds", std::to_string(seconds)}, {}, {}});
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return json::parse(ended.out);
  }

  store::MotionModel joint_ = moving_model();
  std::string file_ = path("serve.h5"), address_;
  std::unique_ptr<test::Process> program_;
};

double distance_mm(const json& matrix, const Pose& X)
{
  double largest = 0.0;
  for (std::size_t r = 0; r < 4; ++r) {
    for (std::size_t c = 0; c < 4; ++c)
      largest =
          std::max(largest, std::abs(matrix[r][c].get<double>() -
                                     X.matrix()(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c))));
  }
  return largest;
}

TEST_F(Serve, PosesAnglesAndMeshesAreThoseOfTheFile)
{
  const store::Motion motion(joint_, "raw");
  for (const double flexion_deg : {0.0, 30.0, 67.5}) {
    SCOPED_TRACE(flexion_deg);
    start({"serve", file_, "--igtl", "0", "--set", "raw", "--flexion", std::to_string(flexion_deg), "--varus",
           "2"});
    const json read_ = read(0.5);
    const store::JointPose pose = motion.at({rad_from_deg(flexion_deg), rad_from_deg(2.0)});
    EXPECT_LE(distance_mm(read_["last"]["femur"], Pose::Identity()), sent_mm);
    EXPECT_LE(distance_mm(read_["last"]["tibia"], pose.X_reference_moving), sent_mm);
    EXPECT_NEAR(read_["angles"].back()["flexion_deg"], flexion_deg, 1e-3);
    EXPECT_NEAR(read_["angles"].back()["varus_deg"], 2.0, 1e-3);
    EXPECT_EQ(read_["angles"].back()["live"], true);
    // Once per client, first of all.
    EXPECT_EQ(read_["first_kinds"][0], "POLYDATA");
    EXPECT_EQ(read_["first_kinds"][1], "POLYDATA");
    EXPECT_EQ(read_["meshes"].size(), 2U);
    // Named as on screen, whatever the job calls them.
    for (const auto& [name, body] :
         {std::pair("femur", &joint_.reference), std::pair("tibia", &joint_.moving)}) {
      SCOPED_TRACE(name);
      EXPECT_EQ(read_["messages"][std::string("POLYDATA ") + name + "_mesh"], 1);
      const json& mesh = read_["meshes"][std::string(name) + "_mesh"];
      EXPECT_EQ(mesh["triangles"], body->contact.mesh.triangles.rows() + body->visual.mesh.triangles.rows());
      for (int axis = 0; axis < 3; ++axis) {
        double least = body->contact.mesh.vertices_mm.col(axis).minCoeff();
        if (body->visual.mesh.vertices_mm.rows() > 0)
          least = std::min(least, body->visual.mesh.vertices_mm.col(axis).minCoeff());
        EXPECT_NEAR(mesh["least"][static_cast<std::size_t>(axis)], least, sent_mm);
      }
    }
    EXPECT_FALSE(read_["messages"].contains("TRANSFORM eye")) << "there is no bench";
    program_.reset();
  }
}

TEST_F(Serve, AnglesBeyondTheModelAreReported)
{
  const test::Ended ended = run({"serve", file_, "--igtl", "0", "--set", "raw", "--flexion", "300", "--varus",
                                 "45", "--seconds", "0.1"});
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
  EXPECT_THAT(ended.err, HasSubstr("--flexion: found 300, wanted"));
  EXPECT_THAT(ended.err, HasSubstr("--varus: found 45, wanted"));
}

/// $VRDA_IGTL_SECONDS: a longer run; player/bench/README.md has the result of a minute.
TEST_F(Serve, SixtyASecondArriveWithoutLoss)
{
  const char* const wanted = std::getenv("VRDA_IGTL_SECONDS");
  const double seconds = wanted != nullptr ? std::atof(wanted) : 3.0;
  start({"serve", file_, "--igtl", "0", "--period", "2"});
  const json read_ = read(seconds);
  EXPECT_EQ(read_["frames_missing"], 0);
  EXPECT_NEAR(read_["rate_hz"].get<double>(), 60.0, 0.5 + 3.0 / seconds);
  const auto n_frames = read_["frames"].get<std::int64_t>();
  for (const std::string device : {"femur", "tibia"}) {
    // The end of the reading may fall between a pose and its angles.
    EXPECT_NEAR(read_["messages"]["TRANSFORM " + device].get<double>(), static_cast<double>(n_frames), 1.0);
  }
  double least_deg = 1e3, most_deg = -1e3;
  for (const json& angles : read_["angles"]) {
    least_deg = std::min(least_deg, angles["flexion_deg"].get<double>());
    most_deg = std::max(most_deg, angles["flexion_deg"].get<double>());
  }
  EXPECT_NEAR(least_deg, 0.0, 1.0);
  EXPECT_NEAR(most_deg, 90.0, 1.0);
  if (wanted != nullptr)
    std::printf("%.1f s: %lld frames, %.3f a second, %d missing, longest pause %.1f ms\n", seconds,
                static_cast<long long>(n_frames), read_["rate_hz"].get<double>(),
                read_["frames_missing"].get<int>(), 1e3 * read_["longest_pause_s"].get<double>());
}

TEST_F(Serve, ATrackedLegIsSentAndAHiddenBodyIsLeftOutAndMarked)
{
  const std::string bench =
      scratch_
          .write(
              "bench.toml",
              test::bench_text({.tables = "[calibration]\nrectangles = [[100, 0], [100, 50]]\n[simulation]\n"
                                          "leg = [[0, 40, 0]]\nfemur = [10, 20, 30, 0, 0, 0]\nnoise_mm = 0\n"
                                          "noise_deg = 0\n[[simulation.occlusion]]\ntool = \"tibia\"\n"
                                          "from_s = 1.5\nto_s = 1000\n"}))
          .string();
  std::string text = test::read_bytes(bench);
  // The simulator's port is free when it starts: serve is queried first.
  start({"serve", file_, "--igtl", "0"});
  const std::string port = address_.substr(address_.find(':') + 1);
  program_.reset();
  text.replace(text.find("port = 1\n"), 9, "port = " + port + "\n");
  scratch_.write("bench.toml", text);
  start({"serve", file_, "--igtl", "0", "--bench", bench});
  // The tracker is absent: nothing is sent as seen.
  const json absent = read(0.5);
  EXPECT_FALSE(absent["messages"].contains("TRANSFORM femur"));
  EXPECT_EQ(absent["angles"].back()["live"], false);
  EXPECT_THAT(absent["angles"].back()["marks"].dump(), HasSubstr("femur not seen yet"));
  const test::Process simulator(command({"simulate", bench, "--model", file_, "--quiet"}));
  const json seen = read(5.0);
  const auto n_of = [&](const std::string& device) {
    return seen["messages"].value("TRANSFORM " + device, 0);
  };
  EXPECT_GT(n_of("tibia"), 10);
  EXPECT_GT(n_of("femur"), n_of("tibia") + 30) << "the tibia's body is hidden";
  EXPECT_GT(n_of("eye"), 100);
  EXPECT_EQ(seen["frames_missing"], 0);
  EXPECT_THAT(seen["angles"].back()["marks"].dump(), HasSubstr("tibia hidden for"));
  EXPECT_EQ(seen["angles"].back()["live"], false);
  EXPECT_NEAR(seen["angles"].back()["flexion_deg"], 40.0, 0.5);
}

TEST_F(Serve, TheBenchSendsBesideItsPicture)
{
  const std::string bench = scratch_.write("bench.toml", test::bench_text({})).string();
  start({"bench", file_, "--bench", bench, "--headless", "--seconds", "60", "--igtl", "0"});
  const json read_ = read(2.0);
  EXPECT_EQ(read_["messages"].size(), 4U) << "two meshes, eye, angles: the tracker is absent";
  EXPECT_GT(read_["messages"]["TRANSFORM eye"], 5);
  EXPECT_THAT(read_["angles"].back()["marks"].dump(), HasSubstr("tibia not seen yet"));
  program_->send(SIGTERM);
  EXPECT_EQ(program_->wait().exit_code, 0);
}

TEST_F(Serve, AClientThatReadsNothingStopsNeitherTheOthersNorTheProgram)
{
  // A reader in Python keeps up with this rate on a busy machine.
  start({"serve", file_, "--igtl", "0", "--rate", "400"});
  const test::Process silent({"/usr/bin/python3",
                              {"-c",
                               "import socket, sys, time\nhost, port = sys.argv[1].split(':')\n"
                               "s = socket.create_connection((host, int(port)))\ntime.sleep(60)",
                               address_},
                              {},
                              {}});
  const json read_ = read(5.0);
  EXPECT_EQ(read_["frames_missing"], 0);
  const std::string port = address_.substr(address_.find(':') + 1);
  EXPECT_THAT(run({"serve", file_, "--igtl", port, "--seconds", "0.1"}),
              test::refuses({"--igtl", "port", port, "free port"}));
  program_->send(SIGTERM);
  EXPECT_EQ(program_->wait().exit_code, 0);
}

#ifdef VRDA_IGTL_RECEIVE_CLIENT
TEST_F(Serve, DebiansExampleClientsReadIt)
{
  start({"serve", file_, "--igtl", "0", "--flexion", "30", "--seconds", "3"});
  const std::size_t colon = address_.find(':');
  const std::vector<std::string> at{address_.substr(0, colon), address_.substr(colon + 1)};
  // It prints what it receives, and ends when the server does.
  const test::Ended received = test::run({VRDA_IGTL_RECEIVE_CLIENT, at, {}, {}});
  EXPECT_THAT(received.err, HasSubstr("Receiving TRANSFORM data type."));
  EXPECT_THAT(received.err + received.out, HasSubstr("\"flexion_deg\": 30"));
  start({"serve", file_, "--igtl", "0", "--seconds", "20"});
  const std::vector<std::string> next{"127.0.0.1", address_.substr(address_.find(':') + 1)};
  const test::Ended meshes = test::run({VRDA_IGTL_POLYDATA_CLIENT, next, {}, {}});
  EXPECT_THAT(meshes.err, HasSubstr("Receiving POLYDATA data type."));
}
#endif

}  // namespace vrda::serve_test
