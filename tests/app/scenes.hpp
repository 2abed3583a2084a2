/// Small jobs for tests of the command line.
#pragma once

#include <filesystem>
#include <nlohmann/json.hpp>
#include <string>

#include "store/motion_model.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::test {

/// `vrda` with these arguments, then `more`.
Command vrda(std::vector<std::string> words, const std::vector<std::string>& more = {});
Ended run_vrda(const std::vector<std::string>& words, const std::vector<std::string>& more = {});
/// What it prints with --json; expects that exit code.
nlohmann::json json_of(const std::vector<std::string>& words, int exit_code = 0);
/// The valid model that `vrda run` makes of the job with each setting after --set; expects that exit code.
store::MotionModel solved(const std::filesystem::path& job, const std::vector<std::string>& settings = {},
                          int exit_code = 0);

/// With VRDA_FAULTS_ALL set tests of faults and kills cover more calls, settings and interleavings.
bool runs_full_set();

/// A ball under a dish given as STL files in the folder, 3 x 5 attitudes, joint = "other"; solved in well
/// under a second. Returns the job file.
std::filesystem::path small_job(const Scratch& scratch);

/// Edges of a ball from pole to pole and around. Coarser balls are warned of.
struct BallEdges {
  int n_rings = 12, n_sectors = 16;
};

/// A right or left knee of two balls under a plate with two dents, 7 x 5 attitudes; the left one is mirrored.
std::filesystem::path small_knee_job(const Scratch& scratch, const std::string& side,
                                     const BallEdges& edges = {});

/// small_knee_job with some hundred attitudes: long enough to be interrupted.
std::filesystem::path longer_knee_job(const Scratch& scratch);

/// Adds a bead to a job of two balls (small_knee_job, right), pulled against the plate in front of the
/// lateral ball by three lines, and tied to that ball by two fibres. Returns the job.
std::filesystem::path sesamoid_job(const Scratch& scratch, const std::filesystem::path& job);

/// Tables of a laxity test of the generic knee and of a fit to it.
extern const char* const laxity_tables;
extern const char* const fit_tables;

/// Waits until the file has `n` bytes or the process has ended.
void wait_for_bytes(Process& process, const std::filesystem::path& file, std::uintmax_t n);

std::string text_of(const std::filesystem::path& file);

/// Expects `vrda` with these arguments to end with exit code 2, one line that names the refusal, and nothing
/// on standard output.
Ended expect_refused(const std::vector<std::string>& words, const Refusal& refusal);
/// The same of `vrda run`, without an output file.
void expect_run_refused(const std::filesystem::path& job, const std::filesystem::path& output,
                        const Refusal& refusal);

/// A job of the generic knee, coarse, varus free; 48 samples of uncertain stiffnesses and strains for it.
extern const std::string coarse_knee_text;
extern const std::string prior_and_its_spread;
extern const std::string stiffness_and_strain;
/// [uncertainty] of sesamoid_job(): ten samples of the tension of its lines and the stiffness of its tendon.
extern const std::string uncertain_sesamoid;

/// A test in a folder of its own.
class CommandTest : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return (scratch_.path() / name).string(); }
  /// Expects exit code 0.
  static Ended succeed(const std::vector<std::string>& words, const std::vector<std::string>& more = {});
  /// A solved model of small_knee_job(), SIDE.h5; its job and meshes are next to it.
  std::string solved_knee(const std::string& side) const;

  Scratch scratch_;
};

/// Number of lines.
std::ptrdiff_t n_lines(const std::string& text);

/// Replaces the first `from` in a file by `to`; the file must contain it.
void edit(const std::filesystem::path& file, const std::string& from, const std::string& to);

/// Output of `sha256sum` for the file.
std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace vrda::test
