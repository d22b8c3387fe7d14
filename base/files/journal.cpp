// The journal of unfinished work: see journal.hpp.
#include "base/files/journal.hpp"

#include <array>
#include <cstring>
#include <span>

#include "base/files/sha256.hpp"

namespace decid {

Journal::Journal(const std::filesystem::path& path, std::string_view name)
    : file_(path, DiskFile::Access::write), name_(std::string(name) + '\n') {}

bool Journal::is_foreign() const {
  std::string found(name_.size(), '\0');
  found.resize(file_.read(0, std::as_writable_bytes(std::span(found))));
  return !name_.starts_with(found);
}

std::optional<std::string> Journal::request() {
  std::string found(name_.size(), '\0');
  if (file_.read(0, std::as_writable_bytes(std::span(found))) != found.size() || found != name_) return std::nullopt;
  position_ = name_.size();
  return next();
}

void Journal::start(std::string_view request) {
  file_.truncate(0);
  file_.write(0, name_);
  position_ = name_.size();
  append(request);
  sync();
}

std::optional<std::string> Journal::next() {
  std::array<char, front_size> front{};
  if (file_.read(position_, std::as_writable_bytes(std::span(front))) != front_size) return std::nullopt;
  std::uint64_t size = 0;
  std::memcpy(&size, front.data(), sizeof size);
  const std::uint64_t begin = position_ + front_size;
  if (size > file_.size() - begin) return std::nullopt;  // before memory is asked for it
  std::string bytes(static_cast<std::size_t>(size), '\0');
  if (file_.read(begin, std::as_writable_bytes(std::span(bytes))) != bytes.size() ||
      sha256(bytes) != std::string_view(front.data() + sizeof size, hash_size))
    return std::nullopt;
  position_ = begin + size;
  return bytes;
}

void Journal::append(std::string_view bytes) {
  const std::uint64_t size = bytes.size();
  std::string entry(sizeof size, '\0');
  std::memcpy(entry.data(), &size, sizeof size);
  entry += sha256(bytes);
  entry += bytes;
  if (file_.size() > position_) file_.truncate(position_);
  file_.write(position_, entry);
  position_ += entry.size();
}

}  // namespace decid
