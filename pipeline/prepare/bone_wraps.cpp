#include "prepare/bone_wraps.hpp"

#include <algorithm>

#include "geometry/wrap_over.hpp"
#include "model/frames.hpp"

namespace vrda::prepare {
namespace {

using geometry::BonesOfJoint, geometry::FibreCrossing;

constexpr double crossed_mm = 0.5;  // half of what is allowed: flexions between the solved ones

// A cylinder that clears every bump of a noisy surface is too large: 1 mm of noise made the MCL 1 mm longer.
std::vector<geometry::NearestSurface> bone_without_noise(const Body& body)
{
  std::vector<geometry::NearestSurface> surfaces;
  for (const geometry::NearestSurface& surface : geometry::bone_of(body))
    surfaces.emplace_back(geometry::without_noise(surface.mesh()));
  return surfaces;
}

std::vector<FibreCrossing> crossings_of(const BonesOfJoint& bones, const model::Ligaments& ligaments,
                                        const std::vector<Pose>& X_reference_moving)
{
  std::vector<FibreCrossing> crossings;
  for (const model::Fibre& fibre : ligaments.fibres)
    crossings.push_back(geometry::deepest_crossing(bones, fibre, ligaments.wraps, X_reference_moving));
  return crossings;
}

// Row of the wrap fitted to a fibre; a new row, if it has none.
int row_of(const model::Wrap& fitted, std::vector<model::Wrap>& wraps)
{
  const auto found = std::ranges::find(wraps, fitted.name, &model::Wrap::name);
  if (found == wraps.end()) {
    wraps.push_back(fitted);
    return static_cast<int>(wraps.size()) - 1;
  }
  *found = fitted;
  return static_cast<int>(found - wraps.begin());
}

std::string wrap_name(const model::Fibre& fibre)
{
  return fibre.name + "_over_bone";
}

// The wrap over either bone that leaves the least depth; false if none leaves less than `left_mm`.
bool wrap_fibre(const BonesOfJoint& bones, const std::vector<Pose>& X_reference_moving, double left_mm,
                model::Fibre& fibre, std::vector<model::Wrap>& wraps)
{
  std::optional<model::Wrap> best;
  for (const BodyIndex body : all_bodies) {
    std::optional<model::Wrap> wrap = geometry::wrap_over(bones, body, fibre, X_reference_moving);
    if (!wrap) continue;
    wrap->name = wrap_name(fibre);
    model::Fibre over = fibre;
    over.wrap = 0;
    const double depth_mm = geometry::deepest_crossing(bones, over, {*wrap}, X_reference_moving).depth_mm;
    if (depth_mm >= left_mm) continue;
    left_mm = depth_mm;
    best = wrap;
  }
  if (best) fibre.wrap = row_of(*best, wraps);
  return best.has_value();
}

std::vector<BundleCrossing> by_bundle(const job::Case& joint, const std::vector<FibreCrossing>& straight,
                                      const std::vector<FibreCrossing>& left,
                                      const std::vector<double>& flexion_rad)
{
  std::vector<BundleCrossing> bundles;
  const model::Ligaments& ligaments = joint.ligaments;
  for (std::size_t i = 0; i < ligaments.fibres.size(); ++i) {
    const model::Fibre& fibre = ligaments.fibres[i];
    auto found = std::ranges::find(bundles, fibre.bundle, &BundleCrossing::bundle);
    if (found == bundles.end()) {
      found = bundles.emplace(bundles.end());
      found->bundle = fibre.bundle;
    }
    ++found->n_fibres;
    if (fibre.wrap >= 0 && ligaments.wraps[static_cast<std::size_t>(fibre.wrap)].name == wrap_name(fibre))
      ++found->n_wrapped;
    found->left_mm = std::max(found->left_mm, left[i].depth_mm);
    if (straight[i].depth_mm <= found->straight_mm) continue;
    found->straight_mm = straight[i].depth_mm;
    found->bone = (straight[i].body == BodyIndex::moving ? joint.moving : joint.reference).name;
    found->flexion_rad = flexion_rad[straight[i].pose];
  }
  std::erase_if(bundles, [](const BundleCrossing& bundle) {
    return bundle.n_wrapped == 0 && bundle.straight_mm <= crossed_mm && bundle.left_mm <= crossed_mm;
  });
  return bundles;
}

}  // namespace

std::vector<BundleCrossing> wrap_over_bones(job::Case& subject, SlackLengths& lengths, SlackResult& slack)
{
  constexpr int most_rounds = 3;
  const BonesOfJoint bones{bone_without_noise(subject.reference), bone_without_noise(subject.moving)};
  const std::vector<double> first_rad = slack.loads.flexion_rad;
  std::vector<Pose> all = slack.loads.X_reference_moving;
  const std::vector<FibreCrossing> straight = crossings_of(bones, subject.ligaments, all);
  std::vector<FibreCrossing> left = straight;
  for (int round = 0; round < most_rounds; ++round) {
    bool has_changed = false;
    for (std::size_t i = 0; i < left.size(); ++i) {
      if (left[i].depth_mm <= crossed_mm) continue;
      has_changed |=
          wrap_fibre(bones, all, left[i].depth_mm, subject.ligaments.fibres[i], subject.ligaments.wraps);
    }
    if (!has_changed || lengths.is_stopped()) break;
    slack = lengths.set();
    const std::vector<Pose>& now = slack.loads.X_reference_moving;
    left = crossings_of(bones, subject.ligaments, now);
    all.insert(all.end(), now.begin(), now.end());
  }
  return by_bundle(subject, straight, left, first_rad);
}

}  // namespace vrda::prepare
