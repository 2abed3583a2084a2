#include "store/trace_file.hpp"

#include <span>

#include "core/error.hpp"
#include "core/whole_file.hpp"
#include "store/dataset_writer.hpp"
#include "store/seal.hpp"
#include "store/trace_binding.hpp"
#include "store/trace_layout.hpp"
#include "store/trace_values.hpp"

namespace vrda {
namespace {

void write_attributes(H5Writer& writer, const Trace& trace)
{
  writer.write_attribute("/", "format", std::string(trace_format_name));
  writer.write_attribute("/", "format_version", std::string(trace_format_version));
  writer.write_attribute("/", "Conventions", std::string(conventions));
  writer.write_attribute("/", "title", trace.title);
  writer.write_attribute("/", "side", trace.side);
  writer.write_attribute("/", "job_key", trace.job_key);
  writer.write_attribute("/", "approach_step_mm", std::span<const double>(&trace.approach_step_mm, 1));
  writer.write_attribute("/", "translation_resolution_mm",
                         std::span<const double>(&trace.translation_resolution_mm, 1));
  writer.write_attribute("/", "rotation_resolution_deg",
                         std::span<const double>(&trace.rotation_resolution_deg, 1));
}

std::string bytes_of(const std::string& path, const Trace& trace)
{
  const FileLayout layout = trace_layout_of(shape_of(trace));
  H5Writer writer(path);
  write_attributes(writer, trace);
  for (const std::string& group : layout.groups) writer.create_group(group);
  visit_trace(trace, DatasetWriter(writer, layout));
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
  write_whole(path, {content, seal_of(content)});
}

void require_beside(const Trace& trace, const std::string& trace_file, const MotionModel& model,
                    const std::string& model_file)
{
  const std::vector<Finding> findings = check_beside(trace, model);
  if (findings.empty()) return;
  throw InputError({trace_file, findings[0].where, findings[0].found,
                    findings[0].wanted + ", the trace of " + model_file});
}

}  // namespace vrda
