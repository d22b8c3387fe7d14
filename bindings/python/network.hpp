// A network as the module decid._nn has it: with a guard against calls while another call changes it.
#pragma once

#include <pybind11/pybind11.h>

#include <optional>
#include <thread>
#include <utility>

#include "base/error.hpp"
#include "nn/network.hpp"

namespace decid::python {

namespace py = pybind11;

/// A network and who uses it. Read and changed only with the interpreter's lock.
struct Network : nn::Network<float> {
  using nn::Network<float>::Network;
  explicit Network(nn::Network<float>&& of) : nn::Network<float>(std::move(of)) {}

  int readers = 0;  // calls that read it without the lock
  bool in_fit = false;
  std::optional<std::thread::id> in_callback = {};  // the thread in which a fit calls a function
};

[[noreturn]] inline void refuse_use(const char* problem, const char* remedy) {
  throw Error(Code::not_supported, "network", problem, remedy);
}

/// Raises decid.Error if a fit changes the network. The functions that a fit calls may read it.
inline void require_readable(const Network& network) {
  if (network.in_fit && network.in_callback != std::this_thread::get_id())
    refuse_use("is in fit(), which changes it", "wait until fit() returns, or use the network in what fit() calls");
}

/// Raises decid.Error if other calls use the network.
inline void require_changeable(const Network& network) {
  if (network.in_fit)
    refuse_use("is in fit(), which changes it", "wait until fit() returns, or change another network");
  if (network.readers > 0)
    refuse_use("is used by another thread's call", "wait until that call returns, or change a copy");
}

/// Runs an action at the end of its scope.
template <class Action>
class AtExit {
 public:
  explicit AtExit(Action action) : action_(action) {}
  ~AtExit() { action_(); }
  AtExit(const AtExit&) = delete;
  AtExit& operator=(const AtExit&) = delete;

 private:
  Action action_;
};

/// Begins a call that reads the network without the interpreter's lock, until the result is destroyed.
inline auto reading(Network& network) {
  require_readable(network);
  ++network.readers;
  return AtExit([&network] { --network.readers; });
}

/// Begins a fit of the network.
inline auto fitting(Network& network) {
  require_changeable(network);
  network.in_fit = true;
  return AtExit([&network] { network.in_fit = false; });
}

/// Begins a function that a fit calls, until the result is destroyed.
inline auto in_callback(Network& network) {
  network.in_callback = std::this_thread::get_id();
  return AtExit([&network] { network.in_callback.reset(); });
}

}  // namespace decid::python
