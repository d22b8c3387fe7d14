// A child process for untrusted work: see child.hpp. The answer comes through a pipe after its length, so an incomplete
// answer is rejected. Exit codes are not used, because a parent that waits for all its children may have taken them.
#include "recording/formats/detail/child.hpp"

#include <fcntl.h>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstdint>
#include <cstdio>
#include <cstring>

#include "base/error.hpp"
#include "base/text.hpp"

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
#define DECID_SHADOW_MEMORY
#elif defined(__has_feature)
#if __has_feature(address_sanitizer) || __has_feature(thread_sanitizer)
#define DECID_SHADOW_MEMORY
#endif
#endif

#ifdef DECID_COVERAGE
extern "C" void __gcov_dump(void);
#endif

namespace decid::recording {
namespace {

/// Returns the size of the process's address space.
std::size_t address_bytes() {
  unsigned long long pages = 0;
  if (std::FILE* file = std::fopen("/proc/self/statm", "re")) {
    if (std::fscanf(file, "%llu", &pages) != 1) pages = 0;
    std::fclose(file);
  }
  return static_cast<std::size_t>(pages) * static_cast<std::size_t>(::sysconf(_SC_PAGESIZE));
}

void limit(int resource, std::size_t max) {
  rlimit now{};
  if (::getrlimit(static_cast<__rlimit_resource>(resource), &now) != 0) return;
  now.rlim_cur = now.rlim_max = now.rlim_max < max ? now.rlim_max : max;
  ::setrlimit(static_cast<__rlimit_resource>(resource), &now);
}

bool write_whole(int descriptor, const char* from, std::size_t bytes) {
  while (bytes > 0) {
    const ssize_t count = ::write(descriptor, from, bytes);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return false;
    from += count;
    bytes -= static_cast<std::size_t>(count);
  }
  return true;
}

[[noreturn]] void be_child(const std::function<std::string()>& work, [[maybe_unused]] std::size_t max_bytes,
                           unsigned seconds, int answer) noexcept {
  for (const int number : {SIGINT, SIGTERM, SIGHUP, SIGSEGV, SIGBUS, SIGFPE, SIGILL, SIGABRT})
    std::signal(number, SIG_DFL);
  limit(RLIMIT_CORE, 0);
  limit(RLIMIT_CPU, seconds);
#ifndef DECID_COVERAGE
  limit(RLIMIT_FSIZE,
        0);  // the child answers through a pipe and writes no files, except the counters of coverage builds
#endif
#ifndef DECID_SHADOW_MEMORY
  limit(RLIMIT_AS, max_bytes);
#endif
  if (const int nowhere = ::open("/dev/null", O_RDWR | O_CLOEXEC); nowhere >= 0) {
    ::dup2(nowhere, STDOUT_FILENO);
    ::dup2(nowhere, STDERR_FILENO);
  } else {
    ::close(STDOUT_FILENO);
    ::close(STDERR_FILENO);
  }
  try {
    const std::string text = work();
    const std::uint64_t length = text.size();
    if (write_whole(answer, reinterpret_cast<const char*>(&length), sizeof length))
      write_whole(answer, text.data(), text.size());
  } catch (...) {  // an exception gives no answer
  }
#ifdef DECID_COVERAGE
  __gcov_dump();
#endif
  ::_exit(0);
}

/// Returns everything that comes through a pipe; nothing if its length differs from the stated one or exceeds
/// `max_bytes`.
std::optional<std::string> read_answer(int descriptor, std::size_t max_bytes) {
  std::string text(sizeof(std::uint64_t), '\0');
  std::size_t done = 0;
  for (bool has_length = false; done < text.size();) {
    const ssize_t count = ::read(descriptor, text.data() + done, text.size() - done);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return {};
    done += static_cast<std::size_t>(count);
    if (!has_length && done == text.size()) {
      std::uint64_t length = 0;
      std::memcpy(&length, text.data(), sizeof length);
      if (length > max_bytes) return {};
      text.assign(static_cast<std::size_t>(length), '\0');
      has_length = true;
      done = 0;
    }
  }
  return text;
}

}  // namespace

std::optional<std::string> in_child(const std::function<std::string()>& work, const ChildLimits& limits) {
  const auto no_child = [] {
    return Error(Code::system_failed, "the process that reads the file", "cannot be started: " + errno_text(errno),
                 "end other programs, or save the file as another kind");
  };
  int ends[2];
  if (::pipe2(ends, O_CLOEXEC) != 0) throw no_child();
  const std::size_t max_bytes = address_bytes() + limits.memory_bytes;
  const pid_t child = ::fork();
  if (child == 0) {
    ::close(ends[0]);
    be_child(work, max_bytes, limits.seconds, ends[1]);
  }
  const int error = errno;
  ::close(ends[1]);
  if (child < 0) {
    ::close(ends[0]);
    errno = error;
    throw no_child();
  }
  std::optional<std::string> answer;
  try {
    answer = read_answer(ends[0], limits.memory_bytes);
  } catch (...) {
    ::close(ends[0]);
    ::kill(child, SIGKILL);
    while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
    }
    throw;
  }
  ::close(ends[0]);
  while (::waitpid(child, nullptr, 0) < 0 && errno == EINTR) {
  }
  return answer;
}

}  // namespace decid::recording
