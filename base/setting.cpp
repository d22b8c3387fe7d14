// Names of settings in messages: see setting.hpp.
#include "base/setting.hpp"

#include <atomic>

#include "base/error.hpp"

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

void require_at_least(const std::string& where, int value, int minimum) {
  if (value < minimum)
    throw Error(Code::setting_out_of_range, where, "is " + std::to_string(value),
                "give " + std::to_string(minimum) + " or more");
}

}  // namespace decid
