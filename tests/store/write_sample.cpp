// Writes sample motion models, a trace and an index, for checks with other programs:
// write_sample FILE [rich|plain|free|frames|pending|trace|index], and the tables of a page in schemas/:
// write_sample PAGE page
#include <cstdio>
#include <exception>
#include <fstream>
#include <string>

#include "core/files.hpp"
#include "store/motion_model.hpp"
#include "store/sample_model.hpp"
#include "store/trace.hpp"
#include "support/scratch.hpp"
#include "support/traces.hpp"

int main(int argc, char** argv)
{
  if (argc != 3) return 2;
  try {
    const std::string which = argv[2];
    if (which == "page") {
      const std::string name = argv[1];
      const std::string page =
          vrda::test::with_tables(vrda::test::read_bytes(name), name.find("trace") != std::string::npos);
      std::ofstream(name) << page;
      return 0;
    }
    if (which == "index") {
      vrda::write_atomically(argv[1], {vrda::store::index_bytes(argv[1], vrda::test::sample_index())});
      return 0;
    }
    vrda::test::SampleOptions options;
    if (which == "rich") options.n_flexion = 91, options.n_varus = 21, options.n_wraps = 2;
    options.is_equilibrium = which == "rich" || which == "pending";
    options.n_fibres = options.is_equilibrium ? 5 : 0;
    if (which == "plain") options.has_compartments = options.has_visual = false;
    if (which == "free") options.n_varus = 1, options.has_failed_cell = false;
    vrda::store::MotionModel model = vrda::test::sample_model(options);
    if (which == "rich" || which == "free") model = vrda::test::with_derived(model);
    if (which == "frames") model = vrda::test::frames_model();
    if (which == "pending") model = vrda::store::with_pending_cells(model);
    if (which == "trace") {
      vrda::store::write_trace(argv[1], vrda::test::trace_beside(model));
    } else {
      vrda::store::write_motion_model(argv[1], model);
    }
    return 0;
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
}
