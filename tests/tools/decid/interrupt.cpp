// Ctrl-C and SIGTERM: every command ends by the signal, short or long; what has been made until then is kept.
#include <fcntl.h>
#include <sys/stat.h>

#include <chrono>
#include <csignal>
#include <functional>
#include <thread>

#include "tests/tools/decid/run.hpp"

namespace decid {
namespace {

using namespace test;

void wait_a_little() {
  std::this_thread::sleep_for(std::chrono::milliseconds(5));
}

/// The program in a process of its own, which ignores the signals as a shell without job control makes it.
class Process {
 public:
  explicit Process(const std::string& command) : number_(::fork()) {
    if (number_ != 0) return;
    std::signal(SIGINT, SIG_IGN);
    std::signal(SIGTERM, SIG_IGN);
    ::execl("/bin/sh", "sh", "-c", ("exec " DECID_PROGRAM " " + command).c_str(), nullptr);
    ::_exit(127);
  }
  ~Process() {
    if (ended_) return;
    ::kill(number_, SIGKILL);
    ::waitpid(number_, &status_, 0);
  }
  Process(const Process&) = delete;
  Process& operator=(const Process&) = delete;

  /// Returns true if `there()` held before the process ended.
  bool reaches(const std::function<bool()>& there) {
    while (!there()) {
      if (has_ended()) return false;
      wait_a_little();
    }
    return true;
  }
  void send(int signal) const { ::kill(number_, signal); }
  /// Returns the signal that ended the process; 0 if it ended otherwise.
  int signal_of_end() {
    while (!has_ended()) wait_a_little();
    return WIFSIGNALED(status_) ? WTERMSIG(status_) : 0;
  }

 private:
  bool has_ended() { return ended_ = ended_ || ::waitpid(number_, &status_, WNOHANG) == number_; }

  pid_t number_;
  int status_ = 0;
  bool ended_ = false;
};

}  // namespace

TEST_CASE("every command ends by Ctrl-C or SIGTERM, at once where nothing has been made") {
  const Folder folder;
  test::run_ok("simulate --quiet -o " + folder / "t.csv");
  const std::string pipe = folder / "pipe";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  // Each waits for the pipe's content, which never comes. The signals take turns: all commands share their handler.
  int signal = SIGINT;
  for (const std::string& command :
       {"simulate --protocol " + pipe + " -o " + folder / "o.csv",
        "stimulus --protocol " + pipe + " -o " + folder / "o",
        "dataset --count 10 --protocol " + pipe + " -o " + folder / "o.npz",
        "train --stream --protocol " + pipe + " -o " + folder / "o.safetensors",
        "evaluate --data " + folder / "d.npz" + " --model " + pipe, "identify " + pipe + " -o " + folder / "o.json",
        "fit --protocol " + pipe + " " + folder / "t.csv", "fit --frf " + pipe, "calibrate --protocol " + pipe,
        "compare --model " + pipe, "study --model " + pipe + " -o " + folder / "o", "info " + pipe,
        "export c " + pipe + " -o " + folder / "o", "export controller " + pipe + " -o " + folder / "o",
        "export sway " + pipe + " -o " + folder / "o"}) {
    CAPTURE(command);
    signal = signal == SIGINT ? SIGTERM : SIGINT;
    Process process(command + " >" + folder / "out" + " 2>" + folder / "err");
    int writer = -1;
    // Opening it succeeds once the program has opened it for reading.
    REQUIRE(process.reaches([&] { return (writer = ::open(pipe.c_str(), O_WRONLY | O_NONBLOCK)) >= 0; }));
    process.send(signal);
    CHECK(process.signal_of_end() == signal);
    ::close(writer);
    CHECK(read_text(folder / "out").empty());
  }
  CHECK(folder.files() == 4);  // t.csv, pipe, out, err
}

TEST_CASE("SIGTERM, as batch systems send it, leaves a training's checkpoint and says how to go on") {
  const Folder folder;
  const std::string model = folder / "m.safetensors";
  Process process("train --stream --stream-trials 64 --validation-trials 8 --preset small --epochs 2000 -o " + model +
                  " 2>" + folder / "err");
  REQUIRE(process.reaches([&] { return std::filesystem::exists(model + ".checkpoint"); }));
  process.send(SIGTERM);
  CHECK(process.signal_of_end() == SIGTERM);
  CHECK(contains(read_text(folder / "err"), "stopped; the same command, with --resume or without, continues"));
  CHECK(std::filesystem::exists(model + ".checkpoint"));
  CHECK_FALSE(std::filesystem::exists(model));
}

TEST_CASE("a second Ctrl-C ends the program at once") {
  const Folder folder;
  const std::string pipe = folder / "pipe";
  REQUIRE(::mkfifo(pipe.c_str(), 0600) == 0);
  Process process("fit " + pipe + " 2>" + folder / "err");
  int writer = -1;
  REQUIRE(process.reaches([&] { return (writer = ::open(pipe.c_str(), O_WRONLY | O_NONBLOCK)) >= 0; }));
  process.send(SIGINT);
  for (int i = 0; i < 20; ++i) wait_a_little();  // or the two would be one
  process.send(SIGINT);
  CHECK(process.signal_of_end() == SIGINT);  // though the recording has not come
  ::close(writer);
  CHECK(read_text(folder / "err").empty());
}

}  // namespace decid
