#include "core/search_move.hpp"

#include "core/error.hpp"

namespace vrda {

const char* name_of(MoveKind kind)
{
  switch (kind) {
    case MoveKind::retreat:
      return "retreat";
    case MoveKind::approach:
      return "approach";
    case MoveKind::bisect:
      return "bisect";
    case MoveKind::rotate:
      return "rotate";
    case MoveKind::translate:
      return "translate";
  }
  throw InternalError("a move without a name");
}

}  // namespace vrda
