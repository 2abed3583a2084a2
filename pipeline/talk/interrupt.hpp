/// Ctrl-C and SIGTERM ask a run to end in good order.
#pragma once

namespace vrda {

/// From now on the first SIGINT or SIGTERM only sets the flag; a second one ends the process.
void watch_for_interrupts();

/// A second SIGTERM changes nothing either, from now on: a batch system tells all processes of a task, and
/// the script that is one of them passes it on. Who means it sends SIGKILL.
void bear_repeated_terms();

bool is_interrupted();

}  // namespace vrda
