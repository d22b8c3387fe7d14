// Ctrl-C, SIGTERM and SIGHUP: see interrupt.hpp.
#include "tools/decid/interrupt.hpp"

#include <atomic>
#include <csignal>
#include <iostream>

namespace decid::tools {
namespace {

std::atomic<int> caught_signal{0};
static_assert(std::atomic<int>::is_always_lock_free, "set in a signal handler");

void end_by(int signal) {
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

extern "C" void on_interrupt(int signal) {
  if (caught_signal.exchange(signal) != 0) end_by(signal);
}

void handle(void (*handler)(int)) {
  for (const int signal : {SIGINT, SIGTERM}) std::signal(signal, handler);
  if (std::signal(SIGHUP, handler) == SIG_IGN) std::signal(SIGHUP, SIG_IGN);  // as nohup wants it
}

}  // namespace

void end_at_interrupt() {
  handle(SIG_DFL);
}
void catch_interrupt(bool usr1) {
  handle(on_interrupt);
  if (usr1) std::signal(SIGUSR1, on_interrupt);
}
bool interrupted() {
  return caught_signal.load() != 0;
}
void end_if_interrupted() {
  const int signal = caught_signal.load();
  if (signal == 0) return;
  std::cout.flush();
  end_by(signal);
}

}  // namespace decid::tools
