/// Coverage that processes made by fork add to, so that libFuzzer sees what its copies reach.
#pragma once

namespace vrda::test {

/// From here on this process and its copies count in the same memory. Ends the program where that fails.
void share_coverage();

}  // namespace vrda::test
