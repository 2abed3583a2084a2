/// The error facts of a failing action.
#pragma once

#include <gtest/gtest.h>

#include "core/text.hpp"

namespace vrda::test {

/// The InputError thrown by `action`; fails the test if none is thrown.
template <typename Action>
InputError::Facts input_error(Action action)
{
  try {
    action();
  } catch (const InputError& error) {
    return error.facts();
  }
  ADD_FAILURE() << "no InputError";
  return {};
}

}  // namespace vrda::test
