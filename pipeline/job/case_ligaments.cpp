#include "job/case_ligaments.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "core/text.hpp"
#include "job/component_loader.hpp"
#include "job/input_file.hpp"
#include "job/ligament_table.hpp"
#include "job/wraps_file.hpp"
#include "geometry/shapes.hpp"

namespace vrda::job {
namespace {

constexpr const char* generated_key = "ligaments.generate";

[[noreturn]] void refuse(const FibreJob& fibre, const std::string& key, const std::string& found,
                         const std::string& wanted)
{
  throw InputError({fibre.source, fibre_key(fibre, key), found, wanted});
}

void check_names(const std::vector<FibreJob>& fibres)
{
  std::vector<std::string> names;
  for (const FibreJob& fibre : fibres) names.push_back(fibre.name);
  std::sort(names.begin(), names.end());
  const auto twice = std::adjacent_find(names.begin(), names.end());
  if (twice == names.end()) return;
  const auto is_named = [&](const FibreJob& fibre) { return fibre.name == *twice; };
  const auto first = std::find_if(fibres.begin(), fibres.end(), is_named);
  refuse(*std::find_if(first + 1, fibres.end(), is_named), "name", "\"" + *twice + "\" a second time",
         "a unique name for each fibre");
}

int wrap_named(const FibreJob& fibre, const std::vector<model::Wrap>& wraps, const std::string& wraps_file)
{
  if (fibre.wrap.empty()) return -1;
  std::vector<std::string> names;
  for (std::size_t i = 0; i < wraps.size(); ++i) {
    if (wraps[i].name == fibre.wrap) return static_cast<int>(i);
    names.push_back(wraps[i].name);
  }
  refuse(fibre, "wrap", "\"" + fibre.wrap + "\"",
         wraps_file.empty() ? "no wrap, or ligaments.wraps = \"wraps.json\" with this wrap"
                            : "a wrap of \"" + wraps_file + "\"; the nearest is \"" +
                                  nearest_word(fibre.wrap, names) + "\"");
}

// Slack lengths from reference strains and the lengths at the pose of the meshes.
void set_slack_lengths(LoadedLigaments& loaded)
{
  const std::vector<model::FibreState> states = model::fibre_states(loaded.ligaments, {}, {});
  for (std::size_t i = 0; i < states.size(); ++i) {
    const FibreJob& job = loaded.jobs[i];
    if (!job.reference_strain) continue;
    if (!(states[i].length_mm > 0.0))
      refuse(job, "reference_strain", "a fibre without length", "two different attachments");
    loaded.ligaments.fibres[i].slack_length_mm = states[i].length_mm / (1.0 + *job.reference_strain);
  }
}

Pose canonical(const Pose& X_native, const AxisMap& map)
{
  Pose X = Pose::Identity();
  X.linear() = map.X_canonical_native.linear() * X_native.linear();
  X.translation() = map.X_canonical_native * Eigen::Vector3d(X_native.translation());
  return X;
}

// Both files are read before either is parsed, so a missing file is reported first.
struct Files {
  InputFile fibres, wraps;
};

Files files_of(const Job& job, const std::string& data_directory)
{
  Files files;
  const LigamentsJob& named = *job.ligaments;
  if (!named.fibres_file.empty())
    files.fibres = input_file(job, data_directory, {"ligaments.fibres", named.fibres_file, "a CSV file"});
  if (!named.wraps_file.empty())
    files.wraps = input_file(job, data_directory, {"ligaments.wraps", named.wraps_file, "a JSON file"});
  return files;
}

// Generated fibres are canonical already, like generated parts.
void add_generated(const Job& job, LoadedLigaments& loaded)
{
  const GenerateJob& generate = *job.ligaments->generate;
  const std::string key = generated_key;
  const std::string source = job.document.source_of(key);
  with_job_key(job, key, generate, [&] {
    const geometry::ShapeRequest request{generate.shape, generate.numbers, generate.words};
    for (const geometry::ShapeFibre& fibre : geometry::generate_fibres(request)) {
      loaded.jobs.push_back({fibre.name, fibre.bundle, fibre.reference_mm, fibre.moving_mm, fibre.stiffness_n,
                             fibre.slack_length_mm, std::nullopt, "", source, key});
      loaded.ligaments.fibres.push_back({fibre.name, fibre.bundle, fibre.reference_mm, fibre.moving_mm,
                                         fibre.stiffness_n, fibre.slack_length_mm, -1});
    }
    loaded.inputs.push_back(
        {shape_request_text(generate) + " ligaments", sha256_of(geometry::fibre_table(request))});
  });
}

void add_wraps(const Job& job, const InputFile& file, const BodyMaps& maps, LoadedLigaments& loaded)
{
  const std::string& name = job.ligaments->wraps_file;
  if (name.empty()) return;
  loaded.ligaments.wraps = read_wraps(file.path, file.bytes, {job.reference.name, job.moving.name});
  for (model::Wrap& wrap : loaded.ligaments.wraps)
    wrap.X_body_wrap = canonical(wrap.X_body_wrap,
                                 wrap.body == model::WrapBody::reference ? maps.reference : maps.moving);
  loaded.inputs.push_back({name, sha256_of(file.bytes)});
}

void add_fibres(const Job& job, const InputFile& file, const BodyMaps& maps, LoadedLigaments& loaded)
{
  const LigamentsJob& named = *job.ligaments;
  loaded.jobs = named.fibres;
  if (!named.fibres_file.empty()) {
    loaded.jobs = read_ligament_table(file.path, file.bytes);
    loaded.inputs.push_back({named.fibres_file, sha256_of(file.bytes)});
  }
  check_names(loaded.jobs);
  for (const FibreJob& fibre : loaded.jobs) {
    loaded.ligaments.fibres.push_back(
        {fibre.name, fibre.bundle.empty() ? default_bundle(fibre.name) : fibre.bundle,
         maps.reference.X_canonical_native * fibre.reference_native_mm,
         maps.moving.X_canonical_native * fibre.moving_native_mm, fibre.stiffness_n,
         fibre.slack_length_mm.value_or(1.0), wrap_named(fibre, loaded.ligaments.wraps, named.wraps_file)});
  }
  set_slack_lengths(loaded);
}

Box box_of(const Body& body)
{
  // Either part may be empty, not both.
  const Mesh& contact = body.contact.mesh;
  const Mesh& visual = body.visual.mesh;
  if (visual.vertices_mm.rows() == 0) return bounding_box(contact);
  const Box a = bounding_box(contact), b = bounding_box(visual);
  return {a.min_mm.cwiseMin(b.min_mm), a.max_mm.cwiseMax(b.max_mm)};
}

std::string in_mm(const Eigen::Vector3d& p)
{
  return "(" + shortest_decimal(p.x()) + ", " + shortest_decimal(p.y()) + ", " + shortest_decimal(p.z()) +
         ")";
}

void check_inside(const Eigen::Vector3d& p_mm, const FibreJob& fibre, const Body& body,
                  const std::string& key)
{
  const Box box = box_of(body);
  const double margin_mm = 0.5 * (box.max_mm - box.min_mm).maxCoeff();
  const bool is_inside = (p_mm.array() >= box.min_mm.array() - margin_mm).all() &&
                         (p_mm.array() <= box.max_mm.array() + margin_mm).all();
  if (is_inside) return;
  if (fibre.field == generated_key)
    throw InputError(
        {fibre.source, generated_key,
         "generated fibres, which fit the generated bones: \"" + fibre.name + "\" is attached at " +
             in_mm(p_mm) + " mm, away from " + body.name,
         "fibres = \"ligaments.csv\" of these bones (vrda prepare makes them), or no [ligaments]"});
  refuse(fibre, key, "fibre \"" + fibre.name + "\" attached at " + in_mm(p_mm) + " mm in canonical axes",
         "a point within " + shortest_decimal(margin_mm) + " mm of " + body.name + "'s bounding box, " +
             in_mm(box.min_mm) + " to " + in_mm(box.max_mm) + " mm");
}

// Attachments in cm or m give fibres that are 10 or 1000 times too short. Zero lengths are inconclusive.
void check_fibre_unit(const LoadedLigaments& loaded)
{
  constexpr double shortest_mm = 1.0;
  double longest_mm = 0.0;
  for (const model::Fibre& fibre : loaded.ligaments.fibres)
    longest_mm = std::max(longest_mm, (fibre.reference_mm - fibre.moving_mm).norm());
  if (longest_mm == 0.0 || longest_mm >= shortest_mm) return;
  refuse(
      loaded.jobs.front(), "reference_mm",
      "attachments whose longest fibre measures " + shortest_decimal(std::round(1e4 * longest_mm) / 1e4) +
          " mm",
      "attachments in mm, independent of frame.unit; a table in m has the columns reference_x_m and so on");
}

}  // namespace

std::string fibre_key(const FibreJob& fibre, const std::string& key)
{
  return fibre.field.starts_with("line ") ? fibre.field + ", " + key : fibre.field + "." + key;
}

LoadedLigaments load_ligaments(const Job& job, const std::string& data_directory, const BodyMaps& maps)
{
  LoadedLigaments loaded;
  if (!job.ligaments) return loaded;
  const Files files = files_of(job, data_directory);
  loaded.ligaments.transition_strain = job.ligaments->transition_strain;
  add_wraps(job, files.wraps, maps, loaded);
  if (job.ligaments->generate) {
    add_generated(job, loaded);
  } else {
    add_fibres(job, files.fibres, maps, loaded);
  }
  return loaded;
}

void check_attachments(const LoadedLigaments& loaded, const Body& reference, const Body& moving)
{
  check_fibre_unit(loaded);
  for (std::size_t i = 0; i < loaded.jobs.size(); ++i) {
    const model::Fibre& fibre = loaded.ligaments.fibres[i];
    check_inside(fibre.reference_mm, loaded.jobs[i], reference, "reference_mm");
    check_inside(fibre.moving_mm, loaded.jobs[i], moving, "moving_mm");
  }
}

}  // namespace vrda::job
