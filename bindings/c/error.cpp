// Errors as C has them, and what concerns the library as a whole.
#include <omp.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <exception>
#include <iterator>
#include <new>
#include <string_view>

#include "base/parallel.hpp"
#include "base/per_thread.hpp"
#include "base/setting.hpp"
#include "base/version.hpp"
#include "bindings/c/handles.hpp"

namespace decid::c {
namespace {

struct LastError {
  std::string text, code, where, problem, remedy;
};

/// The thread's; null if there is no memory for it.
LastError* last() noexcept {
  try {
    return &per_thread<LastError>();
  } catch (...) {
    return nullptr;
  }
}

const char* to_text(std::string LastError::*part) {
  const LastError* const error = last();
  return error != nullptr ? (error->*part).c_str() : "";
}

void remember(const Error& error) {
  per_thread<LastError>() = {error.what(), name(error.code()), error.where(), error.problem(), error.remedy()};
}

/// A setting of the library, and the field of decid.h that sets it; a setting that is not listed has the field's name.
struct Field {
  std::string_view setting, name;
};
constexpr Field fields[] = {{"ankle", "ankle_column"},
                            {"begin", "begin_s"},
                            {"com_height", "com_height_m"},
                            {"fill_gaps", "fill_gaps_s"},
                            {"height", "body_height_m"},
                            {"hip", "hip_column"},
                            {"leg", "leg_column"},
                            {"mass", "mass_kg"},
                            {"missing", "missing_value"},
                            {"prior_noise", "prior_noise_deg"},
                            {"prior_start", "prior_start_s"},
                            {"ranges", "parameter_priors"},
                            {"rate", "rate_hz"},
                            {"shoulder", "shoulder_column"},
                            {"stream", "stream_trials"},
                            {"trunk", "trunk_column"}};

std::string field_of(std::string_view setting) {
  const auto* const found = std::ranges::find(fields, setting, &Field::setting);
  return std::string(found == std::end(fields) ? setting : found->name);
}

/// Bindings to other languages call decid_name_settings() later.
[[maybe_unused]] const bool names_fields = [] {
  name_settings(field_of);
  return true;
}();

std::atomic<pid_t> threaded{0};  // the first process in which a call could have several threads; a fork inherits it

}  // namespace

decid_status remember_failure() noexcept {
  try {
    try {
      throw;
    } catch (const Error& error) {
      remember(error);
      return DECID_BAD_INPUT;
    } catch (const Stopped& stopped) {
      remember(Error(Code::stopped, stopped.where, "was stopped by its callback", "let it return 0"));
      return DECID_STOPPED;
    } catch (const std::bad_alloc&) {
      remember(Error(Code::out_of_memory, "memory", "there is not enough",
                     "ask for fewer trials at a time, or free handles"));
      return DECID_NO_MEMORY;
    } catch (const std::exception& error) {
      remember(Error(Code::internal, "decid", error.what(), "report it: this should have been noticed before"));
      return DECID_FAILED;
    } catch (...) {
      remember(Error(Code::internal, "decid", "an unknown exception", "report it; a callback must not throw"));
      return DECID_FAILED;
    }
  } catch (...) {  // no memory for the text
    if (LastError* const error = last()) *error = {};
    return DECID_NO_MEMORY;
  }
}

void refuse_fork() {
  const pid_t first = threaded.load();
  if (first != 0 && first != getpid())
    throw Error(
        Code::not_supported, "decid",
        "this process was forked from one whose calls had several threads, and has none of these threads",
        "start a new process instead of a fork, run with OMP_NUM_THREADS=1, or make set_threads(1) the first call "
        "of each thread");
}

void record_threads() {
  pid_t none = 0;
  if (omp_get_max_threads() > 1) threaded.compare_exchange_strong(none, getpid());
}

std::vector<decid_warning> to_c(const Warnings& warnings) {
  std::vector<decid_warning> list;
  for (const Warning& warning : warnings)
    list.push_back({static_cast<decid_severity>(warning.severity), warning.code.c_str(), warning.text.c_str()});
  return list;
}

}  // namespace decid::c

using namespace decid::c;

const char* decid_error_text(void) {
  return to_text(&LastError::text);
}
const char* decid_error_code(void) {
  return to_text(&LastError::code);
}
const char* decid_error_where(void) {
  return to_text(&LastError::where);
}
const char* decid_error_problem(void) {
  return to_text(&LastError::problem);
}
const char* decid_error_remedy(void) {
  return to_text(&LastError::remedy);
}

int decid_abi(void) {
  return DECID_ABI;
}
const char* decid_version(void) {
  return decid::version;
}

decid_status decid_name_settings(int names) {
  return caught([&] {
    if (names != DECID_FIELD_NAMES && names != DECID_PLAIN_NAMES)
      throw decid::Error(decid::Code::setting_unknown, "decid_name_settings",
                         decid::format("there are no names %d", names), "give a value of decid_setting_names");
    decid::name_settings(names == DECID_FIELD_NAMES ? field_of : nullptr);
  });
}

decid_status decid_set_threads(int threads) {
  return caught([&] {
    refuse_fork();
    if (threads < 1 || threads > decid::max_threads)
      throw decid::Error(decid::Code::setting_out_of_range, decid::setting("threads"), decid::format("is %d", threads),
                         decid::format("give 1 to %d", decid::max_threads));
    omp_set_num_threads(threads);
    record_threads();  // not before: with one thread the process can still be forked
  });
}
