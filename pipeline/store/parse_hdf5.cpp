#include "store/parse_hdf5.hpp"

#include <cmath>

#include "core/error.hpp"
#include "store/h5_reader.hpp"
#include "store/h5_visitors.hpp"
#include "store/registry.hpp"
#include "store/structure.hpp"
#include "store/trace_registry.hpp"
#include "store/value_findings.hpp"
#include "store/values.hpp"

namespace vrda::store {
namespace {

MotionModel read_model_values(const H5Reader& reader, Structure<MotionModel> structure)
{
  MotionModel model = std::move(structure.content);
  visit_motion_model(model, Hdf5ReadVisitor(reader, structure.sizes));
  if (!model.has_compartments) set_no_compartments(model);
  return model;
}

Trace read_trace_values(const H5Reader& reader, Structure<Trace> structure)
{
  visit_trace(structure.content, Hdf5ReadVisitor(reader, structure.sizes));
  return std::move(structure.content);
}

/// Checks an attribute that repeats a number computed from the group's datasets.
void check_repeated(const H5Reader& reader, const std::string& group, const std::string& name, double wanted,
                    std::vector<Finding>& findings)
{
  const std::optional<AttributeValue> attribute = reader.attribute(group, name);
  check(attribute && attribute->numbers.size() == 1, "the structure must have been checked");
  const double found = attribute->numbers[0];
  if (found == wanted || (std::isnan(found) && std::isnan(wanted))) return;
  findings.push_back(
      {group + "@" + name, text_of(found), text_of(wanted) + ", the value from the group's datasets"});
}

std::vector<Finding> findings_of(const H5Reader& reader, const MotionModel& model)
{
  std::vector<Finding> findings;
  for (const SmoothedSet& set : model.smoothed)
    check_repeated(reader, smoothed_group(set.degree), "degree", set.degree, findings);
  for (const AuditSet& audit : model.audits) {
    const AuditSummary summary = summary_of(audit);
    const std::string group = audit_group(audit.name);
    check_repeated(reader, group, "largest_penetration", summary.largest_penetration_mm, findings);
    check_repeated(reader, group, "largest_gap", summary.largest_gap_mm, findings);
  }
  for (Finding& finding : check_values(model)) findings.push_back(std::move(finding));
  return findings;
}

}  // namespace

MotionModel parse_motion_model(const Hdf5Content& content)
{
  const H5Reader reader(content);
  Structure<MotionModel> structure = structure_of_model(reader);
  require_no_findings(structure.findings, content.file);
  MotionModel model = read_model_values(reader, std::move(structure));
  require_no_findings(findings_of(reader, model), content.file);
  return model;
}

Trace parse_trace(const Hdf5Content& content)
{
  const H5Reader reader(content);
  Structure<Trace> structure = structure_of_trace(reader);
  require_no_findings(structure.findings, content.file);
  Trace trace = read_trace_values(reader, std::move(structure));
  require_no_findings(check_values(trace), content.file);
  return trace;
}

std::vector<Finding> findings_in(const Hdf5Content& content)
{
  const H5Reader reader(content);
  const std::optional<AttributeValue> format = reader.attribute("/", "format");
  try {
    if (format && format->texts == std::vector<std::string>{trace_format_name}) {
      Structure<Trace> structure = structure_of_trace(reader);
      if (!structure.findings.empty()) return structure.findings;
      return check_values(read_trace_values(reader, std::move(structure)));
    }
    Structure<MotionModel> structure = structure_of_model(reader);
    if (!structure.findings.empty()) return structure.findings;
    return findings_of(reader, read_model_values(reader, std::move(structure)));
  } catch (const InputError& error) {
    // A damaged chunk is detected only when its values are read.
    return {{error.facts().field, error.facts().found, error.facts().wanted}};
  }
}

}  // namespace vrda::store
