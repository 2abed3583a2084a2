#include "app/prepare_subject.hpp"

#include <algorithm>
#include <cctype>
#include <cmath>
#include <exception>
#include <filesystem>
#include <fstream>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "app/printing.hpp"
#include "core/console.hpp"
#include "core/document.hpp"
#include "core/fields_json.hpp"
#include "core/files.hpp"
#include "core/parallel.hpp"
#include "geometry/simplified.hpp"
#include "geometry/surface_noise.hpp"
#include "job/case_warnings.hpp"
#include "job/clean_mesh.hpp"
#include "job/component_loader.hpp"
#include "job/job.hpp"
#include "job/slicer_files.hpp"
#include "job/thesis_files.hpp"
#include "prepare/joint_frame.hpp"
#include "prepare/template_joint.hpp"
#include "run/run_output.hpp"

namespace vrda::app {
namespace {

// A file of an option, or several.
struct PartFile {
  std::vector<SubjectPart>* parts = nullptr;  // to which it belongs
  SubjectPart part;                           // without its mesh
  std::string option;
  std::vector<std::string> warnings;
  std::exception_ptr failure;
};

void read_part(PartFile& from)
{
  SubjectPart& part = from.part;
  std::string bytes =
      job::file_bytes(part.file, {part.file, from.option, "", "a mesh file"}, job::largest_mesh_bytes);
  const job::RawMesh raw = job::read_mesh(part.file, std::move(bytes));
  const std::string where = part.file + ": " + from.option + ": ";
  for (const std::string& note : raw.notes) from.warnings.push_back(where + note);
  job::CleanMesh clean = job::clean_mesh(raw, job::Winding::outward, Side::right);
  if (clean.mesh.triangles.rows() == 0)
    throw InputError({part.file, from.option, "no faces", "a mesh with faces"});
  if (const std::string tangle = geometry::tangle_in(clean.mesh); !tangle.empty())
    throw InputError({part.file, from.option, tangle, "the surface of one part"});
  if (clean.n_identical > 0)
    from.warnings.push_back(where + "left out: " + std::to_string(clean.n_identical) +
                            " copies of other triangles");
  part.mesh = job::outer_surface(clean.mesh);
  const Eigen::Index n_enclosed = clean.mesh.triangles.rows() - part.mesh.triangles.rows();
  if (n_enclosed > 0)
    from.warnings.push_back(where + "left out: " + std::to_string(n_enclosed) +
                            " triangles of surfaces inside another (an inner wall or a void)");
  part.small_shells = std::move(clean.small_shells);
  if (n_enclosed == 0) return;
  const std::vector<job::Shell> shells = job::shells_of(part.mesh);
  part.small_shells = job::small_shells(shells, job::outermost_shells(part.mesh, shells));
}

// NAME, or NAME_1, NAME_2, ... for several files.
void add_files(std::vector<PartFile>& all, std::vector<SubjectPart>& parts,
               const std::vector<std::string>& files, const prepare::JobComponent& component,
               const std::string& option)
{
  for (std::size_t i = 0; i < files.size(); ++i) {
    PartFile file{&parts, {component, files[i], {}, {}, {}}, option, {}, {}};
    if (files.size() > 1) file.part.component.name += "_" + std::to_string(i + 1);
    all.push_back(std::move(file));
  }
}

// Into a log, messages are enough.
core::ProgressStyle bar_on_terminal()
{
  const core::ProgressStyle style = core::progress_style_of("auto");
  return style == core::ProgressStyle::bar ? style : core::ProgressStyle::none;
}

std::vector<std::string> list_of(const std::string& file)
{
  return file.empty() ? std::vector<std::string>{} : std::vector<std::string>{file};
}

std::string scan_space_of(const PrepareOptions& options)
{
  std::vector<job::FileSpace> spaces;
  const auto add = [&](const std::vector<std::string>& files) {
    for (const std::string& file : files) {
      std::ifstream stream(file, std::ios::binary);
      std::string header(1024, '\0');
      stream.read(header.data(), static_cast<std::streamsize>(header.size()));
      spaces.emplace_back(file, job::scan_space(file, header));
    }
  };
  for (const auto& [bone, of_bone] : options.bones) add({of_bone.bone});
  add({options.fibula, options.patella});
  for (const auto& [bone, of_bone] : options.bones) add(of_bone.cartilage);
  add(options.menisci);
  add(options.patella_cartilage);
  return job::common_space(spaces);
}

}  // namespace

using geometry::BoneSurfaces;
using geometry::KneeFit;
using geometry::KneeSurfaces;

Subject subject_of(const PrepareOptions& options, std::vector<std::string>& warnings)
{
  const prepare::JointBones bones = prepare::bones_of(options.joint);
  for (const char* bone : {bones.reference, bones.moving}) {
    const BoneFiles& files = options.bones.at(bone);
    if (files.bone.empty() && files.cartilage.empty())
      throw InputError(
          {"--" + std::string(bone), "", "nothing", "the mesh of the bone, or of its cartilage"});
  }
  if (options.joint == "knee" && options.bones.at("tibia").bone.empty() && options.has_ligaments)
    throw InputError(
        {"--tibia", "", "cartilage alone", "the tibia's bone, to which ligaments attach, or --no-ligaments"});
  Subject subject;
  std::vector<PartFile> all;
  for (auto& [parts, name] :
       {std::pair(&subject.reference, bones.reference), std::pair(&subject.moving, bones.moving)}) {
    const std::string bone = name, cartilage = bone + "_cartilage";
    const BoneFiles& files = options.bones.at(bone);
    add_files(all, *parts, list_of(files.bone), {bone, "bone"}, "--" + bone);
    add_files(all, *parts, files.cartilage, {cartilage, "cartilage"}, "--" + bone + "-cartilage");
  }
  const bool is_knee = options.joint == "knee";
  add_files(all, subject.moving, options.menisci, {"meniscus", "meniscus", false}, "--meniscus");
  add_files(all, is_knee ? subject.moving : subject.reference, list_of(options.fibula),
            {"fibula", "bone", !is_knee}, "--fibula");
  add_files(all, subject.patella, list_of(options.patella), {"patella", "bone"}, "--patella");
  add_files(all, subject.patella, options.patella_cartilage, {"patella_cartilage", "cartilage"},
            "--patella-cartilage");
  {
    core::Progress progress(bar_on_terminal(), "surfaces read", static_cast<int>(all.size()), 0);
    for_each_index(all.size(), run::thread_count_or_all(options.n_threads), [&] {
      return [&](std::size_t k) {
        try {
          read_part(all[k]);
        } catch (...) {
          all[k].failure = std::current_exception();  // of several, the first file's is reported
        }
        progress.advance();
      };
    });
  }
  for (PartFile& file : all) {
    if (file.failure) std::rethrow_exception(file.failure);
    warnings.insert(warnings.end(), file.warnings.begin(), file.warnings.end());
    file.parts->push_back(std::move(file.part));
  }
  return subject;
}

BoneSurfaces surfaces_of(const std::vector<SubjectPart>& parts)
{
  BoneSurfaces surfaces;
  for (const SubjectPart& part : parts) {
    if (part.component.name.starts_with("fibula")) continue;
    if (part.component.material == "bone") append(surfaces.bone, part.working());
    if (part.component.material == "cartilage") append(surfaces.cartilage, part.working());
  }
  return surfaces;
}

std::string landmark_text(const std::string& file)
{
  const std::string wanted = "a TOML file of landmarks, or points of 3D Slicer (.mrk.json, .fcsv)";
  if (!std::filesystem::is_regular_file(file)) throw InputError({file, "--landmarks", "no file", wanted});
  return core::read_document_text(file, wanted);
}

Eigen::Matrix4d anatomical_from_file(double unit_mm, const Pose& X_scan_bone)
{
  Eigen::Matrix4d X = X_scan_bone.inverse().matrix();
  X.leftCols<3>() *= unit_mm;
  X(3, 3) = 1.0;
  return X;
}

nlohmann::ordered_json matrix_json(const Eigen::Matrix4d& X)
{
  nlohmann::ordered_json rows = nlohmann::ordered_json::array();
  for (Eigen::Index i = 0; i < 4; ++i) rows.push_back({X(i, 0), X(i, 1), X(i, 2), X(i, 3)});
  return rows;
}

void name_by_side(std::vector<SubjectPart>& parts, double unit_mm, const Pose& X_scan_bone, Side side)
{
  const auto lateral_mm = [&](const SubjectPart& part) {
    const Eigen::Vector3d mean = part.mesh.vertices_mm.colwise().mean();
    return (side == Side::right ? 1.0 : -1.0) * (X_scan_bone.inverse() * (unit_mm * mean)).z();
  };
  for (SubjectPart& first : parts) {
    std::string stem = first.component.name;
    if (!stem.ends_with("_1")) continue;
    stem.resize(stem.size() - 2);
    const auto of_stem = [&](int k) {
      return std::ranges::find_if(parts, [&](const SubjectPart& part) {
        return part.component.name == stem + "_" + std::to_string(k);
      });
    };
    const auto second = of_stem(2);
    if (second == parts.end() || of_stem(3) != parts.end()) continue;
    if (lateral_mm(first) * lateral_mm(*second) >= 0.0) continue;
    const bool is_first_medial = lateral_mm(first) < 0.0;
    first.component.name = stem + (is_first_medial ? "_medial" : "_lateral");
    second->component.name = stem + (is_first_medial ? "_lateral" : "_medial");
  }
}

void move_to_frame(std::vector<SubjectPart>& parts, double unit_mm, const Pose& X_scan_bone)
{
  for (SubjectPart& part : parts) {
    for (Mesh* mesh : {&part.mesh, &part.simpler}) {
      mesh->vertices_mm *= unit_mm;
      *mesh = transformed(*mesh, X_scan_bone.inverse());
    }
  }
}

namespace {

std::string option_of(const SubjectPart& part)
{
  const std::string& name = part.component.name;
  if (part.component.material == "meniscus") return "--meniscus";
  if (part.component.material != "cartilage") return "--" + name;
  return "--" + name.substr(0, name.find('_')) + "-cartilage";
}

double rounded_mm(double mm)
{
  return std::round(1e3 * mm) / 1e3;
}

Mesh in_mm(Mesh mesh, double unit_mm)
{
  mesh.vertices_mm *= unit_mm;
  return mesh;
}

// An earlier part of which this one is a copy or a piece; null: none.
const SubjectPart* original_of(const std::vector<SubjectPart>& parts, std::size_t part, double unit_mm)
{
  const auto is_original = [&](const SubjectPart& earlier) {
    return geometry::is_part_of(in_mm(parts[part].working(), unit_mm), in_mm(earlier.working(), unit_mm));
  };
  const auto end = parts.begin() + static_cast<std::ptrdiff_t>(part);
  const auto found = std::find_if(parts.begin(), end, is_original);
  return found == end ? nullptr : &*found;
}

}  // namespace

nlohmann::ordered_json simplify_copies(Subject& subject, double unit_mm, const PrepareOptions& options)
{
  constexpr Eigen::Index most_triangles = 200'000, n_wanted = 100'000;
  constexpr double within_mm = 0.05;  // a tenth of a voxel
  std::vector<SubjectPart*> all;      // a patella is small
  for (std::vector<SubjectPart>* parts : {&subject.reference, &subject.moving}) {
    for (SubjectPart& part : *parts) all.push_back(&part);
  }
  Eigen::Index n_all = 0, n_left = 0;
  for (const SubjectPart* part : all) n_all += part->mesh.triangles.rows();
  if (n_all <= most_triangles) return {};
  std::vector<double> largest_mm(all.size(), 0.0);
  core::Progress progress(bar_on_terminal(), "surfaces simplified", static_cast<int>(all.size()), 0);
  for_each_index(all.size(), run::thread_count_or_all(options.n_threads), [&] {
    return [&](std::size_t k) {
      SubjectPart& part = *all[k];
      std::optional<geometry::SimplifiedMesh> simpler = geometry::simplified(
          in_mm(part.mesh, unit_mm), part.mesh.triangles.rows() * n_wanted / n_all, within_mm);
      part.simpler = simpler ? std::move(simpler->mesh) : Mesh{};
      part.simpler.vertices_mm /= unit_mm;
      if (simpler) largest_mm[k] = simpler->largest_mm;
      progress.advance();
    };
  });
  for (const SubjectPart* part : all) n_left += part->working().triangles.rows();
  const double within_found_mm = *std::ranges::max_element(largest_mm);
  core::log_info((options.keeps_triangles ? "works on" : "works on and writes") +
                 std::string(" copies of the surfaces with ") + std::to_string(n_left) + " of " +
                 std::to_string(n_all) + " triangles, within " + rounded_text(within_found_mm, 3) +
                 " mm of them" +
                 (options.keeps_triangles ? "" : "; --every-triangle writes the surfaces as they are"));
  return {{"triangles", n_left}, {"of", n_all}, {"within_mm", rounded_mm(within_found_mm)}};
}

namespace {

// The parts in contact as one mesh in the scan's axes, mm, with their small shells.
struct ScannedBody {
  Mesh mesh;
  std::vector<std::vector<Eigen::Index>> small_shells;
  std::vector<std::pair<std::size_t, std::size_t>> shell_of_part;  // part and row, of each small shell
};

ScannedBody scanned_body(const std::vector<SubjectPart>& parts, double unit_mm)
{
  ScannedBody body;
  for (std::size_t p = 0; p < parts.size(); ++p) {
    if (!parts[p].component.has_contact) continue;
    for (std::size_t s = 0; s < parts[p].small_shells.size(); ++s) {
      std::vector<Eigen::Index> shell = parts[p].small_shells[s];
      for (Eigen::Index& t : shell) t += body.mesh.triangles.rows();
      body.small_shells.push_back(std::move(shell));
      body.shell_of_part.emplace_back(p, s);
    }
    append(body.mesh, in_mm(parts[p].mesh, unit_mm));
  }
  return body;
}

}  // namespace

bool leave_specks_out(Subject& subject, const KneeFit& fit, const PrepareOptions& options,
                      nlohmann::ordered_json& report, std::vector<std::string>& warnings)
{
  const std::vector<double> flexions_deg{0, 10, 20, 30, 40, 50, 60, 70, 80, 90};  // of the job
  constexpr std::size_t most_named = 10;                                          // of each bone
  bool has_changed = false;
  const ScannedBody femur = scanned_body(subject.reference, fit.unit_mm);
  const ScannedBody tibia = scanned_body(subject.moving, fit.unit_mm);
  for (const auto& [parts, body, other, X_body, X_other, sign] :
       {std::tuple(&subject.reference, &femur, &tibia, fit.X_scan_femur, fit.X_scan_tibia, 1.0),
        std::tuple(&subject.moving, &tibia, &femur, fit.X_scan_tibia, fit.X_scan_femur, -1.0)}) {
    std::vector<Pose> poses = job::flexed_poses(Eigen::Vector3d::Zero(), flexions_deg, sign);
    for (Pose& X : poses) X = X_other * X * X_body.inverse();
    std::map<std::size_t, std::vector<std::vector<Eigen::Index>>> dropped;  // of each part
    std::size_t n_specks = 0;
    const auto warn = [&](const auto& part, const std::string& what) {
      warnings.push_back(part.file + ": " + option_of(part) +
                         (options.keeps_specks ? ": kept: " : ": left out: ") + what);
    };
    for (const job::Speck& speck :
         job::specks_of({body->mesh, body->small_shells}, {other->mesh, other->small_shells}, poses)) {
      const auto [p, s] = body->shell_of_part[speck.shell];
      const std::vector<Eigen::Index>& shell = (*parts)[p].small_shells[s];
      dropped[p].push_back(shell);
      if (++n_specks <= most_named) {
        warn((*parts)[p],
             "a separate piece of " + job::speck_text(speck, shell.size(), speck.centre_mm) +
                 ", in the joint space" +
                 (options.keeps_specks ? "; it changes the motion" : "; --keep-specks keeps it"));
      }
      report["specks"].push_back({{"file", (*parts)[p].file},
                                  {"triangles", shell.size()},
                                  {"size_mm", speck.size_mm},
                                  {"at_mm", {speck.centre_mm.x(), speck.centre_mm.y(), speck.centre_mm.z()}},
                                  {"left_out", !options.keeps_specks}});
    }
    if (n_specks > most_named) {
      warn((*parts)[0], std::to_string(n_specks - most_named) +
                            " more separate pieces in the joint space, listed in prepare.json");
    }
    for (const auto& [p, shells] : dropped) {
      if (options.keeps_specks) continue;
      Mesh& mesh = (*parts)[p].mesh;
      mesh = job::compacted(mesh, job::others_than(mesh, shells));
      has_changed = true;
    }
  }
  return has_changed;
}

namespace {

// Smooths the surface of a part; true if vertices moved.
bool smooth_part(SubjectPart& part, double unit_mm, const PrepareOptions& options,
                 nlohmann::ordered_json& row, std::vector<std::string>& warnings)
{
  const Mesh mesh = in_mm(part.mesh, unit_mm);
  const geometry::SurfaceNoise noise = geometry::surface_noise(mesh);
  const bool is_smoothed = noise.is_noisy() && !options.keeps_noise;
  row = {{"component", part.component.name},
         {"noise_mm", json_value(rounded_mm(noise.noise_mm))},
         {"limit_mm", rounded_mm(noise.limit_mm)},
         {"edge_mm", rounded_mm(noise.edge_mm)},
         {"smoothed", is_smoothed}};
  if (!noise.is_noisy()) return false;
  std::string warning = part.file + ": " + option_of(part) + ": its surface is rough: vertices are about " +
                        rounded_text(noise.noise_mm, 2) +
                        " mm off it (standard deviation), clean ones with such edges at most " +
                        rounded_text(noise.limit_mm, 2) + " mm; ";
  if (is_smoothed) {
    geometry::SmoothedSurface smoothed = geometry::smoothed_surface(mesh, noise);
    part.moved_mm = std::move(smoothed.moved_mm);
    part.mesh = std::move(smoothed.mesh);
    part.mesh.vertices_mm /= unit_mm;
    const Eigen::Map<const Eigen::VectorXd> moved_mm(part.moved_mm.data(),
                                                     static_cast<Eigen::Index>(part.moved_mm.size()));
    const double rms_mm = moved_mm.norm() / std::sqrt(static_cast<double>(moved_mm.size()));
    row["passes"] = smoothed.n_passes;
    row["moved_rms_mm"] = rounded_mm(rms_mm);
    row["moved_largest_mm"] = rounded_mm(moved_mm.maxCoeff());
    warning += "smoothed: vertices moved by " + rounded_text(rms_mm, 2) + " mm (RMS), at most " +
               rounded_text(moved_mm.maxCoeff(), 2) + " mm; --no-smooth leaves it as it is";
  } else {
    warning += "not smoothed; it changes the motion";
  }
  warnings.push_back(warning);
  return is_smoothed;
}

}  // namespace

bool smooth_noise(Subject& subject, double unit_mm, const PrepareOptions& options,
                  nlohmann::ordered_json& report, std::vector<std::string>& warnings)
{
  struct Row {
    SubjectPart* part = nullptr;
    bool has_changed = false;
    nlohmann::ordered_json noise;
    std::vector<std::string> warnings;
  };
  std::vector<Row> rows;
  for (std::vector<SubjectPart>* parts : {&subject.reference, &subject.moving, &subject.patella}) {
    for (SubjectPart& part : *parts) rows.push_back({&part, false, {}, {}});
  }
  for_each_index(rows.size(), run::thread_count_or_all(options.n_threads), [&] {
    return [&](std::size_t k) {
      Row& row = rows[k];
      row.has_changed = smooth_part(*row.part, unit_mm, options, row.noise, row.warnings);
    };
  });
  bool has_changed = false;
  std::string found;
  for (Row& row : rows) {
    has_changed |= row.has_changed;
    warnings.insert(warnings.end(), row.warnings.begin(), row.warnings.end());
    const nlohmann::ordered_json& mm = row.noise["noise_mm"];
    found += (found.empty() ? "" : ", ") + row.part->component.name + " " +
             (mm.is_null() ? "not judged" : rounded_text(mm.get<double>(), 2) + " mm");
    report["noise"].push_back(std::move(row.noise));
  }
  core::log_info("noise of the surfaces: " + found);
  return has_changed;
}

void warn_of_one_compartment(const Subject& subject, std::vector<std::string>& warnings)
{
  for (const auto& [parts, option, facing] : {std::tuple(&subject.reference, "--femur-cartilage", -1.0),
                                              std::tuple(&subject.moving, "--tibia-cartilage", 1.0)}) {
    const Mesh cartilage = surfaces_of(*parts).cartilage;
    if (cartilage.triangles.rows() == 0 ||
        job::lesser_side_share(cartilage, facing, 0.0) >= job::least_side_share)
      continue;
    warnings.push_back(
        std::string(option) +
        ": cartilage of one compartment only; the knee tilts to the bare one: give the cartilage of "
        "both (the option takes several), or leave it out, so that the bone is thickened");
  }
}

std::optional<InputError::Facts> wrong_part(const Subject& subject, const KneeSurfaces& surfaces,
                                            double unit_mm, std::vector<std::string>& warnings)
{
  const std::string wanted = "this part in the scan of the bones";
  const Mesh femur = in_mm(surfaces.femur.bone, unit_mm), tibia = in_mm(surfaces.tibia.bone, unit_mm);
  for (const auto& [parts, bone, own, other] :
       {std::tuple(&subject.reference, geometry::CartilageOf::femur, &femur, &tibia),
        std::tuple(&subject.moving, geometry::CartilageOf::tibia, &tibia, &femur)}) {
    for (std::size_t p = 0; p < parts->size(); ++p) {
      const SubjectPart& part = (*parts)[p];
      if (const SubjectPart* original = original_of(*parts, p, unit_mm))
        return InputError::Facts{part.file, option_of(part),
                                 "the surface of " + option_of(*original) + " (" + original->file + ")",
                                 wanted};
      geometry::PartCheck check;
      if (part.component.material == "cartilage")
        check = geometry::cartilage_check(in_mm(part.working(), unit_mm), bone, *own, *other);
      if (part.component.material == "meniscus")
        check =
            geometry::meniscus_check(in_mm(part.working(), unit_mm), in_mm(joined(surfaces.tibia), unit_mm));
      if (!check.rejection.empty())
        return InputError::Facts{part.file, option_of(part), check.rejection, wanted};
      if (!check.doubt.empty()) warnings.push_back(part.file + ": " + option_of(part) + ": " + check.doubt);
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
  const std::string source =
      !std::isfinite(gap_mm) ? ", the most that is assumed: the scan has no gap to measure"
      : gap_mm < 0.0 ? ", the least that is assumed: the bones overlap by " + short_decimal(-gap_mm, 2) +
                           " mm in the scan; check that both are in one pose"
      : is_in_range ? ", from the gap in the scan"
                    : ", not from the gap in the scan, which is " + short_decimal(gap_mm, 2) + " mm";
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

namespace {

job::MovedVertices moved_by_smoothing(const std::vector<SubjectPart>& parts)
{
  job::MovedVertices moved;
  for (const SubjectPart& part : parts) {
    for (std::size_t v = 0; v < part.moved_mm.size(); ++v) {
      const Eigen::RowVector3f p = part.mesh.vertices_mm.row(static_cast<Eigen::Index>(v)).cast<float>();
      moved[{p.x(), p.y(), p.z()}] = part.moved_mm[v];
    }
  }
  return moved;
}

// For the caption of the picture.
std::string smoothing_text(const nlohmann::ordered_json& report)
{
  std::string text;
  for (const nlohmann::ordered_json& row : report.value("noise", nlohmann::ordered_json::array())) {
    if (!row["smoothed"].get<bool>()) continue;
    text += (text.empty() ? " Smoothed, vertices moved (RMS, largest): " : ", ") +
            row["component"].get<std::string>() + " " + rounded_text(row["moved_rms_mm"].get<double>(), 2) +
            ", " + rounded_text(row["moved_largest_mm"].get<double>(), 2) + " mm";
  }
  return text + (text.empty() ? "" : ".");
}

std::vector<const std::vector<SubjectPart>*> all_parts(const Subject& subject)
{
  return {&subject.reference, &subject.moving, &subject.patella};
}

}  // namespace

Prepared::Prepared(const PrepareOptions& of_options)
    : options(of_options),
      job_name(options.joint + ".toml"),
      files(options.folder, job_name, "vrda prepare"),
      scan_space(scan_space_of(options))
{
}

void Prepared::check_output(std::vector<std::string> others) const
{
  others.insert(others.begin(), {job_name, "prepare.json", "prepare.png"});
  std::vector<std::string> inputs;
  for (const std::vector<SubjectPart>* parts : all_parts(subject)) {
    for (const SubjectPart& part : *parts) {
      others.push_back(part.component.name + ".stl");
      if (!part.file.empty()) inputs.push_back(part.file);
    }
  }
  files.check_replaced(others, inputs, options.may_replace);
}

prepare::JobDescription Prepared::description() const
{
  prepare::JobDescription job;
  job.joint = options.joint;
  job.title = std::filesystem::path(options.folder).stem().string();
  if (job.title.empty()) job.title = options.joint;
  for (const SubjectPart& part : subject.reference) job.reference.push_back(part.component);
  for (const SubjectPart& part : subject.moving) job.moving.push_back(part.component);
  return job;
}

void Prepared::write_mesh(const std::string& name, const Mesh& mesh) const
{
  write_atomically(files.file(name + ".stl"), {job::stl_bytes(mesh, "vrda prepare, mm, anatomical frame")});
}

job::Case Prepared::written_case(const prepare::JobDescription& job) const
{
  for (const std::vector<SubjectPart>* parts : all_parts(subject)) {
    for (const SubjectPart& part : *parts) write_mesh(part.component.name, part.working());
  }
  return job::load_case(job::parse_job(files.file(job_name), prepare::job_text(job)), "");
}

void Prepared::write_picture(const job::Case& drawn, const std::string& name,
                             const std::string& refusal) const
{
  job::PictureNotes notes;
  notes.n_warnings = warnings.size();
  notes.refusal = refusal;
  notes.has_four_views = true;
  notes.moved = {moved_by_smoothing(subject.reference), moved_by_smoothing(subject.moving)};
  notes.smoothing = smoothing_text(report);
  write_atomically(files.file(name), {job::case_picture(drawn, notes)});
}

core::ExitCode Prepared::publish(const std::string& job_text, const std::vector<std::string>& obsolete)
{
  report["warnings"] = warnings;
  write_atomically(files.file("prepare.json"), {core::json_text(report, 2) + "\n"});
  write_atomically(files.file(job_name), {job_text});
  files.publish_all(obsolete);
  for (const std::string& warning : warnings) core::log_warning(warning);
  if (options.as_json) return print_json(report);
  std::printf("%s\n", path_of(job_name).c_str());
  return core::ExitCode::done;
}

std::string Prepared::path_of(const std::string& name) const
{
  return (std::filesystem::path(options.folder) / name).string();
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
      parts.push_back({{component.name, component.material, part == &body.contact}, "", mesh, {}, {}});
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
