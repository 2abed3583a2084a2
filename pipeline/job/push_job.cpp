#include "job/push_job.hpp"

#include <algorithm>
#include <limits>

#include "core/units.hpp"

namespace vrda::job {
namespace {

std::vector<double> row_of(const core::DocumentValue& value)
{
  return value.list() != nullptr ? core::numbers_of(value)
                                 : std::vector<double>{core::number_at(value, "")};
}

// `key` is that of the value, for messages; `n` its number of components.
FlexionTable over_flexion_of(const core::Document& document, const core::DocumentValue& value,
                             const std::string& key, std::size_t n)
{
  FlexionTable out;
  if (value.find("columns") != nullptr) {
    out.columns = core::texts_at(value, "columns");
    out.key = key + ".columns";
    if (out.columns.size() != n)
      document.refuse(out.key, std::to_string(out.columns.size()) + " columns", std::to_string(n));
    if (document.root.find("frames") == nullptr)
      document.refuse(out.key, "columns without [frames]", "[frames] with file = \"motion.csv\", or numbers");
    return out;
  }
  std::vector<std::vector<double>> rows;
  if (value.table() == nullptr) {
    out.flexion_rad = {0.0};
    rows = {row_of(value)};
  } else {
    out.is_over_driving = value.find("driving") != nullptr;
    out.key = key;
    if (out.is_over_driving == (value.find("flexion_deg") != nullptr))
      document.refuse(key, out.is_over_driving ? "flexion_deg and driving" : "value alone",
                      "flexion_deg or driving");
    const char* const at = out.is_over_driving ? "driving" : "flexion_deg";
    for (const double given : core::numbers_at(value, at)) {
      const double x = out.is_over_driving ? given : rad_from_deg(given);
      if (!out.flexion_rad.empty() && x <= out.flexion_rad.back())
        document.refuse(key + "." + at, core::shown(core::value_at(value, at)),
                        "increasing values");
      out.flexion_rad.push_back(x);
    }
    for (const core::DocumentValue& row : *core::value_at(value, "value").list())
      rows.push_back(row_of(row));
    if (rows.size() != out.flexion_rad.size()) {
      document.refuse(
          key + ".value", std::to_string(rows.size()) + " values",
          std::string("one for each value of ") + at + ", " + std::to_string(out.flexion_rad.size()));
    }
  }
  out.value.resize(static_cast<Eigen::Index>(rows.size()), static_cast<Eigen::Index>(rows.front().size()));
  for (Eigen::Index i = 0; i < out.value.rows(); ++i) {
    for (Eigen::Index j = 0; j < out.value.cols(); ++j) {
      out.value(i, j) = rows[static_cast<std::size_t>(i)][static_cast<std::size_t>(j)];
    }
  }
  return out;
}

}  // namespace

FlexionTable over_flexion_at(const core::Document& document, const std::string& key, std::size_t n)
{
  return over_flexion_of(document, core::value_at(document.root, key), key, n);
}

namespace {

FlexionTable delta_at(const core::Document& document)
{
  FlexionTable delta = over_flexion_at(document, "push.delta", 3);
  for (Eigen::Index i = 0; i < delta.value.rows(); ++i) {
    const Eigen::Vector3d given = delta.value.row(i);
    // Scaled first: squares of huge or tiny components would leave the range of doubles.
    const double largest = given.cwiseAbs().maxCoeff();
    if (!(largest > 0.0))
      document.refuse("push.delta", core::shown(core::value_at(document.root, "push.delta")),
                      "a direction: not all zero");
    delta.value.row(i) = (given / largest).normalized().transpose();
  }
  return delta;
}

// Adds a name; refuses one that an earlier entry of the list has.
void add_name(const core::Document& document, const std::string& key, const std::string& name,
              std::vector<std::string>& names)
{
  if (std::find(names.begin(), names.end(), name) != names.end())
    document.refuse(key + ".name", "\"" + name + "\" a second time", "a unique name");
  names.push_back(name);
}

LoadFrame load_frame_of(const std::string& name)
{
  return name == "world" ? LoadFrame::world : name == "reference" ? LoadFrame::reference : LoadFrame::moving;
}

// Everywhere, as far as the job file says.
bool is_zero(const FlexionTable& setting)
{
  return setting.columns.empty() && setting.value.isZero(0.0);
}

LoadJob load_of(const core::Document& document, const core::DocumentValue& value,
                const std::string& key)
{
  LoadJob load;
  load.at = {core::text_at(value, "name"), load_frame_of(core::text_at(value, "frame")),
             core::vector3_at(value, "point_mm")};
  load.force_n = over_flexion_of(document, *value.find("force_n"), key + ".force_n", 3);
  load.moment_nmm = over_flexion_of(document, *value.find("moment_nmm"), key + ".moment_nmm", 3);
  if (is_zero(load.force_n) && is_zero(load.moment_nmm)) {
    document.refuse(key + ".force_n", core::shown(*value.find("force_n")) + " without a moment",
                    "a force or a moment that is not zero");
  }
  return load;
}

std::vector<Eigen::Vector3d> points_of(const core::DocumentValue& value, const std::string& key)
{
  std::vector<Eigen::Vector3d> points;
  for (const std::vector<double>& row : core::rows_at(value, key))
    points.emplace_back(row[0], row[1], row[2]);
  return points;
}

LineJob line_of(const core::Document& document, const core::DocumentValue& value,
                const std::string& key)
{
  LineJob line;
  line.path = {core::text_at(value, "name"), points_of(value, "reference_mm"),
               points_of(value, "moving_mm")};
  line.tension_n = over_flexion_of(document, *value.find("tension_n"), key + ".tension_n", 1);
  if (is_zero(line.tension_n))
    document.refuse(key + ".tension_n", core::shown(*value.find("tension_n")),
                    "a tension above 0 N at some flexion");
  if (line.path.reference_mm.back() == line.path.moving_mm.front())
    document.refuse(key + ".moving_mm", "a first point that is the last of reference_mm",
                    "another point: the line has no direction between the objects");
  return line;
}

}  // namespace

Eigen::VectorXd value_at_flexion(const FlexionTable& setting, double flexion_rad)
{
  const std::vector<double>& angles = setting.flexion_rad;
  const auto above =
      static_cast<Eigen::Index>(std::upper_bound(angles.begin(), angles.end(), flexion_rad) - angles.begin());
  if (above == 0) return setting.value.row(0).transpose();
  if (above == setting.value.rows()) return setting.value.row(above - 1).transpose();
  const double from_rad = angles[static_cast<std::size_t>(above - 1)];
  const double share = (flexion_rad - from_rad) / (angles[static_cast<std::size_t>(above)] - from_rad);
  return ((1.0 - share) * setting.value.row(above - 1) + share * setting.value.row(above)).transpose();
}

PushJob push_of(const core::Document& document)
{
  const core::DocumentValue& root = document.root;
  PushJob push;
  push.delta = delta_at(document);
  push.is_fixed_in_reference = core::text_or_empty(*root.find("push"), "frame") == "reference";
  push.force_n = over_flexion_at(document, "push.force_n", 1);
  push.lateral_force_n = over_flexion_at(document, "push.lateral_force_n", 2);
  push.moment_nmm = over_flexion_at(document, "push.moment_nmm", 1);
  push.varus_moment_nmm = over_flexion_at(document, "push.varus_moment_nmm", 1);
  push.point_mm = core::vector3_at(root, "push.point_mm");
  std::vector<std::string> load_names, line_names;
  for (const core::DocumentValue& value : core::list_or_empty(root, "push.load")) {
    const std::string key = "push.load." + std::to_string(push.loads.size());
    push.loads.push_back(load_of(document, value, key));
    add_name(document, key, push.loads.back().at.name, load_names);
  }
  for (const core::DocumentValue& value : core::list_or_empty(root, "push.line")) {
    const std::string key = "push.line." + std::to_string(push.lines.size());
    push.lines.push_back(line_of(document, value, key));
    add_name(document, key, push.lines.back().path.name, line_names);
  }
  return push;
}

std::vector<PushTable> tables_of(PushJob& push)
{
  const double any = std::numeric_limits<double>::quiet_NaN();
  std::vector<PushTable> tables{{&push.force_n, 0.0, true},
                                {&push.lateral_force_n, any},
                                {&push.moment_nmm, any},
                                {&push.varus_moment_nmm, any}};
  for (LoadJob& load : push.loads) {
    tables.push_back({&load.force_n, any});
    tables.push_back({&load.moment_nmm, any});
  }
  for (LineJob& line : push.lines) tables.push_back({&line.tension_n, 0.0});
  return tables;
}

Push push_at(const PushJob& job, const Eigen::Vector3d& delta, double flexion_rad, std::size_t frame)
{
  const auto value_of = [&](const FlexionTable& setting) -> Eigen::VectorXd {
    if (setting.columns.empty()) return value_at_flexion(setting, flexion_rad);
    return setting.value.row(static_cast<Eigen::Index>(frame)).transpose();
  };
  Push push;
  push.delta = delta;
  const Eigen::Vector2d across_n = value_of(job.lateral_force_n);
  push.force_n = value_of(job.force_n)[0] * delta + shortest_rotation(Eigen::Vector3d::UnitY(), delta) *
                                                        Eigen::Vector3d(across_n[0], 0.0, across_n[1]);
  push.moment_nmm = value_of(job.moment_nmm)[0];
  push.varus_moment_nmm = value_of(job.varus_moment_nmm)[0];
  for (const LoadJob& load : job.loads) {
    push.load_force_n.emplace_back(value_of(load.force_n));
    push.load_moment_nmm.emplace_back(value_of(load.moment_nmm));
  }
  for (const LineJob& line : job.lines) push.line_tension_n.push_back(value_of(line.tension_n)[0]);
  return push;
}

}  // namespace vrda::job
