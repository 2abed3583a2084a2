#include "app/compare_command.hpp"

#include <algorithm>
#include <charconv>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <set>

#include "app/compare_text.hpp"
#include "audit/audit.hpp"
#include "audit/recontact.hpp"
#include "compare/compare.hpp"
#include "core/error.hpp"
#include "run/solved_model.hpp"

namespace vrda {
namespace {

[[noreturn]] void refuse(const std::string& text)
{
  throw InputError({"vrda compare", "--degrees", "\"" + text + "\"",
                    "degrees from 0 to " + std::to_string(largest_smoothed_degree) +
                        " as a range or a list: 1..12 or 2,4,6"});
}

int degree_of(const std::string& word, const std::string& text)
{
  int degree = -1;
  const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), degree);
  const bool is_whole = error == std::errc() && end == word.data() + word.size();
  if (!is_whole || degree < 0 || degree > largest_smoothed_degree) refuse(text);
  return degree;
}

CompareOptions compare_options(const CompareCommandOptions& options)
{
  const int n_threads = threads_or_all(options.n_threads);
  CompareOptions compare;
  compare.name = options.file;
  compare.degrees = degrees_of(options.degrees);
  compare.smooth.is_robust = options.is_robust;
  if (options.is_recontacted) {
    compare.recontact = [n_threads](const MotionModel& model, const SmoothedSet& set) {
      return recontact(model, set, n_threads);
    };
  }
  if (options.refine > 0) {
    compare.audit = [n_threads, refine = options.refine](const MotionModel& model, const std::string& set) {
      say("measuring " + set);
      return audit(model, set, refine, n_threads);
    };
  }
  return compare;
}

void say_what_is_missing(const std::string& file, const Comparison& comparison)
{
  if (!comparison.degrees_not_carried.empty()) {
    say(file + ": the solved cells carry no degree from " +
        std::to_string(comparison.degrees_not_carried.front()) + " on");
  }
  for (const DegreeRow& row : comparison.rows) {
    if (!row.is_converged)
      warn("degree " + std::to_string(row.set.degree) +
           ": the robust weights had not settled after all steps");
  }
}

}  // namespace

std::vector<int> degrees_of(const std::string& text)
{
  std::set<int> degrees;
  for (std::size_t from = 0; from <= text.size();) {
    const std::size_t comma = std::min(text.find(',', from), text.size());
    const std::string part = text.substr(from, comma - from);
    const std::size_t dots = part.find("..");
    const int first = degree_of(part.substr(0, dots), text);
    const int last = dots == std::string::npos ? first : degree_of(part.substr(dots + 2), text);
    if (last < first) refuse(text);
    for (int degree = first; degree <= last; ++degree) degrees.insert(degree);
    from = comma + 1;
  }
  return {degrees.begin(), degrees.end()};
}

ExitCode compare_command(const CompareCommandOptions& options)
{
  const CompareOptions compare_with = compare_options(options);
  const Comparison comparison = compare(read_solved_model(options.file), compare_with);
  say_what_is_missing(options.file, comparison);
  if (!options.as_json) {
    std::printf("%s%s\n", table_of(comparison).c_str(), sentence_of(comparison.recommendation).c_str());
    return ExitCode::done;
  }
  nlohmann::ordered_json json = {{"file", options.file},
                                 {"robust", options.is_robust},
                                 {"recontacted", options.is_recontacted},
                                 {"refine", options.refine}};
  json.update(json_of(comparison));
  std::printf("%s\n", json.dump(2).c_str());
  return ExitCode::done;
}

}  // namespace vrda
