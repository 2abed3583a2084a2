/// Runs work on untrusted bytes in a separate process that may crash.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <string_view>

#include "store/motion_model.hpp"
#include "store/trace.hpp"

namespace vrda::store {

struct ProcessLimits {
  std::uint64_t memory_bytes = std::uint64_t{512} << 20;  ///< beyond the memory this process has mapped
  std::uint64_t result_bytes = std::uint64_t{256} << 20;
  unsigned processor_s = 5;  ///< several hundred times the time of a typical model
};

/// How the process ended.
struct ProcessResult {
  bool is_complete = false;
  std::string text;  ///< result of `work`; if not complete, how the process ended: "signal 11"
};

/// Runs `work` in a forked child process while this process continues. The child has the limits and no open
/// files of this process, writes no core and no terminal output, and ends with this process; side effects of
/// `work` are lost. `work` must not throw. Threads are not copied: locks that other threads hold at the fork
/// stay locked in the child, so no other thread may use what `work` uses. Memory is not limited under address
/// and thread sanitizers. Throws InputError naming `subject` if the process cannot be created.
class SeparateProcess {
 public:
  SeparateProcess(const std::function<std::string()>& work, std::string subject,
                  const ProcessLimits& limits = {});
  /// Kills the child if its result was not taken.
  ~SeparateProcess();
  SeparateProcess(const SeparateProcess&) = delete;
  SeparateProcess& operator=(const SeparateProcess&) = delete;

  /// Waits for the end of the child. May be called once.
  ProcessResult wait_for_result();

 private:
  int wait();  // status of the child from waitpid

  std::string subject_;
  ProcessLimits limits_;
  int file_ = -1;   // result of the child
  int child_ = -1;  // -1 after wait()
};

/// Runs `work` in a child process and waits for its result.
ProcessResult run_separately(const std::function<std::string()>& work, const std::string& subject,
                             const ProcessLimits& limits = {});

// Motion models and traces from untrusted files.
//
// HDF5 1.10 crashes on some crafted files with a valid seal and plausible values. So HDF5 parses the bytes
// in a separate process (store/read_separately.hpp), confined after reading them (store/read_separately.hpp).
// It returns serialized values, which are checked again here. A crash of that process is an InputError.

/// Asynchronous read_motion_model: the constructor starts the separate process, model() waits for its result.
/// No other thread may use HDF5 during construction.
class SeparateModelRead {
 public:
  explicit SeparateModelRead(const std::string& path);
  SeparateModelRead(const std::string& path, const ProcessLimits& limits);
  /// Waits for the process and returns its model. May be called once.
  MotionModel model();

 private:
  std::string path_;
  SeparateProcess work_;
};

/// Limits for reading the file at `path`: memory of 512 MB or eight times the file's size if that is more.
ProcessLimits reading_limits(const std::string& path);

/// `report` is called once, with the reason, if the kernel rejects the confinement of a reading process; its
/// limits still apply. Without a callback nothing is reported.
void on_unconfined_read(std::function<void(const std::string&)> report);

// System call filter (seccomp) of the current process.

/// Whether address or thread sanitizers are enabled, which exceed memory limits and open files for reports.
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
inline constexpr bool is_sanitized = true;
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
inline constexpr bool is_sanitized = true;
#else
inline constexpr bool is_sanitized = false;
#endif
#else
inline constexpr bool is_sanitized = false;
#endif

/// Restricts this process to computing, allocating memory, reading and writing open files, and exiting. The
/// kernel refuses every other system call with EPERM: no file, socket, program or thread can be opened or
/// started. Returns an empty string, or the reason why the kernel rejected the filter. Does nothing under
/// address and thread sanitizers, whose reports need to open files.
std::string confine_this_process();

// Seal: a trailer after the HDF5 content with 8 bytes "VRDASEAL", the CRC-32 of all bytes before it and 4
// zero bytes. HDF5 programs ignore it, and truncate it when they change the file. Why: HDF5 1.10 has
// checksums for its headers and for compressed values, but not for its heaps; one flipped bit there causes
// reads out of bounds (measured: a crash for most bytes of a heap).

/// The "wanted" text of messages about damaged files.
inline constexpr const char* intact_file = "an intact motion model or trace (HDF5)";

/// An HDF5 file in memory, without its seal.
struct Hdf5Content {
  std::string file;  ///< its name, for messages
  std::string bytes;
};

/// The seal to append to a file with this HDF5 content.
std::string seal_of(std::string_view content);

/// Sets whether this process accepts files without a seal (changed by another program). Default: no.
void accept_unsealed_files(bool accepts = true);

/// Reads the whole file. Throws InputError when it is absent, not a regular HDF5 file, or damaged, or when
/// its seal does not match or is missing and unsealed files are not accepted.
Hdf5Content read_hdf5(const std::string& file);

// Serialization of motion models and traces to pass them between processes. Not a file format.

/// Preconditions as for write_motion_model and write_trace.
std::string serialize(const MotionModel& model);
std::string serialize(const Trace& trace);

/// Inverse of serialize. For any bytes: never reads beyond them, and allocates at most ten times their number
/// plus some MB. Throws InputError naming `file` if the values violate the specification.
MotionModel deserialize_motion_model(std::string_view bytes, const std::string& file);
Trace trace_of(std::string_view bytes, const std::string& file);

}  // namespace vrda::store
