#include "shares.hpp"

#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>

#include <atomic>
#include <chrono>

#include "contact/contacts.hpp"
#include "geometry/gap_query.hpp"

namespace vrda::benchmarks {
namespace {

using Seconds = std::atomic<double>;

Seconds gap, turn, collision, contacts, bullet;

class Clock {
 public:
  explicit Clock(Seconds& total) : total_(total), start_(std::chrono::steady_clock::now()) {}
  ~Clock() { total_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;

 private:
  Seconds& total_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace

void reset_shares()
{
  for (Seconds* total : {&gap, &turn, &collision, &contacts, &bullet}) *total = 0.0;
}
Shares shares()
{
  return {gap, turn, collision, contacts, bullet};
}

// The symbols of CMakeLists.txt. VRDA_REDIRECT declares the function and its replacement: RESULT, name,
// symbol, parameters, of a member function the object first.
#define VRDA_REDIRECT(RESULT, NAME, SYMBOL, ...)             \
  RESULT real_##NAME(__VA_ARGS__) __asm__("__real_" SYMBOL); \
  RESULT timed_##NAME(__VA_ARGS__) __asm__("__wrap_" SYMBOL);

VRDA_REDIRECT(geometry::Gap, next_contact,
              "_ZN4vrda8geometry8GapQuery12next_contactERKNS_5model10MovingPoseE", geometry::GapQuery*,
              const MovingPose&)
geometry::Gap timed_next_contact(geometry::GapQuery* query, const MovingPose& pose)
{
  const Clock clock(gap);
  return real_next_contact(query, pose);
}

VRDA_REDIRECT(double, travel, "_ZN4vrda8geometry8GapQuery9travel_mmERKNS_5model10MovingPoseE",
              geometry::GapQuery*, const MovingPose&)
double timed_travel(geometry::GapQuery* query, const MovingPose& pose)
{
  const Clock clock(gap);
  return real_travel(query, pose);
}

VRDA_REDIRECT(const geometry::GapResult&, features,
              "_ZN4vrda8geometry8GapQuery8featuresERKNS_5model10MovingPoseEd", geometry::GapQuery*,
              const MovingPose&, double)
const geometry::GapResult& timed_features(geometry::GapQuery* query, const MovingPose& pose, double band_mm)
{
  const Clock clock(gap);
  return real_features(query, pose, band_mm);
}

VRDA_REDIRECT(const std::vector<geometry::TrianglePair>&, close_pairs,
              "_ZN4vrda8geometry8GapQuery11close_pairsERKNS_5model10MovingPoseEd", geometry::GapQuery*,
              const MovingPose&, double)
const std::vector<geometry::TrianglePair>& timed_close_pairs(geometry::GapQuery* query,
                                                             const MovingPose& pose, double band_mm)
{
  const Clock clock(gap);
  return real_close_pairs(query, pose, band_mm);
}

VRDA_REDIRECT(geometry::TreeMesh, turned,
              "_ZN4vrda8geometry17rotated_referenceERKNS0_8TreeMeshERKNS_5model8AttitudeE",
              const geometry::TreeMesh&, const Attitude&)
geometry::TreeMesh timed_turned(const geometry::TreeMesh& reference, const Attitude& attitude)
{
  const Clock clock(turn);
  return real_turned(reference, attitude);
}

using Hit = std::optional<geometry::TrianglePair>;
VRDA_REDIRECT(
    Hit, collision,
    "_ZN4vrda7contact14find_collisionERKNS_5model4MeshES4_RKNS1_10MovingPoseERNS_8geometry8GapQueryE"
    "RNS0_11NarrowPhaseERKNS8_12TrianglePairE",
    const Mesh&, const Mesh&, const MovingPose&, geometry::GapQuery&, contact::NarrowPhase&,
    const geometry::TrianglePair&)
Hit timed_collision(const Mesh& reference, const Mesh& moving, const MovingPose& pose,
                    geometry::GapQuery& pairs, contact::NarrowPhase& narrow_phase,
                    const geometry::TrianglePair& hint)
{
  const Clock clock(collision);
  return real_collision(reference, moving, pose, pairs, narrow_phase, hint);
}

// Of the search.
VRDA_REDIRECT(
    std::vector<contact::Contact>, contacts_of_turned,
    "_ZN4vrda7contact13find_contactsERKNS0_14ContactObjectsERKNS_5model10MovingPoseERNS0_11NarrowPhaseE"
    "RKNS0_14ContactOptionsE",
    const contact::ContactObjects&, const MovingPose&, contact::NarrowPhase&, const contact::ContactOptions&)
std::vector<contact::Contact> timed_contacts_of_turned(const contact::ContactObjects& objects,
                                                       const MovingPose& pose,
                                                       contact::NarrowPhase& narrow_phase,
                                                       const contact::ContactOptions& options)
{
  const Clock clock(contacts);
  return real_contacts_of_turned(objects, pose, narrow_phase, options);
}

// Of the equilibrium.
VRDA_REDIRECT(
    std::vector<contact::Contact>, contacts,
    "_ZN4vrda7contact13find_contactsERKNS0_14ContactObjectsERKNS_5model8AttitudeERKNS4_10MovingPoseE"
    "RNS0_11NarrowPhaseERKNS0_14ContactOptionsE",
    const contact::ContactObjects&, const Attitude&, const MovingPose&, contact::NarrowPhase&,
    const contact::ContactOptions&)
std::vector<contact::Contact> timed_contacts(const contact::ContactObjects& objects, const Attitude& attitude,
                                             const MovingPose& pose, contact::NarrowPhase& narrow_phase,
                                             const contact::ContactOptions& options)
{
  const Clock clock(contacts);
  return real_contacts(objects, attitude, pose, narrow_phase, options);
}

using Detector = btDiscreteCollisionDetectorInterface;
VRDA_REDIRECT(void, detector,
              "_ZN17btGjkPairDetector16getClosestPointsERKN36btDiscreteCollisionDetectorInterface"
              "17ClosestPointInputERNS0_6ResultEP12btIDebugDrawb",
              btGjkPairDetector*, const Detector::ClosestPointInput&, Detector::Result&, btIDebugDraw*, bool)
void timed_detector(btGjkPairDetector* detector, const Detector::ClosestPointInput& input,
                    Detector::Result& result, btIDebugDraw* drawer, bool is_swapped)
{
  const Clock clock(bullet);
  real_detector(detector, input, result, drawer, is_swapped);
}

}  // namespace vrda::benchmarks
