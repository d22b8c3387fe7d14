// Tests of base/files/file.hpp: content, replacement in one step, and every error path that root meets too.
#include "base/files/file.hpp"

#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <string>
#include <thread>

#include "base/error.hpp"
#include "tests/helpers.hpp"

namespace fs = std::filesystem;
using decid::Code;
using decid::path_exists;
using decid::PendingFile;
using decid::read_file;
using decid::write_file;
using namespace decid::test;

namespace {

std::string binary_content(std::size_t bytes) {
  std::string content;
  for (std::size_t i = 0; i < bytes; ++i) content += static_cast<char>(i * i % 253);
  return content;
}

}  // namespace

TEST_CASE("files: read_file returns the written bytes") {
  const TemporaryFolder folder;
  // Around the size of the reader's first buffer, 2^16.
  for (const std::size_t bytes : {0u, 1u, 65535u, 65536u, 65537u, 3'000'000u}) {
    const std::string content = binary_content(bytes);
    write_file(folder / "file", content);
    CHECK((read_file(folder / "file") == content));
    CHECK(folder.files() == 1);
  }
}

TEST_CASE("files: a name without a folder is in the current one") {
  const TemporaryFolder folder;
  const fs::path before = fs::current_path();
  fs::current_path(folder / "");
  write_file("bare", "x");
  fs::current_path(before);
  CHECK(read_file(folder / "bare") == "x");
}

TEST_CASE("path_exists: files, folders, nothing, and a name that the system refuses") {
  const TemporaryFolder folder;
  write_text(folder / "a", "a");
  CHECK(path_exists(folder / "a"));
  CHECK(path_exists(folder.path()));
  CHECK_FALSE(path_exists(folder / "b"));
  CHECK_FALSE(path_exists(folder / "a" / "b"));
  CHECK_FALSE(path_exists(""));
  check_error([&] { path_exists(folder / std::string(1000, 'a').c_str()); }, Code::file_unreadable);
}

TEST_CASE("read_file: limits, a file of unknown size, errors") {
  const TemporaryFolder folder;
  const std::string content = binary_content(100);
  write_file(folder / "file", content);
  CHECK((read_file(folder / "file", 100) == content));
  for (const std::uint64_t limit : {99U, 0U})
    check_error([&] { read_file(folder / "file", limit); }, Code::file_too_large, std::to_string(limit) + " bytes");
  check_error([&] { read_file("/dev/zero", 1'000'000); }, Code::file_too_large, "/dev/zero");
  CHECK(contains(read_file("/proc/self/status"), "Pid:"));
  check_error([&] { read_file(folder / "none"); }, Code::file_missing, (folder / "none").string());
  write_file(folder / "large", "x");
  fs::resize_file(folder / "large", decid::max_own_file_bytes + 1);  // without blocks on the disk
  check_error([&] { read_file(folder / "large", decid::max_own_file_bytes); }, Code::file_too_large, "68719476736");
  check_error([&] { read_file(folder / ""); }, Code::file_unreadable, folder.path().string());
}

TEST_CASE("files: a path with a zero byte is refused, and no file of its beginning is written") {
  const TemporaryFolder folder;
  const fs::path path = folder / std::string("a\0b", 3);
  check_error([&] { write_file(path, "x"); }, Code::setting_malformed, "zero byte");
  check_error([&] { PendingFile pending(path); }, Code::setting_malformed);
  CHECK(fs::is_empty(folder.path()));
  write_file(folder / "a", "x");
  check_error([&] { read_file(path); }, Code::setting_malformed);
  check_error([&] { path_exists(path); }, Code::setting_malformed);
}

TEST_CASE("write_file: an output that cannot be opened is unwritable, not unreadable") {
  const TemporaryFolder folder;
  const fs::path path = folder / "socket";
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  REQUIRE(path.native().copy(address.sun_path, sizeof address.sun_path - 1) == path.native().size());
  const int socket = ::socket(AF_UNIX, SOCK_STREAM, 0);
  REQUIRE(::bind(socket, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0);
  check_error([&] { write_file(path, "new"); }, Code::file_unwritable, path.string());
  ::close(socket);
}

TEST_CASE("write_file: errors leave the old file and nothing else") {
  const TemporaryFolder folder;
  write_file(folder / "file", "old");
  fs::create_directory(folder / "sub");
  check_error([&] { write_file(folder / "none/file", "new"); }, Code::file_unwritable,
              "create the folder " + (folder / "none").string());
  for (const fs::path& path : {folder / "file/below", fs::path("/proc/decid-test"), folder / "sub"})
    check_error([&] { write_file(path, "new"); }, Code::file_unwritable, path.string());
  check_error([] { write_file("/dev/full", "new"); }, Code::file_unwritable, "/dev/full");
  CHECK_THROWS_AS(write_file("/dev/full", "new"), decid::WriteError);
  CHECK(read_file(folder / "file") == "old");
  CHECK(folder.files() == 2);
}

TEST_CASE("PendingFile: without commit the old file stays and nothing is left behind") {
  const TemporaryFolder folder;
  write_file(folder / "file", "old");
  try {
    PendingFile pending(folder / "file");
    write_file(pending.path(), "half of the n");
    throw 0;
  } catch (int) {
  }
  CHECK(read_file(folder / "file") == "old");
  CHECK(folder.files() == 1);
}

TEST_CASE("PendingFile: a killed process leaves the old file whole") {
  const TemporaryFolder folder;
  write_file(folder / "file", "old");
  const pid_t child = ::fork();
  if (child == 0) {
    const PendingFile pending(folder / "file");
    write_file(pending.path(), "half of the n");
    ::_exit(0);
  }
  REQUIRE(child > 0);
  ::waitpid(child, nullptr, 0);
  CHECK(read_file(folder / "file") == "old");
  write_file(folder / "file", "new");
  CHECK(read_file(folder / "file") == "new");
}

TEST_CASE("PendingFile: the target changes at commit, not before; two files of one target are independent") {
  const TemporaryFolder folder;
  write_file(folder / "file", "old");
  PendingFile first(folder / "file"), second(folder / "file");
  CHECK(first.path() != second.path());
  CHECK(first.path().parent_path() == folder.path());
  write_file(first.path(), "first");
  write_file(second.path(), "second");
  CHECK(read_file(folder / "file") == "old");
  second.commit();
  CHECK(read_file(folder / "file") == "second");
  first.commit();
  CHECK(read_file(folder / "file") == "first");
  CHECK(folder.files() == 1);
}

TEST_CASE("PendingFile: commit reports a temporary file that is gone, and a target that cannot be replaced") {
  const TemporaryFolder folder;
  {
    PendingFile gone(folder / "gone"), taken(folder / "taken");
    fs::remove(gone.path());
    check_error([&] { gone.commit(); }, Code::file_unwritable, (folder / "gone").string());
    fs::create_directory(folder / "taken");
    check_error([&] { taken.commit(); }, Code::file_unwritable, (folder / "taken").string());
  }
  CHECK(folder.files() == 1);  // the folder `taken`
}

TEST_CASE("write_file: a link keeps pointing to its file, permissions stay") {
  const TemporaryFolder folder;
  fs::create_directory(folder / "sub");
  write_file(folder / "sub/file", "old");
  fs::permissions(folder / "sub/file", fs::perms::owner_read | fs::perms::owner_write);
  fs::create_symlink("sub/file", folder / "link");
  write_file(folder / "link", "new");
  CHECK(fs::is_symlink(folder / "link"));
  CHECK(read_file(folder / "sub/file") == "new");
  CHECK(fs::status(folder / "sub/file").permissions() == (fs::perms::owner_read | fs::perms::owner_write));
}

TEST_CASE("write_file: devices and pipes are written directly") {
  const TemporaryFolder folder;
  write_file("/dev/null", "gone");
  CHECK(fs::is_character_file("/dev/null"));

  REQUIRE(::mkfifo((folder / "pipe").c_str(), 0600) == 0);
  std::string received;
  std::thread reader([&] { received = read_file(folder / "pipe"); });
  const std::string content = binary_content(200'000);  // more than a pipe holds
  write_file(folder / "pipe", content);
  reader.join();
  CHECK((received == content));
  CHECK(fs::is_fifo(folder / "pipe"));
}

TEST_CASE("write_file: /dev/stdout stays the open file") {
  const TemporaryFolder folder;
  write_file(folder / "out", "before ");
  const pid_t child = ::fork();
  if (child == 0) {
    if (std::freopen((folder / "out").c_str(), "a", stdout) == nullptr) ::_exit(1);
    write_file("/dev/stdout", "written");
    ::_exit(0);
  }
  REQUIRE(child > 0);
  int status = -1;
  ::waitpid(child, &status, 0);
  CHECK(status == 0);
  CHECK(read_file(folder / "out") == "before written");
  CHECK(folder.files() == 1);
}
