/// Counts every operator new of a test program that links test_allocations.
#pragma once

namespace vrda::test {

/// Since its start, of all its threads.
long allocations_of_program();
/// Of the calling thread alone: libraries may allocate in threads of their own.
long allocations_of_thread();

}  // namespace vrda::test
