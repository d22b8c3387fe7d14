// Names of settings in messages: see setting.hpp.
#include "base/setting.hpp"

#include <atomic>

namespace decid {
namespace {

std::atomic<std::string (*)(std::string_view)> name_in_messages{nullptr};

}  // namespace

std::string setting(std::string_view name) {
  const auto called = name_in_messages.load();
  return called == nullptr ? std::string(name) : called(name);
}

void name_settings(std::string (*called)(std::string_view name)) {
  name_in_messages.store(called);
}

}  // namespace decid
