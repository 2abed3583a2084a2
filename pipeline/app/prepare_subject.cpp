#include "app/prepare_subject.hpp"

#include <cctype>
#include <cmath>
#include <set>
#include <tuple>
#include <utility>

#include "core/text.hpp"
#include "load/clean_mesh.hpp"
#include "load/input_file.hpp"
#include "prepare/slack_lengths.hpp"
#include "registration/fit_checks.hpp"

namespace vrda::app {
namespace {

// Closed shells are oriented when they are read; a few holes, such as a cut shaft, do not hide the outside
// either.
void orient_nearly_closed(Mesh& mesh)
{
  const Eigen::Index n_boundary = edge_counts(mesh).boundary;
  if (n_boundary == 0 || n_boundary * n_boundary >= mesh.triangles.rows()) return;
  Mesh centred = mesh;
  centred.vertices_mm.rowwise() -= mesh.vertices_mm.colwise().mean().eval();
  if (signed_volume_mm3(centred) < 0.0) registration::reverse_winding(mesh);
}

Mesh mesh_of(const std::string& file, const std::string& option)
{
  std::string bytes = load::file_bytes(file, {file, option, "", "a mesh file"}, load::largest_mesh_bytes);
  load::CleanMesh clean =
      load::clean_mesh(load::read_mesh(file, std::move(bytes)), load::Winding::outward, Side::right);
  if (clean.mesh.triangles.rows() == 0) throw InputError({file, option, "no faces", "a mesh with faces"});
  if (const std::string tangle = registration::tangle_in(clean.mesh); !tangle.empty())
    throw InputError({file, option, tangle, "the surface of one part"});
  orient_nearly_closed(clean.mesh);
  return clean.mesh;
}

// NAME, or NAME_1, NAME_2, ... for several files.
void add_parts(std::vector<SubjectPart>& parts, const std::vector<std::string>& files,
               const prepare::JobComponent& component, const std::string& option)
{
  for (std::size_t i = 0; i < files.size(); ++i) {
    SubjectPart part{component, files[i], mesh_of(files[i], option)};
    if (files.size() > 1) part.component.name += "_" + std::to_string(i + 1);
    parts.push_back(part);
  }
}

std::vector<std::string> list_of(const std::string& file)
{
  return file.empty() ? std::vector<std::string>{} : std::vector<std::string>{file};
}

}  // namespace

using registration::BoneSurfaces;
using registration::KneeFit;
using registration::KneeSurfaces;

Subject subject_of(const PrepareOptions& options)
{
  for (const auto& [bone, cartilage, option] :
       {std::tuple(&options.femur, &options.femur_cartilage, "--femur"),
        std::tuple(&options.tibia, &options.tibia_cartilage, "--tibia")}) {
    if (bone->empty() && cartilage->empty())
      throw InputError({option, "", "nothing", "the mesh of the bone, or of its cartilage"});
  }
  if (options.tibia.empty() && options.has_ligaments)
    throw InputError(
        {"--tibia", "", "cartilage alone", "the tibia's bone, to which ligaments attach, or --no-ligaments"});
  Subject subject;
  add_parts(subject.reference, list_of(options.femur), {"femur", "bone"}, "--femur");
  add_parts(subject.reference, options.femur_cartilage, {"femur_cartilage", "cartilage"},
            "--femur-cartilage");
  add_parts(subject.moving, list_of(options.tibia), {"tibia", "bone"}, "--tibia");
  add_parts(subject.moving, options.tibia_cartilage, {"tibia_cartilage", "cartilage"}, "--tibia-cartilage");
  add_parts(subject.moving, options.menisci, {"meniscus", "meniscus", false}, "--meniscus");
  add_parts(subject.moving, list_of(options.fibula), {"fibula", "bone", false}, "--fibula");
  return subject;
}

BoneSurfaces surfaces_of(const std::vector<SubjectPart>& parts)
{
  BoneSurfaces surfaces;
  for (const SubjectPart& part : parts) {
    if (part.component.name.starts_with("fibula")) continue;
    if (part.component.material == "bone") append(surfaces.bone, part.mesh);
    if (part.component.material == "cartilage") append(surfaces.cartilage, part.mesh);
  }
  return surfaces;
}

void move_to_frame(std::vector<SubjectPart>& parts, double unit_mm, const Pose& X_scan_bone)
{
  for (SubjectPart& part : parts) {
    part.mesh.vertices_mm *= unit_mm;
    part.mesh = transformed(part.mesh, X_scan_bone.inverse());
  }
}

std::optional<InputError::Facts> wrong_part(const Subject& subject, const KneeSurfaces& surfaces,
                                            double unit_mm, std::vector<std::string>& warnings)
{
  const auto in_mm = [unit_mm](Mesh mesh) {
    mesh.vertices_mm *= unit_mm;
    return mesh;
  };
  const Mesh femur = in_mm(surfaces.femur.bone), tibia = in_mm(surfaces.tibia.bone);
  for (const auto& [parts, own, other] :
       {std::tuple(&subject.reference, &femur, &tibia), std::tuple(&subject.moving, &tibia, &femur)}) {
    for (const SubjectPart& part : *parts) {
      const std::string& name = part.component.name;
      registration::PartCheck check;
      if (part.component.material == "cartilage")
        check = registration::cartilage_check(in_mm(part.mesh), *own, *other);
      if (part.component.material == "meniscus")
        check = registration::meniscus_check(in_mm(part.mesh), in_mm(joined(surfaces.tibia)));
      const std::string option = part.component.material == "meniscus" ? "--meniscus"
                                 : name.starts_with("femur")           ? "--femur-cartilage"
                                                                       : "--tibia-cartilage";
      if (!check.rejection.empty())
        return InputError::Facts{part.file, option, check.rejection, "this part in the scan of the bones"};
      if (!check.doubt.empty()) warnings.push_back(part.file + ": " + option + ": " + check.doubt);
    }
  }
  return std::nullopt;
}

void add_cartilage(const PrepareOptions& options, const KneeFit& fit, const KneeSurfaces& surfaces,
                   Subject& subject, nlohmann::ordered_json& report, std::vector<std::string>& warnings)
{
  const bool is_femur_bare = surfaces.femur.cartilage.triangles.rows() == 0;
  const bool is_tibia_bare = surfaces.tibia.cartilage.triangles.rows() == 0;
  const bool is_auto = options.cartilage == "auto";
  if (options.cartilage == "none" || (!is_femur_bare && !is_tibia_bare)) return;
  if (!is_auto && std::stod(options.cartilage) == 0.0) return;
  const double gap_mm = prepare::scanned_gap_mm(fit, surfaces);
  const double both_mm = is_femur_bare && is_tibia_bare ? gap_mm : 2.0 * gap_mm;
  const double half_mm = 0.5 * prepare::cartilage_in_gap_mm(both_mm);
  const bool is_in_range = 2.0 * half_mm == both_mm;
  const double each_mm = std::round(100.0 * (is_auto ? half_mm : std::stod(options.cartilage))) / 100.0;
  const auto hundredths = [](double mm) { return shortest_decimal(std::round(100.0 * mm) / 100.0); };
  const std::string source =
      !std::isfinite(gap_mm) ? ", the most that is assumed: the scan has no gap to measure"
      : gap_mm < 0.0         ? ", the least that is assumed: the bones overlap by " + hundredths(-gap_mm) +
                           " mm in the scan; check that both are in one pose"
      : is_in_range ? ", from the gap in the scan"
                    : ", not from the gap in the scan, which is " + hundredths(gap_mm) + " mm";
  for (auto& [parts, is_bare, name] : {std::tuple(&subject.reference, is_femur_bare, "femur"),
                                       std::tuple(&subject.moving, is_tibia_bare, "tibia")}) {
    if (!is_bare) continue;
    for (SubjectPart& part : *parts) {
      if (part.component.name == name) part.component.inset_mm = -each_mm;
    }
    warnings.push_back(std::string(name) + ": no cartilage given; the bone is thickened by " +
                       shortest_decimal(each_mm) + " mm" + (is_auto ? source : ""));
  }
  report["cartilage"] = {{"scanned_gap_mm", gap_mm}, {"thickness_mm", each_mm}};
}

std::vector<SubjectPart> scaled_parts(const Body& body, const Eigen::Vector3d& scale,
                                      const Eigen::Vector3d& origin_mm)
{
  std::vector<SubjectPart> parts;
  for (const Part* part : {&body.contact, &body.visual}) {
    const std::vector<std::vector<Eigen::Index>> rows = triangles_by_component(body, *part);
    for (std::size_t c = 0; c < rows.size(); ++c) {
      if (rows[c].empty()) continue;
      const Component& component = body.components[c];
      Mesh mesh = select_triangles(part->mesh, rows[c]);
      mesh.vertices_mm = (mesh.vertices_mm.rowwise() - origin_mm.transpose()) * scale.asDiagonal();
      parts.push_back({{component.name, component.material, part == &body.contact}, "", mesh});
    }
  }
  return parts;
}

void set_file_names(Subject& subject)
{
  std::set<std::string> used;
  for (std::vector<SubjectPart>* parts : {&subject.reference, &subject.moving}) {
    for (SubjectPart& part : *parts) {
      std::string& name = part.component.name;
      if (name.find("fibula") != std::string::npos) name = "fibula";
      for (char& c : name) {
        if (std::isalnum(static_cast<unsigned char>(c)) == 0) c = '_';
      }
      while (!used.insert(name).second) name += "_";
    }
  }
}

}  // namespace vrda::app
