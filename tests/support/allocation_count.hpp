/// Counts every operator new of a test program that links test_allocations.
#pragma once

namespace vrda::test {

/// Since the start of the program, over all threads.
long allocations_of_program();
/// Of the calling thread only: libraries may allocate in their own threads.
long allocations_of_thread();

}  // namespace vrda::test
