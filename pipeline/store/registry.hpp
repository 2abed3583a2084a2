/// Registries of the motion model's and of the trace's datasets, and their visitors.
#pragma once

#include <optional>
#include <string>
#include <utility>
#include <variant>
#include <vector>

#include "core/text.hpp"
#include "model/frames.hpp"
#include "model/step_record.hpp"
#include "store/dataset.hpp"
#include "store/motion_model.hpp"
#include "store/trace.hpp"

namespace vrda::store {

/// CF 1.9 is the first to allow 64-bit integers (row_start).
inline constexpr const char* conventions = "CF-1.9";

/// Visits the rows of a registry, in the order of the file. Every function has an empty default.
class RegistryVisitor {
 public:
  using Member =
      std::variant<std::string*, std::vector<std::string>*, std::vector<double>*, std::vector<float>*,
                   std::vector<std::int8_t>*, std::vector<std::int32_t>*, std::vector<std::int64_t>*, GridD*,
                   GridB*, GridI*, Exponents*, Points*, Points32*, Triangles*>;
  using Attribute = std::variant<std::string*, bool*, double*, std::int32_t*, Eigen::Vector3d*>;
  using List = std::variant<std::vector<SmoothedSet>*, std::vector<AuditSet>*, std::vector<PriorTermRows>*,
                            std::vector<FollowerRows>*, std::vector<SmoothedFollower>*,
                            std::vector<FollowerAudit>*, std::vector<UncertainFollower>*>;

  virtual ~RegistryVisitor() = default;
  /// Whether it fills or changes what it visits. The others may visit constant models.
  virtual bool may_change() const { return false; }
  virtual void group(const std::string& /*path*/) {}
  /// Whether an optional object exists: in the model (`is_there`), or in the file being read.
  virtual bool has(const std::string& /*path*/, bool is_there) { return is_there; }
  virtual void dimension(const std::string& path, const DimensionSize& count)
  {
    sizes_.push_back({path, count.n});
  }

  // As the rows call the functions below; a reader fills the members.
  template <typename Type>
  void attribute(const std::string& object, const std::string& name, Type& value,
                 const Unit& units = unit::none)
  {
    visit_attribute(object, name, &value, units);
  }
  /// An attribute that repeats a value stored elsewhere in the model.
  template <typename Type>
  void derived_attribute(const std::string& object, const std::string& name, Type value)
  {
    visit_derived(object, name, &value);
  }
  /// A list with one group per element below `group`.
  template <typename Type>
  void list(const std::string& group, Type& elements)
  {
    visit_list(group, &elements);
  }
  template <typename Type>
  void operator()(const Dataset& dataset, Type& member)
  {
    visit_dataset(dataset, &member);
  }

  /// Size of a dimension that was visited before.
  std::int64_t size(const std::string& path) const
  {
    for (const auto& [known, n] : sizes_)
      if (known == path) return n;
    throw InternalError("a dataset uses a dimension that is not in the registry");
  }
  std::vector<std::int64_t> shape_of(const Dataset& dataset) const
  {
    std::vector<std::int64_t> shape;
    for (const std::string& dimension : dataset.dimensions) shape.push_back(size(dimension));
    return shape;
  }

 protected:
  virtual void visit_attribute(const std::string& /*object*/, const std::string& /*name*/, Attribute,
                               const Unit&)
  {
  }
  virtual void visit_derived(const std::string& /*object*/, const std::string& /*name*/, Attribute) {}
  virtual void visit_list(const std::string& /*group*/, List) {}
  virtual void visit_dataset(const Dataset&, Member) {}

 private:
  std::vector<std::pair<std::string, std::int64_t>> sizes_;
};

/// Calls use(values) with the values of a member as a span.
template <typename Use>
decltype(auto) with_values(const RegistryVisitor::Member& member, const Use& use)
{
  return std::visit([&](auto* all) { return use(values_of(*all)); }, member);
}
inline ValueKind kind_of(const RegistryVisitor::Member& member)
{
  return with_values(member, []<typename Scalar>(std::span<Scalar>) { return value_kind<Scalar>(); });
}

/// One row per dataset (registry.cpp). Writing, reading, checking, scaling and comparing models visit them;
/// the tables of schemas/motion-model.md and trace.md are generated from them.
void visit_registry(MotionModel& model, RegistryVisitor& visit);
void visit_registry(Trace& trace, RegistryVisitor& visit);
/// For a visitor that changes nothing.
template <typename Content>
void visit_registry(const Content& content, RegistryVisitor& visit)
{
  check(!visit.may_change(), "a visitor that changes a model needs one that is not constant");
  visit_registry(const_cast<Content&>(content), visit);
}

inline constexpr const char* trace_format_name = "vrda search trace";
inline constexpr const char* trace_format_version = "1.1";
inline constexpr int trace_format_minor_version = 1;

// Building blocks of a registry's rows, and the parts of the motion model's.

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
/// BodyIndex of a body that is not the world.
inline ValueRule body_number(std::size_t n_followers)
{
  return integer(0, static_cast<double>(1 + n_followers));
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
void visit_column(RegistryVisitor& visit, const Dataset& dataset, List& list, Text text)
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
bool has_optional(RegistryVisitor& visit, const std::string& path, Optional& part)
{
  const bool found = visit.has(path, part.has_value());
  if (found && !part) part.emplace();
  return found;
}

/// Translation in the world frame and rotation about Delta of a motion's poses.
template <typename Poses>
void visit_poses(Poses& poses, const std::string& group, const std::vector<std::string>& dimensions,
                 const ValueRule& valid, RegistryVisitor& visit)
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
inline void visit_paths(ContactPaths& paths, const std::string& group,
                        const std::vector<std::string>& dimensions, const ValueCondition& answered,
                        RegistryVisitor& visit)
{
  const ValueRule points = rule(Rule::whole_rows, answered);
  for (const auto& [side, name, meaning] : compartment_names) {
    const std::string of =
        std::string("centre of contact of the ") + name + " compartment, canonical axes of the ";
    const std::string path = group + '/' + name;
    visit({path + "_reference", dimensions, unit::mm, points, of + "reference body"},
          paths[side].reference_mm);
    visit({path + "_moving", dimensions, unit::mm, points, of + "moving body"}, paths[side].moving_mm);
  }
}

struct AuditedModel {
  bool has_compartments, has_frames;
};

void visit_smoothed(SmoothedSet& set, RegistryVisitor& visit);
void visit_two_sided(TwoSided& motion, RegistryVisitor& visit);
void visit_repair(RepairedFrames& repair, RegistryVisitor& visit);
void visit_zero_varus(ZeroVarus& motion, bool has_compartments, RegistryVisitor& visit);
void visit_audit(AuditSet& audit, const AuditedModel& model, RegistryVisitor& visit);
void visit_push(PushRows& push, RegistryVisitor& visit);
void visit_equilibrium(MotionModel& model, RegistryVisitor& visit);
void visit_coordinates(MotionModel& model, RegistryVisitor& visit);
/// `status` is that of the cells; `n_followers` is 0 for the ligaments of the joint.
void visit_ligaments(LigamentRows& ligaments, const std::string& group, const GridB& status,
                     std::size_t n_followers, RegistryVisitor& visit);
void visit_follower(FollowerRows& follower, const MotionModel& model, RegistryVisitor& visit);
void visit_uncertainty(UncertainMotion& motion, bool has_fibres, RegistryVisitor& visit);
void visit_prior(PriorRows& prior, RegistryVisitor& visit);
void visit_inputs(std::vector<InputFile>& inputs, RegistryVisitor& visit);

}  // namespace registry

}  // namespace vrda::store
