/// Small jobs for the command line, and how to run it.
#pragma once

#include <filesystem>
#include <string>

#include "support/process.hpp"
#include "support/scratch.hpp"

namespace vrda::test {

/// `vrda` with these words.
Command vrda(const std::vector<std::string>& words);
Ended run_vrda(const std::vector<std::string>& words);

/// A ball under a dish given as STL files in the folder, 3 x 5 attitudes, joint = "other"; solved in well
/// under a second. Returns the job file.
std::filesystem::path small_job(const Scratch& scratch);

/// The same as a right or left knee of two balls under a plate with two dents, 7 x 5 attitudes, mirrored for
/// the left.
std::filesystem::path small_knee_job(const Scratch& scratch, const std::string& side);

/// small_knee_job with some hundred attitudes: long enough to be met in the middle.
std::filesystem::path longer_knee_job(const Scratch& scratch);

/// Until the file has `n` bytes or the process has ended.
void wait_for_bytes(Process& process, const std::filesystem::path& file, std::uintmax_t n);

std::string text_of(const std::filesystem::path& file);

/// `vrda run` of the job must end with exit code 2 and one line that says all of these words; no output then.
void expect_refused(const std::filesystem::path& job, const std::filesystem::path& output,
                    const std::vector<std::string>& words);

/// How many lines a program said.
std::ptrdiff_t n_lines(const std::string& text);

/// Replaces the first `from` in a file by `to`; the text must be there.
void edit(const std::filesystem::path& file, const std::string& from, const std::string& to);

/// The hash a user would compare: `sha256sum` of the file.
std::string sha256_of_file(const std::filesystem::path& file);

}  // namespace vrda::test
