#include "store/member_visitor.hpp"

#include "store/registry.hpp"

namespace vrda::store {

void visit_members(MotionModel& model, MemberVisitor& visitor)
{
  visit_motion_model(model, visitor);
}

}  // namespace vrda::store
