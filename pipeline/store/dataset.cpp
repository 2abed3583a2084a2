#include "store/dataset.hpp"

#include "model/step_record.hpp"

namespace vrda::store {
namespace {

constexpr StepStatus solver_statuses[] = {StepStatus::pending,         StepStatus::stable,
                                          StepStatus::no_contact,      StepStatus::no_clearance,
                                          StepStatus::iteration_limit, StepStatus::unbounded};
constexpr StepStatus search_statuses[] = {StepStatus::pending, StepStatus::stable, StepStatus::no_contact,
                                          StepStatus::no_clearance, StepStatus::iteration_limit};

template <typename Codes>
FlagTable table_of(const Codes& codes)
{
  FlagTable table;
  for (const auto code : codes) {
    table.values.push_back(static_cast<std::int8_t>(code));
    table.meanings += (table.meanings.empty() ? "" : " ") + std::string(name_of(code));
  }
  return table;
}

/// The table of codes that are not listed with their enum.
struct Words {
  FlagSet set;
  FlagTable table;
};

/// Description of the valid values, without the condition where they are defined.
std::string value_text(const ValueRule& valid)
{
  const std::string bound = valid.excludes_least         ? " above " + text_of(valid.least)
                            : std::isfinite(valid.least) ? " of at least " + text_of(valid.least)
                                                         : "";
  switch (valid.rule) {
    case Rule::any:
      return "";
    case Rule::number:
      return valid.condition.when == ValueCondition::When::always && bound.empty()
                 ? "finite numbers of magnitude up to 1e9"
                 : "a number" + bound;
    case Rule::number_or_nan:
      return "a number or NaN";
    case Rule::whole_rows:
      return "rows of numbers, or rows of NaN,";
    case Rule::rigid:
      return "a rotation and a translation";
    case Rule::unit_rows:
    case Rule::exact_unit_rows:
      return "unit vectors";
    case Rule::unit_or_zero_rows:
      return "unit vectors, or zero";
    case Rule::axis:
      return "finite, strictly increasing degrees, at least 1e-6 apart";
    case Rule::ascending:
      return "finite, strictly increasing, at least 1e-9 apart";
    case Rule::integer:
      return "a value from " + text_of(valid.least) + " to " + text_of(valid.largest);
    case Rule::row_starts:
      return "non-decreasing, from 0 to the number of entries";
    case Rule::codes:
      return valid.condition.when == ValueCondition::When::always
                 ? "a code of " + flag_table(valid.flags).meanings
                 : "0 or 1";
    case Rule::names:
      return "non-empty names";
    case Rule::unique_names:
      return "unique non-empty names";
    case Rule::sha256:
      return "64 hexadecimal digits";
  }
  throw InternalError("a rule without a description");
}

}  // namespace

FlagTable flag_table(FlagSet set)
{
  switch (set) {
    case FlagSet::none:
      return {};
    case FlagSet::status:
      return table_of(all_step_statuses);
    case FlagSet::solver_status:
      return table_of(solver_statuses);
    case FlagSet::search_status:
      return table_of(search_statuses);
    case FlagSet::plausibility:
      return table_of(all_plausibilities);
    case FlagSet::move_kind:
      return table_of(all_move_kinds);
    case FlagSet::node:
      return table_of(search_step_kinds);
    default:
      break;
  }
  static const Words word_tables[] = {
      {FlagSet::optional_yes_no, {{-1, 0, 1}, "no_answer no yes"}},
      {FlagSet::yes_no, {{0, 1}, "no yes"}},
      {FlagSet::compartment, {{0, 1, 2}, "none medial lateral"}},
      {FlagSet::wrap_shape, {{0, 1}, "cylinder ellipsoid"}},
      {FlagSet::body, {{0, 1}, "reference moving"}},
      {FlagSet::load_frame, {{0, 1, 2}, "world reference moving"}},
      {FlagSet::audit_state, {{-1, 0, 1, 2}, "no_pose free overlapping nothing_ahead"}},
      {FlagSet::zero_varus_source, {{-1, 0, 1, 2}, "none both_touch interpolated free"}},
      {FlagSet::two_sided_contact, {{-1, 0, 1, 2}, "no_pose both medial lateral"}},
      {FlagSet::coordinate_role, {{0, 1, 2}, "driven given free"}},
      {FlagSet::repair_status, {{0, 1, 2, 3}, "unchanged repaired not_converged nothing_ahead"}},
      {FlagSet::case_status, {{0, 1, 2, 3}, "done partial failed missing"}}};
  for (const Words& row : word_tables)
    if (row.set == set) return row.table;
  throw InternalError("a set of flags without a table");
}

std::string rule_text(const ValueRule& valid)
{
  const std::string text = value_text(valid);
  if (valid.condition.when == ValueCondition::When::always) return text;
  return text + " " + valid.condition.text +
         (valid.rule == Rule::codes ? ", -1 elsewhere" : ", NaN elsewhere");
}

bool may_be_nan(const Dataset& dataset, ValueKind kind)
{
  const bool is_partly_answered = dataset.valid.condition.when != ValueCondition::When::always;
  return kind == ValueKind::float64 && (is_partly_answered || dataset.valid.rule == Rule::number_or_nan);
}

}  // namespace vrda::store
