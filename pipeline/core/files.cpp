#include "core/files.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <sstream>
#include <system_error>
#include <thread>

namespace vrda::inline core {

OpenFile::~OpenFile()
{
  const int kept = errno;
  if (value_ >= 0) ::close(value_);
  errno = kept;
}

bool is_open_file_at(int descriptor, const std::string& path)
{
  struct stat opened {
  }, named{};
  return fstat(descriptor, &opened) == 0 && stat(path.c_str(), &named) == 0 &&
         opened.st_dev == named.st_dev && opened.st_ino == named.st_ino;
}

namespace {

/// Of this process; set before it takes its first lock.
struct MissingLocks {
  std::function<void(const std::string&)> report;  ///< none: they are not permitted
  std::string warning;
};
MissingLocks& missing_locks()
{
  static MissingLocks locks;
  return locks;
}

}  // namespace

void permit_missing_locks(std::function<void(const std::string& warning)> report)
{
  missing_locks().report = std::move(report);
}

bool are_missing_locks_permitted()
{
  return missing_locks().report != nullptr;
}

const std::string& missing_lock_warning()
{
  return missing_locks().warning;
}

bool try_lock_file(int descriptor, const std::string& path)
{
  while (flock(descriptor, LOCK_EX | LOCK_NB) != 0) {
    if (errno == EWOULDBLOCK) return false;
    if (errno == EINTR) continue;
    const std::string why = std::string(" (") + std::strerror(errno) + ")";
    MissingLocks& locks = missing_locks();
    if (!locks.report)
      throw InputError({path, "", "a lock that cannot be taken" + why,
                        "a file system with flock (Lustre: mounted with -o flock); --no-lock goes on without "
                        "a lock"});
    if (locks.warning.empty()) {
      locks.warning = InputError({"--no-lock", "", "a file system without locks" + why,
                                  "no other process that writes the same output"})
                          .what();
      locks.report(locks.warning);
    }
    return true;
  }
  return true;
}

bool write_all(int descriptor, std::string_view bytes)
{
  while (!bytes.empty()) {
    const ssize_t n = ::write(descriptor, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    bytes.remove_prefix(static_cast<std::size_t>(n));
  }
  return true;
}

void sync_parent_directory(const std::string& path)
{
  const std::size_t slash = path.rfind('/');
  const std::string folder = slash == std::string::npos ? "." : path.substr(0, slash + 1);
  const OpenFile descriptor(open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  if (descriptor.is_open() && fsync(descriptor.get()) == 0) return;
  throw InputError({path, "", std::string("a folder that cannot be flushed (") + std::strerror(errno) + ")",
                    "a folder that can be written and free space"});
}

namespace {

std::string host_name()
{
  std::array<char, 256> name{};
  return gethostname(name.data(), name.size() - 1) == 0 ? name.data() : "unknown host";
}

OpenFile opened(const std::string& path)
{
  OpenFile file(open(path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0666));
  if (file.is_open() || errno != EACCES) return file;
  OpenFile other(open(path.c_str(), O_RDONLY | O_CLOEXEC));  // another user's file in a shared folder
  if (!other.is_open()) errno = EACCES;
  return other;
}

std::string holder_name(const std::string& command, pid_t process)
{
  return command + ", process " + std::to_string(process) + " on " + host_name();
}

std::string holder_in(int descriptor)
{
  std::array<char, 512> text{};
  const ssize_t n = pread(descriptor, text.data(), text.size(), 0);
  return n > 0 ? std::string(text.data(), static_cast<std::size_t>(n)) : "another process";
}

// Where the file system has no locks: a killed holder has left its name, one of another host is unknown.
bool runs_here(const std::string& holder)
{
  const std::size_t command = holder.find(',');
  const std::size_t number = holder.find_first_of("0123456789", command);
  if (number == std::string::npos) return false;
  const pid_t process = std::atoi(holder.c_str() + number);
  return holder == holder_name(holder.substr(0, command), process) &&
         (kill(process, 0) == 0 || errno == EPERM);
}

}  // namespace

std::optional<OutputLock> OutputLock::acquire(const std::string& output, const std::string& command,
                                              const WaitOptions& waiting)
{
  const std::string path = resolve_links(output) + ".lock";
  for (bool is_announced = false;;) {
    OpenFile file = opened(path);
    if (!file.is_open()) {
      throw InputError({output, "", std::strerror(errno), "a folder that exists and can be written"});
    }
    if (try_lock_file(file.get(), output)) {
      if (!is_open_file_at(file.get(), path)) continue;  // the previous holder has just removed it
      const std::string holder = holder_name(command, getpid());
      // Informative only: a write error (full disk) is ignored.
      if (ftruncate(file.get(), 0) == 0)
        static_cast<void>(!pwrite(file.get(), holder.data(), holder.size(), 0));
      return OutputLock(path, std::move(file));
    }
    if (!is_announced && waiting.on_wait) waiting.on_wait(holder_in(file.get()));
    is_announced = true;
    if (waiting.is_cancelled()) return std::nullopt;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
}

bool OutputLock::is_held(const std::string& output)
{
  const OpenFile file(open((resolve_links(output) + ".lock").c_str(), O_RDONLY | O_CLOEXEC));
  if (!file.is_open() || flock(file.get(), LOCK_SH | LOCK_NB) == 0) return false;
  return errno == EWOULDBLOCK || runs_here(holder_in(file.get()));
}

OutputLock::~OutputLock()
{
  if (file_.is_open()) unlink(path_.c_str());  // while locked, so a new holder's file is never removed
}

namespace {

namespace fs = std::filesystem;

/// Reports errno as the reason.
[[noreturn]] void fail(const std::string& path, const std::string& what)
{
  throw InputError(
      {path, "", what + " (" + std::strerror(errno) + ")", "a folder that can be written and free space"});
}

void write_pieces(int descriptor, const std::string& path, std::initializer_list<std::string_view> pieces)
{
  if (std::all_of(pieces.begin(), pieces.end(),
                  [&](std::string_view piece) { return write_all(descriptor, piece); }))
    return;
  std::size_t n_bytes = 0;
  for (const std::string_view piece : pieces) n_bytes += piece.size();
  fail(path, "an output of " + std::to_string(n_bytes) + " bytes that cannot be written");
}

/// Some file systems report a full disk only on close. A duplicate is closed, because the original holds the
/// lock that marks the writer as alive.
bool is_closed_well(int descriptor)
{
  const int second = dup(descriptor);
  return second >= 0 && close(second) == 0;
}

/// The first bytes of a file.
std::string head_of(const std::string& path)
{
  std::array<char, 512> bytes{};
  const OpenFile file(open(path.c_str(), O_RDONLY | O_CLOEXEC));
  const ssize_t n = file.is_open() ? read(file.get(), bytes.data(), bytes.size()) : -1;
  if (n < 0) fail(path, "a file to replace that cannot be read");
  return std::string(bytes.data(), static_cast<std::size_t>(n));
}

void require_replaceable(const std::string& path, const std::string& target, const struct stat& old,
                         std::string_view first_piece)
{
  constexpr mode_t write_bits = S_IWUSR | S_IWGRP | S_IWOTH;
  // Root could write such a file, but its mode forbids every write.
  if ((old.st_mode & write_bits) == 0 || access(target.c_str(), W_OK) != 0) {
    throw InputError({path, "", "a file without write permission",
                      "write permission (chmod u+w), or another name for the output"});
  }
  const std::string head = head_of(target);
  const std::string_view found = file_type_of(head), made = file_type_of(first_piece);
  if (found.empty() || made.empty() || found == made) return;
  throw InputError({path, "", std::string(found) + " to be replaced by " + std::string(made),
                    "a new name, or a file of the same kind to replace"});
}

void keep_owner_and_mode(int descriptor, const std::string& path, const struct stat& old)
{
  struct stat made {};
  if (fstat(descriptor, &made) != 0) fail(path, "an output that cannot be read back");
  const bool has_owner = made.st_uid == old.st_uid && made.st_gid == old.st_gid;
  if (!has_owner && fchown(descriptor, old.st_uid, old.st_gid) != 0) {
    throw InputError({path, "",
                      std::string("a file of another owner or group (") + std::strerror(errno) + ")",
                      "to run as its owner, or another name for the output"});
  }
  constexpr mode_t permissions = S_ISUID | S_ISGID | S_ISVTX | S_IRWXU | S_IRWXG | S_IRWXO;
  if (fchmod(descriptor, old.st_mode & permissions) != 0) fail(path, "an output whose mode cannot be kept");
}

void write_through(const std::string& path, std::initializer_list<std::string_view> pieces)
{
  const OpenFile file(open(path.c_str(), O_WRONLY | O_CLOEXEC));
  if (!file.is_open()) fail(path, "an output that cannot be opened");
  write_pieces(file.get(), path, pieces);
  if (!is_closed_well(file.get())) fail(path, "an output that cannot be written");
}

}  // namespace

/// A uniquely named temporary file, locked while its writer runs. The destructor removes it unless it was
/// renamed.
class NewFile::Temporary {
 public:
  /// Several processes may write one target concurrently; temporaries of dead writers are removed.
  explicit Temporary(const std::string& target)
  {
    constexpr int n_names = 8;
    for (int n = 0; n < n_names; ++n) remove_abandoned(name_of(target, n));
    for (int n = 0; n < n_names; ++n) {
      path_ = name_of(target, n);
      file_.emplace(open(path_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666));
      if (!file_->is_open() && errno != EEXIST) fail(target, "an output that cannot be created");
      // Between creation and lock another writer may have removed it as abandoned. Without lock support
      // (some network file systems) no file is considered abandoned.
      const bool is_locked = file_->is_open() &&
                             (flock(file_->get(), LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK) &&
                             is_open_file_at(file_->get(), path_);
      if (is_locked) return;
      file_.reset();
    }
    throw InputError(
        {target, "", std::to_string(n_names) + " processes writing it", "fewer concurrent writers"});
  }
  struct Written {
    const std::string& file;
  };
  explicit Temporary(const Written& written) : path_(written.file)
  {
    file_.emplace(open(path_.c_str(), O_RDWR | O_NOFOLLOW | O_CLOEXEC));
    if (!file_->is_open()) fail(path_, "an output that cannot be opened");
  }
  ~Temporary()
  {
    if (!is_renamed_) std::remove(path_.c_str());
  }
  Temporary(const Temporary&) = delete;
  Temporary& operator=(const Temporary&) = delete;

  int descriptor() const { return file_->get(); }
  bool rename_to(const std::string& target)
  {
    is_renamed_ = std::rename(path_.c_str(), target.c_str()) == 0;
    return is_renamed_;
  }

 private:
  static std::string name_of(const std::string& target, int n)
  {
    return target + ".partial" + (n == 0 ? "" : "-" + std::to_string(n));
  }

  static void remove_abandoned(const std::string& path)
  {
    const OpenFile file(open(path.c_str(), O_RDONLY | O_NOFOLLOW | O_NONBLOCK | O_CLOEXEC));
    if (!file.is_open() || flock(file.get(), LOCK_EX | LOCK_NB) != 0 || !is_open_file_at(file.get(), path))
      return;
    // Repeated after an error, since this target may never be written again.
    if (std::remove(path.c_str()) != 0) std::remove(path.c_str());
  }

  std::string path_;
  std::optional<OpenFile> file_;
  bool is_renamed_ = false;
};

InputError input_error_of(const fs::filesystem_error& error)
{
  return InputError({error.path1().string(), "", error.code().message(), "a path that can be used"});
}

std::string resolve_links(const std::string& path)
{
  constexpr int most_links = 40;  // as the system
  std::string target = path;
  std::error_code error;
  for (int n = 0; n < most_links; ++n) {
    if (!fs::is_symlink(fs::symlink_status(target, error))) return target;
    const fs::path next = fs::read_symlink(target, error);
    target = next.is_absolute() ? next.string() : (fs::path(target).parent_path() / next).string();
  }
  throw InputError({path, "", "a cycle of symbolic links", "a file or a link to one"});
}

std::string_view file_type_of(std::string_view head)
{
  using namespace std::string_view_literals;
  struct Magic {
    std::string_view bytes, kind;
  };
  constexpr std::array magics{Magic{"\x89HDF\r\n\x1a\n"sv, "an HDF5 file"}, Magic{"\x89PNG"sv, "a PNG image"},
                              Magic{"%PDF"sv, "a PDF file"}, Magic{"glTF"sv, "a glTF file"},
                              Magic{"VRDA"sv, "a journal or recording"}};
  constexpr std::size_t n_head_bytes = 512;
  if (head.empty()) return "";
  head = head.substr(0, n_head_bytes);
  for (const Magic& magic : magics)
    if (head.substr(0, magic.bytes.size()) == magic.bytes) return magic.kind;
  const std::size_t first = head.find_first_not_of(" \t\r\n");
  if (first != std::string_view::npos && head[first] == '<') return "an HTML or XML file";  // or VTK
  if (head.find('\0') != std::string_view::npos) return "a binary file";
  return first != std::string_view::npos && head[first] == '{' ? "a JSON file" : "a text file";
}

std::optional<std::string> read_text_file(const std::string& path)
{
  std::ifstream file(path, std::ios::binary);
  if (!file) return std::nullopt;
  std::stringstream bytes;
  bytes << file.rdbuf();
  return bytes.str();
}

void require_same_file_type(const std::string& path, std::string_view head)
{
  const std::string target = resolve_links(path);
  struct stat old {};
  if (stat(target.c_str(), &old) == 0 && S_ISREG(old.st_mode)) require_replaceable(path, target, old, head);
}

NewFile::NewFile(const std::string& path, std::initializer_list<std::string_view> pieces)
    : path_(path), target_(resolve_links(path))
{
  struct stat old {};
  const bool exists = stat(target_.c_str(), &old) == 0;
  if (exists && S_ISDIR(old.st_mode)) throw InputError({path, "", "a folder", "a name for a file"});
  if (exists && !S_ISREG(old.st_mode)) {
    write_through(path, pieces);
    return;
  }
  if (exists) require_replaceable(path, target_, old, pieces.size() == 0 ? "" : *pieces.begin());

  temporary_ = std::make_unique<Temporary>(target_);
  const int descriptor = temporary_->descriptor();
  if (exists) keep_owner_and_mode(descriptor, path, old);
  write_pieces(descriptor, path, pieces);
  if (fsync(descriptor) != 0 || !is_closed_well(descriptor)) fail(path, "an output that cannot be written");
}

NewFile::NewFile(const std::string& path) : path_(path), target_(resolve_links(path)) {}

NewFile NewFile::of_written(const std::string& path, const std::string& file)
{
  NewFile made(path);
  auto temporary = std::make_unique<Temporary>(Temporary::Written{file});
  struct stat old {};
  const bool exists = stat(made.target_.c_str(), &old) == 0;
  if (exists && !S_ISREG(old.st_mode)) {
    write_through(path, {read_text_file(file).value_or("")});
    return made;
  }
  if (exists) {
    require_replaceable(path, made.target_, old, head_of(file));
    keep_owner_and_mode(temporary->descriptor(), path, old);
  }
  if (fsync(temporary->descriptor()) != 0) fail(path, "an output that cannot be written");
  made.temporary_ = std::move(temporary);
  return made;
}

NewFile::NewFile(NewFile&&) noexcept = default;
NewFile::~NewFile() = default;

void NewFile::swap_in()
{
  if (!temporary_) return;
  if (!temporary_->rename_to(target_)) fail(path_, "a file that cannot be replaced");
  sync_parent_directory(target_);
  temporary_.reset();
}

void write_atomically(const std::string& path, std::initializer_list<std::string_view> pieces)
{
  NewFile(path, pieces).swap_in();
}

namespace {

namespace fs = std::filesystem;

// Each new file is open until it is swapped in; a process may open 1024.
constexpr std::size_t most_open_files = 200;

// Throws if it stays.
void remove_file(const std::string& file)
{
  std::error_code error;
  fs::remove(file, error);
  if (error) throw InputError({file, "", error.message(), "a file that can be replaced"});
}

}  // namespace

std::optional<Publication> Publication::begin(const std::string& main, const std::string& command,
                                              const OutputLock::WaitOptions& waiting)
{
  std::error_code error;
  const fs::file_status status = fs::status(main, error);
  if (fs::is_directory(status)) throw InputError({main, "", "a folder", "a name for a file"});
  if (fs::exists(status) && !fs::is_regular_file(status)) return Publication(main, std::nullopt);
  std::optional<OutputLock> lock = OutputLock::acquire(main, command, waiting);
  if (!lock) return std::nullopt;
  return Publication(main, std::move(lock));
}

Publication::Publication(std::string main, std::optional<OutputLock> lock)
    : main_(std::move(main)), lock_(std::move(lock))
{
  if (!lock_) return;
  if (fs::exists(main_)) {  // complete
    remove_file(note());
    return;
  }
  std::istringstream names(read_text_file(note()).value_or(""));
  for (std::string name; std::getline(names, name);) left_.insert(name);
}

// Lists the files from before the first swap until after the last one. While `main` is absent, they belong to
// no process.
std::string Publication::note() const
{
  return resolve_links(main_) + ".publishing";
}

std::string Publication::name_in_note(const std::string& file) const
{
  const fs::path folder = fs::path(main_).parent_path();
  return fs::path(file).lexically_normal().lexically_relative(folder.lexically_normal()).string();
}

void Publication::require_absent(const std::vector<std::string>& files, InputError::Facts refusal) const
{
  for (const std::string& file : files) {
    if (!fs::exists(file) || left_.count(name_in_note(file)) > 0) continue;
    refusal.file = file;
    throw InputError(std::move(refusal));
  }
}

void Publication::add(const std::string& file, std::string_view bytes)
{
  added_.emplace_back(file, std::initializer_list<std::string_view>{bytes});
  names_.insert(name_in_note(file));
  if (added_.size() >= most_open_files) swap_added();
}

void Publication::start_swap()
{
  if (!lock_) return;
  std::string text = name_in_note(main_) + '\n';
  for (const std::set<std::string>* names : {&left_, &names_}) {
    for (const std::string& name : *names) text += name + '\n';
  }
  write_atomically(note(), {text});
  remove_file(resolve_links(main_));
}

void Publication::swap_added()
{
  start_swap();
  for (NewFile& file : added_) file.swap_in();
  added_.clear();
}

void Publication::publish(std::string_view main_bytes, const std::vector<std::string>& obsolete)
{
  publish(NewFile(main_, {main_bytes}), obsolete);
}

void Publication::publish_written(const std::string& file)
{
  publish(NewFile::of_written(main_, file), {});
}

void Publication::publish(NewFile main, const std::vector<std::string>& obsolete)
{
  const bool is_one_of_several = !names_.empty() || !obsolete.empty();
  if (is_one_of_several) {
    swap_added();
    for (const std::string& file : obsolete) {
      if (names_.count(name_in_note(file)) == 0) remove_file(file);
    }
  }
  main.swap_in();
  if (lock_) remove_file(note());
}

}  // namespace vrda::inline core
