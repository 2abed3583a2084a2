#include "app/player_stills.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <optional>

#include "app/own_program.hpp"
#include "core/error.hpp"
#include "load/file_bytes.hpp"

namespace vrda {
namespace {

namespace fs = std::filesystem;

constexpr int n_steps = 3;  // pictures of a view, less one
constexpr std::uintmax_t largest_png_bytes = 16u << 20;
// Of the player (player/app/README.md): done, and some attitudes without an answer.
constexpr int player_done = 0, player_unsolved = 3;

/// A folder for the time of a run, removed with it.
class TemporaryFolder {
 public:
  TemporaryFolder()
  {
    std::error_code error;
    std::string name = (fs::temp_directory_path(error) / "vrda-report-XXXXXX").string();
    if (!error && mkdtemp(name.data()) != nullptr) path_ = name;
  }
  ~TemporaryFolder()
  {
    std::error_code ignored;
    if (!path_.empty()) fs::remove_all(path_, ignored);
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;

  /// Empty when it could not be made.
  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

/// Runs a program without input or output; its exit code, nothing when it did not start or end by itself.
std::optional<int> exit_code_of(std::vector<std::string> words)
{
  std::vector<char*> arguments;
  for (std::string& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  posix_spawn_file_actions_t actions;
  posix_spawn_file_actions_init(&actions);
  posix_spawn_file_actions_addopen(&actions, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDOUT_FILENO, "/dev/null", O_WRONLY, 0);
  posix_spawn_file_actions_addopen(&actions, STDERR_FILENO, "/dev/null", O_WRONLY, 0);
  pid_t pid = -1;
  const int refused = posix_spawn(&pid, arguments.front(), &actions, nullptr, arguments.data(), environ);
  posix_spawn_file_actions_destroy(&actions);
  if (refused != 0) return std::nullopt;
  int status = 0;
  while (waitpid(pid, &status, 0) < 0) {
    if (errno != EINTR) return std::nullopt;
  }
  if (!WIFEXITED(status)) return std::nullopt;
  return WEXITSTATUS(status);
}

std::string flexion_range(const MotionModel& model)
{
  const double first = model.flexion_deg.front(), last = model.flexion_deg.back();
  const double step = last > first ? (last - first) / n_steps : 1.0;
  std::array<char, 96> text{};
  std::snprintf(text.data(), text.size(), "--flexion=%.9g:%.9g:%.9g", first, last, step);
  return text.data();
}

// "front_flexion_030.png" as view and label; the label keeps what it cannot read.
Still still_of(const fs::path& file)
{
  constexpr std::string_view between = "_flexion_";
  const std::string name = file.stem().string();
  Still still;
  const std::size_t at = name.find(between);
  still.view = name.substr(0, at);
  const std::string angle = at == std::string::npos ? "" : name.substr(at + between.size());
  double degrees = 0.0;
  const auto [end, error] = std::from_chars(angle.data(), angle.data() + angle.size(), degrees);
  const bool is_number = error == std::errc() && end == angle.data() + angle.size();
  std::array<char, 48> text{};
  std::snprintf(text.data(), text.size(), "flexion %.4g°", degrees);
  still.label = is_number ? text.data() : name;
  still.png = file_bytes(file.string(), {file.string(), "", "", "a picture"}, largest_png_bytes);
  return still;
}

std::vector<Still> stills_in(const fs::path& folder)
{
  std::vector<fs::path> files;
  for (const fs::directory_entry& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == ".png") files.push_back(entry.path());
  }
  std::sort(files.begin(), files.end());
  std::vector<Still> stills;
  for (const fs::path& file : files) stills.push_back(still_of(file));
  return stills;
}

}  // namespace

std::string player_program(const std::string& player)
{
  std::error_code error;
  if (!player.empty()) {
    if (!fs::is_regular_file(player, error))
      throw InputError({player, "--player", "no such program", "the path of vrda-player"});
    return fs::absolute(player).string();
  }
  const fs::path own = own_program();
  const fs::path beside = own.parent_path() / "vrda-player";
  return !own.empty() && fs::is_regular_file(beside, error) ? beside.string() : "";
}

Stills player_stills(const std::string& player, const std::string& file, const MotionModel& model)
{
  if (player.empty())
    return {{}, "No pictures: vrda-player was not found beside vrda; --player PATH tells where it is."};
  const TemporaryFolder folder;
  if (folder.path().empty()) return {{}, "No pictures: there is no room for temporary files."};
  const std::optional<int> code =
      exit_code_of({player, "show", file, "--offscreen", folder.path().string(), flexion_range(model),
                    "--views", "front,lateral", "--size", "440x440", "--quiet"});
  if (!code || (*code != player_done && *code != player_unsolved))
    return {{},
            "No pictures: vrda-player did not draw them" +
                (code ? " (exit code " + std::to_string(*code) + ")." : std::string("."))};
  return {stills_in(folder.path()),
          *code == player_unsolved ? "Some attitudes have no pose, hence no picture." : ""};
}

}  // namespace vrda
