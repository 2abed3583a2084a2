#include "store/trace_file.hpp"

#include "core/atomic_file.hpp"
#include "core/error.hpp"
#include "store/h5_visitors.hpp"
#include "store/seal.hpp"
#include "store/trace_registry.hpp"
#include "store/values.hpp"

namespace vrda::store {
namespace {

std::string bytes_of(const std::string& path, const Trace& trace)
{
  H5Writer writer(path);
  write_format(writer, trace_format_name, trace_format_version);
  write_hdf5(writer, [&](Hdf5WriteVisitor& visitor) { visit_trace(trace, visitor); });
  return writer.bytes();
}

}  // namespace

std::string trace_name(const std::string& motion_model_file)
{
  const std::string ending = ".h5";
  const bool has_ending =
      motion_model_file.size() > ending.size() &&
      motion_model_file.compare(motion_model_file.size() - ending.size(), ending.size(), ending) == 0;
  return motion_model_file.substr(0, motion_model_file.size() - (has_ending ? ending.size() : 0)) +
         ".trace.h5";
}

void write_trace(const std::string& path, const Trace& trace)
{
  const std::string content = bytes_of(path, trace);
  write_atomically(path, {content, seal_of(content)});
}

void require_trace_matches_model(const Trace& trace, const std::string& trace_file, const MotionModel& model,
                                 const std::string& model_file)
{
  const std::vector<Finding> findings = compare_trace(trace, model);
  if (findings.empty()) return;
  throw InputError({trace_file, findings[0].where, findings[0].found,
                    findings[0].wanted + ", the trace of " + model_file});
}

}  // namespace vrda::store
