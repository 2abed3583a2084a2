#include "app/index_command.hpp"

#include <cstdio>
#include <filesystem>
#include <vector>

#include "cluster/index.hpp"

namespace vrda {

namespace fs = std::filesystem;

ExitCode write_index_of(const std::string& folder, const Submission& submission)
{
  std::vector<IndexRow> rows;
  rows.reserve(submission.cases.size());
  for (const SubmittedCase& c : submission.cases) {
    rows.push_back(index_row({c.spec, c.levels}, output_of(folder, c)));
  }
  write_index(folder, submission.title, submission.axes, rows);
  std::printf("%s\n", (fs::path(folder) / "index.csv").c_str());
  return ExitCode::done;
}

ExitCode index_command(const std::string& folder)
{
  const std::string absolute = fs::absolute(folder).lexically_normal().string();
  return write_index_of(absolute, read_submission(absolute));
}

}  // namespace vrda
