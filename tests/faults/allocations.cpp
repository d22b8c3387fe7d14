// Each allocation of the C interface's functions fails once, in turn: DECID_NO_MEMORY, nothing made, and the process
// lives. Each call is made in a child, so that one that ends the process is counted. The share of what libzip takes for
// a damaged file has a limit.
//   allocations SOURCE_FOLDER [STRIDE]
//   allocations SOURCE_FOLDER FUNCTION INDEX     that one alone and in this process, for a debugger
#include <errno.h>
#include <signal.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "decid.h"

namespace {

std::atomic<long> left{-1};  // allocations until one fails; negative: none does

bool fails() {
  return left.load() >= 0 && left.fetch_sub(1) == 0;
}

}  // namespace

extern "C" {
// glibc's own functions behind its public ones.
void* __libc_malloc(size_t bytes);
void* __libc_calloc(size_t count, size_t bytes);
void* __libc_realloc(void* old, size_t bytes);
void* __libc_memalign(size_t alignment, size_t bytes);

void* malloc(size_t bytes) {
  return fails() ? nullptr : __libc_malloc(bytes);
}
void* calloc(size_t count, size_t bytes) {
  return fails() ? nullptr : __libc_calloc(count, bytes);
}
void* realloc(void* old, size_t bytes) {
  return fails() ? nullptr : __libc_realloc(old, bytes);
}
void* aligned_alloc(size_t alignment, size_t bytes) {
  return fails() ? nullptr : __libc_memalign(alignment, bytes);
}
int posix_memalign(void** place, size_t alignment, size_t bytes) {
  if (fails()) return ENOMEM;
  *place = __libc_memalign(alignment, bytes);
  return *place == nullptr ? ENOMEM : 0;
}
}

namespace {

struct Step {
  const char* name;
  std::function<decid_status()> call;
};

/// Returns the step that makes a handle, which must be null where the call failed. The child's exit frees it.
template <class Handle, class Call>
Step makes(const char* name, const Call& call) {
  return {name, [call] {
            Handle* handle = nullptr;
            const decid_status status = call(&handle);
            if ((status == DECID_OK) != (handle != nullptr)) std::_Exit(99);
            return status;
          }};
}

constexpr int reached_the_end = 100;

/// In a child: what the call returned when its allocation number `index` failed; 128 + signal if a signal ended it.
int outcome(const Step& step, long index) {
  const pid_t child = ::fork();
  if (child == 0) {
    const rlimit no_core{0, 0};
    ::setrlimit(RLIMIT_CORE, &no_core);
    std::fclose(stderr);  // "terminate called ..", thousands of times
    left = index;
    const decid_status status = step.call();
    const bool all_done = left.load() >= 0;
    left = -1;
    // A large array that finds no place is an error of its file, with its size.
    const bool said = status == DECID_BAD_INPUT && std::strstr(decid_error_problem(), "memory") != nullptr;
    ::_exit(all_done ? reached_the_end : static_cast<int>(said ? DECID_NO_MEMORY : status));
  }
  int status = 0;
  if (child < 0 || ::waitpid(child, &status, 0) != child) std::abort();
  return WIFSIGNALED(status) ? 128 + WTERMSIG(status) : WEXITSTATUS(status);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) return 2;
  // A process whose calls had threads cannot be forked and go on (decid.h).
  if (const char* threads = std::getenv("OMP_NUM_THREADS"); threads == nullptr || std::string(threads) != "1") {
    ::setenv("OMP_NUM_THREADS", "1", 1);
    ::execv("/proc/self/exe", argv);
    return 1;
  }
  const std::filesystem::path golden = std::filesystem::path(argv[1]) / "tests/golden/0.2.0";
  const long stride = argc == 3 ? std::atol(argv[2]) : 1;
  const std::string protocol_file = golden / "protocol.json", model_file = golden / "net.safetensors";
  const std::string recording_file = golden / "trial.csv", data_file = golden / "data.npz";
  const std::string mat_file = std::filesystem::path(argv[1]) / "tests/recording/mat/v7_struct.mat";
  decid_protocol* protocol = nullptr;
  decid_model* model = nullptr;
  decid_recording* recording = nullptr;
  decid_dataset* dataset = nullptr;
  if (decid_set_threads(1) || decid_protocol_load(protocol_file.c_str(), &protocol) ||
      decid_model_load(model_file.c_str(), &model) ||
      decid_recording_read(recording_file.c_str(), nullptr, &recording) ||
      decid_dataset_read(data_file.c_str(), &dataset)) {
    std::fprintf(stderr, "allocations: %s\n", decid_error_text());
    return 1;
  }
  decid_dataset_options few;
  decid_dataset_defaults(&few, sizeof few);
  few.count = 3;
  decid_read_options column;
  decid_read_defaults(&column, sizeof column);
  column.column = "trial.signals.COM_x";
  std::vector<double> parameters(decid_protocol_parameters(protocol)), sway(decid_protocol_samples(protocol));
  unsigned char valid = 0;
  for (size_t p = 0; p < parameters.size(); ++p) parameters[p] = decid_protocol_parameter(protocol, p)->low;

  const Step steps[]{
      makes<decid_protocol>("protocol_load", [&](auto to) { return decid_protocol_load(protocol_file.c_str(), to); }),
      makes<decid_model>("model_load", [&](auto to) { return decid_model_load(model_file.c_str(), to); }),
      makes<decid_recording>("recording_read",
                             [&](auto to) { return decid_recording_read(recording_file.c_str(), nullptr, to); }),
      makes<decid_recording>("recording_read MAT",
                             [&](auto to) { return decid_recording_read(mat_file.c_str(), &column, to); }),
      makes<decid_result>("identify", [&](auto to) { return decid_identify(model, recording, nullptr, to); }),
      makes<decid_dataset>("dataset_make", [&](auto to) { return decid_dataset_make(protocol, &few, to); }),
      makes<decid_dataset>("dataset_read", [&](auto to) { return decid_dataset_read(data_file.c_str(), to); }),
      {"simulate", [&] { return decid_simulate(protocol, parameters.data(), 1, 1, sway.data(), &valid); }},
      {"evaluate",
       [&] {
         decid_evaluation to;
         return decid_evaluate(model, dataset, DECID_ALL, &to, sizeof to);
       }},
  };
  if (argc == 4) {
    for (const Step& step : steps) {
      if (std::strcmp(step.name, argv[2]) != 0) continue;
      left = std::atol(argv[3]);
      const decid_status status = step.call();
      left = -1;
      std::printf("%s: %d %s\n", step.name, static_cast<int>(status), status != DECID_OK ? decid_error_text() : "");
    }
    return 0;
  }
  long all = 0, terminated = 0, misnamed = 0, wrong = 0;
  for (const Step& step : steps) {
    long calls = 0, ended = 0, without = 0;
    for (long index = 0;; index += stride) {
      const int found = outcome(step, index);
      if (found == reached_the_end) break;
      ++calls;
      if (found == 128 + SIGABRT) {
        ++ended;
        std::fprintf(stderr, "%s: allocation %ld ended the process\n", step.name, index);
      } else if (found == DECID_OK) {
        ++without;
      } else if (found == DECID_BAD_INPUT) {
        ++misnamed;
      } else if (found != DECID_NO_MEMORY) {
        ++wrong;
        std::fprintf(stderr, "%s: allocation %ld: %d\n", step.name, index, found);
      }
    }
    std::printf("%-20s %6ld allocations failed, %ld could be done without, %ld ended the process\n", step.name, calls,
                without, ended);
    std::fflush(stdout);
    all += calls;
    terminated += ended;
  }
  std::printf("%ld in all, %ld were called bad input, %ld of other outcome, %ld ended the process\n", all, misnamed,
              wrong, terminated);
  return wrong == 0 && misnamed * 50 <= all && terminated == 0 ? 0 : 1;
}
