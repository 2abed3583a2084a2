// Loaded before Bullet (LD_PRELOAD): a pair detector that reports every pair as overlapping, or closest
// points that are displaced by a unit, 0.1 to 1 mm (VRDA_WRONG_BULLET=displaced).
#include <BulletCollision/NarrowPhaseCollision/btGjkPairDetector.h>

#include <cstdlib>
#include <cstring>

namespace {

struct Displaced : btDiscreteCollisionDetectorInterface::Result {
  explicit Displaced(Result& result) : result_(result) {}
  void setShapeIdentifiersA(int part, int index) override { result_.setShapeIdentifiersA(part, index); }
  void setShapeIdentifiersB(int part, int index) override { result_.setShapeIdentifiersB(part, index); }
  void addContactPoint(const btVector3& normal, const btVector3& point, btScalar depth) override
  {
    result_.addContactPoint(normal, point + btVector3(1, 0, 0), depth);
  }

 private:
  Result& result_;
};

}  // namespace

void btGjkPairDetector::getClosestPoints(const ClosestPointInput& input, Result& result, btIDebugDraw* drawer,
                                         bool)
{
  const char* what = std::getenv("VRDA_WRONG_BULLET");
  if (what == nullptr || std::strcmp(what, "displaced") != 0) return;
  Displaced displaced(result);
  getClosestPointsNonVirtual(input, displaced, drawer);
}
