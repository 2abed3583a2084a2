#include "analysis/laxity_files.hpp"

#include <cmath>
#include <nlohmann/json.hpp>

#include "core/text.hpp"
#include "core/units.hpp"
#include "core/json_file.hpp"

namespace vrda::analysis {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value)
{
  return std::isfinite(value) ? Json(value) : Json();
}

Json coordinates_json(const JointCoordinates& coordinates)
{
  Json json = Json::object();
  for (std::size_t k = 0; k < n_joint_coordinates; ++k) {
    const double value = coordinates(static_cast<Eigen::Index>(k));
    json[std::string(joint_coordinate_names[k]) + (is_rotation(k) ? "_deg" : "_mm")] =
        number(is_rotation(k) ? deg_from_rad(value) : value);
  }
  return json;
}

Json resistance_json(const BundleResistance& of)
{
  return {{"name", of.bundle}, {"force", number(of.force)}, {"share", number(of.share)}};
}

Json curve_json(const LaxityDocument& document, const LaxityCurve& curve)
{
  const TestKind& kind = kind_of(curve.test);
  Json poses = Json::array(), bundles = Json::array();
  for (const LoadedPose& pose : curve.poses)
    poses.push_back({{"load", pose.load},
                     {"status", name_of(pose.status)},
                     {"coordinates", coordinates_json(pose.coordinates)}});
  for (const BundleResistance& bundle : curve.bundles) bundles.push_back(resistance_json(bundle));
  Json json = {{"state", document.result.states[curve.state]},
               {"flexion_deg", document.result.loads.flexion_deg[curve.flexion]},
               {"test", kind.name},
               {"load_unit", kind.is_force() ? "N" : "N mm"},
               {"unit", kind.is_force() ? "mm" : "degree"},
               {"laxity", number(in_file_unit(kind, curve.laxity()))},
               {"poses", poses},
               {"bundles", bundles},
               {"contact", resistance_json(curve.contact)}};
  if (curve.state > 0)
    json["replaced"] = {{"distance_mm", number(curve.replaced_mm)},
                        {"angle_deg", number(deg_from_rad(curve.replaced_rad))}};
  return json;
}

Json compared_json(const Compared& one)
{
  const PublishedValue& row = one.published;
  return {{"test", row.test},           {"flexion_deg", row.flexion_deg},
          {"load", number(row.load)},   {"value", row.value},
          {"sd", number(row.sd)},       {"source", row.source},
          {"found", number(one.found)}, {"difference", number(one.difference())},
          {"missing", one.missing}};
}

std::string cell(double value)
{
  return std::isfinite(value) ? shortest_decimal(value) : "";
}

std::string csv_text(const std::string& text)
{
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + '"';
}

}  // namespace

const LaxityCurve* curve_of(const LaxityResult& result, std::size_t state, std::size_t flexion,
                            LaxityTest test)
{
  for (const LaxityCurve& curve : result.curves) {
    if (curve.state == state && curve.flexion == flexion && curve.test == test) return &curve;
  }
  return nullptr;
}

std::string laxity_json(const LaxityDocument& document)
{
  Json inputs = Json::array(), curves = Json::array(), compared = Json::array();
  for (const job::LoadedInput& input : document.inputs)
    inputs.push_back({{"name", input.name}, {"sha256", input.sha256}});
  for (const LaxityCurve& curve : document.result.curves) curves.push_back(curve_json(document, curve));
  for (const Compared& one : document.compared) compared.push_back(compared_json(one));
  const job::LaxityJob& loads = document.result.loads;
  const Json json = {{"format", "vrda laxity"},
                     {"version", 1},
                     {"program", document.program},
                     {"solver", document.solver},
                     {"title", document.title},
                     {"joint", document.joint},
                     {"side", document.side},
                     {"job", document.job},
                     {"inputs", inputs},
                     {"flexion_deg", loads.flexion_deg},
                     {"states", document.result.states},
                     {"curves", curves},
                     {"published", compared}};
  return core::json_text(json, 1) + '\n';
}

std::string laxity_csv(const LaxityDocument& document)
{
  const LaxityResult& result = document.result;
  std::string csv = "state,test,flexion_deg,load,load_unit,value,unit,position,change_by_cut,status\n";
  for (const LaxityCurve& curve : result.curves) {
    const TestKind& kind = kind_of(curve.test);
    const LaxityCurve* whole = curve_of(result, 0, curve.flexion, curve.test);
    const std::string at = csv_text(result.states[curve.state]) + ',';
    const std::string flexion = shortest_decimal(result.loads.flexion_deg[curve.flexion]) + ',';
    const std::string load = shortest_decimal(curve.poses.back().load) + (kind.is_force() ? ",N," : ",N mm,");
    const std::string unit = kind.is_force() ? ",mm," : ",degree,";
    csv += at + kind.name + ',' + flexion + load + cell(in_file_unit(kind, curve.laxity())) + unit +
           cell(in_file_unit(kind, curve.position())) + ',' +
           (curve.state == 0 ? "" : cell(in_file_unit(kind, curve.position() - whole->position()))) + ',' +
           name_of(curve.poses.back().status) + '\n';
    if (static_cast<std::size_t>(curve.test) % 2 == 0) continue;
    // Both directions together, after the second.
    const auto first = static_cast<LaxityTest>(static_cast<std::size_t>(curve.test) - 1);
    const LaxityCurve* other = curve_of(result, curve.state, curve.flexion, first);
    csv += at + kind.both + ',' + flexion + load +
           cell(in_file_unit(kind, curve.laxity() + other->laxity())) + unit + ",," +
           (curve.is_complete() ? name_of(other->poses.back().status) : name_of(curve.poses.back().status)) +
           '\n';
  }
  return csv;
}

std::string share_csv(const LaxityDocument& document)
{
  const LaxityResult& result = document.result;
  std::string csv = "state,test,flexion_deg,bundle,force,force_unit,share\n";
  for (const LaxityCurve& curve : result.curves) {
    const TestKind& kind = kind_of(curve.test);
    std::vector<BundleResistance> rows = curve.bundles;
    if (curve.is_complete()) rows.push_back(curve.contact);
    for (const BundleResistance& row : rows)
      csv += csv_text(result.states[curve.state]) + ',' + kind.name + ',' +
             shortest_decimal(result.loads.flexion_deg[curve.flexion]) + ',' + csv_text(row.bundle) + ',' +
             cell(row.force) + (kind.is_force() ? ",N," : ",N mm,") + cell(row.share) + '\n';
  }
  return csv;
}

}  // namespace vrda::analysis
