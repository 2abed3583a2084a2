// A motion model to HDF5: attributes, then the datasets of the layout, sealed and written atomically.
#include <algorithm>
#include <filesystem>

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "store/h5_visitors.hpp"
#include "store/motion_model_file.hpp"
#include "store/registry.hpp"
#include "store/seal.hpp"

namespace vrda::store {
namespace {

/// Preconditions of the registry.
void require_consistent(const MotionModel& model)
{
  check(model.equilibrium.has_value() == (model.method == "equilibrium"),
        "equilibrium surfaces must exist exactly for method equilibrium");
  check(model.contact_paths.has_value() == model.has_compartments,
        "contact paths must exist exactly where there are compartments");
  for (const SmoothedSet& set : model.smoothed) {
    check(set.surfaces.size() == 4 || set.surfaces.size() == 5,
          "a smoothed set must have four or five surfaces");
    for (std::size_t i = 0; i < set.surfaces.size(); ++i)
      check(set.surfaces[i].name == smoothed_names[i],
            "the surfaces of a smoothed set must be tx, ty, tz, theta, varus");
  }
  const auto is_unsorted = [](const auto& list, auto is_before) {
    return std::adjacent_find(list.begin(), list.end(),
                              [&](const auto& a, const auto& b) { return !is_before(a, b); }) != list.end();
  };
  check(!is_unsorted(model.smoothed, [](const auto& a, const auto& b) { return a.degree < b.degree; }),
        "smoothed sets must be sorted by degree, each degree once");
  check(!is_unsorted(model.audits, [](const auto& a, const auto& b) { return a.name < b.name; }),
        "audits must be sorted by name, each name once");
  for (const AuditSet& audit : model.audits)
    check(is_audit_name(audit.name), "an audit must have the name of a motion");
}

std::string bytes_of(const std::string& path, const MotionModel& model)
{
  require_consistent(model);
  H5Writer writer(path);
  write_format(writer, format_name, format_version);
  write_hdf5(writer, [&](Hdf5WriteVisitor& visitor) { visit_motion_model(model, visitor); });
  return writer.bytes();
}

/// Journals are removed after this file is written, so the content on disk is verified.
void require_written(const std::string& path, std::size_t n_bytes)
{
  std::error_code error;
  const std::uintmax_t n_found = std::filesystem::file_size(path, error);
  if (error || n_found != n_bytes) {
    throw InputError({path, "", error ? error.message() : std::to_string(n_found) + " bytes on the disk",
                      "the " + std::to_string(n_bytes) + " bytes just written"});
  }
  read_hdf5(path);
}

}  // namespace

void write_motion_model(const std::string& path, const MotionModel& model)
{
  const std::string content = bytes_of(path, model);
  const std::string seal = seal_of(content);
  write_atomically(path, {content, seal});
  require_written(path, content.size() + seal.size());
}

}  // namespace vrda::store
