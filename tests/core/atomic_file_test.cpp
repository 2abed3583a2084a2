// Atomic replacement of files: mode, links, file types and the lock on outputs.
#include "core/files.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>

#include "core/text.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::whole_file_test {

namespace fs = std::filesystem;
using testing::HasSubstr;
using testing::UnorderedElementsAre;

std::vector<std::string> names_in(const fs::path& folder)
{
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
  return names;
}

struct stat facts_of(const fs::path& file)
{
  struct stat facts {};
  EXPECT_EQ(lstat(file.c_str(), &facts), 0);
  return facts;
}

InputError::Facts refused(const fs::path& file, std::string_view bytes)
{
  try {
    write_atomically(file, {bytes});
  } catch (const InputError& error) {
    EXPECT_EQ(error.facts().file, file.string());
    return error.facts();
  }
  ADD_FAILURE() << "nothing was refused";
  return {};
}

TEST(WholeFile, mode_of_a_new_file)
{
  const test::Scratch scratch;
  const mode_t mask = umask(027);
  write_atomically(scratch.path() / "a", {"x", "y"});
  umask(mask);
  EXPECT_EQ(test::read_bytes(scratch.path() / "a"), "xy");
  EXPECT_EQ(facts_of(scratch.path() / "a").st_mode & 07777u, 0640u);
  EXPECT_THAT(names_in(scratch.path()), UnorderedElementsAre("a"));
}

TEST(WholeFile, mode_and_owner_stay)
{
  const test::Scratch scratch;
  for (const mode_t mode : {0600u, 0640u, 0664u, 0200u}) {
    SCOPED_TRACE(mode);
    const fs::path file = scratch.write("a", "old");
    ASSERT_EQ(chmod(file.c_str(), mode), 0);
    const bool is_root = geteuid() == 0;
    if (is_root) {
      ASSERT_EQ(chown(file.c_str(), 12345, 23456), 0);
    }
    const struct stat old = facts_of(file);
    if (!is_root && (mode & S_IRUSR) == 0) continue;  // its type cannot be read
    write_atomically(file, {"new"});
    EXPECT_EQ(facts_of(file).st_mode, old.st_mode);
    EXPECT_EQ(facts_of(file).st_uid, old.st_uid);
    EXPECT_EQ(facts_of(file).st_gid, old.st_gid);
    fs::remove(file);
  }
}

TEST(WholeFile, links_are_followed)
{
  const test::Scratch scratch;
  fs::create_directory(scratch.path() / "far");
  const fs::path file = scratch.write("far/a", "old");
  fs::create_symlink("far/a", scratch.path() / "near");
  fs::create_symlink(scratch.path() / "near", scratch.path() / "nearer");
  write_atomically(scratch.path() / "nearer", {"new"});
  EXPECT_TRUE(fs::is_symlink(scratch.path() / "near"));
  EXPECT_TRUE(fs::is_symlink(scratch.path() / "nearer"));
  EXPECT_EQ(test::read_bytes(file), "new");
  fs::remove(file);
  write_atomically(scratch.path() / "near", {"again"});  // creates the link's target
  EXPECT_EQ(test::read_bytes(file), "again");
}

TEST(WholeFile, kinds_of_files)
{
  const test::Scratch scratch;
  const std::string hdf5 = "\x89HDF\r\n\x1a\n....", png = "\x89PNG....", json = "\n {\"a\": 1}",
                    text = "a,b\n1,2\n", html = "<!DOCTYPE html>", gltf = "glTF....", pdf = "%PDF-1.4";
  const std::vector<std::string> kinds{hdf5, png, json, text, html, gltf, pdf, std::string("\1\0\2", 3)};
  for (const std::string& old : kinds) {
    for (const std::string& made : kinds) {
      SCOPED_TRACE(testing::Message() << file_type_of(old) << " by " << file_type_of(made));
      const fs::path file = scratch.write("a", old);
      if (old == made) {
        EXPECT_NO_THROW(write_atomically(file, {made}));
      } else {
        EXPECT_THAT(refused(file, made), test::refuses({.found = std::string(file_type_of(old))}));
        EXPECT_EQ(test::read_bytes(file), old);
      }
    }
    const fs::path empty = scratch.write("empty", "");
    EXPECT_NO_THROW(write_atomically(empty, {old}));
  }
}

TEST(WholeFile, what_is_refused_stays)
{
  const test::Scratch scratch;
  const fs::path kept = scratch.write("kept", "old");
  ASSERT_EQ(chmod(kept.c_str(), 0444), 0);  // refused for root, too
  fs::create_symlink("b", scratch.path() / "a");
  fs::create_symlink("a", scratch.path() / "b");
  for (const auto& [file, found] :
       std::vector<std::pair<fs::path, std::string>>{{kept, "permission"},
                                                     {scratch.path() / "a", "symbolic links"},
                                                     {scratch.path(), "folder"},
                                                     {scratch.path() / "none" / "a", "No such file"},
                                                     {"/dev/full", "No space left"}})
    EXPECT_THAT(refused(file, "new"), test::refuses({.found = found}));
  EXPECT_EQ(test::read_bytes(kept), "old");
  EXPECT_THAT(names_in(scratch.path()), UnorderedElementsAre("a", "b", "kept"));
  EXPECT_NO_THROW(write_atomically("/dev/null", {"new"}));
}

TEST(WholeFile, temporaries_of_dead_writers)
{
  const test::Scratch scratch;
  const fs::path dead = scratch.write("a.partial", "half"), alive = scratch.write("a.partial-2", "half");
  const OpenFile writer(open(alive.c_str(), O_WRONLY | O_CLOEXEC));
  ASSERT_TRUE(try_lock_file(writer.get(), alive));
  write_atomically(scratch.path() / "a", {"new"});
  EXPECT_THAT(names_in(scratch.path()), UnorderedElementsAre("a", "a.partial-2"));
  EXPECT_EQ(test::read_bytes(alive), "half");
}

TEST(OutputLock, one_at_a_time)
{
  const test::Scratch scratch;
  const fs::path output = scratch.path() / "m.h5", link = scratch.path() / "l.h5";
  fs::create_symlink("m.h5", link);
  std::string holder;
  bool is_stopped = false;
  const auto note = [&](const std::string& name) {
    holder = name;
    is_stopped = true;
  };
  {
    const auto first = OutputLock::acquire(output, "vrda smooth", {});
    ASSERT_TRUE(first);
    EXPECT_FALSE(OutputLock::acquire(link, "vrda audit", {note, [&] { return is_stopped; }}));
    EXPECT_THAT(holder, HasSubstr("vrda smooth, process " + std::to_string(getpid())));
  }
  EXPECT_TRUE(OutputLock::acquire(output, "vrda audit", {}));
  EXPECT_THAT(names_in(scratch.path()), UnorderedElementsAre("l.h5"));  // no lock or temporary file remains
}

// Several processes increment a number in a file under the lock; some are killed at random times.
TEST(OutputLock, no_change_is_lost)
{
  const test::Scratch scratch;
  const std::string output = scratch.write("n", "0"), done = scratch.path() / "done";
  constexpr int n_processes = 8, n_changes = 40;
  const auto add_one = [&] {
    const auto lock = OutputLock::acquire(output, "test", {});
    const int n = std::stoi(test::read_bytes(output));
    write_atomically(output, {std::to_string(n + 1)});
    const OpenFile log(open(done.c_str(), O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0666));
    return write(log.get(), "+", 1) == 1;
  };
  std::vector<pid_t> children;
  for (int p = 0; p < n_processes; ++p) {
    children.push_back(fork());
    ASSERT_GE(children.back(), 0);
    if (children.back() == 0) {
      for (int k = 0; k < n_changes; ++k)
        if (!add_one()) _exit(1);
      _exit(0);
    }
  }
  std::mt19937 random(7);
  int n_killed = 0;
  for (std::size_t p = 0; p < children.size(); p += 2, ++n_killed) {
    usleep(std::uniform_int_distribution<useconds_t>(0, 20000)(random));
    kill(children[p], SIGKILL);
  }
  for (const pid_t child : children) waitpid(child, nullptr, 0);
  // A killed process may have written the file but not its log entry.
  const int n_noted = static_cast<int>(test::read_bytes(done).size()),
            n = std::stoi(test::read_bytes(output));
  EXPECT_GE(n, n_noted);
  EXPECT_LE(n, n_noted + n_killed);
  EXPECT_GE(n_noted, n_processes / 2 * n_changes);
  // A lock that a killed process has left blocks no other process and is removed by the next one.
  EXPECT_TRUE(OutputLock::acquire(output, "test", {}));
  EXPECT_FALSE(fs::exists(output + ".lock"));
}

}  // namespace vrda::whole_file_test
