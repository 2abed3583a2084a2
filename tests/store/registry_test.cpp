// Consistency of the registry of datasets, the pages in schemas/ and the enumerations.
#include "store/registry.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <set>

#include "core/text.hpp"
#include "store/sample_model.hpp"
#include "support/real_knees.hpp"
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

  void dimension(const std::string& path, const store::DimensionSize& count)
  {
    store::RegistryVisitor::dimension(path, count);
    dimensions.insert(path);
  }
  template <typename Member>
  void attribute(const std::string&, const std::string& name, const Member&,
                 const core::Unit& = core::unit::none)
  {
    attributes.insert(name);
  }
  template <typename Value>
  void derived_attribute(const std::string&, const std::string& name, const Value&)
  {
    attributes.insert(name);
  }
  template <typename Member>
  void operator()(const store::Dataset& dataset, const Member& member)
  {
    SCOPED_TRACE(dataset.path);
    EXPECT_TRUE(paths.insert(dataset.path).second) << "twice";
    EXPECT_NE(*dataset.long_name, '\0');
    constexpr store::ValueKind kind = store::member_kind<Member>();
    EXPECT_EQ(*dataset.units.name == '\0',
              kind == store::ValueKind::text || dataset.flags() != store::FlagSet::none);
    std::int64_t n = 1;
    for (const std::int64_t size : shape_of(dataset)) n *= size;
    EXPECT_EQ(store::values_of(member).size(), static_cast<std::size_t>(n));
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
  store::visit_motion_model(whole, model);
  store::visit_trace(none, trace);
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

TEST(Registry, AnUnknownDimensionThrowsInternalError)
{
  EXPECT_THROW(store::RegistryVisitor().size("/nothing"), InternalError);
}

}  // namespace vrda::registry_test
