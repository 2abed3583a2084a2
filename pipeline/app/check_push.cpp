#include "app/check_push.hpp"

#include <cstdio>

#include "core/text.hpp"
#include "core/units.hpp"

namespace vrda::app {
namespace {

using Json = nlohmann::ordered_json;

std::vector<double> numbers_of(const Eigen::Vector3d& v)
{
  return {v.x(), v.y(), v.z()};
}

// A number or a list; a setting over flexion becomes a table with one row per angle, as in the job.
Json over_flexion_json(const job::FlexionTable& setting)
{
  if (!setting.columns.empty()) return {{"columns", setting.columns}};
  Json rows = Json::array(), angles_deg = Json::array();
  for (Eigen::Index i = 0; i < setting.value.rows(); ++i) {
    const Eigen::VectorXd row = setting.value.row(i).transpose();
    rows.push_back(row.size() == 1 ? Json(row[0]) : Json(std::vector<double>(row.begin(), row.end())));
  }
  if (rows.size() == 1) return rows[0];
  for (const double flexion_rad : setting.flexion_rad) angles_deg.push_back(deg_from_rad(flexion_rad));
  return {{"flexion_deg", angles_deg}, {"value", rows}};
}

Json points_json(const std::vector<Eigen::Vector3d>& points_mm)
{
  Json rows = Json::array();
  for (const Eigen::Vector3d& p_mm : points_mm) rows.push_back(numbers_of(p_mm));
  return rows;
}

Json loads_json(const job::PushJob& push, const job::Case& job_case)
{
  Json loads = Json::array();
  for (std::size_t k = 0; k < push.loads.size(); ++k) {
    const job::LoadPoint& at = job_case.loads.at(k);
    loads.push_back({{"name", at.name},
                     {"frame", name_of(at.frame)},
                     {"force_n", over_flexion_json(push.loads[k].force_n)},
                     {"moment_nmm", over_flexion_json(push.loads[k].moment_nmm)},
                     {"point_mm", numbers_of(at.point_mm)}});
  }
  return loads;
}

Json lines_json(const job::PushJob& push, const job::Case& job_case)
{
  Json lines = Json::array();
  for (std::size_t k = 0; k < push.lines.size(); ++k) {
    const job::LinePath& path = job_case.lines.at(k);
    lines.push_back({{"name", path.name},
                     {"tension_n", over_flexion_json(push.lines[k].tension_n)},
                     {"reference_mm", points_json(path.reference_mm)},
                     {"moving_mm", points_json(path.moving_mm)}});
  }
  return lines;
}

}  // namespace

Json push_json(const job::PushJob& push, const job::Case& job_case)
{
  return {{"delta", over_flexion_json(push.delta)},
          {"force_n", over_flexion_json(push.force_n)},
          {"lateral_force_n", over_flexion_json(push.lateral_force_n)},
          {"moment_nmm", over_flexion_json(push.moment_nmm)},
          {"varus_moment_nmm", over_flexion_json(push.varus_moment_nmm)},
          {"point_mm", numbers_of(job_case.push_point_mm)},
          {"loads", loads_json(push, job_case)},
          {"lines", lines_json(push, job_case)}};
}

std::string number_text(const Json& number_or_list)
{
  if (!number_or_list.is_array()) return shortest_decimal(number_or_list.get<double>());
  std::string text;
  for (const Json& number : number_or_list)
    text += (text.empty() ? "[" : " ") + shortest_decimal(number.get<double>());
  return text + "]";
}

namespace {

// "20 N", or the first and last row of a table over flexion.
void print_load(const char* name, const Json& load, const char* unit)
{
  std::string text;
  if (!load.is_object()) {
    text = number_text(load) + unit;
  } else if (load.contains("columns")) {
    text = "from columns of the frames";
    for (const Json& column : load["columns"]) text += " " + column.get<std::string>();
  } else {
    const Json& angles_deg = load["flexion_deg"];
    const Json& rows = load["value"];
    text = number_text(rows.front()) + unit + " at " + shortest_decimal(angles_deg.front().get<double>()) +
           " degrees of flexion to " + number_text(rows.back()) + unit + " at " +
           shortest_decimal(angles_deg.back().get<double>()) + ", in " + std::to_string(rows.size()) +
           " rows";
  }
  std::printf("  %-18s %s\n", name, text.c_str());
}

}  // namespace

void print_push(const Json& p, bool has_forces)
{
  std::printf("push\n");
  print_load("delta", p["delta"], "");
  if (!has_forces) return;  // the search moves along Delta without a force
  print_load("force", p["force_n"], " N along delta");
  print_load("lateral force", p["lateral_force_n"], " N across delta");
  print_load("moment", p["moment_nmm"], " N mm about delta");
  print_load("varus moment", p["varus_moment_nmm"], " N mm");
  print_load("point", p["point_mm"], " mm from the rotation centre");
  for (const Json& load : p["loads"]) {
    std::printf("  load %s, frame %s\n", load["name"].get<std::string>().c_str(),
                load["frame"].get<std::string>().c_str());
    print_load("  force", load["force_n"], " N");
    print_load("  moment", load["moment_nmm"], " N mm");
    print_load("  point", load["point_mm"], " mm from the rotation centre");
  }
  for (const Json& line : p["lines"]) {
    std::printf("  line %s\n", line["name"].get<std::string>().c_str());
    print_load("  tension", line["tension_n"], " N");
    print_load("  from", line["reference_mm"].back(), " mm on the reference");
    print_load("  to", line["moving_mm"].front(), " mm on the moving object");
  }
}

}  // namespace vrda::app
