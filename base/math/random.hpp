// Counter-based random numbers: every number is a pure function of (seed, stream, item, index), so that results depend
// neither on threads nor on the order of calls. Generator: Philox4x32-10, Salmon et al., "Parallel random numbers: as
// easy as 1, 2, 3", SC 2011. Normal deviates: inverse normal distribution, Wichura, algorithm AS 241 (PPND16), Applied
// Statistics 37, 1988.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "base/isa.hpp"

namespace decid {

/// The purpose of a random number. Each purpose has its own numbers; the values determine the bits of results. Headers
/// named streams.hpp name the numbers 1 to 5, 8 to 14, 17 and 18 for the libraries above.
enum class Stream : std::uint32_t {
  weights = 6,        ///< item: parameter tensor
  shuffle = 7,        ///< item: epoch
  augmentation = 15,  ///< item: epoch and sample; what nn::fit hands to a sample's callback
  dropout = 16,       ///< item: step and layer
  user = 1U << 16U,   ///< this number and all above: programs that use decid
};

/// Returns one block of Philox4x32-10: four 32-bit words from a 128-bit counter and a 64-bit key.
std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                        std::array<std::uint32_t, 2> key) noexcept;

/// Returns the inverse of the standard normal distribution function for 0 < p < 1, relative error below 1e-15.
double inverse_normal(double p) noexcept;

/// The random numbers of one (seed, stream, item), addressed by index: below 2^57 for libraries' streams, whose numbers
/// are below 256, and below 2^33 from Stream::user on, because wider stream numbers share bits with larger indices.
/// Copies are cheap.
class Random {
 public:
  Random(std::uint64_t seed, Stream stream, std::uint64_t item) noexcept;

  std::uint64_t bits(std::uint64_t index) const noexcept;
  /// Returns a uniform number on the open interval (0, 1): (k + 1/2) / 2^52.
  double uniform(std::uint64_t index) const noexcept;
  /// Returns a uniform number on (low, high).
  double uniform(std::uint64_t index, double low, double high) const noexcept;
  /// Returns a standard normal deviate.
  double normal(std::uint64_t index) const noexcept;
  /// Sets values[i] = normal(first + i), several at once. isa: tests may choose another.
  void fill_normal(std::span<double> values, std::uint64_t first = 0, Isa isa = chosen_isa()) const;
  /// Returns a uniform integer in [0, bound), bound > 0; the bias, bound / 2^64, is undetectable.
  std::uint64_t below(std::uint64_t index, std::uint64_t bound) const noexcept;

 private:
  /// Returns block `number` of the generator, as the numbers of index 2 * number and 2 * number + 1.
  std::array<std::uint64_t, 2> block(std::uint64_t number) const noexcept;

  std::array<std::uint32_t, 2> key_;
  std::uint32_t stream_;
  std::uint64_t item_;
};

}  // namespace decid
