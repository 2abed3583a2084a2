// Directions in which the stability search rotates and translates next, from the contacts (thesis 3.4 and
// 3.5).
#include "solve/stability_search.hpp"

#include <algorithm>
#include <cmath>

namespace vrda::solve {
namespace {

// A moment (mm, unit normal) or a projection below this is rounding: contact points are accurate to 1e-8 mm.
constexpr double negligible = 1e-7;

// Limit of iterations over the contacts; ten are rarely needed.
constexpr std::size_t max_prediction_steps = 100;

// +1 or -1 when all moments that are not negligible agree in sign, 0 otherwise. Contact `skipped` is ignored.
int common_sign(const std::vector<contact::Contact>& contacts, const Eigen::Vector3d& centre,
                std::size_t skipped)
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

// Whether a normal that is not parallel to Delta has no moment about the centre.
bool passes_through(const contact::Contact& contact, const Eigen::Vector3d& centre)
{
  const bool is_oblique =
      std::abs(contact.normal.x()) > negligible || std::abs(contact.normal.z()) > negligible;
  return is_oblique && std::abs(moment_about_mm(contact, centre)) <= negligible;
}

// Mean of the positive components; 0 without any.
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

using Vectors = std::vector<Eigen::Vector3d>;

// The point nearest to the origin on the line or plane through two or three corners, if it is between them.
std::optional<Eigen::Vector3d> nearest_on_span(const Vectors& c)
{
  if (c.size() == 1) return c[0];
  const Eigen::Vector3d u = c[1] - c[0];
  if (c.size() == 2) {
    const double t = -c[0].dot(u) / u.squaredNorm();
    if (t > 0.0 && t < 1.0) return c[0] + t * u;
    return std::nullopt;
  }
  const Eigen::Vector3d v = c[2] - c[0];
  const double uu = u.dot(u), uv = u.dot(v), vv = v.dot(v), cu = -c[0].dot(u), cv = -c[0].dot(v);
  const double area_sq = uu * vv - uv * uv;
  const double s = (cu * vv - cv * uv) / area_sq, t = (cv * uu - cu * uv) / area_sq;
  if (s > 0.0 && t > 0.0 && s + t < 1.0) return c[0] + s * u + t * v;
  return std::nullopt;
}

struct Nearest {
  Eigen::Vector3d point;
  Vectors corners;  // the fewest that span it
};

// Over the corners, edges and faces of a simplex of at most four corners.
Nearest nearest_of_simplex(const Vectors& simplex)
{
  std::optional<Nearest> best;
  for (unsigned chosen = 1; chosen < 1U << simplex.size(); ++chosen) {
    Vectors corners;
    for (std::size_t k = 0; k < simplex.size(); ++k) {
      if ((chosen >> k & 1U) != 0) corners.push_back(simplex[k]);
    }
    if (corners.size() > 3) continue;
    const std::optional<Eigen::Vector3d> point = nearest_on_span(corners);
    if (point && (!best || point->squaredNorm() < best->point.squaredNorm())) best = {*point, corners};
  }
  return *best;
}

// Gilbert, Johnson and Keerthi (1988): adds the support point towards the origin to the simplex until none is
// nearer. Zero when the hull contains the origin: then no plane has all points on its far side.
Eigen::Vector3d nearest_of_hull(const Vectors& points)
{
  Nearest nearest{points.front(), {points.front()}};
  for (std::size_t k = 0; k < max_prediction_steps; ++k) {
    const Eigen::Vector3d& p = nearest.point;
    const double distance_sq = p.squaredNorm();
    if (distance_sq <= negligible * negligible) return Eigen::Vector3d::Zero();
    const Eigen::Vector3d& support = *std::min_element(
        points.begin(), points.end(), [&](const auto& l, const auto& r) { return l.dot(p) < r.dot(p); });
    if (support.dot(p) >= (1.0 - negligible) * distance_sq) return p;
    Vectors simplex = nearest.corners;
    simplex.push_back(support);
    const Nearest next = nearest_of_simplex(simplex);
    // No progress: the simplex contains the origin, or what is left to gain is rounding.
    if (next.point.squaredNorm() >= distance_sq) {
      if (support.dot(p) > 0.0) return p;
      break;
    }
    nearest = next;
  }
  return Eigen::Vector3d::Zero();
}

}  // namespace

double moment_about_mm(const contact::Contact& contact, const Eigen::Vector3d& centre)
{
  const Eigen::Vector3d arm = contact.application_mm - centre;
  return arm.z() * contact.normal.x() - arm.x() * contact.normal.z();
}

Eigen::Vector3d mean_point(const std::vector<contact::Contact>& contacts)
{
  Eigen::Vector3d sum = Eigen::Vector3d::Zero();
  for (const contact::Contact& c : contacts) sum += c.application_mm;
  return contacts.empty() ? sum : Eigen::Vector3d(sum / static_cast<double>(contacts.size()));
}

RotationPrediction predict_rotation(const std::vector<contact::Contact>& contacts)
{
  if (contacts.size() < 2) return {};
  const std::size_t none_skipped = contacts.size();
  const Eigen::Vector3d middle = mean_point(contacts);
  const int sign = common_sign(contacts, middle, none_skipped);
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
  // Two opposite forces on one line both qualify and their mean is on that line; a third contact beside it
  // translates the object instead.
  if (std::any_of(contacts.begin(), contacts.end(),
                  [&](const contact::Contact& c) { return passes_through(c, centre); }))
    return {};
  return {common_sign(contacts, centre, none_skipped), centre};
}

RotationPrediction predict_rotation_about(const std::vector<contact::Contact>& contacts,
                                          const Eigen::Vector3d& centre_mm)
{
  return {contacts.empty() ? 0 : common_sign(contacts, centre_mm, contacts.size()), centre_mm};
}

Eigen::Vector3d predict_translation(const std::vector<contact::Contact>& contacts)
{
  HalfAxis plus_x, minus_x, plus_z, minus_z;
  for (const contact::Contact& c : contacts) {
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

Ascent predict_ascent(const std::vector<contact::Contact>& contacts, std::optional<double> lever_mm,
                      const HeldMotions& held, const Eigen::Vector3d& origin_mm)
{
  if (contacts.empty()) return {};
  const bool turns = lever_mm.has_value() && !held.theta;
  Ascent climb;
  climb.centre_mm = held.any_translation() ? origin_mm : mean_point(contacts);
  std::vector<Eigen::Vector3d> slopes;
  for (const contact::Contact& c : contacts) {
    const double moment = turns ? moment_about_mm(c, climb.centre_mm) / *lever_mm : 0.0;
    const double x = held.x ? 0.0 : c.normal.x(), z = held.z ? 0.0 : c.normal.z();
    slopes.push_back(Eigen::Vector3d(x, moment, z) / -c.normal.y());
  }
  const Eigen::Vector3d nearest = nearest_of_hull(slopes);
  climb.rise = nearest.norm();
  if (climb.rise <= negligible) return {};
  climb.direction = Eigen::Vector3d(nearest.x(), 0.0, nearest.z()) / climb.rise;
  if (turns) climb.turn_rad_per_mm = nearest.y() / climb.rise / *lever_mm;
  return climb;
}

}  // namespace vrda::solve
