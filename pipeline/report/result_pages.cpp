#include "report/result_pages.hpp"

#include "core/document.hpp"
#include "core/units.hpp"
#include "model/coordinates.hpp"
#include "report/model_json.hpp"

namespace vrda::report {
namespace {

Json maps_json(const analysis::RomMaps& maps)
{
  return {{"titles", maps.titles},    {"legend", maps.legend},    {"x", maps.x_edges_deg},
          {"y", maps.y_edges_deg},    {"slices", maps.slice_deg}, {"cells", maps.cells},
          {"outlines", maps.outlines}};
}

Json volume_json(const char* name, const analysis::RomVolume& volume)
{
  return {{"name", name},
          {"cells", volume.n_cells},
          {"volume", volume.volume},
          {"share", volume.volume / volume.driven_volume},
          {"n_driven", volume.n_driven}};
}

Json range_json(const analysis::RomDocument& document)
{
  const analysis::RangeOfMotion& range = document.range;
  return {{"title", document.title},
          {"limits",
           {{"translation_mm", range.limits.translation_mm},
            {"opening_mm", range.limits.opening_mm},
            {"strain", range.limits.strain},
            {"delta_of", name_of(range.delta_body)}}}};
}

Json end_json(const analysis::RomDocument& document, const analysis::RangeEnd& end)
{
  return {{"deg", end.deg}, {"cause", analysis::cause_of(document, end)}};
}

// Through the neutral attitude.
Json ends_json(const analysis::RomDocument& document)
{
  Json ends = Json::array();
  for (const analysis::RangeAlong& along : analysis::boundaries_of(document.range)) {
    if (along.at != document.range.neutral) continue;
    Json row = {{"name", label_of(joint_kind(document.joint), static_cast<JointCoordinate>(along.axis))}};
    if (!along.is_empty) {
      row["low"] = end_json(document, along.low);
      row["high"] = end_json(document, along.high);
    }
    ends.push_back(std::move(row));
  }
  return ends;
}

}  // namespace

std::string laxity_page(const analysis::LaxityDocument& document)
{
  const job::LaxityJob& loads = document.result.loads;
  Json cuts = Json::array();
  for (const job::LaxityJob::Cut& cut : loads.cuts) cuts.push_back(cut.bundles);
  return page_of(document.title + ": laxity", {{"program", document.program + ", " + document.solver},
                                               {"laxity",
                                                {{"document", core::json_in(analysis::laxity_json(document))},
                                                 {"cuts", std::move(cuts)},
                                                 {"load_steps", loads.load_steps},
                                                 {"loads",
                                                  {{"anterior", loads.anterior_force_n},
                                                   {"internal", loads.internal_moment_nmm},
                                                   {"varus", loads.varus_moment_nmm}}}}}});
}

std::string range_page(const analysis::RomDocument& document)
{
  const analysis::RomMaps maps = analysis::status_maps(document);
  return page_of(maps.title,
                 {{"program", document.program},
                  {"range",
                   {{"maps", maps_json(maps)},
                    {"ranges", Json::array({range_json(document)})},
                    {"volumes", Json::array({volume_json("the joint", volume_of(document.range))})},
                    {"ends", ends_json(document)}}}});
}

std::string range_comparison_page(const analysis::RomDocument& a, const analysis::RomDocument& b)
{
  const analysis::RomComparison found = analysis::compare_ranges(a.range, b.range, b.title);
  const analysis::RomMaps maps = analysis::comparison_maps(a, b);
  Json volumes = Json::array();
  for (const auto& [name, volume] :
       {std::pair("the first", found.a), std::pair("the second", found.b), std::pair("both", found.both),
        std::pair("the first only", found.only_a), std::pair("the second only", found.only_b)})
    volumes.push_back(volume_json(name, volume));
  return page_of(maps.title, {{"program", a.program},
                              {"range",
                               {{"maps", maps_json(maps)},
                                {"ranges", Json::array({range_json(a), range_json(b)})},
                                {"volumes", std::move(volumes)}}}});
}

}  // namespace vrda::report
