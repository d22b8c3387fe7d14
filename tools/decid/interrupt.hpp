// Ctrl-C (SIGINT) and SIGTERM. The program always ends by the signal, which shells report as 130 and 143 and which also
// ends their loops; work that keeps something, or has something to say, is asked to stop first.
#pragma once

namespace decid::tools {

/// To be called first: either signal ends the program at once, also where a shell without job control, which starts
/// what stands before a & with SIGINT ignored, called it.
void end_at_interrupt();
/// From now on the first signal only sets the flag that interrupted() reads; the second one ends the program. To be
/// called when the work that reads the flag begins: what comes before it need not wait.
/// usr1: SIGUSR1 likewise.
void catch_interrupt(bool usr1 = false);
bool interrupted();
/// To be called last: ends the program by the signal that was caught, if one was.
void end_if_interrupted();

}  // namespace decid::tools
