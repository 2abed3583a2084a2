/// What an action refuses.
#pragma once

#include <gtest/gtest.h>

#include "core/error.hpp"

namespace vrda::test {

/// The InputError that `action` throws; fails the test when it throws none.
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
