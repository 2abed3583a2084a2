// [scaling] of a job: the factor from landmarks, and whether the steps are kept.
#include "job/component_loader.hpp"

#include <algorithm>
#include <cmath>
#include <compare>
#include <cstdint>
#include <numeric>

#include "job/ligament_files.hpp"
#include "job/slicer_files.hpp"

namespace vrda::job {
namespace {

// The limits of schemas/job.schema.json (infant to adult and reverse); others are probably a wrong unit.
constexpr double smallest_factor = 0.1, largest_factor = 10.0;

// Relative RMS residual above which a fit is reported: 4 mm of the 80 mm between a knee's epicondyles, about
// the error of skin markers.
constexpr double largest_misfit = 0.05;

std::string rounded(double value, double step)
{
  return shortest_decimal(std::round(value / step) * step);
}

std::string shown_factor(const Eigen::Vector3d& factor)
{
  if (is_uniform(factor)) return shortest_decimal(factor.x());
  return "[" + core::numbers_text(factor) + "]";
}

std::vector<std::string> warnings_of_fit(const Scaling& scaling)
{
  const std::string key = "scaling.landmarks: ";
  if (scaling.landmark.size() == 1) return {key + "one pair, so the error of the factor is unknown"};
  double subject_sq = 0.0;
  for (const double subject_mm : scaling.subject_mm) subject_sq += subject_mm * subject_mm;
  const double n = static_cast<double>(scaling.subject_mm.size());
  const double misfit = scaling.residual_rms_mm / std::sqrt(subject_sq / n);
  if (misfit <= largest_misfit) return {};
  const auto is_smaller = [](double a, double b) { return std::abs(a) < std::abs(b); };
  const auto worst = std::max_element(scaling.residual_mm.begin(), scaling.residual_mm.end(), is_smaller);
  return {key + "the residual of the factor is " + rounded(scaling.residual_rms_mm, 0.01) + " mm, " +
          rounded(100.0 * misfit, 0.1) + " % of the distances (root mean square), most at \"" +
          scaling.landmark[static_cast<std::size_t>(worst - scaling.residual_mm.begin())] + "\", " +
          rounded(*worst, 0.01) +
          " mm: the subject is not a uniformly scaled model; use three factors or meshes of the subject in a "
          "new run"};
}

Mesh scaled(const Mesh& mesh, const Eigen::Vector3d& centre_mm, const Eigen::Vector3d& factor)
{
  Mesh out = mesh;
  for (Eigen::Index v = 0; v < out.vertices_mm.rows(); ++v) {
    const Eigen::Vector3d p_mm = mesh.vertices_mm.row(v);
    out.vertices_mm.row(v) = (centre_mm + factor.cwiseProduct(p_mm - centre_mm)).transpose();
  }
  for (double& offset_mm : out.offset_mm) offset_mm *= factor.x();
  for (double& overlap_mm : out.overlap_mm) overlap_mm *= factor.x();
  if (is_uniform(factor)) return out;
  // Normals are covectors. Zero normals stay zero.
  for (Eigen::Index v = 0; v < out.normals.rows(); ++v) {
    const Eigen::Vector3d n = Eigen::Vector3d(mesh.normals.row(v)).cwiseQuotient(factor);
    if (n.squaredNorm() > 0.0) out.normals.row(v) = n.normalized().transpose();
  }
  return out;
}

void scale(model::Ligaments& ligaments, const Eigen::Vector3d& centre_mm, const Eigen::Vector3d& factor)
{
  const auto at = [&](const Eigen::Vector3d& p_mm) -> Eigen::Vector3d {
    return centre_mm + factor.cwiseProduct(p_mm - centre_mm);
  };
  for (model::Fibre& fibre : ligaments.fibres) {
    const Eigen::Vector3d span_mm = fibre.reference_mm - fibre.moving_mm;
    // The strain at the pose of the meshes is kept. With a non-uniform factor all fibres are straight.
    fibre.slack_length_mm *=
        is_uniform(factor) ? factor.x() : factor.cwiseProduct(span_mm).norm() / span_mm.norm();
    fibre.reference_mm = at(fibre.reference_mm);
    fibre.moving_mm = at(fibre.moving_mm);
  }
  for (model::Wrap& wrap : ligaments.wraps) {
    wrap.X_body_wrap.translation() = at(wrap.X_body_wrap.translation());
    wrap.radii_mm *= factor.x();
  }
}

// Updates the survey: box corners are scaled, all else is measured again.
void update_survey(Case& loaded, const Eigen::Vector3d& factor)
{
  const Eigen::Vector3d& centre_mm = loaded.frame.rotation_centre_mm;
  std::size_t entry = 0;
  std::vector<const Body*> bodies{&loaded.reference, &loaded.moving};
  for (const Follower& follower : loaded.followers) bodies.push_back(&follower.body);
  for (const Body* body : bodies) {
    const auto contact = triangles_by_component(*body, body->contact);
    const auto visual = triangles_by_component(*body, body->visual);
    for (std::size_t c = 0; c < body->components.size(); ++c, ++entry) {
      ComponentSurvey& survey = loaded.survey.at(entry);
      const Part& part = survey.has_contact ? body->contact : body->visual;
      const Mesh mesh = select_triangles(part.mesh, (survey.has_contact ? contact : visual)[c]);
      survey.box.min_mm = centre_mm + factor.cwiseProduct(survey.box.min_mm - centre_mm);
      survey.box.max_mm = centre_mm + factor.cwiseProduct(survey.box.max_mm - centre_mm);
      survey.mean_edge_mm = mean_edge_length_mm(mesh);
      survey.area_mm2 = area_mm2(mesh);
      survey.volume_mm3 = signed_volume_mm3(mesh);
    }
  }
}

// Scales every length of the joint, but no solver settings.
void scale_lengths(Case& loaded, const Eigen::Vector3d& factor)
{
  const Eigen::Vector3d& centre_mm = loaded.frame.rotation_centre_mm;
  std::vector<Body*> bodies{&loaded.reference, &loaded.moving};
  for (Follower& follower : loaded.followers) {
    bodies.push_back(&follower.body);
    scale(follower.ligaments, centre_mm, factor);
    const auto scale_shift = [&](Pose& X) {  // uniform, so angles stay
      X.translation() =
          factor.x() * X.translation() + (1.0 - factor.x()) * (centre_mm - X.linear() * centre_mm);
    };
    scale_shift(follower.X_of_scan);
    scale_shift(follower.X_reference_moving_scan);
    follower.centre_mm = centre_mm + factor.cwiseProduct(follower.centre_mm - centre_mm);
  }
  for (Body* body : bodies) {
    for (Part* part : {&body->contact, &body->visual}) part->mesh = scaled(part->mesh, centre_mm, factor);
  }
  scale(loaded.ligaments, centre_mm, factor);
  loaded.initial.translation_mm = factor.cwiseProduct(loaded.initial.translation_mm);
  loaded.push_point_mm = factor.cwiseProduct(loaded.push_point_mm);
  for (LoadPoint& load : loaded.loads) load.point_mm = factor.cwiseProduct(load.point_mm);
  for (LinePath& line : loaded.lines) {
    for (std::vector<Eigen::Vector3d>* points : {&line.reference_mm, &line.moving_mm}) {
      for (Eigen::Vector3d& p_mm : *points) p_mm = factor.cwiseProduct(p_mm);
    }
  }
  update_survey(loaded, factor);
}

// Why the steps at factor 1 cannot be reused; empty if they can.
std::string reason_for_rerun(const Case& loaded, const Eigen::Vector3d& factor)
{
  if (!is_uniform(factor)) return "the factors differ, which changes the shapes";
  if (factor.x() != 1.0 && loaded.coordinates)
    return "coordinates are given, which do not scale with the joint";
  if (factor.x() != 1.0 && loaded.uncertainty)
    return "uncertain lengths and loads do not scale with the joint";
  if (factor.x() != 1.0 && !loaded.followers.empty()) return "fibres hold a body that follows the joint";
  // The search uses contact and directions only.
  if (factor.x() == 1.0 || loaded.method != "equilibrium") return "";
  if (!loaded.prior.empty()) return "a prior acts, whose curves do not scale with the joint";
  if (!loaded.ligaments.fibres.empty()) return "ligaments constrain the joint";
  if (loaded.equilibrium.contact_stiffness_n_per_mm3 > 0.0)
    return "the stiffness of contact does not scale with the joint";
  const bool has_moment = std::any_of(loaded.push.begin(), loaded.push.end(), [](const Push& push) {
    const auto is_moment = [](const Eigen::Vector3d& moment_nmm) { return !moment_nmm.isZero(0.0); };
    return push.moment_nmm != 0.0 || push.varus_moment_nmm != 0.0 ||
           std::any_of(push.load_moment_nmm.begin(), push.load_moment_nmm.end(), is_moment);
  });
  return has_moment ? "a moment acts, which does not scale with the joint" : "";
}

void check_uneven(const Case& loaded, const Job& job, const Eigen::Vector3d& factor)
{
  if (is_uniform(factor)) return;
  const std::string key = "scaling.factor";
  const auto refuse = [&](const std::string& with, const std::string& wanted) {
    throw InputError({job.document.source_of(key), key, shown_factor(factor) + " with " + with, wanted});
  };
  if (!loaded.followers.empty()) refuse("[[follower]]", "one factor");
  for (const Body* body : {&loaded.reference, &loaded.moving}) {
    if (!body->contact.mesh.offset_mm.empty())
      refuse("offset_mm of a component", "one factor: an unevenly scaled sphere is not a sphere");
    if (!body->contact.mesh.overlap_mm.empty())
      refuse("overlap_mm of a component", "one factor: the overlap is a length along any direction");
  }
  if (!loaded.ligaments.wraps.empty()) {
    refuse("the wrapping surface \"" + loaded.ligaments.wraps.front().name + "\"",
           "one factor: a non-uniformly scaled cylinder is not a cylinder");
  }
  for (const model::Fibre& fibre : loaded.ligaments.fibres) {
    if (fibre.reference_mm != fibre.moving_mm) continue;
    refuse("the fibre \"" + fibre.name + "\", whose attachments coincide",
           "one factor, or different attachments: the slack length is scaled by their distance");
  }
}

}  // namespace

namespace {

// All pairs of the labels that points of the model and of the subject have, in mm.
std::vector<LandmarkPair> pairs_of(const InputFile& model_file, const InputFile& subject_file)
{
  const SlicerPoints model = read_slicer_points(model_file.path, model_file.bytes);
  const SlicerPoints subject = read_slicer_points(subject_file.path, subject_file.bytes);
  std::vector<std::pair<LabelledPoint, Eigen::Vector3d>> both;
  for (const LabelledPoint& point : model.points)
    for (const LabelledPoint& other : subject.points)
      if (other.label == point.label) both.emplace_back(point, other.p_mm);
  std::vector<LandmarkPair> pairs;
  for (std::size_t i = 0; i < both.size(); ++i) {
    for (std::size_t j = i + 1; j < both.size(); ++j) {
      const auto& [a, a_mm] = both[i];
      const auto& [b, b_mm] = both[j];
      const double subject_mm = (a_mm - b_mm).norm();
      if (a.p_mm == b.p_mm || subject_mm == 0.0)
        throw InputError({a.p_mm == b.p_mm ? model_file.path : subject_file.path, "",
                          quoted_text(a.label) + " and " + quoted_text(b.label) + " at one point",
                          "different points"});
      pairs.push_back({a.label + " - " + b.label, a.p_mm, b.p_mm, subject_mm});
    }
  }
  if (pairs.empty())
    throw InputError({subject_file.path, "", std::to_string(both.size()) + " labels of " + model_file.path,
                      "at least two points with the same labels in both files"});
  return pairs;
}

}  // namespace

RequestedScaling load_scaling(const Job& job, const std::string& data_directory, const AxisMap& map)
{
  RequestedScaling loaded;
  if (!job.scaling) return loaded;
  const std::string& name = job.scaling->landmarks_file;
  if (name.empty()) {
    loaded.scaling.emplace().factor = job.scaling->factor;
    return loaded;
  }
  const std::string key = "scaling.landmarks";
  const std::string model_key = "scaling.model_landmarks";
  const std::string& model_name = core::text_or_empty(job.document.root, model_key);
  if (model_name.empty() == is_slicer_points(name))
    job.document.refuse(model_key,
                        model_name.empty() ? "nothing" : quoted_text(model_name) + " with a CSV file",
                        "the points of the model, where landmarks are points of 3D Slicer");
  const InputFile file = input_file(job, data_directory, {key, name, "a CSV file or points of 3D Slicer"});
  if (model_name.empty()) {
    loaded.scaling = fit_scaling(read_landmarks(file.path, file.bytes), map.unit_mm);
  } else {
    const InputFile model = input_file(job, data_directory, {model_key, model_name, "points of 3D Slicer"});
    loaded.scaling = fit_scaling(pairs_of(model, file), 1.0);
    loaded.inputs.push_back({model_name, sha256_of(model.bytes)});
  }
  const double factor = loaded.scaling->factor.x();
  if (!(factor >= smallest_factor && factor <= largest_factor)) {
    throw InputError({file.path, "",
                      "distances that make the subject " + shortest_decimal(factor) + " times the model",
                      "a factor from 0.1 to 10: points are in the mesh files' unit (frame.unit = \"" +
                          job.frame.unit + "\"), distances in mm"});
  }
  loaded.inputs.push_back({name, sha256_of(file.bytes)});
  loaded.warnings = warnings_of_fit(*loaded.scaling);
  return loaded;
}

void apply_scaling(Case& loaded, const Job& job, const RequestedScaling& requested)
{
  loaded.steps_job_text = job.steps_text;
  loaded.scaling = requested.scaling;
  if (!requested.scaling) return;
  const Eigen::Vector3d& factor = requested.scaling->factor;
  check_uneven(loaded, job, factor);
  loaded.rerun_reason = reason_for_rerun(loaded, factor);
  const bool keeps_steps = loaded.rerun_reason.empty();
  loaded.scaling->keeps_steps = keeps_steps;
  if (keeps_steps) {
    loaded.steps_scale = factor.x();
    loaded.steps_job_text = job.unscaled_text;
  } else {
    scale_lengths(loaded, factor);
  }
  for (LoadedInput input : requested.inputs) {
    input.affects_steps = !keeps_steps;
    loaded.inputs.push_back(input);
  }
}

Case scaled_to_subject(const Case& solved)
{
  Case subject = solved;
  if (solved.steps_scale == 1.0) return subject;
  const double s = solved.steps_scale;
  scale_lengths(subject, Eigen::Vector3d::Constant(s));
  // The steps were solved with these settings at factor 1, so they scale as well.
  for (double* length_mm : {&subject.search.approach_step_mm, &subject.search.translation_step_mm,
                            &subject.search.translation_resolution_mm, &subject.equilibrium.tolerance_mm,
                            &subject.equilibrium.contact_resolution_mm}) {
    *length_mm *= s;
  }
  subject.steps_scale = 1.0;
  return subject;
}

// Removes copies of triangles.

namespace {

using Triangle = std::array<std::int32_t, 3>;

constexpr std::size_t no_copy = static_cast<std::size_t>(-1);

Triangle sorted(Triangle t)
{
  std::sort(t.begin(), t.end());
  return t;
}

// Whether the corners run through their sorted order forward.
bool is_forward(const Triangle& t)
{
  return (t[0] < t[1]) + (t[1] < t[2]) + (t[2] < t[0]) == 2;
}

// Whether two triangles may have the same vertices: nearly always exact, and much faster than a full sort.
bool may_have_copies(const std::vector<Triangle>& triangles)
{
  std::vector<std::uint64_t> keys;
  keys.reserve(triangles.size());
  for (const Triangle& triangle : triangles) {
    std::uint64_t key = 0;
    for (const std::int32_t v : sorted(triangle))
      key = (key ^ static_cast<std::uint64_t>(v)) * 0x9e3779b97f4a7c15U ^ key >> 29U;
    keys.push_back(key);
  }
  std::sort(keys.begin(), keys.end());
  return std::adjacent_find(keys.begin(), keys.end()) != keys.end();
}

// Triangles with the same vertices: the first one of each winding.
struct Copies {
  std::size_t first = no_copy, other = no_copy;

  bool is_open() const { return other != no_copy; }
  void choose_other() { first = other; }
  void close() { other = no_copy; }
};

std::vector<Copies> copies_of(const std::vector<Triangle>& triangles)
{
  std::vector<std::size_t> order(triangles.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    const Triangle l = sorted(triangles[a]), r = sorted(triangles[b]);
    return l != r ? l < r : a < b;
  });
  std::vector<Copies> groups;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const Triangle& t = triangles[order[k]];
    if (k == 0 || sorted(t) != sorted(triangles[order[k - 1]])) {
      groups.push_back({order[k], no_copy});
    } else if (!groups.back().is_open() && is_forward(t) != is_forward(triangles[groups.back().first])) {
      groups.back().other = order[k];
    }
  }
  std::sort(groups.begin(), groups.end(), [](const Copies& a, const Copies& b) { return a.first < b.first; });
  return groups;
}

bool runs_along(const Triangle& t, std::int32_t from, std::int32_t to)
{
  for (std::size_t k = 0; k < 3; ++k) {
    if (t[k] == from && t[(k + 1) % 3] == to) return true;
  }
  return false;
}

// Chooses the winding of open groups from neighbour to neighbour, over edges of two groups.
class Windings {
 public:
  Windings(const std::vector<Triangle>& triangles, std::vector<Copies>& groups)
      : triangles_(triangles), groups_(groups)
  {
    for (std::size_t g = 0; g < groups.size(); ++g) {
      const Triangle& t = triangles[groups[g].first];
      for (std::size_t k = 0; k < 3; ++k)
        edges_.push_back({std::min(t[k], t[(k + 1) % 3]), std::max(t[k], t[(k + 1) % 3]), g});
    }
    std::sort(edges_.begin(), edges_.end());
  }

  void choose()
  {
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if (!groups_[g].is_open()) known_.push_back(g);
    }
    spread();
    for (std::size_t g = 0; g < groups_.size(); ++g) {
      if (!groups_[g].is_open()) continue;
      groups_[g].close();
      known_.push_back(g);
      spread();
    }
  }

 private:
  struct Edge {
    std::int32_t low, high;
    std::size_t group;
    auto operator<=>(const Edge&) const = default;
  };

  void spread()
  {
    for (; next_ < known_.size(); ++next_) {
      const Triangle t = triangles_[groups_[known_[next_]].first];
      for (std::size_t k = 0; k < 3; ++k) reach(known_[next_], t[k], t[(k + 1) % 3]);
    }
  }

  void reach(std::size_t g, std::int32_t from, std::int32_t to)
  {
    const Edge edge{std::min(from, to), std::max(from, to), 0};
    const auto at = std::lower_bound(edges_.begin(), edges_.end(), edge);
    std::size_t n = 0, neighbour = no_copy;
    for (auto e = at; e != edges_.end() && e->low == edge.low && e->high == edge.high; ++e, ++n) {
      if (e->group != g) neighbour = e->group;
    }
    if (n != 2 || neighbour == no_copy || !groups_[neighbour].is_open()) return;
    if (!runs_along(triangles_[groups_[neighbour].first], to, from)) groups_[neighbour].choose_other();
    groups_[neighbour].close();
    known_.push_back(neighbour);
  }

  const std::vector<Triangle>& triangles_;
  std::vector<Copies>& groups_;
  std::vector<Edge> edges_;
  std::vector<std::size_t> known_;  // groups whose neighbours are reached, in order
  std::size_t next_ = 0;
};

}  // namespace

std::vector<Triangle> without_copies(const std::vector<Triangle>& triangles)
{
  if (!may_have_copies(triangles)) return triangles;
  std::vector<Copies> groups = copies_of(triangles);
  if (std::any_of(groups.begin(), groups.end(), [](const Copies& c) { return c.is_open(); }))
    Windings(triangles, groups).choose();
  std::vector<std::size_t> kept;
  for (const Copies& group : groups) kept.push_back(group.first);
  std::sort(kept.begin(), kept.end());
  std::vector<Triangle> out;
  for (const std::size_t t : kept) out.push_back(triangles[t]);
  return out;
}

}  // namespace vrda::job
