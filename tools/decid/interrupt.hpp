// Ctrl-C (SIGINT) and SIGTERM. The program always ends by the signal. Shells report that as 130 and 143, and it also
// ends their loops. Work that saves or prints a result receives a request to stop first.
#pragma once

namespace decid::tools {

/// Makes either signal end the program at once; call it first. This also works if a shell without job control, which
/// starts background commands (&) with SIGINT ignored, started the program.
void end_at_interrupt();
/// Makes the first signal only set the flag that interrupted() reads; the second signal ends the program. Call it when
/// the work that reads the flag begins: earlier steps need not wait. usr1: treats SIGUSR1 in the same way.
void catch_interrupt(bool usr1 = false);
bool interrupted();
/// Ends the program by the caught signal, if there was one; call it last.
void end_if_interrupted();

}  // namespace decid::tools
