// A sample index.
#include "store/sample_model.hpp"

#include <limits>

namespace vrda::test {

store::IndexTable sample_index()
{
  using Texts = std::vector<std::string>;
  store::IndexTable table;
  table.title = "Three cases (étude)";
  table.columns.push_back({"case", "", "name of the case", Texts{"a_rest", "a_search", "b_rest"}});
  table.columns.push_back(
      {"status", "", "how far it is", std::vector<std::int8_t>{0, 2, 3}, store::FlagSet::case_status});
  table.columns.push_back({"remark", "", "why", Texts{"", "a \"quoted\", longer\nremark", ""}});
  table.columns.push_back({"gap_mm", "mm", "a length",
                           std::vector<double>{0.125, std::numeric_limits<double>::quiet_NaN(), -1e-5}});
  return table;
}

}  // namespace vrda::test
