// Consistency of the registry of datasets, the pages in schemas/ and the enumerations.
// Every dataset and attribute of the registry is required in a file, and its rule is checked.
#include <gmock/gmock.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <set>

#include "core/text.hpp"
#include "store/model_checks.hpp"
#include "store/motion_model.hpp"
#include "store/registry.hpp"
#include "store/sample_model.hpp"
#include "support/damaged_models.hpp"
#include "support/real_knees.hpp"
#include "support/refusal.hpp"
#include "support/scratch.hpp"

namespace vrda::registry_test {

using ::testing::HasSubstr;

std::string page_of(const char* name)
{
  return test::read_bytes(test::source_directory() / "schemas" / name);
}

/// Collects dimensions and attributes, and checks every row.
class Rows : public store::RegistryVisitor {
 public:
  std::set<std::string> paths, dimensions, attributes;

  void dimension(const std::string& path, const store::DimensionSize& count) override
  {
    store::RegistryVisitor::dimension(path, count);
    dimensions.insert(path);
  }
  void visit_attribute(const std::string&, const std::string& name, Attribute, const core::Unit&) override
  {
    attributes.insert(name);
  }
  void visit_derived(const std::string&, const std::string& name, Attribute) override
  {
    attributes.insert(name);
  }
  void visit_dataset(const store::Dataset& dataset, Member member) override
  {
    SCOPED_TRACE(dataset.path);
    EXPECT_TRUE(paths.insert(dataset.path).second) << "twice";
    EXPECT_FALSE(dataset.long_name.empty());
    const store::ValueKind kind = store::kind_of(member);
    EXPECT_EQ(*dataset.units.name == '\0',
              kind == store::ValueKind::text || dataset.flags() != store::FlagSet::none);
    std::int64_t n = 1;
    for (const std::int64_t size : shape_of(dataset)) n *= size;
    store::with_values(member, [&](auto values) { EXPECT_EQ(values.size(), static_cast<std::size_t>(n)); });
  }
};

TEST(Registry, TheTablesOfThePagesAreMadeOfIt)
{
  // After a change: write_sample PAGE page
  EXPECT_TRUE(page_of("motion-model.md") == test::with_tables(page_of("motion-model.md"), false));
  EXPECT_TRUE(page_of("trace.md") == test::with_tables(page_of("trace.md"), true));
}

TEST(Registry, ThePagesNameEveryDimensionAndAttribute)
{
  Rows model, trace;
  const store::MotionModel whole = test::whole_model();
  const store::Trace none;
  store::visit_registry(whole, model);
  store::visit_registry(none, trace);
  for (const auto& [rows, name] : {std::pair(&model, "motion-model.md"), std::pair(&trace, "trace.md")}) {
    const std::string page = page_of(name);
    for (const std::string& attribute : rows->attributes) EXPECT_THAT(page, HasSubstr("`" + attribute + "`"));
    for (const std::string& path : rows->dimensions)
      EXPECT_THAT(page, HasSubstr(path.substr(path.rfind('/')) + "`")) << path;
    EXPECT_THAT(page, HasSubstr(std::string("`") + store::conventions + "`"));
  }
  EXPECT_THAT(page_of("motion-model.md"), HasSubstr(std::string("format version ") + store::format_version));
  EXPECT_THAT(page_of("trace.md"), HasSubstr(std::string("format version ") + store::trace_format_version));
  EXPECT_EQ(store::format_version, "1." + std::to_string(store::format_minor_version));
  EXPECT_LE(store::least_minor_version, store::format_minor_version);
  EXPECT_EQ(store::trace_format_version, "1." + std::to_string(store::trace_format_minor_version));
}

TEST(Registry, TheCodesAreThoseOfTheEnumerations)
{
  using Codes = std::vector<std::int8_t>;
  EXPECT_EQ(store::flag_table(store::FlagSet::status).values, (Codes{-1, 0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(store::flag_table(store::FlagSet::solver_status).values, (Codes{-1, 0, 1, 2, 3, 4}));
  EXPECT_EQ(store::flag_table(store::FlagSet::search_status).values, (Codes{-1, 0, 1, 2, 3}));
  EXPECT_EQ(store::flag_table(store::FlagSet::plausibility).meanings,
            "not_judged nothing_found nothing_ahead unstable_balance dislocated border_contact "
            "overstrained");
  EXPECT_EQ(store::flag_table(store::FlagSet::audit_state).values,
            (Codes{store::code_of(store::AuditState::no_pose), store::code_of(store::AuditState::free),
                   store::code_of(store::AuditState::overlapping),
                   store::code_of(store::AuditState::nothing_ahead)}));
  EXPECT_EQ(store::flag_table(store::FlagSet::audit_state).meanings,
            "no_pose free overlapping nothing_ahead");
  EXPECT_EQ(
      store::flag_table(store::FlagSet::zero_varus_source).values,
      (Codes{store::code_of(store::ZeroVarusSource::none), store::code_of(store::ZeroVarusSource::both_touch),
             store::code_of(store::ZeroVarusSource::interpolated),
             store::code_of(store::ZeroVarusSource::free)}));
  EXPECT_EQ(store::flag_table(store::FlagSet::zero_varus_source).meanings,
            "none both_touch interpolated free");
}

constexpr double infinity = std::numeric_limits<double>::infinity();

struct Named {
  std::string object, attribute;
};

/// Paths of all datasets except dimension scales, and all attributes of the registry.
class Names : public store::RegistryVisitor {
 public:
  std::vector<store::Dataset> datasets;
  std::vector<Named> attributes;

  void visit_attribute(const std::string& object, const std::string& name, Attribute,
                       const core::Unit&) override
  {
    attributes.push_back({object, name});
  }
  void visit_derived(const std::string& object, const std::string& name, Attribute) override
  {
    attributes.push_back({object, name});
  }
  void visit_dataset(const store::Dataset& dataset, Member) override { datasets.push_back(dataset); }
};

Names names_of(const store::MotionModel& model)
{
  Names names;
  store::visit_registry(model, names);
  return names;
}

/// A file with every dataset, to be changed repeatedly.
class WholeFile {
 public:
  WholeFile() : path_((scratch_.path() / "knee.h5").string())
  {
    store::write_motion_model(path_, test::whole_model());
    bytes_ = test::read_bytes(path_);
  }

  std::vector<store::Finding> findings_after(const std::function<void(hid_t)>& action) const
  {
    std::ofstream(path_, std::ios::binary) << bytes_;
    test::change(path_, action);
    return store::findings_in(store::read_hdf5(path_));
  }

 private:
  test::Scratch scratch_;
  std::string path_, bytes_;
};

bool is_optional(const std::string& path)
{
  return path.ends_with("/normals") || path.ends_with("/offset") || path.ends_with("/overlap") ||
         path.ends_with("/recontact") || path.ends_with("/touches_drawn") || path == "/job/warnings" ||
         (path.starts_with("/followers/") && path.ends_with("/plausibility"));  // since 1.14
}

/// A change of a file, and the finding it must give.
struct Expected {
  std::function<void(hid_t)> act;
  std::string where, found, wanted;
};

/// Of each of the rows, made in a few files: all findings of a file are listed.
void expect_each_found(const std::vector<Expected>& rows)
{
  const WholeFile file;
  constexpr std::size_t n_files = 8;
  for (std::size_t k = 0; k < n_files; ++k) {
    std::vector<const Expected*> changed;
    for (std::size_t i = k; i < rows.size(); i += n_files) changed.push_back(&rows[i]);
    const std::vector<store::Finding> findings = file.findings_after([&](hid_t id) {
      for (const Expected* row : changed) row->act(id);
    });
    for (const Expected* row : changed)
      EXPECT_TRUE(
          std::any_of(findings.begin(), findings.end(),
                      [&](const store::Finding& finding) {
                        return finding.where == row->where && test::names_value(finding.found, row->found) &&
                               (row->wanted.empty() || test::names_value(finding.wanted, row->wanted));
                      }))
          << row->where << ": " << row->found;
  }
}

TEST(EveryDataset, IsNeeded)
{
  std::vector<Expected> rows;
  for (const store::Dataset& dataset : names_of(test::whole_model()).datasets) {
    if (is_optional(dataset.path)) continue;
    rows.push_back(
        {[path = dataset.path](hid_t id) { test::remove(id, path.c_str()); }, dataset.path, "nothing", "a"});
  }
  expect_each_found(rows);
}

TEST(EveryDataset, HasItsTypeShapeAndUnit)
{
  std::vector<Expected> shapes, units;
  for (const store::Dataset& dataset : names_of(test::whole_model()).datasets) {
    const std::string path = dataset.path;
    if (dataset.dimensions != std::vector<std::string>{path})
      shapes.push_back({[path](hid_t id) {
                          test::replace(id, {path.c_str(), {2, 2}, H5T_STD_U16LE});
                        },
                        path, "another type", ""});
    if (*dataset.units.name == '\0') continue;
    units.push_back({[path](hid_t id) { test::set_text(id, path.c_str(), "units", "furlong"); },
                     path + "@units", "furlong", dataset.units.name});
  }
  expect_each_found(shapes);
  expect_each_found(units);
}

TEST(EveryAttribute, IsNeeded)
{
  std::vector<Expected> rows;
  for (const Named& name : names_of(test::whole_model()).attributes) {
    const auto act = [name](hid_t id) {
      ASSERT_GE(H5Adelete_by_name(id, name.object.c_str(), name.attribute.c_str(), H5P_DEFAULT), 0);
    };
    rows.push_back({act, name.object + "@" + name.attribute, "nothing", "of"});
  }
  expect_each_found(rows);
}

/// Violates the rule of one dataset in one of `n_ways` ways, which it counts.
class Damage : public store::RegistryVisitor {
 public:
  Damage(std::string path, int way) : path_(std::move(path)), way_(way) {}
  bool is_done() const { return is_done_; }
  bool may_change() const override { return true; }

 private:
  void visit_dataset(const store::Dataset& dataset, Member member) override
  {
    store::with_values(member, [&]<typename Scalar>(std::span<Scalar> values) {
      if (dataset.path != path_ || values.empty()) return;
      if constexpr (std::is_same_v<Scalar, std::string>) {
        damage_texts(dataset.valid, values);
      } else {
        damage_values(dataset.valid, values);
      }
    });
  }

  void damage_texts(const store::ValueRule& valid, std::span<std::string> texts)
  {
    if (valid.rule == store::Rule::any || way_ > 1) return;
    if (way_ == 1 && valid.rule != store::Rule::unique_names) return;
    texts.back() = way_ == 1 ? texts[0] : "";
    is_done_ = true;
  }

  template <typename Scalar>
  void damage_values(const store::ValueRule& valid, std::span<Scalar> values)
  {
    for (const std::pair<std::size_t, double>& bad : bad_values(valid, values)) {
      if (way_-- > 0) continue;
      values[bad.first] = static_cast<Scalar>(bad.second);
      is_done_ = true;
      return;
    }
  }

  /// Entries with invalid values.
  template <typename Scalar>
  std::vector<std::pair<std::size_t, double>> bad_values(const store::ValueRule& valid,
                                                         std::span<Scalar> values) const
  {
    using Bad = std::vector<std::pair<std::size_t, double>>;
    const std::size_t last = values.size() - 1;
    switch (valid.rule) {
      case store::Rule::any:
        return {};
      case store::Rule::axis:
        return values.size() > 1 ? Bad{{1, values[0]}, {0, infinity}} : Bad{{0, infinity}};
      case store::Rule::integer:
        return {{0, valid.least - 1}, {last, valid.largest < 1e9 ? valid.largest + 1 : -7}};
      case store::Rule::row_starts:
        return {{0, 1}, {last, valid.largest + 1}, {1, -1}};
      case store::Rule::unit_rows:
      case store::Rule::exact_unit_rows:
      case store::Rule::unit_or_zero_rows:
        return {{1, 3.0}, {0, infinity}};
      default:
        break;
    }
    if (valid.rule == store::Rule::codes && valid.condition.when == store::ValueCondition::When::always)
      return {{0, 77}, {last, -7}};
    Bad bad;
    const std::size_t n =
        valid.condition.when == store::ValueCondition::When::always ? values.size() : valid.condition.size();
    const std::size_t width = valid.rule == store::Rule::rigid ? 16 : values.size() / n;
    const bool is_number = valid.rule != store::Rule::codes;
    bool has_known = false, has_unknown = false;
    for (std::size_t i = 0; i < values.size() / width; ++i) {
      bool& has = valid.condition.at(i) ? has_known : has_unknown;
      if (has) continue;
      has = true;
      if (!valid.condition.at(i)) {
        bad.push_back({i * width + width - 1, 1});
        continue;
      }
      bad.push_back({i * width, is_number ? infinity : -1});
      if (std::isfinite(valid.least))
        bad.push_back({i * width, valid.least - (valid.excludes_least ? 0 : 1)});
    }
    return bad;
  }

  std::string path_;
  int way_;
  bool is_done_ = false;
};

TEST(EveryDataset, KeepsItsRule)
{
  const store::MotionModel model = test::whole_model();
  ASSERT_TRUE(store::check_values(model).empty());
  int n_tried = 0;
  for (const store::Dataset& dataset : names_of(model).datasets) {
    for (int way = 0;; ++way) {
      store::MotionModel damaged = model;
      Damage damage(dataset.path, way);
      store::visit_registry(damaged, damage);
      if (!damage.is_done()) break;
      ++n_tried;
      std::vector<std::string> places;
      for (const store::Finding& finding : store::check_values(damaged)) places.push_back(finding.where);
      EXPECT_THAT(places, ::testing::Contains(dataset.path)) << "way " << way;
    }
  }
  // Some rows have no rule; most rules can be violated in two or more ways.
  EXPECT_GT(n_tried, 200);
}

}  // namespace vrda::registry_test
