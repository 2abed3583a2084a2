#include "store/read_separately.hpp"

#include <fcntl.h>
#include <seccomp.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>
#include <zlib.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstring>
#include <initializer_list>
#include <limits>
#include <memory>
#include <new>
#include <span>
#include <type_traits>
#include <utility>

#include "core/files.hpp"
#include "core/text.hpp"
#include "store/model_checks.hpp"
#include "store/registry.hpp"

namespace vrda::store {
namespace {

constexpr int done = 0, not_written = 1;

/// Bytes mapped by this process.
std::uint64_t mapped_bytes()
{
  unsigned long long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "r")) {
    if (std::fscanf(file, "%llu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return pages * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
}

void limit(int what, std::uint64_t value)
{
  const rlimit both{value, value};
  setrlimit(static_cast<__rlimit_resource_t>(what), &both);  // a stricter limit remains in force
}

/// `answer` is the descriptor of the result file, the only one that stays open.
void restrict_this_process(const ProcessLimits& limits, int answer)
{
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  prctl(PR_SET_NO_NEW_PRIVS, 1, 0, 0, 0);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, limits.processor_s);
  limit(RLIMIT_FSIZE, limits.result_bytes);
  limit(RLIMIT_NPROC, 0);
  if (!is_sanitized) limit(RLIMIT_AS, mapped_bytes() + limits.memory_bytes);
  // The C library would print to the terminal on heap corruption, which the caller reports.
  const int null_device = open("/dev/null", O_RDWR | O_CLOEXEC);
  if (null_device >= 0) {
    dup2(null_device, STDOUT_FILENO);
    dup2(null_device, STDERR_FILENO);
  }
  close_range(STDERR_FILENO + 1, static_cast<unsigned>(answer) - 1, 0);
  close_range(static_cast<unsigned>(answer) + 1, ~0U, 0);
  if (is_sanitized) return;  // keep the sanitizers' signal handlers
  for (const int signal : {SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT, SIGXCPU, SIGXFSZ, SIGINT, SIGTERM})
    std::signal(signal, SIG_DFL);
}

bool write_all(int file, const std::string& text)
{
  std::size_t n_written = 0;
  while (n_written < text.size()) {
    const ssize_t n = ::write(file, text.data() + n_written, text.size() - n_written);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return false;
    n_written += static_cast<std::size_t>(n);
  }
  return true;
}

std::string read_all(int file)
{
  struct stat facts = {};
  std::string text(fstat(file, &facts) == 0 ? static_cast<std::size_t>(facts.st_size) : 0, '\0');
  std::size_t n_read = 0;
  while (n_read < text.size()) {
    const ssize_t n = pread(file, text.data() + n_read, text.size() - n_read, static_cast<off_t>(n_read));
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) break;
    n_read += static_cast<std::size_t>(n);
  }
  text.resize(n_read);
  return text;
}

std::string ending_of(int status, const ProcessLimits& limits)
{
  if (WIFEXITED(status)) return "exit code " + std::to_string(WEXITSTATUS(status));
  const int signal = WTERMSIG(status);
  // Hard and soft limits are equal; at the hard limit the kernel sends SIGKILL.
  if (signal == SIGXCPU) return "more than " + std::to_string(limits.processor_s) + " s of processor time";
  if (signal == SIGXFSZ) return "more than " + std::to_string(limits.result_bytes) + " bytes of values";
  return "signal " + std::to_string(signal);
}

constexpr const char* wanted_process = "resources for another process";

}  // namespace

SeparateProcess::SeparateProcess(const std::function<std::string()>& work, std::string subject,
                                 const ProcessLimits& limits)
    : subject_(std::move(subject)), limits_(limits)
{
  // A file in memory instead of a pipe: the parent need not read while the child writes.
  file_ = memfd_create("vrda", MFD_CLOEXEC);
  if (file_ < 0) throw InputError({subject_, "", std::strerror(errno), wanted_process});
  child_ = fork();
  if (child_ < 0) {
    const int error = errno;
    ::close(file_);
    throw InputError({subject_, "", std::strerror(error), wanted_process});
  }
  if (child_ > 0) return;
  restrict_this_process(limits_, file_);
  _exit(write_all(file_, work()) ? done : not_written);
}

SeparateProcess::~SeparateProcess()
{
  if (child_ > 0) {
    ::kill(child_, SIGKILL);
    wait();
  }
  ::close(file_);
}

int SeparateProcess::wait()
{
  int status = 0;
  pid_t ended = -1;
  do {
    ended = waitpid(child_, &status, 0);
  } while (ended < 0 && errno == EINTR);
  child_ = -1;
  return ended < 0 ? -1 : status;
}

ProcessResult SeparateProcess::wait_for_result()
{
  check(child_ > 0, "the result may be taken once");
  const int status = wait();
  if (status < 0) throw InputError({subject_, "", std::strerror(errno), "the end of a process"});
  if (WIFEXITED(status) && WEXITSTATUS(status) == done) return {true, read_all(file_)};
  return {false, ending_of(status, limits_)};
}

ProcessResult run_separately(const std::function<std::string()>& work, const std::string& subject,
                             const ProcessLimits& limits)
{
  return SeparateProcess(work, subject, limits).wait_for_result();
}

// A motion model as a stream of its values in memory layout, for the pipe from the process that reads HDF5 to
// its parent, which is the same program: no byte order, no version. A stream that ends early throws
// InputError.

namespace {

/// write_value() appends a value; as a visitor it appends every value of the registry.
class BinaryWriter : public RegistryVisitor {
 public:
  /// Until reserve_counted(), bytes are only counted.
  void count() { is_counting_ = true; }
  void reserve_counted()
  {
    is_counting_ = false;
    bytes_.reserve(n_counted_);
  }
  std::string take() { return std::move(bytes_); }

  template <typename Value>
  void write_value(const Value& value)
  {
    if constexpr (std::is_same_v<Value, std::string>) {
      write_value(static_cast<std::uint32_t>(value.size()));
      append(value.data(), value.size());
    } else if constexpr (std::is_same_v<Value, Eigen::Vector3d>) {
      append(value.data(), 3 * sizeof(double));
    } else {
      static_assert(std::is_arithmetic_v<Value>);
      append(&value, sizeof value);
    }
  }

  bool has(const std::string&, bool is_there) override
  {
    write_value(is_there);
    return is_there;
  }
  void dimension(const std::string& path, const DimensionSize& count) override
  {
    RegistryVisitor::dimension(path, count);
    if (count.kind != DimensionSize::Kind::fixed) write_value(count.n);
  }

 private:
  void visit_attribute(const std::string&, const std::string&, Attribute value, const Unit&) override
  {
    std::visit([&](const auto* one) { write_value(*one); }, value);
  }
  void visit_list(const std::string&, List list) override
  {
    std::visit(
        [&](const auto* elements) {
          write_value(static_cast<std::uint32_t>(elements->size()));
          for (const auto& element : *elements) write_value(group_name(element));
        },
        list);
  }
  void visit_dataset(const Dataset&, Member member) override
  {
    with_values(member, [&]<typename Scalar>(std::span<Scalar> values) {
      if constexpr (std::is_same_v<Scalar, std::string>) {
        for (const std::string& text : values) write_value(text);
      } else {
        append(values.data(), values.size_bytes());
      }
    });
  }

  void append(const void* data, std::size_t size)
  {
    if (is_counting_) {
      n_counted_ += size;
    } else if (size > 0) {
      bytes_.append(static_cast<const char*>(data), size);
    }
  }

  std::string bytes_;
  std::size_t n_counted_ = 0;
  bool is_counting_ = false;
};

/// Inverse of BinaryWriter. Throws InputError naming `file` where the bytes end or are invalid.
class BinaryReader : public RegistryVisitor {
 public:
  BinaryReader(std::string_view bytes, const std::string& file) : bytes_(bytes), file_(file) {}

  std::size_t left() const { return bytes_.size(); }
  bool may_change() const override { return true; }

  template <typename Value>
  void read_value(Value& value)
  {
    if constexpr (std::is_same_v<Value, std::string>) {
      std::uint32_t size = 0;
      read_value(size);
      require(size);
      value.assign(bytes_.substr(0, size));
      bytes_.remove_prefix(size);
    } else if constexpr (std::is_same_v<Value, Eigen::Vector3d>) {
      take(value.data(), 3 * sizeof(double));
    } else if constexpr (std::is_same_v<Value, bool>) {
      std::int8_t code = 0;
      take(&code, 1);
      value = code != 0;
    } else {
      static_assert(std::is_arithmetic_v<Value>);
      take(&value, sizeof value);
    }
  }

  bool has(const std::string&, bool) override
  {
    bool is_there = false;
    read_value(is_there);
    return is_there;
  }
  void dimension(const std::string& path, const DimensionSize& count) override
  {
    std::int64_t n = count.n;
    if (count.kind != DimensionSize::Kind::fixed) read_value(n);
    const bool is_axis = count.kind == DimensionSize::Kind::axis;
    if (n < (is_axis ? 1 : 0) || n > std::numeric_limits<std::int32_t>::max()) refuse(path);
    RegistryVisitor::dimension(path, DimensionSize::fixed(n));
  }

  /// Throws unless at least `size` bytes remain.
  void require(std::uint64_t size) const
  {
    if (size <= bytes_.size()) return;
    throw InputError({file_, "", std::to_string(bytes_.size()) + " bytes of serialized values",
                      std::to_string(size) + " bytes"});
  }

 private:
  void visit_attribute(const std::string&, const std::string&, Attribute value, const Unit&) override
  {
    std::visit([&](auto* one) { read_value(*one); }, value);
  }
  void visit_list(const std::string& group, List list) override
  {
    /// Limit of sets and audits; the file's reader accepts 10000 objects.
    constexpr std::uint32_t most_elements = 1000;
    std::uint32_t n = 0;
    read_value(n);
    if (n > most_elements) refuse(group);
    std::visit(
        [&](auto* elements) {
          elements->resize(n);
          for (auto& element : *elements) {
            std::string name;
            read_value(name);
            if (!set_group_name(element, name)) refuse(group);
          }
        },
        list);
  }
  void visit_dataset(const Dataset& dataset, Member member) override
  {
    const std::vector<std::int64_t> shape = shape_of(dataset);
    std::uint64_t bytes = bytes_of(store::kind_of(member));
    for (const std::int64_t size : shape) {
      if (__builtin_mul_overflow(bytes, static_cast<std::uint64_t>(size), &bytes)) refuse(dataset.path);
    }
    require(bytes);
    std::visit([&](auto* all) { resize(*all, shape); }, member);
    with_values(member, [&]<typename Scalar>(std::span<Scalar> values) {
      if constexpr (std::is_same_v<Scalar, std::string>) {
        for (std::string& text : values) read_value(text);
      } else {
        take(values.data(), values.size_bytes());
      }
    });
  }

  [[noreturn]] void refuse(const std::string& where) const
  {
    throw InputError({file_, where, "invalid serialized bytes", "serialized values"});
  }

  void take(void* data, std::size_t size)
  {
    require(size);
    if (size > 0) std::memcpy(data, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }

  std::string_view bytes_;
  const std::string& file_;
};

/// First code of the child process's answer.
enum class Kind : std::int8_t { value, input_error, internal_error };

std::function<void(const std::string&)>& unconfined_listener()
{
  static std::function<void(const std::string&)> listener;
  return listener;
}

/// In the separate process: the result of `parse` for the file's content, or the error. Throws nothing.
template <typename Parse>
std::string parse_answer(const std::string& path, const Parse& parse)
{
  std::string why_unconfined;
  const auto answer = [&](Kind kind, const std::vector<std::string>& texts) {
    BinaryWriter stream;
    stream.write_value(why_unconfined);
    stream.write_value(static_cast<std::int8_t>(kind));
    for (const std::string& text : texts) stream.write_value(text);
    return stream.take();
  };
  const auto refusal = [&](const InputError::Facts& facts) {
    return answer(Kind::input_error, {facts.file, facts.field, facts.found, facts.wanted});
  };
  try {
    const Hdf5Content content = read_hdf5(path);
    why_unconfined = confine_this_process();
    const std::string value = parse(content);
    return answer(Kind::value, {}) + value;
  } catch (const InputError& error) {
    return refusal(error.facts());
  } catch (const std::bad_alloc&) {
    return refusal({path, "", "a file that needs more memory than the limit", intact_file});
  } catch (const std::exception& error) {
    return answer(Kind::internal_error, {error.what()});
  }
}

/// The serialized values of an answer; throws the error if the answer contains one.
std::string_view value_of(const std::string& answer, const std::string& path)
{
  BinaryReader stream(answer, path);
  std::string why_unconfined;
  stream.read_value(why_unconfined);
  if (!why_unconfined.empty() && unconfined_listener())
    std::exchange(unconfined_listener(), {})(why_unconfined);
  std::int8_t kind = 0;
  stream.read_value(kind);
  if (kind == static_cast<std::int8_t>(Kind::value))
    return std::string_view(answer).substr(answer.size() - stream.left());
  InputError::Facts facts;
  if (kind == static_cast<std::int8_t>(Kind::input_error)) {
    for (std::string* text : {&facts.file, &facts.field, &facts.found, &facts.wanted})
      stream.read_value(*text);
    throw InputError(facts);
  }
  std::string why;
  stream.read_value(why);
  throw InternalError(why);
}

std::string text_of_complete(const ProcessResult& answer, const std::string& path)
{
  if (answer.is_complete) return answer.text;
  throw InputError(
      {path, "", "a file that HDF5 cannot read (its process ended with " + answer.text + ")", intact_file});
}

template <typename Parse>
std::string read_in_process(const std::string& path, const Parse& parse)
{
  const auto work = [&] { return parse_answer(path, parse); };
  return text_of_complete(run_separately(work, path, reading_limits(path)), path);
}

}  // namespace

ProcessLimits reading_limits(const std::string& path)
{
  struct stat status = {};
  const std::uint64_t size =
      stat(path.c_str(), &status) == 0 ? static_cast<std::uint64_t>(status.st_size) : 0;
  ProcessLimits limits;
  limits.memory_bytes = std::max(limits.memory_bytes, 8 * size);
  limits.result_bytes = std::max(limits.result_bytes, 4 * size);
  return limits;
}

void on_unconfined_read(std::function<void(const std::string&)> report)
{
  unconfined_listener() = std::move(report);
}

SeparateModelRead::SeparateModelRead(const std::string& path) : SeparateModelRead(path, reading_limits(path))
{
}

SeparateModelRead::SeparateModelRead(const std::string& path, const ProcessLimits& limits)
    : path_(path),
      work_(
          [&path] {
            return parse_answer(
                path, [](const Hdf5Content& content) { return serialize(parse_motion_model(content)); });
          },
          path, limits)
{
}

MotionModel SeparateModelRead::model()
{
  const std::string answer = text_of_complete(work_.wait_for_result(), path_);
  return deserialize_motion_model(value_of(answer, path_), path_);
}

MotionModel read_motion_model(const std::string& path)
{
  return SeparateModelRead(path).model();
}

Trace read_trace(const std::string& path)
{
  const std::string answer =
      read_in_process(path, [](const Hdf5Content& content) { return serialize(parse_trace(content)); });
  return trace_of(value_of(answer, path), path);
}

std::vector<Finding> validate_hdf5(const std::string& path)
{
  const std::string answer = read_in_process(path, [](const Hdf5Content& content) {
    BinaryWriter stream;
    for (const Finding& finding : findings_in(content))
      for (const std::string* text : {&finding.where, &finding.found, &finding.wanted})
        stream.write_value(*text);
    return stream.take();
  });
  BinaryReader stream(value_of(answer, path), path);
  std::vector<Finding> findings;
  while (stream.left() > 0) {
    Finding& finding = findings.emplace_back();
    for (std::string* text : {&finding.where, &finding.found, &finding.wanted}) stream.read_value(*text);
  }
  return findings;
}

namespace {

/// System calls that the C and C++ libraries, zlib and HDF5 need for open files and memory.
constexpr std::initializer_list<int> allowed_calls{
    SCMP_SYS(read),       SCMP_SYS(write),      SCMP_SYS(pread64),       SCMP_SYS(pwrite64),
    SCMP_SYS(lseek),      SCMP_SYS(close),      SCMP_SYS(fstat),         SCMP_SYS(brk),
    SCMP_SYS(munmap),     SCMP_SYS(mremap),     SCMP_SYS(madvise),       SCMP_SYS(futex),
    SCMP_SYS(exit),       SCMP_SYS(exit_group), SCMP_SYS(rt_sigreturn),  SCMP_SYS(rt_sigaction),
    SCMP_SYS(getpid),     SCMP_SYS(gettid),     SCMP_SYS(tgkill),        SCMP_SYS(rt_sigprocmask),
    SCMP_SYS(getrandom),  SCMP_SYS(getrusage),  SCMP_SYS(clock_gettime), SCMP_SYS(gettimeofday),
    SCMP_SYS(sched_yield)};

int load_filter(scmp_filter_ctx filter)
{
  for (const int call : allowed_calls)
    if (const int error = seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, 0); error != 0) return error;
  // Memory, but not executable memory.
  for (const int call : {SCMP_SYS(mmap), SCMP_SYS(mprotect)}) {
    const int error =
        seccomp_rule_add(filter, SCMP_ACT_ALLOW, call, 1, SCMP_A2(SCMP_CMP_MASKED_EQ, PROT_EXEC, 0));
    if (error != 0) return error;
  }
  return seccomp_load(filter);  // sets no_new_privs too
}

}  // namespace

std::string confine_this_process()
{
  if (is_sanitized) return {};
  const std::unique_ptr<void, decltype(&seccomp_release)> filter(seccomp_init(SCMP_ACT_ERRNO(EPERM)),
                                                                 &seccomp_release);
  const int error = filter ? load_filter(filter.get()) : -ENOMEM;
  return error == 0 ? "" : std::strerror(-error);
}

namespace {

constexpr std::string_view magic = "VRDASEAL";
constexpr std::size_t seal_bytes = 16;
std::atomic<bool> accepts_unsealed = false;

std::uint64_t little_endian(std::string_view bytes)
{
  std::uint64_t value = 0;
  for (std::size_t i = bytes.size(); i-- > 0;) value = value << 8 | static_cast<unsigned char>(bytes[i]);
  return value;
}

/// End of the HDF5 content from its superblock (version 2 or 3); 0 for another version.
std::uint64_t content_end(std::string_view bytes)
{
  if (bytes.size() < 36 || (bytes[8] != 2 && bytes[8] != 3)) return 0;
  return little_endian(bytes.substr(28, 8));
}

std::string bytes_of_file(const std::string& file)
{
  const auto refuse = [&](const std::string& found) { throw InputError({file, "", found, intact_file}); };
  const OpenFile open_file(
      open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));  // does not block on a FIFO
  struct stat status = {};
  if (!open_file.is_open() || fstat(open_file.get(), &status) != 0) refuse(std::strerror(errno));
  if (!S_ISREG(status.st_mode)) refuse("not a regular file");
  std::string bytes(static_cast<std::size_t>(status.st_size), '\0');
  for (std::size_t n_read = 0; n_read < bytes.size();) {
    const ssize_t n = read(open_file.get(), bytes.data() + n_read, bytes.size() - n_read);
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) refuse(std::string("a read error (") + std::strerror(errno) + ")");
    if (n == 0) refuse("a file that was truncated while being read");
    n_read += static_cast<std::size_t>(n);
  }
  return bytes;
}

/// The HDF5 content must begin at byte 0: an HDF5 "user block" before it would not be checked.
void require_signature(const std::string& file, std::string_view bytes)
{
  constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
  if (bytes.substr(0, signature.size()) == signature) return;
  throw InputError(
      {file, "", std::to_string(bytes.size()) + " bytes that are not an HDF5 file", intact_file});
}

void require_whole(const std::string& file, std::string_view bytes)
{
  const std::uint64_t end = content_end(bytes);
  if (end == 0 || end == bytes.size()) return;
  const char* problem = bytes.size() < end ? " bytes, a truncated file" : " bytes, a damaged end of file";
  throw InputError({file, "", std::to_string(bytes.size()) + problem,
                    intact_file + std::string(" of ") + std::to_string(end) + " bytes"});
}

}  // namespace

std::string seal_of(std::string_view content)
{
  // CRC-32 of ISO 3309.
  const uLong crc = crc32_z(0, reinterpret_cast<const Bytef*>(content.data()), content.size());
  std::string bytes(magic);
  for (int shift = 0; shift < 32; shift += 8) bytes.push_back(static_cast<char>(crc >> shift & 0xffu));
  bytes.resize(seal_bytes, '\0');
  return bytes;
}

void accept_unsealed_files(bool accepts)
{
  accepts_unsealed = accepts;
}

Hdf5Content read_hdf5(const std::string& file)
{
  std::string bytes = bytes_of_file(file);
  require_signature(file, bytes);
  const std::size_t sealed = bytes.size() < seal_bytes ? 0 : bytes.size() - seal_bytes;
  const std::string tail = bytes.substr(sealed);
  if (tail.compare(0, magic.size(), magic) == 0) {
    bytes.resize(sealed);
    if (tail == seal_of(bytes)) return {file, std::move(bytes)};
    throw InputError({file, "", "a damaged file (its checksum does not match)", intact_file});
  }
  require_whole(file, bytes);
  if (accepts_unsealed) return {file, std::move(bytes)};
  throw InputError({file, "", "a file without a seal, written or changed by another program",
                    "a sealed motion model or trace, or the option --unsealed"});
}

namespace {

template <typename Content>
std::string bytes_of(const Content& content)
{
  BinaryWriter stream;
  // Counted first, so that one allocation suffices.
  stream.count();
  visit_registry(content, stream);
  stream.reserve_counted();
  visit_registry(content, stream);
  return stream.take();
}

template <typename Content>
Content content_of(std::string_view bytes, const std::string& file)
{
  Content content;
  BinaryReader stream(bytes, file);
  visit_registry(content, stream);
  if constexpr (std::is_same_v<Content, MotionModel>)
    if (!content.has_compartments) set_no_compartments(content);
  require_no_findings(check_values(content), file);
  return content;
}

}  // namespace

std::string serialize(const MotionModel& model)
{
  return bytes_of(model);
}

MotionModel deserialize_motion_model(std::string_view bytes, const std::string& file)
{
  return content_of<MotionModel>(bytes, file);
}

std::string serialize(const Trace& trace)
{
  return bytes_of(trace);
}

Trace trace_of(std::string_view bytes, const std::string& file)
{
  return content_of<Trace>(bytes, file);
}

}  // namespace vrda::store
