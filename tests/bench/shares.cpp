#include "shares.hpp"

#include <chrono>

#include "contact/contacts.hpp"
#include "proximity/gap_query.hpp"

namespace vrda::bench {
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

#define VRDA_GAP \
  "_ZN4vrda15directional_gapERKNS_8TreeMeshERKNS_4MeshERKNS_7BoxTreeERKNS_10MovingPoseERKNS_10GapOptionsE"
#define VRDA_TOUCH "_ZN4vrda8GapQuery5touchERKNS_10MovingPoseE"
#define VRDA_COLLISION \
  "_ZN4vrda14find_collisionERKNS_8TreeMeshES2_RKNS_10MovingPoseERNS_11NarrowPhaseERKNS_12TrianglePairE"
#define VRDA_CONTACTS \
  "_ZN4vrda13find_contactsERKNS_8TouchingERKNS_10MovingPoseERNS_11NarrowPhaseERKNS_14ContactOptionsE"
#define VRDA_TURNED "_ZN4vrda6turnedERKNS_8TreeMeshERKNS_8AttitudeE"

Gap real_gap(const TreeMesh&, const Mesh&, const BoxTree&, const MovingPose&,
             const GapOptions&) __asm__("__real_" VRDA_GAP);
Gap timed_gap(const TreeMesh&, const Mesh&, const BoxTree&, const MovingPose&,
              const GapOptions&) __asm__("__wrap_" VRDA_GAP);
Gap real_touch(GapQuery*, const MovingPose&) __asm__("__real_" VRDA_TOUCH);
Gap timed_touch(GapQuery*, const MovingPose&) __asm__("__wrap_" VRDA_TOUCH);
std::optional<TrianglePair> real_collision(const TreeMesh&, const TreeMesh&, const MovingPose&, NarrowPhase&,
                                           const TrianglePair&) __asm__("__real_" VRDA_COLLISION);
std::optional<TrianglePair> timed_collision(const TreeMesh&, const TreeMesh&, const MovingPose&, NarrowPhase&,
                                            const TrianglePair&) __asm__("__wrap_" VRDA_COLLISION);
std::vector<Contact> real_contacts(const Touching&, const MovingPose&, NarrowPhase&,
                                   const ContactOptions&) __asm__("__real_" VRDA_CONTACTS);
std::vector<Contact> timed_contacts(const Touching&, const MovingPose&, NarrowPhase&,
                                    const ContactOptions&) __asm__("__wrap_" VRDA_CONTACTS);
TreeMesh real_turned(const TreeMesh&, const Attitude&) __asm__("__real_" VRDA_TURNED);
TreeMesh timed_turned(const TreeMesh&, const Attitude&) __asm__("__wrap_" VRDA_TURNED);

Gap timed_gap(const TreeMesh& reference, const Mesh& mesh, const BoxTree& moving, const MovingPose& pose,
              const GapOptions& options)
{
  const Clock clock(spent.gap_s);
  return real_gap(reference, mesh, moving, pose, options);
}

Gap timed_touch(GapQuery* query, const MovingPose& pose)
{
  const Clock clock(spent.gap_s);
  return real_touch(query, pose);
}

std::optional<TrianglePair> timed_collision(const TreeMesh& reference, const TreeMesh& moving,
                                            const MovingPose& pose, NarrowPhase& narrow_phase,
                                            const TrianglePair& hint)
{
  const Clock clock(spent.collision_s);
  return real_collision(reference, moving, pose, narrow_phase, hint);
}

std::vector<Contact> timed_contacts(const Touching& objects, const MovingPose& pose,
                                    NarrowPhase& narrow_phase, const ContactOptions& options)
{
  const Clock clock(spent.contacts_s);
  return real_contacts(objects, pose, narrow_phase, options);
}

TreeMesh timed_turned(const TreeMesh& reference, const Attitude& attitude)
{
  const Clock clock(spent.turn_s);
  return real_turned(reference, attitude);
}

}  // namespace vrda::bench
