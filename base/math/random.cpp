// Counter-based random numbers: see random.hpp.
// Generator: Philox4x32-10, Salmon et al., SC 2011. A counter holds (block, item, stream), the key is the seed.
#include "base/math/random.hpp"

#include "base/kernels/kernels.hpp"
#include "base/math/math_lanes.hpp"

namespace decid {
namespace {

constexpr std::uint32_t low_word(std::uint64_t x) {
  return static_cast<std::uint32_t>(x);
}
constexpr std::uint32_t high_word(std::uint64_t x) {
  return static_cast<std::uint32_t>(x >> 32);
}

}  // namespace

std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                        std::array<std::uint32_t, 2> key) noexcept {
  const auto [words] = philox_lanes<One>({{counter[0], counter[1], counter[2], counter[3]}}, key[0], key[1]);
  std::array<std::uint32_t, 4> result{};
  for (std::size_t i = 0; i < result.size(); ++i) result[i] = static_cast<std::uint32_t>(words[i]);
  return result;
}

double inverse_normal(double p) noexcept {
  const bool central = One::abs(p - 0.5) <= central_half;
  return central ? central_normal_lanes<One>(p) : tail_normal_lanes<One>(p);
}

Random::Random(std::uint64_t seed, Stream stream, std::uint64_t item) noexcept
    : key_{low_word(seed), high_word(seed)}, stream_(static_cast<std::uint32_t>(stream)), item_(item) {}

std::array<std::uint64_t, 2> Random::block(std::uint64_t number) const noexcept {
  // A library's stream occupies 8 bits, which leaves 56 for the block's number; a user's leaves 32.
  const auto words =
      philox4x32({low_word(number), low_word(item_), high_word(item_), stream_ | high_word(number) << 8}, key_);
  return {words[0] | std::uint64_t{words[1]} << 32, words[2] | std::uint64_t{words[3]} << 32};
}

std::uint64_t Random::bits(std::uint64_t index) const noexcept {
  return block(index / 2)[index % 2];
}

double Random::uniform(std::uint64_t index) const noexcept {
  return to_unit_interval<One>(static_cast<std::int64_t>(bits(index)));
}

double Random::uniform(std::uint64_t index, double low, double high) const noexcept {
  return low + (high - low) * uniform(index);
}

double Random::normal(std::uint64_t index) const noexcept {
  return inverse_normal(uniform(index));
}

void Random::fill_normal(std::span<double> values, std::uint64_t first, Isa isa) const {
  std::size_t i = 0;
  if (first % 2 == 1 && !values.empty()) values[i++] = normal(first);
  const std::size_t blocks = (values.size() - i) / 2;
  const NormalsRequest request{{key_[0], key_[1]}, stream_, item_, (first + i) / 2};
  random_kernels(isa).normals(request, static_cast<std::int64_t>(blocks), values.data() + i);
  i += 2 * blocks;
  if (i < values.size()) values[i] = normal(first + i);
}

std::uint64_t Random::below(std::uint64_t index, std::uint64_t bound) const noexcept {
  // The high word of the product bits * bound, in 32-bit pieces: standard C++ has no 128-bit integer.
  const std::uint64_t x = bits(index);
  const std::uint64_t low_high = std::uint64_t{low_word(x)} * high_word(bound);
  const std::uint64_t high_low = std::uint64_t{high_word(x)} * low_word(bound);
  const std::uint64_t low_low = std::uint64_t{low_word(x)} * low_word(bound);
  const std::uint64_t middle = high_word(low_low) + std::uint64_t{low_word(low_high)} + low_word(high_low);
  return std::uint64_t{high_word(x)} * high_word(bound) + high_word(low_high) + high_word(high_low) + high_word(middle);
}

}  // namespace decid
