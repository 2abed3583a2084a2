// The tables of the pages in schemas/, from the registries.

#include <algorithm>
#include <limits>
#include <map>
#include <set>
#include <sstream>

#include "store/registry.hpp"
#include "store/sample_model.hpp"

namespace vrda::test {
namespace {

std::string replaced(std::string text, const std::string& old, const std::string& now)
{
  const std::size_t at = text.find(old);
  return at == std::string::npos ? text : text.replace(at, old.size(), now);
}

/// The page's notation: B for both bodies, N for the degree, NAME for the audited motion or the follower.
std::string on_page(const std::string& path)
{
  for (const std::string group : {"/audit/", "/followers/"})
    if (path.rfind(group, 0) == 0)
      return replaced(group + "NAME" + path.substr(path.find('/', group.size())), "/bead/", "/FOLLOWER/");
  return replaced(
      replaced(replaced(replaced(path, "/bodies/reference", "/bodies/B"), "/bodies/moving", "/bodies/B"),
               "degree_1", "degree_N"),
      "/bead/", "/FOLLOWER/");
}

std::string codes_text(store::FlagSet flags)
{
  const store::FlagTable table = store::flag_table(flags);
  std::istringstream words(table.meanings);
  std::string text, word;
  for (const std::int8_t value : table.values) {
    words >> word;
    text += (text.empty() ? "" : ", ") + std::to_string(value) + " " + word;
  }
  return text;
}

std::string last_name(const std::string& path)
{
  return path.substr(path.rfind('/') + 1);
}

std::string valid_text(const store::Dataset& dataset)
{
  // The registry is that of a sample file, whose number of rows is not a limit of the format.
  if (dataset.valid.rule == store::Rule::integer &&
      dataset.valid.largest < std::numeric_limits<std::int32_t>::max())
    return (dataset.valid.least < 0.0 ? "-1" : "0") + std::string(" to the number of rows - 1");
  if (dataset.flags() == store::FlagSet::none) return store::rule_text(dataset.valid);
  const bool is_partly = dataset.valid.condition.when != store::ValueCondition::When::always;
  return codes_text(dataset.flags()) +
         (is_partly ? std::string("; 0 or 1 ") + dataset.valid.condition.text + ", -1 elsewhere" : "");
}

class TableRows : public store::RegistryVisitor {
 public:
  std::vector<std::pair<std::string, std::string>> rows;  ///< path on the page, and its line

  void visit_dataset(const store::Dataset& dataset, Member member) override
  {
    const store::ValueKind kind = store::kind_of(member);
    const std::string path = on_page(dataset.path);
    if (!seen_.insert(path).second) return;
    std::string dimensions;
    for (const std::string& dimension : dataset.dimensions)
      dimensions += (dimensions.empty() ? "" : ", ") + last_name(dimension);
    rows.push_back({path, "| `" + path + "` | " + (dimensions.empty() ? "none" : dimensions) + " | " +
                              (kind == store::ValueKind::text ? "text" : core::name_of(kind)) + " | " +
                              dataset.units.name + " | " + on_page(dataset.long_name) + " | " +
                              valid_text(dataset) + " |\n"});
  }

 private:
  std::set<std::string> seen_;
};

}  // namespace

std::string with_tables(const std::string& page, bool is_trace)
{
  TableRows table;
  if (is_trace) {
    const store::Trace trace;
    store::visit_registry(trace, table);
  } else {
    const store::MotionModel whole = whole_model(),
                             free = with_derived(sample_model({4, 1, true, true, false})),
                             frames = frames_model();
    for (const store::MotionModel* model : {&whole, &free, &frames}) store::visit_registry(*model, table);
  }
  const std::string mark = "<!-- table ";
  std::istringstream lines(page);
  std::vector<std::string> groups;
  for (std::string line; std::getline(lines, line);)
    if (line.rfind(mark, 0) == 0) groups.push_back(line.substr(mark.size(), line.rfind(' ') - mark.size()));
  // Each row belongs to the longest group that contains it.
  std::map<std::string, std::string> tables;
  for (const auto& [path, row] : table.rows) {
    const std::string* best = nullptr;
    for (const std::string& group : groups)
      if (path.rfind(group, 0) == 0 && (best == nullptr || group.size() > best->size())) best = &group;
    tables[best == nullptr ? "" : *best] += row;
  }
  std::istringstream old(page);
  std::string result;
  bool is_in_table = false;
  for (std::string line; std::getline(old, line);) {
    if (is_in_table && line.rfind("|", 0) == 0) continue;
    is_in_table = line.rfind(mark, 0) == 0;
    result += line + "\n";
    if (!is_in_table) continue;
    result += "| path | dimensions | type | unit | meaning | values |\n|---|---|---|---|---|---|\n" +
              tables[line.substr(mark.size(), line.rfind(' ') - mark.size())];
  }
  return result + tables[""];
}

}  // namespace vrda::test
