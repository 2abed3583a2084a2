/// A table of published or measured laxities, and its comparison with a result.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "analysis/laxity.hpp"

namespace vrda::analysis {

/// One row of the table; angles in degrees and lengths in mm, as written.
struct PublishedValue {
  std::string test;  ///< name of a test, or of both directions together ("anterior-posterior")
  double flexion_deg = 0.0;
  double load = nan;   ///< N or N mm; NaN: the whole load of the job
  double value = 0.0;  ///< mm or degrees
  double sd = nan;     ///< standard deviation over subjects; NaN: not given
  std::string source;
};

/// Parses the CSV text (schemas/laxity.md). Throws InputError naming file, line and column.
std::vector<PublishedValue> published_values(const std::string& file, std::string_view text);

struct Compared {
  PublishedValue published;
  double found = nan;   ///< of the intact joint, mm or degrees; NaN outside the job's flexions or loads
  std::string missing;  ///< why there is no difference
  double difference() const { return found - published.value; }
};

/// The value of the intact joint at the row's flexion and load, linear between the job's.
std::vector<Compared> compared(const LaxityResult& result, const std::vector<PublishedValue>& published);

/// Whether a name is that of a test or of both directions together.
bool is_test_name(const std::string& name);

/// Angles in degrees, lengths in mm.
double in_file_unit(const TestKind& kind, double value);

}  // namespace vrda::analysis
