// Files at positions: what is written is read, however it is cut into pieces; ends, locks and refusals.
#include "base/files/disk_file.hpp"

#include <doctest/doctest.h>
#include <unistd.h>

#include <string>
#include <vector>

#include "tests/helpers.hpp"

using decid::DiskFile;
using decid::test::check_error;

namespace {

struct TemporaryFile {
  std::filesystem::path path =
      std::filesystem::temp_directory_path() / ("decid-disk-file-" + std::to_string(::getpid()));
  ~TemporaryFile() {
    std::error_code ignored;
    std::filesystem::remove(path, ignored);
  }
};

std::string content(const DiskFile& file, std::uint64_t position, std::size_t bytes) {
  std::string text(bytes, '?');
  text.resize(file.read(position, std::as_writable_bytes(std::span(text))));
  return text;
}

}  // namespace

TEST_CASE("pieces are written one after the other, empty ones and more than one call takes too") {
  const TemporaryFile temporary;
  DiskFile file(temporary.path, DiskFile::Access::write);
  std::vector<std::string> texts;
  std::string whole;
  for (int i = 0; i < 1500; ++i) {
    texts.push_back(i % 7 == 0 ? "" : std::string(static_cast<std::size_t>(i % 50), static_cast<char>('a' + i % 26)));
    whole += texts.back();
  }
  std::vector<std::span<const std::byte>> pieces;
  for (const std::string& text : texts) pieces.push_back(std::as_bytes(std::span(text)));
  file.write(3, pieces);
  CHECK(file.size() == whole.size() + 3);
  CHECK(content(file, 3, whole.size()) == whole);
  CHECK(content(file, 0, 3) == std::string(3, '\0'));
  file.write(3, std::span<const std::span<const std::byte>>());
  CHECK(file.size() == whole.size() + 3);

  CHECK(content(file, whole.size(), 100) == whole.substr(whole.size() - 3));  // no more than there is
  CHECK(content(file, whole.size() + 50, 10).empty());
  file.truncate(5);
  file.write(4, "xyz");
  CHECK(content(file, 3, 100) == whole.substr(0, 1) + "xyz");
  file.start_writeback(0, 4);
  file.sync();
}

TEST_CASE("one holds the lock, until it is closed") {
  const TemporaryFile temporary;
  DiskFile second(temporary.path, DiskFile::Access::write);
  {
    DiskFile first(temporary.path, DiskFile::Access::write);
    CHECK(first.try_lock());
    CHECK_FALSE(second.try_lock());
  }
  CHECK(second.try_lock());
  CHECK(second.is_still_at_its_path());
  std::filesystem::remove(temporary.path);
  CHECK_FALSE(second.is_still_at_its_path());
  const DiskFile other(temporary.path, DiskFile::Access::write);
  CHECK_FALSE(second.is_still_at_its_path());
}

TEST_CASE("an unreadable file is an error with the reason") {
  const TemporaryFile temporary;
  check_error([&] { DiskFile(temporary.path, DiskFile::Access::read); }, decid::Code::file_missing);
  check_error([&] { DiskFile(temporary.path / "x", DiskFile::Access::write); }, decid::Code::file_unwritable);
  for (const auto access : {DiskFile::Access::read, DiskFile::Access::write})
    check_error([&] { DiskFile(temporary.path.native() + std::string("\0b", 2), access); },
                decid::Code::setting_malformed);
  CHECK_FALSE(std::filesystem::exists(temporary.path));
  check_error([&] { DiskFile("/", DiskFile::Access::write); }, decid::Code::file_unwritable);
  DiskFile(temporary.path, DiskFile::Access::write).write(0, "content");
  DiskFile reader(temporary.path, DiskFile::Access::read);
  CHECK(content(reader, 0, 100) == "content");
  check_error([&] { reader.write(0, "x"); }, decid::Code::file_unwritable);
}
