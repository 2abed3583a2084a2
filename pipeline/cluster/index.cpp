#include "cluster/index.hpp"

#include <filesystem>
#include <nlohmann/json.hpp>

#include "cluster/case_spec.hpp"
#include "cluster/file_text.hpp"
#include "cluster/shard.hpp"
#include "core/error.hpp"
#include "core/number_text.hpp"
#include "core/units.hpp"
#include "core/whole_file.hpp"
#include "load/file_bytes.hpp"
#include "store/index_table.hpp"
#include "store/motion_model_file.hpp"

namespace vrda {
namespace {

namespace fs = std::filesystem;

bool is_there(const std::string& path)
{
  std::error_code ignored;
  return fs::exists(path, ignored);
}

// A run, whole or in parts, has begun: what it leaves stands beside its output.
bool is_begun(const std::string& output)
{
  if (is_there(start_file_of(output)) || is_there(journal_of(output))) return true;
  std::error_code ignored;
  const fs::path folder = fs::path(output).parent_path();
  if (!fs::is_directory(folder.empty() ? "." : folder, ignored)) return false;
  return is_there(spine_journal_of(output)) || !shard_journals_beside(output).empty();
}

std::optional<CaseTimes> times_beside(const std::string& output)
{
  const std::optional<std::string> text = text_of_file(output + ".run.json");
  if (!text) return std::nullopt;
  try {
    const auto json = nlohmann::json::parse(*text);
    return CaseTimes{json.at("begun"),         json.at("host"),
                     json.at("seconds"),       json.at("solving_processor_seconds"),
                     json.at("threads"),       json.at("processors"),
                     json.at("steps_recalled")};
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;  // of no result: not worth failing for
  }
}

void add_model(IndexRow& row)
{
  const MotionModel model = read_motion_model(row.file);
  const std::string bytes = file_bytes(row.file, {row.file, "", "", "a motion model"}, largest_model_bytes);
  row.title = model.title;
  row.joint = model.joint;
  row.side = model.side;
  row.solver = model.method;
  row.curve = index_curve_of(model);
  row.numbers = index_numbers_of(model, static_cast<double>(bytes.size()));
  row.sha256 = sha256_of(bytes);
  row.status = CaseStatus::done;
}

// One value a row.
template <typename Value, typename Of>
std::vector<Value> each(const std::vector<IndexRow>& rows, const Of& of)
{
  std::vector<Value> values;
  values.reserve(rows.size());
  for (const IndexRow& row : rows) values.push_back(of(row));
  return values;
}

template <typename Of>
IndexColumn text_column(const std::string& name, const std::string& what, const std::vector<IndexRow>& rows,
                        const Of& of)
{
  return {name, "", what, each<std::string>(rows, of), FlagSet::none};
}

std::string relative_to(const fs::path& folder, const std::string& file)
{
  return fs::path(file).lexically_relative(folder).generic_string();
}

void add_text_of_models(std::vector<IndexColumn>& columns, const std::vector<IndexRow>& rows)
{
  columns.push_back(text_column("title", "title of the job", rows, [](const auto& r) { return r.title; }));
  columns.push_back(text_column("joint", "knee or other", rows, [](const auto& r) { return r.joint; }));
  columns.push_back(text_column("side", "right or left", rows, [](const auto& r) { return r.side; }));
  columns.push_back(
      text_column("solver", "method that solved the case", rows, [](const auto& r) { return r.solver; }));
  columns.push_back(text_column("curve", "motion over flexion that columns are taken from", rows,
                                [](const auto& r) { return r.curve; }));
}

void add_numbers(std::vector<IndexColumn>& columns, const std::vector<IndexRow>& rows)
{
  for (std::size_t k = 0; k < index_numbers().size(); ++k) {
    const IndexNumber& number = index_numbers()[k];
    const auto value = [k](const IndexRow& row) { return row.numbers.empty() ? nan : row.numbers.at(k); };
    columns.push_back(
        {number.name, number.units, number.long_name, each<double>(rows, value), FlagSet::none});
  }
}

IndexTable table_of(const fs::path& folder, const std::string& title, const std::vector<std::string>& axes,
                    const std::vector<IndexRow>& rows)
{
  IndexTable table{title, {}};
  std::vector<IndexColumn>& columns = table.columns;
  columns.push_back(text_column("case", "name of the case", rows, [](const auto& r) { return r.name; }));
  for (std::size_t a = 0; a < axes.size(); ++a) {
    columns.push_back(text_column(axes[a], "level of this axis of the campaign", rows,
                                  [a](const auto& r) { return r.levels.at(a); }));
  }
  const auto code = [](const IndexRow& row) { return static_cast<std::int8_t>(row.status); };
  columns.push_back(
      {"status", "", "how far the case is", each<std::int8_t>(rows, code), FlagSet::case_status});
  columns.push_back(text_column("remark", "why it failed", rows, [](const auto& r) { return r.remark; }));
  add_text_of_models(columns, rows);
  add_numbers(columns, rows);
  columns.push_back(text_column("sha256", "SHA-256 of the motion model's file", rows,
                                [](const auto& r) { return r.sha256; }));
  columns.push_back(text_column("file", "the motion model, from this file's folder", rows,
                                [&](const auto& r) { return relative_to(folder, r.file); }));
  return table;
}

IndexTable times_of(const std::vector<IndexRow>& rows)
{
  IndexTable table;
  std::vector<IndexColumn>& columns = table.columns;
  columns.push_back(text_column("case", "", rows, [](const auto& r) { return r.name; }));
  columns.push_back(
      text_column("begun", "", rows, [](const auto& r) { return r.times ? r.times->begun : ""; }));
  columns.push_back(
      text_column("host", "", rows, [](const auto& r) { return r.times ? r.times->host : ""; }));
  const auto add = [&](const char* name, const auto& of) {
    const auto value = [&](const IndexRow& row) {
      return row.times ? static_cast<double>(of(*row.times)) : nan;
    };
    columns.push_back({name, "", "", each<double>(rows, value), FlagSet::none});
  };
  add("seconds", [](const CaseTimes& t) { return t.seconds; });
  add("solving_processor_seconds", [](const CaseTimes& t) { return t.solving_processor_seconds; });
  add("threads", [](const CaseTimes& t) { return t.n_threads; });
  add("processors", [](const CaseTimes& t) { return t.n_processors; });
  add("steps_recalled", [](const CaseTimes& t) { return t.n_recalled; });
  return table;
}

}  // namespace

const char* name_of(CaseStatus status)
{
  switch (status) {
    case CaseStatus::done:
      return "done";
    case CaseStatus::partial:
      return "partial";
    case CaseStatus::failed:
      return "failed";
    case CaseStatus::missing:
      return "missing";
  }
  return "";
}

IndexRow index_row(const CampaignCase& campaign_case, const std::string& model_path)
{
  IndexRow row;
  row.name = campaign_case.spec.name;
  row.levels = campaign_case.levels;
  row.file = fs::absolute(model_path).lexically_normal().string();
  if (!is_there(row.file)) {
    row.status = is_begun(row.file) ? CaseStatus::partial : CaseStatus::missing;
    return row;
  }
  row.times = times_beside(row.file);
  try {
    add_model(row);
  } catch (const InputError& error) {
    row.status = CaseStatus::failed;
    // Without its folder: the index is the same wherever it was made.
    const InputError::Facts& facts = error.facts();
    row.remark =
        (facts.field.empty() ? "" : facts.field + ": ") + "found " + facts.found + ", wanted " + facts.wanted;
  }
  return row;
}

void write_index(const std::string& folder, const std::string& title, const std::vector<std::string>& axes,
                 const std::vector<IndexRow>& rows)
{
  const fs::path home = fs::absolute(folder).lexically_normal();
  const IndexTable table = table_of(home, title, axes, rows);
  write_index_file((home / "index.h5").string(), table);
  write_whole((home / "index.csv").string(), {index_csv(table)});
  write_whole((home / "index.times.csv").string(), {index_csv(times_of(rows))});
}

}  // namespace vrda
