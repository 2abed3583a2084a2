/// Ctrl-C and SIGTERM ask a run to end in good order.
#pragma once

namespace vrda {

/// From now on the first SIGINT or SIGTERM only sets the flag; a second one ends the process.
void watch_for_interrupts();

bool is_interrupted();

}  // namespace vrda
