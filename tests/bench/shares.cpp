#include "shares.hpp"

#include <chrono>

#include "contact/contacts.hpp"
#include "proximity/gap_query.hpp"

namespace vrda::benchmarks {
namespace {

thread_local Shares spent;

class Clock {
 public:
  explicit Clock(double& total) : total_(total), start_(std::chrono::steady_clock::now()) {}
  ~Clock() { total_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }
  Clock(const Clock&) = delete;
  Clock& operator=(const Clock&) = delete;

 private:
  double& total_;
  std::chrono::steady_clock::time_point start_;
};

}  // namespace

void reset_shares()
{
  spent = {};
}
Shares shares()
{
  return spent;
}

#define VRDA_GAP                                                                              \
  "_ZN4vrda9proximity15directional_gapERKNS0_8TreeMeshERKNS_4core4MeshERKNS0_7BoxTreeERKNS4_" \
  "10MovingPoseERKNS0_10GapOptionsE"
#define VRDA_TOUCH "_ZN4vrda9proximity8GapQuery12next_contactERKNS_4core10MovingPoseE"
#define VRDA_COLLISION                                                                        \
  "_ZN4vrda7contact14find_collisionERKNS_9proximity8TreeMeshES4_RKNS_4core10MovingPoseERNS0_" \
  "11NarrowPhaseERKNS1_12TrianglePairE"
#define VRDA_CONTACTS                                                                                       \
  "_ZN4vrda7contact13find_contactsERKNS0_14ContactObjectsERKNS_4core10MovingPoseERNS0_11NarrowPhaseERKNS0_" \
  "14ContactOptionsE"
#define VRDA_TURNED "_ZN4vrda9proximity17rotated_referenceERKNS0_8TreeMeshERKNS_4core8AttitudeE"

proximity::Gap real_gap(const proximity::TreeMesh&, const Mesh&, const proximity::BoxTree&, const MovingPose&,
                        const proximity::GapOptions&) __asm__("__real_" VRDA_GAP);
proximity::Gap timed_gap(const proximity::TreeMesh&, const Mesh&, const proximity::BoxTree&,
                         const MovingPose&, const proximity::GapOptions&) __asm__("__wrap_" VRDA_GAP);
proximity::Gap real_touch(proximity::GapQuery*, const MovingPose&) __asm__("__real_" VRDA_TOUCH);
proximity::Gap timed_touch(proximity::GapQuery*, const MovingPose&) __asm__("__wrap_" VRDA_TOUCH);
std::optional<proximity::TrianglePair> real_collision(
    const proximity::TreeMesh&, const proximity::TreeMesh&, const MovingPose&, contact::NarrowPhase&,
    const proximity::TrianglePair&) __asm__("__real_" VRDA_COLLISION);
std::optional<proximity::TrianglePair> timed_collision(
    const proximity::TreeMesh&, const proximity::TreeMesh&, const MovingPose&, contact::NarrowPhase&,
    const proximity::TrianglePair&) __asm__("__wrap_" VRDA_COLLISION);
std::vector<contact::Contact> real_contacts(const contact::ContactObjects&, const MovingPose&,
                                            contact::NarrowPhase&,
                                            const contact::ContactOptions&) __asm__("__real_" VRDA_CONTACTS);
std::vector<contact::Contact> timed_contacts(const contact::ContactObjects&, const MovingPose&,
                                             contact::NarrowPhase&,
                                             const contact::ContactOptions&) __asm__("__wrap_" VRDA_CONTACTS);
proximity::TreeMesh real_turned(const proximity::TreeMesh&, const Attitude&) __asm__("__real_" VRDA_TURNED);
proximity::TreeMesh timed_turned(const proximity::TreeMesh&, const Attitude&) __asm__("__wrap_" VRDA_TURNED);

proximity::Gap timed_gap(const proximity::TreeMesh& reference, const Mesh& mesh,
                         const proximity::BoxTree& moving, const MovingPose& pose,
                         const proximity::GapOptions& options)
{
  const Clock clock(spent.gap_s);
  return real_gap(reference, mesh, moving, pose, options);
}

proximity::Gap timed_touch(proximity::GapQuery* query, const MovingPose& pose)
{
  const Clock clock(spent.gap_s);
  return real_touch(query, pose);
}

std::optional<proximity::TrianglePair> timed_collision(const proximity::TreeMesh& reference,
                                                       const proximity::TreeMesh& moving,
                                                       const MovingPose& pose,
                                                       contact::NarrowPhase& narrow_phase,
                                                       const proximity::TrianglePair& hint)
{
  const Clock clock(spent.collision_s);
  return real_collision(reference, moving, pose, narrow_phase, hint);
}

std::vector<contact::Contact> timed_contacts(const contact::ContactObjects& objects, const MovingPose& pose,
                                             contact::NarrowPhase& narrow_phase,
                                             const contact::ContactOptions& options)
{
  const Clock clock(spent.contacts_s);
  return real_contacts(objects, pose, narrow_phase, options);
}

proximity::TreeMesh timed_turned(const proximity::TreeMesh& reference, const Attitude& attitude)
{
  const Clock clock(spent.turn_s);
  return real_turned(reference, attitude);
}

}  // namespace vrda::benchmarks
