#include "run/index.hpp"

#include <algorithm>
#include <array>
#include <deque>
#include <filesystem>
#include <memory>
#include <nlohmann/json.hpp>

#include "run/case_spec.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "store/run_files.hpp"
#include "job/input_file.hpp"
#include "store/index_table.hpp"
#include "store/read_separately.hpp"

namespace vrda::run {
namespace {

namespace fs = std::filesystem;

bool file_exists(const std::string& path)
{
  std::error_code ignored;
  return fs::exists(path, ignored);
}

// Whether a run or a shard has left a start file or journal next to its output.
bool is_started(const std::string& output)
{
  if (file_exists(store::start_file_of(output)) || file_exists(store::journal_of(output))) return true;
  return file_exists(store::spine_journal_of(output)) ||
         !store::list_shard_journals_if_readable(output).empty();
}

std::optional<CaseTimes> times_beside(const std::string& output)
{
  const std::optional<std::string> text = read_text_file(output + ".run.json");
  if (!text) return std::nullopt;
  try {
    const auto json = nlohmann::json::parse(*text);
    return CaseTimes{json.at("begun"),         json.at("host"),
                     json.at("seconds"),       json.at("solving_processor_seconds"),
                     json.at("threads"),       json.at("processors"),
                     json.at("steps_recalled")};
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;  // not part of the results, so not an error
  }
}

void add_model(IndexRow& row, const store::MotionModel& model)
{
  const std::string bytes =
      job::file_bytes(row.file, {row.file, "", "", "a motion model"}, run::largest_model_bytes);
  row.title = model.title;
  row.joint = model.joint;
  row.side = model.side;
  row.solver = model.method;
  row.curve = index_curve_of(model);
  row.numbers = index_numbers_of(model, static_cast<double>(bytes.size()));
  row.sha256 = job::sha256_of(bytes);
  row.status = CaseStatus::done;
}

// One value per row.
template <typename Value, typename Of>
std::vector<Value> each(const std::vector<IndexRow>& rows, const Of& of)
{
  std::vector<Value> values;
  values.reserve(rows.size());
  for (const IndexRow& row : rows) values.push_back(of(row));
  return values;
}

template <typename Of>
store::IndexColumn text_column(const std::string& name, const std::string& what,
                               const std::vector<IndexRow>& rows, const Of& of)
{
  return {name, "", what, each<std::string>(rows, of), store::FlagSet::none};
}

struct TextColumn {
  const char* name;
  const char* what;
  std::string IndexRow::*value;
};

constexpr TextColumn texts[] = {
    {"remark", "reason of the failure", &IndexRow::remark},
    {"title", "title of the job", &IndexRow::title},
    {"joint", "knee, hip, ankle, subtalar or other", &IndexRow::joint},
    {"side", "right or left", &IndexRow::side},
    {"solver", "method that solved the case", &IndexRow::solver},
    {"curve", "motion over flexion used for the curve columns", &IndexRow::curve},
};

std::string relative_to(const fs::path& folder, const std::string& file)
{
  return fs::path(file).lexically_relative(folder).generic_string();
}

void add_numbers(std::vector<store::IndexColumn>& columns, const std::vector<IndexRow>& rows)
{
  for (std::size_t k = 0; k < index_numbers().size(); ++k) {
    const IndexNumber& number = index_numbers()[k];
    const auto value = [k](const IndexRow& row) { return row.numbers.empty() ? nan : row.numbers.at(k); };
    columns.push_back(
        {number.name, number.units, number.long_name, each<double>(rows, value), store::FlagSet::none});
  }
}

store::IndexTable table_of(const fs::path& folder, const std::string& title,
                           const std::vector<std::string>& axes, const std::vector<IndexRow>& rows)
{
  store::IndexTable table{title, {}};
  std::vector<store::IndexColumn>& columns = table.columns;
  columns.push_back(text_column("case", "name of the case", rows, [](const auto& r) { return r.name; }));
  for (std::size_t a = 0; a < axes.size(); ++a) {
    columns.push_back(text_column(axes[a], "level of this campaign axis", rows,
                                  [a](const auto& r) { return r.levels.at(a); }));
  }
  const auto code = [](const IndexRow& row) { return static_cast<std::int8_t>(row.status); };
  columns.push_back(
      {"status", "", "progress of the case", each<std::int8_t>(rows, code), store::FlagSet::case_status});
  for (const TextColumn& text : texts) {
    columns.push_back(text_column(text.name, text.what, rows, [&](const auto& r) { return r.*text.value; }));
  }
  add_numbers(columns, rows);
  columns.push_back(text_column("sha256", "SHA-256 of the motion model's file", rows,
                                [](const auto& r) { return r.sha256; }));
  columns.push_back(text_column("file", "path of the motion model, relative to this file's folder", rows,
                                [&](const auto& r) { return relative_to(folder, r.file); }));
  return table;
}

store::IndexTable times_of(const std::vector<IndexRow>& rows)
{
  store::IndexTable table;
  std::vector<store::IndexColumn>& columns = table.columns;
  columns.push_back(text_column("case", "", rows, [](const auto& r) { return r.name; }));
  columns.push_back(
      text_column("begun", "", rows, [](const auto& r) { return r.times ? r.times->started : ""; }));
  columns.push_back(
      text_column("host", "", rows, [](const auto& r) { return r.times ? r.times->host : ""; }));
  const auto add = [&](const char* name, const auto& of) {
    const auto value = [&](const IndexRow& row) {
      return row.times ? static_cast<double>(of(*row.times)) : nan;
    };
    columns.push_back({name, "", "", each<double>(rows, value), store::FlagSet::none});
  };
  add("seconds", [](const CaseTimes& t) { return t.seconds; });
  add("solving_processor_seconds", [](const CaseTimes& t) { return t.solving_processor_seconds; });
  add("threads", [](const CaseTimes& t) { return t.n_threads; });
  add("processors", [](const CaseTimes& t) { return t.n_processors; });
  add("steps_recalled", [](const CaseTimes& t) { return t.n_recalled; });
  return table;
}

std::string absolute_path(const std::string& path)
{
  return fs::absolute(path).lexically_normal().string();
}

IndexRow row_of(const IndexedCase& one, store::SeparateModelRead* reading)
{
  IndexRow row;
  row.name = one.name;
  row.levels = one.levels;
  row.file = absolute_path(one.model_path);
  if (reading == nullptr) {
    row.status = is_started(row.file) ? CaseStatus::partial : CaseStatus::missing;
    return row;
  }
  row.times = times_beside(row.file);
  try {
    const store::MotionModel model = reading->model();
    store::require_grid(model, row.file, "an index");
    add_model(row, model);
  } catch (const InputError& error) {
    row.status = CaseStatus::failed;
    // Without the folder, so that the index does not depend on its location.
    const InputError::Facts& facts = error.facts();
    row.remark =
        (facts.field.empty() ? "" : facts.field + ": ") + "found " + facts.found + ", wanted " + facts.wanted;
  }
  return row;
}

}  // namespace

const char* name_of(CaseStatus status)
{
  constexpr std::array<const char*, 4> names{"done", "partial", "failed", "missing"};
  return names.at(static_cast<std::size_t>(status));
}

std::string index_file_of(const std::string& folder)
{
  return folder + "/index.h5";
}

std::vector<IndexRow> index_rows(const std::vector<IndexedCase>& cases, int n_processes)
{
  std::vector<IndexRow> rows;
  std::deque<std::unique_ptr<store::SeparateModelRead>> pending;  // null if there is no model
  const auto n_pending = static_cast<std::size_t>(std::max(1, n_processes));
  for (std::size_t k = 0; k < cases.size(); ++k) {
    for (std::size_t next = k + pending.size(); next < std::min(cases.size(), k + n_pending); ++next) {
      const std::string file = absolute_path(cases[next].model_path);
      pending.push_back(file_exists(file) ? std::make_unique<store::SeparateModelRead>(file) : nullptr);
    }
    rows.push_back(row_of(cases[k], pending.front().get()));
    pending.pop_front();
  }
  return rows;
}

void publish_index(Publication& publication, const std::string& folder, const std::string& title,
                   const std::vector<std::string>& axes, const std::vector<IndexRow>& rows)
{
  const fs::path root = fs::absolute(folder).lexically_normal();
  const store::IndexTable table = table_of(root, title, axes, rows);
  publication.add((root / "index.csv").string(), store::index_csv(table));
  publication.add((root / "index.times.csv").string(), store::index_csv(times_of(rows)));
  publication.publish(store::index_bytes(index_file_of(root.string()), table));
}

}  // namespace vrda::run
