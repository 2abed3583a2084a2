#include "show/comparison.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <filesystem>
#include <set>
#include <utility>

#include "core/text.hpp"
#include "model/coordinates.hpp"
#include "view/keys.hpp"

namespace vrda::show {
namespace {

constexpr std::size_t n_samples = 61;
constexpr float overlaid_opacity = 0.4F;  // as on the page
constexpr std::array band_ends{"quantile_5", "quantile_95"};
constexpr std::array<std::size_t, 2> band_rows{1, 3};  // of store::band_probabilities: 5 and 95 %

using Numbers = std::array<double, 6>;  // store::uncertain_quantities: degrees, mm

std::optional<Numbers> numbers_of(const store::MotionModel& model, const store::JointPose& pose)
{
  if (pose.status != store::PoseStatus::solved) return std::nullopt;
  const ClinicalCoordinates joint =
      clinical_coordinates(pose.X_reference_moving, side_named(model.side), model.rotation_centre_mm);
  return Numbers{deg_from_rad(joint.flexion_rad),
                 deg_from_rad(joint.varus_rad),
                 deg_from_rad(joint.internal_rotation_rad),
                 joint.anterior_mm,
                 joint.proximal_mm,
                 joint.lateral_mm};
}

// Zero-terminated in `text`.
void write_caption(std::span<char> text, const char* which, const std::string& name, const JointKind& kind,
                   const std::optional<Numbers>& numbers)
{
  if (numbers) {
    const auto [flexion, varus, internal, anterior, proximal, lateral] = *numbers;
    std::snprintf(text.data(), text.size(), "%s: %s: flexion %.1f°, varus %.1f°, %s %.1f°, %s %.1f mm", which,
                  name.c_str(), flexion, varus, kind.words[2].of(internal), std::abs(internal),
                  kind.words[3].of(anterior), std::abs(anterior));
  } else {
    std::snprintf(text.data(), text.size(), "%s: %s: no pose here", which, name.c_str());
  }
}

/// Quantity `k` of Numbers at an end of the band of an uncertain job; NaN without one.
double band_at(const store::MotionModel& model, std::size_t end, double flexion_deg, std::size_t k)
{
  const std::vector<double>& axis = model.flexion_deg;
  if (!model.uncertainty || axis.empty()) return nan;
  const std::vector<double>& band =
      k < 3 ? model.uncertainty->rotation_band_deg : model.uncertainty->translation_band_mm;
  const auto value = [&](std::size_t i) { return band.at(3 * (band_rows[end] * axis.size() + i) + k % 3); };
  const auto above = static_cast<std::size_t>(std::ranges::lower_bound(axis, flexion_deg) - axis.begin());
  if (above == 0 || above == axis.size()) return value(std::min(above, axis.size() - 1));
  const double part = (flexion_deg - axis[above - 1]) / (axis[above] - axis[above - 1]);
  return std::lerp(value(above - 1), value(above), part);
}

/// Percent; NaN for a bundle of constant tension and without a pose.
double strain_at(const view::BundleReader& bundles, const std::string& id, const store::JointPose& pose)
{
  const auto reading = bundles.at(id, pose);
  return reading && !reading->is_line ? 100.0 * reading->strain : nan;
}

/// The last part of an id.
std::string short_name(const std::string& id)
{
  return id.substr(id.rfind('/') + 1);
}

std::string chosen_set(const store::MotionModel& model, const ComparisonOptions& options)
{
  if (options.set.empty()) return store::default_motion(model).set;
  const std::vector<std::string> names = store::all_set_names(model);
  if (std::ranges::find(names, options.set) == names.end())
    view::refuse_option("--other-set", options.set, join_alternatives(names));
  return options.set;
}

view::AppearanceOptions without_structures(view::AppearanceOptions look)
{
  look.see_through.clear();  // names of the first model
  look.hidden.clear();
  return look;
}

}  // namespace

view::Viewport column(const view::Viewport& area, std::size_t row, std::size_t n)
{
  const auto edge = [&](std::size_t i) {
    return static_cast<int>(static_cast<std::size_t>(area.width) * i / n);
  };
  return {area.x + edge(row), area.y, edge(row + 1) - edge(row), area.height};
}

Comparison::Comparison(const store::MotionModel& first, const ComparisonOptions& options,
                       const view::AppearanceOptions& look, view::Backdrop backdrop)
    : first_(first),
      options_(options),
      motion_(model(), chosen_set(model(), options)),
      joint_(model(), without_structures(look), backdrop),
      first_bundles_(first)
{
  const std::string file = options.file.empty() ? "this model" : options.file;
  store::require_grid(first, "the first model", "a comparison");
  store::require_grid(model(), file, "a comparison");
  if (options.varus_deg && motion_.is_varus_free())
    view::refuse_option("--other-varus", chosen_set(model(), options) + ", whose varus is its own",
                        "with --other-set a set over varus: raw or degree_N");
  std::set<std::string> bundles;
  for (std::size_t k = 0; k < joint_.structures().size(); ++k) {
    const view::Structure& structure = joint_.structures()[k];
    if (structure.group != view::StructureGroup::ligaments) continue;
    const std::string bundle = short_name(structure.id);
    bundles.insert(bundle);
    if (bundle == options.without || structure.id == options.without) lacking_.push_back(k);
  }
  if (!options.without.empty() && lacking_.empty()) {
    view::refuse_option("--without", options.without,
                        bundles.empty() ? "a model with ligaments"
                                        : "a bundle: " + join_alternatives({bundles.begin(), bundles.end()}));
  }
  name_ = options.file.empty() ? view::set_label(chosen_set(model(), options))
                               : std::filesystem::path(options.file).stem().string();
  if (options.varus_deg)
    name_ += ", varus " + std::string(*options.varus_deg < 0.0 ? "" : "+") +
             shortest_decimal(*options.varus_deg) + "°";
  if (!options.without.empty()) name_ += ", " + options.without + " not drawn";
}

store::JointPose Comparison::pose_at(double flexion_rad, std::optional<double> varus_rad) const
{
  return motion_.at({flexion_rad, varus_rad.value_or(motion_.balanced_varus_rad(flexion_rad)) +
                                      rad_from_deg(options_.varus_deg.value_or(0.0))});
}

void Comparison::show(JointView& first, const store::JointPose& pose, std::optional<double> varus_rad,
                      const view::LayerSet& layers)
{
  view::Looks& looks = joint_.looks();
  looks.highlighted.reset();
  for (std::size_t k = 0; k < looks.of.size(); ++k) {
    const std::optional<std::size_t> row = first.structure_row(joint_.structures()[k].id);
    looks.of[k] = row ? first.looks().of[*row] : view::StructureLook{};
    if (row && row == first.looks().highlighted) looks.highlighted = k;
    if (options_.is_over) looks.of[k].opacity *= overlaid_opacity;
  }
  for (const std::size_t k : lacking_) looks.of[k].is_visible = false;
  joint_.fixed_object = first.fixed_object;
  joint_.scene().section = first.scene().section;
  first.scene().other = &joint_.scene();
  const store::JointPose own = pose_at(pose.attitude.flexion_rad, varus_rad);
  joint_.show(motion_, own, layers);
  write_caption(captions_[0], options_.is_over ? "First (opaque)" : "First (left)", first_.title,
                joint_kind(first_.joint), numbers_of(first_, pose));
  write_caption(captions_[1], options_.is_over ? "Second (translucent)" : "Second (right)", name_,
                joint_kind(model().joint), numbers_of(model(), own));
}

void Comparison::sample(const store::Motion& first, std::optional<double> varus_rad)
{
  sampled_ = &first;
  sampled_varus_rad_ = varus_rad;
  differences_.first_flexion_rad = std::max(first.first_flexion_rad(), motion_.first_flexion_rad());
  differences_.last_flexion_rad = std::min(first.last_flexion_rad(), motion_.last_flexion_rad());
  const auto lines = [](std::initializer_list<const char*> names) {
    std::vector<view::CurveLine> all;
    for (const char* name : names) all.emplace_back().name = name;
    return all;
  };
  differences_.plots = {{"rotation, °", lines({"varus", "internal"})},
                        {"translation, mm", lines({"anterior", "proximal", "lateral"})},
                        {"largest strain, %", {}}};
  std::vector<std::string> bundles;
  for (const view::Structure& structure : joint_.structures()) {
    const bool is_lacking = std::ranges::any_of(
        lacking_, [&](std::size_t k) { return joint_.structures()[k].id == structure.id; });
    if (structure.group != view::StructureGroup::ligaments || is_lacking) continue;
    bundles.push_back(structure.id);
    differences_.plots[2].lines.emplace_back().name = short_name(structure.id);
  }
  const std::vector<std::string> names = store::all_set_names(first_);
  std::vector<store::Motion> ends;
  for (const char* end : band_ends)
    if (std::ranges::find(names, end) != names.end()) ends.emplace_back(first_, end);
  const double span_rad = differences_.last_flexion_rad - differences_.first_flexion_rad;
  for (std::size_t i = 0; i < n_samples && span_rad >= 0.0; ++i) {
    const double flexion_rad =
        differences_.first_flexion_rad + span_rad * static_cast<double>(i) / (n_samples - 1);
    const store::JointPose own = pose_at(flexion_rad, varus_rad);
    const store::JointPose pose =
        first.at({flexion_rad, varus_rad.value_or(first.balanced_varus_rad(flexion_rad))});
    const std::array<std::optional<Numbers>, 2> numbers{numbers_of(first_, pose), numbers_of(model(), own)};
    for (std::size_t k = 1; k < 6; ++k) {
      view::CurveLine& line = k < 3 ? differences_.plots[0].lines[k - 1] : differences_.plots[1].lines[k - 3];
      const bool has_both = numbers[0] && numbers[1];
      line.values.push_back(static_cast<float>(has_both ? (*numbers[1])[k] - (*numbers[0])[k] : nan));
      // Of two uncertain models the root of the sum of squares, about no difference.
      std::array<double, 2> off{};
      for (std::size_t end = 0; end < 2; ++end) {
        for (std::size_t m = 0; m < 2 && has_both; ++m) {
          const double at = band_at(m == 0 ? first_ : model(), end, deg_from_rad(flexion_rad), k);
          if (std::isfinite(at)) off[end] = std::hypot(off[end], at - (*numbers[m])[k]);
        }
      }
      if (!first_.uncertainty && !model().uncertainty) continue;
      line.low.push_back(static_cast<float>(-off[0]));
      line.high.push_back(static_cast<float>(off[1]));
    }
    for (std::size_t k = 0; k < bundles.size(); ++k) {
      view::CurveLine& line = differences_.plots[2].lines[k];
      const double at = strain_at(first_bundles_, bundles[k], pose);
      line.values.push_back(static_cast<float>(strain_at(joint_.bundles(), bundles[k], own) - at));
      if (ends.size() < 2) continue;
      double low = 0.0, high = 0.0;
      for (const store::Motion& end : ends) {
        const double off = strain_at(first_bundles_, bundles[k], end.at(pose.attitude)) - at;
        low = std::fmin(low, off);
        high = std::fmax(high, off);
      }
      line.low.push_back(static_cast<float>(low));
      line.high.push_back(static_cast<float>(high));
    }
  }
  std::erase_if(differences_.plots[2].lines, [](const view::CurveLine& line) {
    return std::ranges::none_of(line.values, [](float value) { return std::isfinite(value); });
  });
}

const view::Differences& Comparison::differences(const store::Motion& first, std::optional<double> varus_rad)
{
  if (sampled_ != &first || sampled_varus_rad_ != varus_rad) sample(first, varus_rad);
  for (std::size_t k = 0; k < captions_.size(); ++k) differences_.captions[k] = captions_[k].data();
  return differences_;
}

void Comparison::add_shots(std::vector<view::Shot>& shots, const view::Camera& camera,
                           const view::Viewport& area) const
{
  if (options_.is_over) return shots.push_back({camera, area});
  for (const bool is_own : {true, false})
    shots.push_back({camera, column(area, is_own ? 0 : 1, 2), is_own, !is_own});
}

std::span<const view::ScreenLabel> Comparison::labels(JointView& first, std::span<const view::Shot> shots)
{
  std::size_t n = 0;
  for (const view::Shot& shot : shots) {
    for (const view::ScreenLabel& label : (shot.has_own ? first : joint_).labels({&shot, 1})) {
      if (n == labels_.size()) labels_.emplace_back();
      labels_[n++] = label;
    }
  }
  return std::span(labels_).first(n);
}

std::vector<Eigen::Vector3d> Comparison::framed_points(const store::JointPose& pose,
                                                       std::optional<double> varus_rad, BodyIndex fixed,
                                                       view::Framing framing)
{
  joint_.fixed_object = fixed;
  const store::JointPose own = pose_at(pose.attitude.flexion_rad, varus_rad);
  if (own.status != store::PoseStatus::solved) return {};
  return joint_.framed_points(own, framing);
}

}  // namespace vrda::show
