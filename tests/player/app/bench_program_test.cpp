// The programs `bench`, `simulate` and `devices`; the simulator runs as a separate process.
#include <arpa/inet.h>
#include <sys/socket.h>
#include <unistd.h>

#include <nlohmann/json.hpp>

#include <algorithm>
#include <chrono>
#include <csignal>
#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <thread>

#include "core/text.hpp"
#include "player/app/player_programs.hpp"

namespace vrda::bench_program_test {

using testing::HasSubstr;

sockaddr_in local(std::uint16_t port)
{
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  address.sin_port = htons(port);
  return address;
}

/// A free port; empty if the machine has no loopback interface.
std::optional<std::uint16_t> free_port()
{
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  sockaddr_in address = local(0);
  socklen_t n = sizeof address;
  const bool has_port = bind(socket, reinterpret_cast<sockaddr*>(&address), n) == 0 &&
                        getsockname(socket, reinterpret_cast<sockaddr*>(&address), &n) == 0;
  close(socket);
  if (!has_port) return std::nullopt;
  return ntohs(address.sin_port);
}

bool is_listening(std::uint16_t port)
{
  const int socket = ::socket(AF_INET, SOCK_STREAM, 0);
  const sockaddr_in address = local(port);
  const bool is_taken = connect(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  close(socket);
  return is_taken;
}

/// Upper limit, so that a failing test does not hang.
constexpr auto longest = std::chrono::seconds(120);

class BenchProgram : public test::PlayerPrograms {
 protected:
  void SetUp() override
  {
    const std::optional<std::uint16_t> port = free_port();
    if (!port) GTEST_SKIP() << "no loopback interface";
    port_ = *port;
    tracker_ = "[tracker]\nport = " + std::to_string(port_) + "\n";
    bench_ =
        scratch_
            .write("bench.toml",
                   test::bench_text({.keys = "prediction_ms = 20\n",
                                     .tracker = tracker_,
                                     .tables = "[board]\nport = \"" + board_ +
                                               "\"\npotentiometer = \"selected\"\n[simulation]\nleg = "
                                               "[[0, 0, 0], [1, 60, 2], [2, 0, 0]]\nstage = [[0, 0], [1, "
                                               "20], [2, 0]]\n[[simulation.occlusion]]\ntool = "
                                               "\"tibia\"\nfrom_s = 0.5\nto_s = 0.7\nevery_s = 2\n"}))
            .string();
  }

  /// Waits until both devices can be opened.
  void simulate()
  {
    simulator_ = std::make_unique<test::Process>(command({"simulate", bench_, "--quiet"}));
    const auto end = std::chrono::steady_clock::now() + longest;
    while (!is_listening(port_) || !std::filesystem::exists(board_)) {
      ASSERT_TRUE(simulator_->is_running()) << simulator_->wait().err;
      ASSERT_LT(std::chrono::steady_clock::now(), end) << simulator_->said();
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    }
  }

  std::string board_ = path("board"), bench_, tracker_;
  std::uint16_t port_ = 0;
  std::unique_ptr<test::Process> simulator_;
};

std::map<std::string, std::string> files_in(const std::string& folder)
{
  std::map<std::string, std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder))
    files[entry.path().filename()] = test::read_bytes(entry.path());
  return files;
}

TEST_F(BenchProgram, AReplayShowsTheSamePictures)
{
  simulate();
  const std::string log = path("a.log"), live = path("live"), again = path("again");
  const test::Ended bench =
      run({"bench", model_, "--bench", bench_, "--headless", "--seconds", "3", "--record", log, "--pictures",
           live, "--every", "3", "--timing", path("t.json")});
  ASSERT_EQ(bench.exit_code, 0) << bench.err;
  EXPECT_THAT(bench.err, test::reports("", "latency"));
  EXPECT_THAT(test::read_bytes(path("t.json")), HasSubstr("\"latency_ms\": {\"n\": "));
  const test::Ended replay =
      run({"bench", model_, "--replay", log, "--headless", "--pictures", again, "--every", "3"});
  ASSERT_EQ(replay.exit_code, 0) << replay.err;
  EXPECT_THAT(replay.err, test::reports("", {"tibia", "33 ms"}));
  const std::map<std::string, std::string> shown = files_in(live), replayed = files_in(again);
  EXPECT_GT(shown.size(), 1u);
  EXPECT_NE(shown.begin()->second, shown.rbegin()->second);
  ASSERT_EQ(replayed.size(), shown.size());
  for (const auto& [name, bytes] : shown) {
    ASSERT_EQ(replayed.count(name), 1u) << name;
    EXPECT_TRUE(replayed.at(name) == bytes) << name;
  }

  const test::Ended late = run({"bench", model_, "--replay", log, "--headless", "--from", "60"});
  EXPECT_THAT(late, test::refuses({"--from", "", "60", "0"}));

  const test::Ended taken =
      run({"bench", model_, "--bench", bench_, "--headless", "--seconds", "1", "--record", log});
  EXPECT_THAT(taken, test::refuses({.file = log, .found = "existing"}));
  // Before anything is recorded, not after the session.
  const std::string before = test::read_bytes(model_), unused = path("unused.log");
  const test::Ended onto_model = run({"bench", model_, "--bench", bench_, "--headless", "--seconds", "1",
                                      "--record", unused, "--timing", model_});
  EXPECT_THAT(onto_model, test::refuses({.file = model_, .found = "HDF5"}));
  EXPECT_TRUE(test::read_bytes(model_) == before);
  EXPECT_FALSE(std::filesystem::exists(unused));
  const std::string other = path("other.h5");
  test::ModelPlan plan;
  plan.flexion_deg = {0, 45, 90};
  write_model(other, plan);
  const test::Ended wrong = run({"bench", other, "--replay", log, "--headless"});
  EXPECT_THAT(wrong, test::refuses({other, "", "another motion model", model_}));
}

TEST_F(BenchProgram, DevicesAreListedWhileTheyAnswer)
{
  const test::Ended silent = run({"devices", bench_, "--json", "--seconds", "0.5"});
  EXPECT_EQ(silent.exit_code, 3);
  const nlohmann::json before = nlohmann::json::parse(silent.out);
  EXPECT_EQ(before["tracker"]["peer"], "127.0.0.1:" + std::to_string(port_));
  EXPECT_EQ(before["tracker"]["answers"], false);
  EXPECT_EQ(before["board"]["peer"], board_);
  EXPECT_EQ(before["board"]["answers"], false);
  simulate();
  const test::Ended up = run({"devices", bench_, "--json", "--seconds", "3"});
  EXPECT_EQ(up.exit_code, 0) << up.out;
  const nlohmann::json now = nlohmann::json::parse(up.out);
  EXPECT_EQ(now["tracker"]["tools"][0]["name"], "femur");
  EXPECT_EQ(now["tracker"]["tools"][0]["state"], "seen");
  EXPECT_GT(now["tracker"]["tools"][0]["rate_hz"], 0.0);
  EXPECT_EQ(now["board"]["peer"], board_);
  EXPECT_EQ(now["board"]["answers"], true);
  EXPECT_THAT(up.out, testing::Not(HasSubstr("null")));
  simulator_->send(SIGTERM);
  EXPECT_EQ(simulator_->wait().err, "");
  EXPECT_FALSE(std::filesystem::exists(board_));
}

/// The frames in the log that a bench is writing; empty before the log exists.
std::vector<bench::BenchFrame> shown_so_far(const std::string& log, const std::string& model)
{
  try {
    return test::frames_of(log, model);
  } catch (const InputError&) {
    return {};
  }
}

bool is_without_simulator(const bench::BenchFrame& frame)
{
  return !frame.bodies[1].is_live && !frame.bodies[2].is_live && !frame.stage.is_live &&
         !frame.potentiometer.is_live;
}

/// True if there are at least `n` frames and the last `n` satisfy `claim`.
bool are_last(const std::vector<bench::BenchFrame>& frames, std::size_t n,
              bool (*claim)(const bench::BenchFrame&))
{
  return frames.size() >= n &&
         std::all_of(frames.end() - static_cast<std::ptrdiff_t>(n), frames.end(), claim);
}

TEST_F(BenchProgram, GoesOnWithoutItsSimulatorAndFindsTheNextOne)
{
  constexpr std::size_t n_without = 30;
  const std::string log = path("a.log");
  simulate();
  test::Process bench(
      command({"bench", model_, "--bench", bench_, "--headless", "--seconds", "1000", "--record", log}));
  std::vector<bench::BenchFrame> frames;
  const auto await = [&](std::size_t n, bool (*claim)(const bench::BenchFrame&)) {
    const auto end = std::chrono::steady_clock::now() + longest;
    while (std::chrono::steady_clock::now() < end && bench.is_running()) {
      frames = shown_so_far(log, model_);
      if (are_last(frames, n, claim)) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  };
  ASSERT_TRUE(await(1, bench::is_live)) << bench.said();
  simulator_.reset();  // killed
  ASSERT_TRUE(await(n_without, is_without_simulator)) << bench.said();
  // The display continues with the last valid poses, marked as stale.
  const bench::BenchFrame first = frames[frames.size() - n_without], last = frames.back();
  EXPECT_TRUE(last.bodies[1].was_seen && last.bodies[2].was_seen);
  EXPECT_EQ(last.X_tracker_reference.matrix(), first.X_tracker_reference.matrix());
  EXPECT_EQ(last.X_tracker_moving.matrix(), first.X_tracker_moving.matrix());
  EXPECT_EQ(last.X_tracker_eyes.matrix(), first.X_tracker_eyes.matrix());
  EXPECT_THAT(bench::input_status_text("femur", last.bodies[1]), testing::StartsWith("femur silent for "));
  EXPECT_THAT(bench::stage_status_text(last), testing::StartsWith("stage silent for "));
  simulate();
  ASSERT_TRUE(await(1, bench::is_live)) << bench.said();
  EXPECT_NE(frames.back().X_tracker_moving.matrix(), last.X_tracker_moving.matrix());
  bench.send(SIGTERM);
  const test::Ended ended = bench.wait();
  EXPECT_EQ(ended.exit_code, 0) << ended.err;
}

TEST_F(BenchProgram, TheSimulatorListensWhereTheBenchFileOrTheOptionSays)
{
  const auto said = [&](const std::string& simulation, std::vector<std::string> more) {
    std::string text = test::read_bytes(bench_);
    text.insert(text.find("leg = [["), simulation);
    const std::string bench = scratch_.write("address.toml", text).string();
    std::vector<std::string> arguments{"simulate", bench, "--quiet", "--seconds", "0.1"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const test::Ended ended = run(arguments);
    EXPECT_EQ(ended.exit_code, 0) << ended.err;
    return ended.out;
  };
  const std::string port = ":" + std::to_string(port_) + "\n";
  EXPECT_THAT(said("", {}), HasSubstr("tracker 127.0.0.1" + port));
  EXPECT_THAT(said("", {"--address", "127.0.0.2"}), HasSubstr("tracker 127.0.0.2" + port));
  const std::string other = "address = \"127.0.0.3\"\n";
  EXPECT_THAT(said(other, {}), HasSubstr("tracker 127.0.0.3" + port));
  EXPECT_THAT(said(other, {"--address", "127.0.0.1"}), HasSubstr("tracker 127.0.0.1" + port));
}

TEST_F(BenchProgram, ASecondSimulatorLeavesTheLinkOfTheFirst)
{
  simulate();
  const std::filesystem::path target = std::filesystem::read_symlink(board_);
  // The same bench: the port is taken.
  EXPECT_EQ(run({"simulate", bench_, "--quiet", "--seconds", "0.1"}).exit_code, 2);
  EXPECT_EQ(std::filesystem::read_symlink(board_), target);
  // Another port, the same link.
  const std::optional<std::uint16_t> other = free_port();
  ASSERT_TRUE(other);
  std::string text = test::read_bytes(bench_);
  const std::string port = "[tracker]\nport = ";
  text.replace(text.find(port) + port.size(), std::to_string(port_).size(), std::to_string(*other));
  const test::Ended second =
      run({"simulate", scratch_.write("second.toml", text).string(), "--quiet", "--seconds", "0.1"});
  EXPECT_EQ(second.exit_code, 2);
  EXPECT_THAT(second.err, test::reports(board_, {"running simulation"}));
  EXPECT_EQ(std::filesystem::read_symlink(board_), target);
  // A killed one's link is replaced.
  simulator_->send(SIGKILL);
  simulator_->wait();
  EXPECT_EQ(run({"simulate", bench_, "--quiet", "--seconds", "0.1"}).exit_code, 0);
}

TEST_F(BenchProgram, ABodyOfMarkersIsMeasuredAndThenTracked)
{
  // The noise leaves 0.04 mm after a fit of six coordinates; of 0.05 mm one draw in 70 left more than 0.1 mm.
  std::string head = test::bench_text({.leg = "rigid",
                                       .tracker = tracker_ + "[board]\nport = \"" + board_ +
                                                  "\"\n[simulation]\nnoise_mm = 0.03\nnoise_deg = 0\n"});
  head.resize(head.find("[body.leg]"));
  const std::string markers = "[body.leg]\nmarkers = [\"a\", \"b\", \"c\", \"d\"]\n";
  const std::string unmeasured = scratch_.write("unmeasured.toml", head + markers).string();
  bench_ =
      scratch_.write("bench.toml", head + markers + "markers_mm = [0, 0, 0, 90, 0, 0, 0, 60, 0, 0, 0, 50]\n")
          .string();
  simulate();
  EXPECT_THAT(run({"devices", unmeasured, "--seconds", "1"}).out,
              HasSubstr("body leg  no markers_mm yet: vrda-player body leg\n"));
  EXPECT_EQ(run({"bench", model_, "--bench", unmeasured, "--headless", "--seconds", "1"}).exit_code, 2);
  const test::Ended body = run({"body", "leg", "--bench", unmeasured, "--seconds", "3", "--quiet"});
  ASSERT_EQ(body.exit_code, 0) << body.err;
  EXPECT_EQ(body.err, "");
  EXPECT_THAT(body.out, HasSubstr(markers + "markers_mm = ["));
  EXPECT_THAT(body.out, HasSubstr(" mm (root mean square)\n"));
  EXPECT_THAT(body.out, testing::Not(HasSubstr("not converged")));
  const std::string measured = scratch_.write("measured.toml", head + body.out).string();
  const test::Ended devices = run({"devices", measured, "--json", "--seconds", "1"});
  ASSERT_EQ(devices.exit_code, 0) << devices.out;
  const nlohmann::json fitted = nlohmann::json::parse(devices.out)["tracker"]["bodies"].at(0);
  EXPECT_EQ(fitted["role"], "leg");
  EXPECT_EQ(fitted["status"], "fitted");
  EXPECT_EQ(fitted["markers"], 4);
  EXPECT_LT(fitted["residual_mm"], 0.1);
  EXPECT_THAT(run({"devices", measured, "--seconds", "1"}).out,
              HasSubstr(" mm at 4 markers, rotation sd 0."));
}

}  // namespace vrda::bench_program_test
