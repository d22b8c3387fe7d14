// Texts between ranks: see communicator.hpp.
#include "base/communicator.hpp"

#include <cstdint>
#include <numeric>

namespace decid {

std::string broadcast_text(Communicator* ranks, std::string text) {
  if (ranks == nullptr) return text;
  std::uint64_t size = text.size();
  ranks->broadcast(std::as_writable_bytes(std::span(&size, 1)));
  text.resize(static_cast<std::size_t>(size));
  if (size > 0) ranks->broadcast(std::as_writable_bytes(std::span(text)));
  return text;
}

std::vector<std::string> gather_texts(Communicator* ranks, const std::string& own) {
  if (ranks == nullptr) return {own};
  const auto count = static_cast<std::size_t>(ranks->size());
  const std::uint64_t size = own.size();
  std::vector<std::uint64_t> lengths(count);
  const std::vector<std::size_t> each(count, sizeof(size));
  ranks->all_gather(std::as_bytes(std::span(&size, 1)), each, std::as_writable_bytes(std::span(lengths)));
  const std::vector<std::size_t> sizes(lengths.begin(), lengths.end());
  std::string all(std::accumulate(sizes.begin(), sizes.end(), std::size_t{0}), '\0');
  ranks->all_gather(std::as_bytes(std::span(own)), sizes, std::as_writable_bytes(std::span(all)));
  std::vector<std::string> texts;
  std::size_t place = 0;
  for (const std::size_t length : sizes) {
    texts.push_back(all.substr(place, length));
    place += length;
  }
  return texts;
}

}  // namespace decid
