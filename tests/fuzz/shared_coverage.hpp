/// Coverage counters shared with forked processes, so that libFuzzer sees the children's coverage.
#pragma once

namespace vrda::test {

/// From now on this process and its children count in shared memory. Exits on failure.
void share_coverage();

}  // namespace vrda::test
