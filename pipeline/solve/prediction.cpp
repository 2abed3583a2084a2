#include "solve/prediction.hpp"

#include <algorithm>
#include <cmath>

namespace vrda {
namespace {

// A moment (mm, unit normal) or a projection below this is rounding: contact points are good to 1e-8 mm.
constexpr double negligible = 1e-7;

// +1 or -1 when all moments that are not negligible agree, 0 otherwise or when there is none. `skipped` is
// left out.
int common_sign(const std::vector<Contact>& contacts, const Eigen::Vector3d& centre, std::size_t skipped)
{
  int sign = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (k == skipped) continue;
    const double moment = moment_about_mm(contacts[k], centre);
    if (std::abs(moment) <= negligible) continue;
    const int own = moment > 0.0 ? 1 : -1;
    if (sign != 0 && own != sign) return 0;
    sign = own;
  }
  return sign;
}

// Whether a normal that leans across Delta passes through the centre: only one along Delta has no say there.
bool passes_through(const Contact& contact, const Eigen::Vector3d& centre)
{
  const bool leans = std::abs(contact.normal.x()) > negligible || std::abs(contact.normal.z()) > negligible;
  return leans && std::abs(moment_about_mm(contact, centre)) <= negligible;
}

// Mean of the positive values among the components; 0 when there is none.
class HalfAxis {
 public:
  void add(double component)
  {
    if (component <= 0.0) return;
    sum_ += component;
    ++n_;
  }
  double mean() const { return n_ > 0 ? sum_ / n_ : 0.0; }

 private:
  double sum_ = 0.0;
  int n_ = 0;
};

// The point of the segment from `a` to `b` nearest to the origin.
Eigen::Vector2d nearest_to_origin(const Eigen::Vector2d& a, const Eigen::Vector2d& b)
{
  const Eigen::Vector2d along = b - a;
  const double length_sq = along.squaredNorm();
  if (length_sq <= 0.0) return a;
  return a + std::clamp(-a.dot(along) / length_sq, 0.0, 1.0) * along;
}

}  // namespace

double moment_about_mm(const Contact& contact, const Eigen::Vector3d& centre)
{
  const Eigen::Vector3d arm = contact.application_mm - centre;
  return arm.z() * contact.normal.x() - arm.x() * contact.normal.z();
}

Eigen::Vector3d mean_point(const std::vector<Contact>& contacts)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const Contact& c : contacts) sum += c.application_mm;
  return contacts.empty() ? sum : Eigen::Vector3d(sum / static_cast<double>(contacts.size()));
}

RotationPrediction predict_rotation(const std::vector<Contact>& contacts)
{
  if (contacts.size() < 2) return {};
  const std::size_t nobody = contacts.size();
  const Eigen::Vector3d middle = mean_point(contacts);
  const int sign = common_sign(contacts, middle, nobody);
  if (sign != 0) return {sign, middle};
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  int n_centres = 0;
  for (std::size_t k = 0; k < contacts.size(); ++k) {
    if (common_sign(contacts, contacts[k].application_mm, k) == 0) continue;
    sum += contacts[k].application_mm;
    ++n_centres;
  }
  if (n_centres == 0) return {};
  const Eigen::Vector3d centre = sum / n_centres;
  // Opposite pushes along one line qualify both and meet in their mean: a third beside them slides the
  // object.
  if (std::any_of(contacts.begin(), contacts.end(),
                  [&](const Contact& c) { return passes_through(c, centre); }))
    return {};
  return {common_sign(contacts, centre, nobody), centre};
}

Eigen::Vector3d predict_translation(const std::vector<Contact>& contacts)
{
  HalfAxis plus_x, minus_x, plus_z, minus_z;
  for (const Contact& c : contacts) {
    const double length = std::sqrt(c.normal.x() * c.normal.x() + c.normal.z() * c.normal.z());
    if (length <= negligible) continue;
    const double x = c.normal.x() / length, z = c.normal.z() / length;
    plus_x.add(x);
    minus_x.add(-x);
    plus_z.add(z);
    minus_z.add(-z);
  }
  return {plus_x.mean() - minus_x.mean(), 0.0, plus_z.mean() - minus_z.mean()};
}

Climb predict_climb(const std::vector<Contact>& contacts)
{
  std::vector<Eigen::Vector2d> slopes;
  for (const Contact& c : contacts)
    slopes.emplace_back(c.normal.x() / -c.normal.y(), c.normal.z() / -c.normal.y());
  if (slopes.empty()) return {};
  // Outside the hull, the origin's nearest point of it lies on a segment between two of its points.
  Eigen::Vector2d nearest = slopes.front();
  for (std::size_t i = 0; i < slopes.size(); ++i) {
    for (std::size_t k = i; k < slopes.size(); ++k) {
      const Eigen::Vector2d p = nearest_to_origin(slopes[i], slopes[k]);
      if (p.squaredNorm() < nearest.squaredNorm()) nearest = p;
    }
  }
  const double rise = nearest.norm();
  if (rise <= negligible) return {};
  const bool all_give_way = std::all_of(slopes.begin(), slopes.end(), [&](const Eigen::Vector2d& slope) {
    return slope.dot(nearest) >= (1.0 - negligible) * rise * rise;
  });
  if (!all_give_way) return {};
  return {Eigen::Vector3d(nearest.x() / rise, 0.0, nearest.y() / rise), rise};
}

}  // namespace vrda
