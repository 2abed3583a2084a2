/// Files of laxity tests (schemas/laxity.md): the document, tables and a page.
#pragma once

#include <string>
#include <vector>

#include "analysis/laxity.hpp"
#include "analysis/published_values.hpp"

namespace vrda::analysis {

struct LaxityDocument {
  std::string program, solver;            ///< that wrote it, and the solver's version
  std::string title, joint, side, job;    ///< of the job; its resolved text
  std::vector<job::LoadedInput> inputs;  ///< names and hashes
  LaxityResult result;
  std::vector<Compared> compared;  ///< empty without published values
};

/// Text of laxity.json. Angles in degrees, lengths in mm; every number reads back exactly.
std::string laxity_json(const LaxityDocument& document);

/// One row per state, flexion, test and both directions together: laxity, position and its change by the cut.
std::string laxity_csv(const LaxityDocument& document);

/// One row per state, flexion and test and bundle: force and share.
std::string share_csv(const LaxityDocument& document);

/// A self-contained HTML page: tables, laxity over flexion, load against displacement, shares.
std::string laxity_page(const LaxityDocument& document);

/// The curve of a state, flexion and test; null if there is no such test.
const LaxityCurve* curve_of(const LaxityResult& result, std::size_t state, std::size_t flexion,
                            LaxityTest test);

}  // namespace vrda::analysis
