// Malicious motion models: each gives one InputError, in bounded memory and time.
#include <fcntl.h>
#include <gmock/gmock.h>
#include <hdf5.h>
#include <hdf5_hl.h>
#include <sys/mman.h>
#include <sys/prctl.h>
#include <sys/resource.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <csignal>
#include <filesystem>
#include <iostream>
#include <limits>
#include <memory>
#include <new>
#include <vector>

#include "core/units.hpp"
#include "store/model_checks.hpp"
#include "store/motion_model.hpp"
#include "store/read_separately.hpp"
#include "store/sample_model.hpp"
#include "store/trace.hpp"
#include "support/damaged_models.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"
#include "support/traces.hpp"

namespace vrda::hostile_file_test {

using test::expect_first;
using test::findings_after;
using test::replace;
using ::testing::HasSubstr;

/// The error of reading a file, changed by `action`, in a separate process.
InputError::Facts refusal_of(const test::Scratch& scratch, const std::function<void(hid_t)>& action)
{
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, test::sample_model());
  test::change(path, action);
  return test::input_error([&] { store::read_motion_model(path); });
}

InputError::Facts refusal_of_bytes(const test::Scratch& scratch, const std::string& bytes)
{
  const std::string path = scratch.write("knee.h5", bytes);
  return test::input_error([&] { store::read_motion_model(path); });
}

/// Peak memory of the largest child process so far; never decreases.
long peak_kb_of_children()
{
  rusage usage = {};
  getrusage(RUSAGE_CHILDREN, &usage);
  return usage.ru_maxrss;
}

TEST(ReadApart, GivesTheSameModelAndTheSameErrors)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, test::with_derived(test::sample_model()));
  test::expect_equal(store::parse_motion_model(store::read_hdf5(path)), store::read_motion_model(path));
  const std::string trace = store::trace_name(path);
  store::write_trace(trace, test::trace_beside(test::sample_model()));
  EXPECT_EQ(store::read_trace(trace).moves.theta_deg,
            store::parse_trace(store::read_hdf5(trace)).moves.theta_deg);
  for (const std::string& wrong :
       {trace, std::string("absent.h5"), scratch.write("text.h5", "no model").string()}) {
    const InputError::Facts here =
        test::input_error([&] { store::parse_motion_model(store::read_hdf5(wrong)); });
    EXPECT_THAT(test::input_error([&] { store::read_motion_model(wrong); }),
                test::refuses({wrong, here.field, here.found, here.wanted}));
  }
}

/// Writes `n` chunks, each of the same compressed zeros.
void write_zeros(hid_t dataset, hsize_t n_chunks, hsize_t rows_of_chunk)
{
  // The compressed bytes of the first chunk as written by HDF5.
  const std::vector<double> zeros(3 * rows_of_chunk, 0.0);
  const hid_t file_space = H5Dget_space(dataset);
  const hsize_t start[] = {0, 0}, count[] = {rows_of_chunk, 3};
  H5Sselect_hyperslab(file_space, H5S_SELECT_SET, start, nullptr, count, nullptr);
  const hid_t memory_space = H5Screate_simple(2, count, nullptr);
  ASSERT_GE(H5Dwrite(dataset, H5T_NATIVE_DOUBLE, memory_space, file_space, H5P_DEFAULT, zeros.data()), 0);
  H5Dflush(dataset);
  hsize_t size = 0;
  ASSERT_GE(H5Dget_chunk_storage_size(dataset, start, &size), 0);
  std::vector<char> packed(size);
  std::uint32_t filters = 0;
  ASSERT_GE(H5Dread_chunk(dataset, H5P_DEFAULT, start, &filters, packed.data()), 0);
  for (hsize_t k = 1; k < n_chunks; ++k) {
    const hsize_t at[] = {k * rows_of_chunk, 0};
    ASSERT_GE(H5Dwrite_chunk(dataset, H5P_DEFAULT, filters, at, size, packed.data()), 0);
  }
  H5Sclose(memory_space);
  H5Sclose(file_space);
}

/// Arrays over `axis` of `n_chunks` chunks of zeros, of 1 MiB each and packed into a kilobyte.
void pack_zeros(hid_t file, const char* axis, hsize_t n_chunks, const std::vector<const char*>& arrays)
{
  constexpr hsize_t rows = 43'690;
  const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
  const hsize_t chunk[] = {rows, 3};
  H5Pset_chunk(creation, 2, chunk);
  H5Pset_deflate(creation, 9);
  test::promise(file, axis, rows * n_chunks, arrays, creation);
  const hid_t scale = H5Dopen2(file, axis, H5P_DEFAULT);
  for (const char* path : arrays) {
    const hid_t dataset = H5Dopen2(file, path, H5P_DEFAULT);
    write_zeros(dataset, n_chunks, rows);
    H5DSattach_scale(dataset, scale, 0);
    H5Dclose(dataset);
  }
  H5Dclose(scale);
  H5Pclose(creation);
}

// Ten gigabytes of zeros in ten megabytes are refused before they are unpacked.
TEST(HostileFile, PackedZeros)
{
  const test::Scratch scratch;
  const long before_kb = peak_kb_of_children();
  const InputError::Facts facts = refusal_of(scratch, [](hid_t file) {
    pack_zeros(file, "/bodies/reference/vertex", 10'240,
               {"/bodies/reference/vertices", "/bodies/reference/normals"});
  });
  EXPECT_LT(std::filesystem::file_size(scratch.path() / "knee.h5"), 30'000'000U);
  EXPECT_EQ(facts.file, scratch.path() / "knee.h5");
  EXPECT_FALSE(facts.found.empty());
  // The child process starts as a copy of this one. Sanitizers need memory of their own.
  constexpr long most_kb = store::is_sanitized ? std::numeric_limits<long>::max() : 400L * 1024;
  EXPECT_LT(peak_kb_of_children(), std::max(before_kb, most_kb));
}

// 30 million vertices, whose values take 720 MB: more than the limit, however they are stored.
TEST(HostileFile, TooManyValues)
{
  const std::vector<store::Finding> findings = findings_after(test::sample_model(), [](hid_t file) {
    pack_zeros(file, "/bodies/moving/vertex", 700, {"/bodies/moving/vertices"});
  });
  EXPECT_EQ(findings.back().where, "/");
  EXPECT_TRUE(test::names_value(findings.back().found, "bytes")) << findings.back().found;
  EXPECT_TRUE(test::names_value(findings.back().wanted, "536870912")) << findings.back().wanted;
}

TEST(HostileFile, SharedTexts)
{
  // 2000 input files whose names all refer to one heap object of 60,000 letters: 120 MB.
  store::MotionModel model = test::sample_model();
  const std::string sum(64, 'a');
  model.job.inputs = {{std::string(60'000, 'x'), sum}};
  for (int k = 1; k < 2000; ++k) model.job.inputs.push_back({"file " + std::to_string(k), sum});
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, model);
  haddr_t address = HADDR_UNDEF;
  test::change(path, [&](hid_t file) {
    const hid_t dataset = H5Dopen2(file, "/job/input_name", H5P_DEFAULT);
    address = H5Dget_offset(dataset);
    H5Dclose(dataset);
  });
  ASSERT_NE(address, HADDR_UNDEF);
  std::string bytes = test::read_bytes(path);
  constexpr std::size_t element_bytes = 16;  // length, address of the heap, index
  const std::string first = bytes.substr(address, element_bytes);
  for (std::size_t k = 1; k < 2000; ++k) bytes.replace(address + k * element_bytes, element_bytes, first);
  bytes.resize(bytes.size() - store::seal_of("").size());
  bytes += store::seal_of(bytes);
  EXPECT_THAT(refusal_of_bytes(scratch, bytes), test::refuses({.field = "/job/input_name", .found = "HDF5"}));
}

TEST(HostileFile, CrashOfHdf5)
{
  if (store::is_sanitized) GTEST_SKIP() << "the sanitizer ends the process before the crash";
  // The size of the first text in HDF5's heap is set to a huge value; the seal matches the changed file.
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, test::sample_model());
  std::string bytes = test::read_bytes(path);
  bytes.resize(bytes.size() - store::seal_of("").size());
  const std::size_t heap = bytes.find("GCOL");
  ASSERT_NE(heap, std::string::npos);
  int n_ended = 0;
  for (std::size_t at = heap + 24; at < heap + 32; ++at) {
    std::string changed = bytes;
    changed[at] = '\xff';
    const InputError::Facts facts = refusal_of_bytes(scratch, changed + store::seal_of(changed));
    EXPECT_EQ(facts.file, path);
    n_ended += test::names_value(facts.found, "process") ? 1 : 0;
  }
  // HDF5 1.10.8 crashes on some. If a later version rejects all, the separate process is no longer needed.
  EXPECT_GT(n_ended, 0);
}

// The list of findings is bounded.
TEST(HostileFile, ManyLinks)
{
  const std::vector<store::Finding> links = findings_after(test::sample_model(), [](hid_t file) {
    for (int k = 0; k < 1500; ++k)
      H5Lcreate_soft("/tx", file, ("/link" + std::to_string(k)).c_str(), H5P_DEFAULT, H5P_DEFAULT);
  });
  EXPECT_LT(links.size(), 110u);
  EXPECT_TRUE(test::names_value(links[0].found, "symbolic link")) << links[0].found;
}

TEST(HostileFile, VirtualDataset)
{
  const test::Scratch scratch;
  // Opening this one would block forever.
  const std::string pipe = scratch.path() / "elsewhere.h5";
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  const InputError::Facts facts = refusal_of(scratch, [&](hid_t file) {
    const hsize_t size[] = {4, 3}, largest[] = {H5S_UNLIMITED, 3}, start[] = {0, 0};
    const hsize_t count[] = {H5S_UNLIMITED, 1}, block[] = {1, 3};
    const hid_t space = H5Screate_simple(2, size, largest);
    H5Sselect_hyperslab(space, H5S_SELECT_SET, start, nullptr, count, block);
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    H5Pset_layout(creation, H5D_VIRTUAL);
    ASSERT_GE(H5Pset_virtual(creation, space, pipe.c_str(), "/tx", space), 0);
    test::remove(file, "/tx");
    const hid_t dataset = H5Dcreate2(file, "/tx", H5T_IEEE_F64LE, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    ASSERT_GE(dataset, 0);
    H5Dclose(dataset);
    H5Pclose(creation);
    H5Sclose(space);
  });
  EXPECT_THAT(facts, test::refuses({.field = "/tx", .found = "virtual"}));
}

TEST(HostileFile, NoPlugins)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, test::sample_model());
  // In this process; whatever another test left.
  ASSERT_GE(H5PLset_loading_state(H5PL_ALL_PLUGIN), 0);
  store::parse_motion_model(store::read_hdf5(path));
  unsigned state = H5PL_ALL_PLUGIN;
  EXPECT_GE(H5PLget_loading_state(&state), 0);
  EXPECT_EQ(state, 0u);
}

TEST(HostileFile, HugeChunks)
{
  const auto act = [](hid_t file) {
    const hid_t creation = H5Pcreate(H5P_DATASET_CREATE);
    const hsize_t chunk[] = {30'000, 10'000}, largest[] = {H5S_UNLIMITED, H5S_UNLIMITED};
    H5Pset_chunk(creation, 2, chunk);
    H5Pset_deflate(creation, 1);
    test::remove(file, "/tx");
    const hsize_t size[] = {4, 3};
    const hid_t space = H5Screate_simple(2, size, largest);
    const hid_t dataset = H5Dcreate2(file, "/tx", H5T_IEEE_F64LE, space, H5P_DEFAULT, creation, H5P_DEFAULT);
    std::vector<char> packed(2000, 'x');
    const hsize_t at[] = {0, 0};
    H5Dwrite_chunk(dataset, H5P_DEFAULT, 0, at, packed.size(), packed.data());
    H5Dclose(dataset);
    H5Sclose(space);
    H5Pclose(creation);
  };
  expect_first(findings_after(test::sample_model(), act), "/tx", "chunks larger than the dataset",
               "can be read");
}

TEST(HostileFile, UserBlock)
{
  const test::Scratch scratch;
  const std::string path = scratch.path() / "knee.h5";
  store::write_motion_model(path, test::sample_model());
  const std::string whole = test::read_bytes(path);
  EXPECT_THAT(refusal_of_bytes(scratch, std::string(512, '\0') + whole), test::refuses({.found = "HDF5"}));
}

TEST(SeparateProcess, AnswersWithWhateverBytes)
{
  for (const std::size_t size : {0u, 1u, 5'000'000u}) {
    std::string text(size, '\0');
    for (std::size_t i = 0; i < size; ++i) text[i] = static_cast<char>(i % 251);
    const store::ProcessResult answer = store::run_separately([&] { return text; }, "x");
    EXPECT_TRUE(answer.is_complete);
    EXPECT_EQ(answer.text, text);
  }
}

TEST(SeparateProcess, LeavesThisOneAlone)
{
  int changed = 0;
  const store::ProcessResult answer = store::run_separately(
      [&] {
        changed = 1;
        std::cout << "not to be seen" << std::flush;
        return std::to_string(getpid());
      },
      "x");
  EXPECT_EQ(changed, 0);
  EXPECT_NE(answer.text, std::to_string(getpid()));
}

TEST(SeparateProcess, GoesOnWhileThisOneDoes)
{
  void* const memory =
      mmap(nullptr, sizeof(std::atomic<char>), PROT_READ | PROT_WRITE, MAP_SHARED | MAP_ANONYMOUS, -1, 0);
  ASSERT_NE(memory, MAP_FAILED);
  auto& byte = *new (memory) std::atomic<char>('\0');
  store::SeparateProcess work(
      [&] {
        while (byte == '\0') usleep(1000);
        return std::string(1, byte);
      },
      "x");
  // The child waits for this; if it had run synchronously, the test would block.
  byte = 'y';
  EXPECT_EQ(work.wait_for_result().text, "y");
  munmap(memory, sizeof(std::atomic<char>));
}

TEST(SeparateProcess, IsEndedIfItsResultIsNotCollected)
{
  {
    const store::SeparateProcess endless(
        []() -> std::string {
          for (;;) pause();
        },
        "x");
  }
  EXPECT_EQ(waitpid(-1, nullptr, WNOHANG), -1);
  EXPECT_EQ(errno, ECHILD);
}

TEST(SeparateProcess, ThatEndsBadlySaysHow)
{
  struct Row {
    std::function<std::string()> work;
    const char* how;
  };
  for (const Row& row : {Row{[]() -> std::string {
                               std::raise(SIGKILL);
                               return "x";
                             },
                             "signal 9"},
                         Row{[]() -> std::string { std::abort(); }, "signal 6"},
                         Row{[]() -> std::string { _exit(3); }, "exit code 3"}}) {
    const store::ProcessResult answer = store::run_separately(row.work, "x");
    EXPECT_FALSE(answer.is_complete);
    EXPECT_EQ(answer.text, row.how);
  }
}

TEST(SeparateProcess, HasNoneOfTheOpenFiles)
{
  std::array<int, 2> ends{};
  ASSERT_EQ(pipe(ends.data()), 0);
  const store::ProcessResult answer = store::run_separately(
      [&] { return std::string(write(ends[1], "x", 1) < 0 && errno == EBADF ? "none" : "open"); }, "x");
  EXPECT_EQ(answer.text, "none");
  close(ends[0]);
  close(ends[1]);
}

// Each of these succeeds before the confinement and fails after it.
TEST(Confinement, OpensNoFileAndNoSocketStartsNoProgramAndRunsNoNewCode)
{
  if (store::is_sanitized) GTEST_SKIP() << "sanitizers open files for their reports";
  const auto tried = [] {
    std::string done;
    const auto note = [&](const char* what, bool is_done) { done += is_done ? what : ""; };
    note("open ", open("/dev/null", O_RDONLY) >= 0);
    note("socket ", socket(AF_UNIX, SOCK_STREAM, 0) >= 0);
    const pid_t child = fork();
    if (child == 0) _exit(execl("/bin/true", "true", nullptr));
    int status = -1;
    note("exec ", child > 0 && waitpid(child, &status, 0) == child && status == 0);
    note("code ",
         mmap(nullptr, 4096, PROT_READ | PROT_EXEC, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0) != MAP_FAILED);
    note("memory ", std::make_unique<char[]>(std::size_t{8} << 20) != nullptr);
    return done;
  };
  const store::ProcessResult answer = store::run_separately(
      [&] {
        const std::string before =
            "no_new_privs=" + std::to_string(prctl(PR_GET_NO_NEW_PRIVS, 0, 0, 0, 0)) + " " + tried();
        const std::string why = store::confine_this_process();
        return before + "then " + why + tried();
      },
      "x");
  EXPECT_EQ(answer.text, "no_new_privs=1 open socket exec code memory then memory ");
}

TEST(SeparateProcess, HasLimits)
{
  store::ProcessLimits limits;
  limits.processor_s = 1;
  limits.result_bytes = 1000;
  volatile bool goes_on = true;
  const store::ProcessResult endless = store::run_separately(
      [&] {
        while (goes_on) {
        }
        return std::string();
      },
      "x", limits);
  EXPECT_FALSE(endless.is_complete);
  EXPECT_TRUE(endless.text == "signal 9" || endless.text == "more than 1 s of processor time")
      << endless.text;
  const store::ProcessResult long_answer =
      store::run_separately([] { return std::string(2000, 'x'); }, "x", limits);
  EXPECT_FALSE(long_answer.is_complete);
  EXPECT_TRUE(test::names_value(long_answer.text, "1000 bytes")) << long_answer.text;
}

TEST(SeparateProcess, HasNoMoreMemoryThanAllowed)
{
  if (store::is_sanitized) GTEST_SKIP() << "sanitizers need memory of their own";
  store::ProcessLimits limits;
  limits.memory_bytes = std::uint64_t{64} << 20;
  const store::ProcessResult answer = store::run_separately(
      [] {
        try {
          const std::vector<char> large(std::size_t{128} << 20, 1);
          return std::to_string(large.size());
        } catch (const std::bad_alloc&) {
          return std::string("refused");
        }
      },
      "x", limits);
  EXPECT_EQ(answer.text, "refused");
}

}  // namespace vrda::hostile_file_test
