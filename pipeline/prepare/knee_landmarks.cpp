#include "prepare/knee_landmarks.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/schema.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "job/slicer_files.hpp"

namespace vrda::prepare {

const core::DocumentSchema& joint_landmarks_schema();  // schemas/joint_landmarks.schema.json
const core::DocumentSchema& knee_landmarks_schema();   // schemas/knee_landmarks.schema.json

namespace {

using core::DocumentValue;

// The vertices of the mesh in a box about the rotation centre, of which the outermost is the landmark. Boxes
// are of a right knee.
struct LandmarkPlace {
  const char* name;
  Bone bone;
  Eigen::Vector3d outward;
  Box region;
};

const std::array<LandmarkPlace, 6>& landmark_places()
{
  static const std::array<LandmarkPlace, 6> places{
      LandmarkPlace{"medial_epicondyle", Bone::femur, {0, 0, -1}, {{-25, -25, -70}, {25, 25, 0}}},
      LandmarkPlace{"lateral_epicondyle", Bone::femur, {0, 0, 1}, {{-25, -25, 0}, {25, 25, 70}}},
      LandmarkPlace{"medial_spine", Bone::tibia, {0, 1, 0}, {{-20, -60, -15}, {20, 0, -2}}},
      LandmarkPlace{"lateral_spine", Bone::tibia, {0, 1, 0}, {{-20, -60, 2}, {20, 0, 18}}},
      LandmarkPlace{"medial_plateau", Bone::tibia, {0, 0, -1}, {{-40, -50, -70}, {40, -20, 0}}},
      LandmarkPlace{"lateral_plateau", Bone::tibia, {0, 0, 1}, {{-40, -50, 0}, {40, -20, 70}}}};
  return places;
}

constexpr const char* fibular_head = "fibular_head";

struct Outermost {
  Eigen::Vector3d outward;
  Box region;
};

// Mean of the vertices of triangles within 1 mm of the outermost: a single vertex is as noisy as the mesh.
std::optional<Eigen::Vector3d> outermost_mm(const Mesh& mesh, const Outermost& wanted)
{
  constexpr double depth_mm = 1.0;
  std::vector<bool> is_in(static_cast<std::size_t>(mesh.vertices_mm.rows()), false);
  double outermost = -std::numeric_limits<double>::infinity();
  for (const std::int32_t row : mesh.triangles.reshaped()) {
    const Eigen::Vector3d p_mm = mesh.vertices_mm.row(row);
    if ((p_mm.array() < wanted.region.min_mm.array()).any() ||
        (p_mm.array() > wanted.region.max_mm.array()).any())
      continue;
    is_in[static_cast<std::size_t>(row)] = true;
    outermost = std::max(outermost, p_mm.dot(wanted.outward));
  }
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int n = 0;
  for (std::size_t row = 0; row < is_in.size(); ++row) {
    const Eigen::Vector3d p_mm = mesh.vertices_mm.row(static_cast<Eigen::Index>(row));
    if (!is_in[row] || p_mm.dot(wanted.outward) < outermost - depth_mm) continue;
    sum += p_mm;
    ++n;
  }
  return n == 0 ? std::nullopt : std::optional<Eigen::Vector3d>(sum / n);
}

std::optional<Eigen::Vector3d> point_at(const DocumentValue& table, const char* key)
{
  return !table.contains(key) ? std::nullopt : std::optional<Eigen::Vector3d>(core::vector3_at(table, key));
}

void read_fibres(KneeLandmarks& landmarks)
{
  const core::Document& document = landmarks.document;
  for (const DocumentValue& row : core::list_or_empty(document.root, "fibre")) {
    const std::string key = "fibre." + std::to_string(landmarks.fibres.size());
    FibreEnds ends{core::text_at(row, "name"), point_at(row, "femur"), point_at(row, "tibia")};
    if (!ends.femur && !ends.tibia) document.refuse(key, "neither femur nor tibia", "at least one of them");
    if (std::any_of(landmarks.fibres.begin(), landmarks.fibres.end(),
                    [&](const FibreEnds& other) { return other.name == ends.name; }))
      document.refuse(key + ".name", "\"" + ends.name + "\" a second time", "each fibre once");
    landmarks.fibres.push_back(std::move(ends));
  }
}

void read_distances(KneeLandmarks& landmarks)
{
  const core::Document& document = landmarks.document;
  for (const DocumentValue& row : core::list_or_empty(document.root, "distance")) {
    const std::string key = "distance." + std::to_string(landmarks.distances.size());
    const NamedDistance distance{core::text_at(row, "from"), core::text_at(row, "to"),
                                 core::number_at(row, "mm")};
    if (distance.from == distance.to)
      document.refuse(key + ".to", "\"" + distance.to + "\", the same as from", "another landmark");
    if (bone_of(distance.from) != bone_of(distance.to))
      document.refuse(key + ".to",
                      "\"" + distance.to + "\", a landmark of another bone than \"" + distance.from + "\"",
                      "a landmark of the same bone: other distances change with the pose");
    landmarks.distances.push_back(distance);
  }
}

// A point of the subject and of the template.
struct SizedPoint {
  std::string name;
  Eigen::Vector3d template_mm, subject_mm;
};

// A length of the subject between two points of the template.
struct SizedDistance {
  std::string name;
  Eigen::Vector3d span_mm;
  double subject_mm;
};

std::vector<SizedPoint> points_of(const KneeLandmarks& landmarks, const TemplateJoint& joint, Bone bone,
                                  double unit_mm)
{
  std::vector<SizedPoint> points;
  for (const NamedPoint& point : landmarks.points) {
    const std::optional<Eigen::Vector3d> at_mm = landmark_mm(joint, point.name);
    if (bone_of(point.name) == bone && at_mm) points.push_back({point.name, *at_mm, unit_mm * point.p});
  }
  for (const FibreEnds& ends : landmarks.fibres) {
    const std::optional<Eigen::Vector3d>& end = bone == Bone::femur ? ends.femur : ends.tibia;
    if (!end) continue;
    for (const model::Fibre& fibre : joint.joint.ligaments.fibres) {
      if (fibre.name != ends.name) continue;
      points.push_back(
          {ends.name, bone == Bone::femur ? fibre.reference_mm : fibre.moving_mm, unit_mm * *end});
    }
  }
  return points;
}

std::vector<SizedDistance> distances_of(const KneeLandmarks& landmarks, const TemplateJoint& joint, Bone bone,
                                        double unit_mm)
{
  // Shorter ones depend more on the points' errors than on the bone.
  constexpr double shortest_mm = 5.0;
  std::vector<SizedDistance> distances;
  for (const NamedDistance& given : landmarks.distances) {
    const std::optional<Eigen::Vector3d> from = landmark_mm(joint, given.from),
                                         to = landmark_mm(joint, given.to);
    if (bone_of(given.from) == bone && from && to)
      distances.push_back({given.from + " - " + given.to, *to - *from, given.mm});
  }
  const std::vector<SizedPoint> points = points_of(landmarks, joint, bone, unit_mm);
  for (std::size_t i = 0; i < points.size(); ++i) {
    for (std::size_t j = i + 1; j < points.size(); ++j) {
      const Eigen::Vector3d span_mm = points[j].template_mm - points[i].template_mm;
      if (span_mm.norm() < shortest_mm) continue;
      distances.push_back({points[i].name + " - " + points[j].name, span_mm,
                           (points[j].subject_mm - points[i].subject_mm).norm()});
    }
  }
  return distances;
}

// Gauss-Newton from the best single factor.
Scaling fitted_scaling(const std::vector<SizedDistance>& distances)
{
  // mm^2 per squared deviation of a factor from the mean of the three: people's proportions differ by some
  // 5 %, distances between palpated points are wrong by some 3 mm.
  constexpr double evenness_mm2 = 3600.0;
  constexpr int n_iterations = 30;
  double model_subject = 0.0, model_sq = 0.0;
  for (const SizedDistance& distance : distances) {
    model_subject += distance.span_mm.norm() * distance.subject_mm;
    model_sq += distance.span_mm.squaredNorm();
  }
  Scaling scaling;
  scaling.factor.setConstant(model_subject / model_sq);
  const Eigen::Matrix3d deviation = Eigen::Matrix3d::Identity() - Eigen::Matrix3d::Constant(1.0 / 3.0);
  for (int i = 0; i < n_iterations; ++i) {
    Eigen::Matrix3d H = evenness_mm2 * deviation;
    Eigen::Vector3d g = evenness_mm2 * deviation * scaling.factor;
    for (const SizedDistance& distance : distances) {
      const double length_mm = scaling.factor.cwiseProduct(distance.span_mm).norm();
      const Eigen::Vector3d slope = scaling.factor.cwiseProduct(distance.span_mm.cwiseAbs2()) / length_mm;
      H += slope * slope.transpose();
      g += (length_mm - distance.subject_mm) * slope;
    }
    scaling.factor -= H.ldlt().solve(g);
  }
  double residual_sq = 0.0;
  for (const SizedDistance& distance : distances) {
    const double residual_mm = distance.subject_mm - scaling.factor.cwiseProduct(distance.span_mm).norm();
    scaling.landmark.push_back(distance.name);
    scaling.model_mm.push_back(distance.span_mm.norm());
    scaling.subject_mm.push_back(distance.subject_mm);
    scaling.residual_mm.push_back(residual_mm);
    residual_sq += residual_mm * residual_mm;
  }
  scaling.residual_rms_mm = std::sqrt(residual_sq / static_cast<double>(distances.size()));
  return scaling;
}

void check_factor(const KneeLandmarks& landmarks, const Scaling& scaling, const char* bone)
{
  constexpr double least = 0.5, most = 2.0;
  if (scaling.factor.minCoeff() >= least && scaling.factor.maxCoeff() <= most) return;
  landmarks.document.refuse("",
                            std::string("points and distances that make the ") + bone + " " +
                                short_decimal(scaling.factor.x(), 2) + ", " +
                                short_decimal(scaling.factor.y(), 2) + " and " +
                                short_decimal(scaling.factor.z(), 2) + " times the template's",
                            "factors from 0.5 to 2: points are in the unit of --unit, distances in mm");
}

void warn_of_misfit(const Scaling& scaling, const char* bone, std::vector<std::string>& warnings)
{
  constexpr double largest_misfit = 0.05;  // as of [scaling] (job/scaling.cpp)
  double subject_sq = 0.0;
  for (const double subject_mm : scaling.subject_mm) subject_sq += subject_mm * subject_mm;
  const double mean_mm = std::sqrt(subject_sq / static_cast<double>(scaling.subject_mm.size()));
  if (scaling.residual_rms_mm <= largest_misfit * mean_mm) return;
  warnings.push_back(std::string(bone) + ": the residual of its three factors is " +
                     short_decimal(scaling.residual_rms_mm, 2) + " mm (root mean square) of distances of " +
                     short_decimal(mean_mm, 2) + " mm; check the landmarks");
}

}  // namespace

Bone bone_of(const std::string& landmark)
{
  return landmark.ends_with("epicondyle") ? Bone::femur : Bone::tibia;
}

namespace {

// As the TOML file would have them.
DocumentValue document_of(const job::SlicerPoints& slicer, double unit_mm)
{
  DocumentValue root = DocumentValue::object();
  const auto values = [unit_mm](const Eigen::Vector3d& p_mm) {
    const Eigen::Vector3d p = p_mm / unit_mm;
    return DocumentValue{p.x(), p.y(), p.z()};
  };
  for (const job::LabelledPoint& point : slicer.points) {
    const std::size_t dot = point.label.rfind('.');
    const std::string bone = dot == std::string::npos ? "" : point.label.substr(dot + 1);
    if (bone != "femur" && bone != "tibia") {
      root["landmarks"][point.label] = values(point.p_mm);
      continue;
    }
    const std::string name = point.label.substr(0, dot);
    DocumentValue& fibres = root["fibre"];
    const auto found =
        std::find_if(fibres.begin(), fibres.end(), [&](const DocumentValue& f) { return f["name"] == name; });
    DocumentValue& fibre =
        found != fibres.end() ? *found : (fibres.push_back({{"name", name}}), fibres.back());
    fibre[bone] = values(point.p_mm);
  }
  return root;
}

core::Document checked_document(const core::DocumentSchema& schema, const std::string& file,
                                std::string_view text, const LandmarkSpace& meshes)
{
  if (!job::is_slicer_points(file)) return schema.read(text, file);
  const job::SlicerPoints points = job::read_slicer_points(file, std::string(text));
  core::Document document{file, document_of(job::in_space(points, meshes.space), meshes.unit_mm)};
  document.root = schema.checked(document);
  return document;
}

std::vector<NamedPoint> points_of(const core::Document& document)
{
  std::vector<NamedPoint> points;
  for (const auto& [name, point] : core::value_at(document.root, "landmarks").items())
    points.push_back({name, core::vector3_at(point, "")});
  return points;
}

}  // namespace

std::vector<NamedPoint> read_joint_landmarks(const std::string& file, std::string_view text,
                                             const LandmarkSpace& meshes)
{
  return points_of(checked_document(joint_landmarks_schema(), file, text, meshes));
}

KneeLandmarks read_knee_landmarks(const std::string& file, std::string_view text, const LandmarkSpace& meshes)
{
  KneeLandmarks landmarks;
  landmarks.document = checked_document(knee_landmarks_schema(), file, text, meshes);
  landmarks.points = points_of(landmarks.document);
  read_fibres(landmarks);
  read_distances(landmarks);
  if (landmarks.points.empty() && landmarks.fibres.empty() && landmarks.distances.empty())
    landmarks.document.refuse("", "no point", "[landmarks], [[fibre]] or [[distance]]");
  return landmarks;
}

void check_fibre_names(const KneeLandmarks& landmarks, const model::Ligaments& ligaments)
{
  std::vector<std::string> names;
  for (const model::Fibre& fibre : ligaments.fibres) names.push_back(fibre.name);
  for (std::size_t i = 0; i < landmarks.fibres.size(); ++i) {
    const std::string& name = landmarks.fibres[i].name;
    if (std::find(names.begin(), names.end(), name) != names.end()) continue;
    landmarks.document.refuse(
        "fibre." + std::to_string(i) + ".name", "\"" + name + "\"",
        names.empty() ? "a template with ligaments"
                      : "a fibre of the template; the nearest is \"" + nearest_word(name, names) + "\"");
  }
}

std::optional<Eigen::Vector3d> landmark_mm(const TemplateJoint& joint, const std::string& name)
{
  const bool is_left = joint.joint.frame.side == Side::left;
  const Eigen::Vector3d flip(1.0, 1.0, is_left ? -1.0 : 1.0);
  // As a right knee about its rotation centre.
  const auto found_in = [&](const Mesh& mesh, const Outermost& wanted) -> std::optional<Eigen::Vector3d> {
    Mesh centred = mesh;
    centred.vertices_mm.rowwise() -= joint.knee.origin_mm.transpose();
    if (is_left) centred.vertices_mm.col(2) *= -1.0;
    const std::optional<Eigen::Vector3d> p_mm = outermost_mm(centred, wanted);
    if (!p_mm) return std::nullopt;
    return Eigen::Vector3d(joint.knee.origin_mm + flip.cwiseProduct(*p_mm));
  };
  if (name == fibular_head) {
    constexpr double anywhere_mm = 1e6;
    const Eigen::Vector3d corner = Eigen::Vector3d::Constant(anywhere_mm);
    return found_in(joint.fibula, {Eigen::Vector3d::UnitY(), {-corner, corner}});
  }
  const auto& places = landmark_places();
  const auto* place =
      std::find_if(places.begin(), places.end(), [&](const LandmarkPlace& p) { return p.name == name; });
  check(place != places.end(), "a landmark of the schema has a place");
  const geometry::BoneSurfaces& surfaces =
      place->bone == Bone::femur ? joint.knee.surfaces.femur : joint.knee.surfaces.tibia;
  if (surfaces.bone.triangles.rows() == 0) return std::nullopt;
  return found_in(joined(surfaces), {place->outward, place->region});
}

std::vector<geometry::KnownPoint> known_points(const KneeLandmarks& landmarks,
                                               const TemplateJoint& right_template, Bone bone)
{
  std::vector<geometry::KnownPoint> points;
  for (const NamedPoint& point : landmarks.points) {
    const std::optional<Eigen::Vector3d> at_mm = landmark_mm(right_template, point.name);
    if (bone_of(point.name) == bone && at_mm) points.push_back({*at_mm, point.p});
  }
  return points;
}

std::vector<double> landmark_residuals_mm(const KneeLandmarks& landmarks, const TemplateJoint& own_side,
                                          const geometry::KneeFit& fit)
{
  constexpr double refused_mm = 30.0;
  std::vector<double> residuals_mm;
  for (const NamedPoint& point : landmarks.points) {
    const std::optional<Eigen::Vector3d> at_mm = landmark_mm(own_side, point.name);
    const geometry::BoneFit& bone = bone_of(point.name) == Bone::femur ? fit.femur : fit.tibia;
    residuals_mm.push_back(at_mm ? (bone(*at_mm) - fit.unit_mm * point.p).norm() : nan);
    if (residuals_mm.back() > refused_mm)
      landmarks.document.refuse(
          "landmarks." + point.name,
          "a point " + short_decimal(residuals_mm.back(), 0) + " mm from where the bones have it",
          "a point in the coordinates and the unit of the mesh files");
  }
  return residuals_mm;
}

LandmarkScales landmark_scales(const KneeLandmarks& landmarks, const TemplateJoint& own_side, double unit_mm)
{
  const std::vector<SizedDistance> of_femur = distances_of(landmarks, own_side, Bone::femur, unit_mm);
  const std::vector<SizedDistance> of_tibia = distances_of(landmarks, own_side, Bone::tibia, unit_mm);
  if (of_femur.empty() && of_tibia.empty())
    landmarks.document.refuse("", "no distance between two points of one bone",
                              "two points of a bone that the template has, or a [[distance]]; or meshes: "
                              "--femur and --tibia");
  LandmarkScales scales;
  const auto set = [&](Scaling& scaling, const std::vector<SizedDistance>& distances, const char* bone) {
    if (distances.empty()) return;
    scaling = fitted_scaling(distances);
    check_factor(landmarks, scaling, bone);
    warn_of_misfit(scaling, bone, scales.warnings);
  };
  set(scales.femur, of_femur, "femur");
  set(scales.tibia, of_tibia, "tibia");
  const auto take = [&](Scaling& scaling, const Scaling& other, const std::string& bone) {
    scaling.factor.setConstant(other.factor.mean());
    scales.warnings.push_back(
        bone + ": no distance between landmarks that the template has; its size is that of the other bone");
  };
  if (of_femur.empty()) take(scales.femur, scales.tibia, "femur");
  if (of_tibia.empty()) take(scales.tibia, scales.femur, "tibia");
  return scales;
}

}  // namespace vrda::prepare
