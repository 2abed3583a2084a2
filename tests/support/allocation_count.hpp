/// Counts every operator new of a test program that links test_allocations.
#pragma once

namespace vrda::test {

/// Since the start of the program, over all threads.
long allocations_of_program();
/// Of the calling thread only: libraries may allocate in their own threads.
long allocations_of_thread();
/// False under the thread sanitizer, whose operators come first.
bool are_allocations_counted();

}  // namespace vrda::test

#define VRDA_REQUIRE_ALLOCATION_COUNT()                        \
  if (!vrda::test::are_allocations_counted())                  \
  GTEST_SKIP() << "the thread sanitizer has its own operator " \
                  "new"
