#include "app/shipped_warnings.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <sstream>

#include "support/messages.hpp"

namespace vrda::test {
namespace {

struct Warning {
  const char* job;
  const char* command;  ///< of both commands if it is empty
  std::string about;
  Values values;
  const char* reason;
};

constexpr const char* open_sheet = "cartilage is segmented as a sheet without its side at the bone";
constexpr const char* as_segmented = "the mesh is the published segmentation, unchanged";
constexpr const char* both_methods = "the campaign compares both methods on one job with ligaments";

constexpr const char* no_ligaments = "without ligaments a real tibia turns and slides off";

const Warning warnings[] = {
    {"knee-vhf-left", "run", "/plausibility", {"6 dislocated", "9"}, no_ligaments},
    {"knee-vhf-right", "run", "/plausibility", {"3 dislocated", "9"}, no_ligaments},
    {"knee-pymskt-dess", "run", "/plausibility", {"1 border_contact", "9"}, as_segmented},
    {"knee-jam-smith2019", "run", "/plausibility", {"1 border_contact", "9"}, open_sheet},
    {"knee-jam-smith2019", "", "", {"\"meniscus_lateral\"", "intersect", "2"}, as_segmented},
    {"knee-pymskt-dess", "", "", {"\"tibia_bone\"", "holes"}, as_segmented},
    {"knee-pymskt-dess", "", "", {"\"tibia_bone\"", "winding", "1"}, as_segmented},
    {"knee-pymskt-dess", "", "", {"\"meniscus_medial\"", "holes"}, as_segmented},
    {"knee-pymskt-dess", "", "", {"\"meniscus_medial\"", "winding", "3"}, as_segmented},
    {"campaign-example search", "run", "ligaments", "stability search", both_methods},
    {"campaign-example search", "run", "push.force_n", "stability search", both_methods},
};

}  // namespace

std::vector<std::string> shipped_jobs()
{
  return {"ankle-generic",
          "hip-generic",
          "knee-generic",
          "knee-generic-contact",
          "knee-jam-smith2019",
          "knee-jam-smith2019-ligaments",
          "knee-pymskt-dess",
          "knee-vhf-left",
          "knee-vhf-right",
          "subtalar-01",
          "validation/ball-in-dish",
          "validation/ball-on-non-monotone-slope",
          "validation/bar-on-pyramids",
          "validation/cap-in-sink",
          "validation/peg-in-hole"};
}

void expect_known_warnings(const std::string& job, const std::string& command, const Ended& ended)
{
  std::vector<testing::Matcher<std::string>> known;
  for (const Warning& row : warnings) {
    const std::string of_command = row.command;
    if (row.job == job && (of_command.empty() || of_command == command))
      known.emplace_back(warns(row.about, row.values));
  }
  std::vector<std::string> printed;
  std::istringstream lines(ended.out + ended.err);
  for (std::string line; std::getline(lines, line);)
    // The range of varus of these runs is narrower than their band of contact.
    if (line.starts_with("warning: ") && line.find("/zero_varus/is_cut_off") == std::string::npos)
      printed.push_back(line);
  EXPECT_THAT(printed, testing::UnorderedElementsAreArray(known)) << job << ", vrda " << command;
}

}  // namespace vrda::test
