/// Building blocks of a registry's rows, and the parts of the motion model's.
#pragma once

#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "model/scaling.hpp"
#include "model/step_record.hpp"
#include "store/motion_model.hpp"
#include "store/registry_visitor.hpp"

namespace vrda::store {

namespace registry {

inline ValueRule number()
{
  return {.rule = Rule::number};
}
inline ValueRule number(const ValueCondition& answered)
{
  return {.rule = Rule::number, .condition = answered};
}
inline ValueRule number_or_nan(const ValueCondition& answered = {})
{
  return {.rule = Rule::number_or_nan, .condition = answered};
}
inline ValueRule at_least_0(const ValueCondition& answered)
{
  return {.rule = Rule::number, .condition = answered, .least = 0.0};
}
inline ValueRule above_0()
{
  return {.rule = Rule::number, .least = 0.0, .excludes_least = true};
}
inline ValueRule integer(double least, double largest)
{
  return {.rule = Rule::integer, .least = least, .largest = largest};
}
inline ValueRule count()
{
  return integer(0, std::numeric_limits<std::int32_t>::max());
}
/// Row indices of a table of `n` rows, from `least`.
inline ValueRule row_of(Eigen::Index n, double least = 0)
{
  return integer(least, static_cast<double>(n - 1));
}
inline ValueRule row_starts(std::size_t n_entries)
{
  return {.rule = Rule::row_starts, .largest = static_cast<double>(n_entries)};
}
inline ValueRule rule(Rule rule, const ValueCondition& answered = {})
{
  return {.rule = rule, .condition = answered};
}
inline ValueRule codes(FlagSet flags, const ValueCondition& answered = {})
{
  return {.rule = Rule::codes, .condition = answered, .flags = flags};
}

template <typename Codes>
ValueCondition where_stable(const Codes& status)
{
  return {ValueCondition::When::at_code, values_of(status), status_stable, "where status is stable"};
}

/// Visits one text member of a list's elements as a column; a reader resizes the list.
template <typename List, typename Text>
void visit_column(RowVisitor& visit, const Dataset& dataset, List& list, Text text)
{
  std::vector<std::string> column;
  for (const auto& element : list) column.push_back(element.*text);
  visit(dataset, column);
  if (!visit.may_change()) return;
  list.resize(column.size());
  for (std::size_t i = 0; i < column.size(); ++i) list[i].*text = column[i];
}

/// Whether an optional part exists; a reader creates it if the file has it.
template <typename Optional>
bool has_optional(RowVisitor& visit, const std::string& path, Optional& part)
{
  const bool found = visit.has(path, part.has_value());
  if (found && !part) part.emplace();
  return found;
}

/// Translation in the world frame and rotation about Delta of a motion's poses.
template <typename Poses>
void visit_poses(Poses& poses, const std::string& group, const std::vector<std::string>& dimensions,
                 const ValueRule& valid, RowVisitor& visit)
{
  visit({group + "/tx", dimensions, unit::mm, valid, "translation along X of the world frame W"},
        poses.tx_mm);
  visit({group + "/ty", dimensions, unit::mm, valid, "translation along Y of the world frame W"},
        poses.ty_mm);
  visit({group + "/tz", dimensions, unit::mm, valid, "translation along Z of the world frame W"},
        poses.tz_mm);
  visit({group + "/theta", dimensions, unit::degree, valid, "rotation about Delta, right-knee sign"},
        poses.theta_deg);
}

/// Centres of contact of the compartments, of the cells or of the zero-varus motion.
template <typename Paths>
void visit_paths(Paths& paths, const std::string& group, const std::vector<std::string>& dimensions,
                 const ValueCondition& answered, RowVisitor& visit)
{
  const ValueRule points = rule(Rule::whole_rows, answered);
  visit({group + "/medial_reference", dimensions, unit::mm, points,
         "centre of contact of the medial compartment, canonical axes of the reference body"},
        paths.medial_reference_mm);
  visit({group + "/medial_moving", dimensions, unit::mm, points,
         "centre of contact of the medial compartment, canonical axes of the moving body"},
        paths.medial_moving_mm);
  visit({group + "/lateral_reference", dimensions, unit::mm, points,
         "centre of contact of the lateral compartment, canonical axes of the reference body"},
        paths.lateral_reference_mm);
  visit({group + "/lateral_moving", dimensions, unit::mm, points,
         "centre of contact of the lateral compartment, canonical axes of the moving body"},
        paths.lateral_moving_mm);
}

struct AuditedModel {
  bool has_compartments, has_frames;
};

void visit_smoothed(SmoothedSet& set, RowVisitor& visit);
void visit_two_sided(TwoSided& motion, RowVisitor& visit);
void visit_repair(RepairedFrames& repair, RowVisitor& visit);
void visit_zero_varus(ZeroVarus& motion, bool has_compartments, RowVisitor& visit);
void visit_audit(AuditSet& audit, const AuditedModel& model, RowVisitor& visit);
void visit_push(PushRows& push, RowVisitor& visit);
void visit_equilibrium(MotionModel& model, RowVisitor& visit);
void visit_coordinates(MotionModel& model, RowVisitor& visit);
void visit_ligaments(MotionModel& model, RowVisitor& visit);
void visit_uncertainty(UncertainMotion& motion, bool has_fibres, RowVisitor& visit);
void visit_inputs(std::vector<InputFile>& inputs, RowVisitor& visit);

}  // namespace registry
}  // namespace vrda::store
