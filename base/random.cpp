// Counter-based random numbers: see random.hpp.
// Generator: Philox4x32-10, Salmon et al., SC 2011. A counter holds (block, item, stream), the key is the seed.
// Normal deviates: Wichura, algorithm AS 241 (PPND16), Applied Statistics 37, 1988; coefficients as printed there.
#include "base/random.hpp"

#include <cmath>

#include "base/math.hpp"

namespace decid {
namespace {

constexpr std::uint32_t low_word(std::uint64_t x) {
  return static_cast<std::uint32_t>(x);
}
constexpr std::uint32_t high_word(std::uint64_t x) {
  return static_cast<std::uint32_t>(x >> 32);
}

// The middle of one of 2^52 equal cells of (0, 1), so that neither 0 nor 1 occurs and 1 - u is exact.
double to_unit_interval(std::uint64_t bits) {
  return (static_cast<double>(static_cast<std::int64_t>(bits >> 12)) + 0.5) * 0x1p-52;
}

using Coefficients = std::array<double, 8>;  // of x^0 .. x^7

double polynomial(const Coefficients& c, double x) {
  double sum = c[7];
  for (std::size_t i = 7; i-- > 0;) sum = sum * x + c[i];
  return sum;
}

double rational(const Coefficients& numerator, const Coefficients& denominator, double x) {
  return polynomial(numerator, x) / polynomial(denominator, x);
}

// |p - 1/2| <= 0.425, in 0.425^2 - (p - 1/2)^2.
constexpr Coefficients center_numerator{3.3871328727963666080e0,  1.3314166789178437745e+2, 1.9715909503065514427e+3,
                                        1.3731693765509461125e+4, 4.5921953931549871457e+4, 6.7265770927008700853e+4,
                                        3.3430575583588128105e+4, 2.5090809287301226727e+3};
constexpr Coefficients center_denominator{1.0,
                                          4.2313330701600911252e+1,
                                          6.8718700749205790830e+2,
                                          5.3941960214247511077e+3,
                                          2.1213794301586595867e+4,
                                          3.9307895800092710610e+4,
                                          2.8729085735721942674e+4,
                                          5.2264952788528545610e+3};
// r = sqrt(-log p) <= 5, in r - 1.6.
constexpr Coefficients near_numerator{1.42343711074968357734e0,  4.63033784615654529590e0, 5.76949722146069140550e0,
                                      3.64784832476320460504e0,  1.27045825245236838258e0, 2.41780725177450611770e-1,
                                      2.27238449892691845833e-2, 7.74545014278341407640e-4};
constexpr Coefficients near_denominator{1.0,
                                        2.05319162663775882187e0,
                                        1.67638483018380384940e0,
                                        6.89767334985100004550e-1,
                                        1.48103976427480074590e-1,
                                        1.51986665636164571966e-2,
                                        5.47593808499534494600e-4,
                                        1.05075007164441684324e-9};
// r > 5, in r - 5.
constexpr Coefficients far_numerator{6.65790464350110377720e0,  5.46378491116411436990e0,  1.78482653991729133580e0,
                                     2.96560571828504891230e-1, 2.65321895265761230930e-2, 1.24266094738807843860e-3,
                                     2.71155556874348757815e-5, 2.01033439929228813265e-7};
constexpr Coefficients far_denominator{1.0,
                                       5.99832206555887937690e-1,
                                       1.36929880922735805310e-1,
                                       1.48753612908506148525e-2,
                                       7.86869131145613259100e-4,
                                       1.84631831751005468180e-5,
                                       1.42151175831644588870e-7,
                                       2.04426310338993978564e-15};

}  // namespace

std::array<std::uint32_t, 4> philox4x32(std::array<std::uint32_t, 4> counter,
                                        std::array<std::uint32_t, 2> key) noexcept {
  constexpr std::uint64_t multiplier0 = 0xD2511F53, multiplier1 = 0xCD9E8D57;
  constexpr std::uint32_t weyl0 = 0x9E3779B9, weyl1 = 0xBB67AE85;  // golden ratio, sqrt(3) - 1
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t product0 = multiplier0 * counter[0];
    const std::uint64_t product1 = multiplier1 * counter[2];
    counter = {high_word(product1) ^ counter[1] ^ key[0], low_word(product1), high_word(product0) ^ counter[3] ^ key[1],
               low_word(product0)};
    key[0] += weyl0;
    key[1] += weyl1;
  }
  return counter;
}

double inverse_normal(double p) noexcept {
  const double q = p - 0.5;
  if (std::abs(q) <= 0.425) return q * rational(center_numerator, center_denominator, 0.180625 - q * q);
  const double r = std::sqrt(-log(q < 0.0 ? p : 1.0 - p));
  const double z = r <= 5.0 ? rational(near_numerator, near_denominator, r - 1.6)
                            : rational(far_numerator, far_denominator, r - 5.0);
  return q < 0.0 ? -z : z;
}

Random::Random(std::uint64_t seed, Stream stream, std::uint64_t item) noexcept
    : key_{low_word(seed), high_word(seed)}, stream_(static_cast<std::uint32_t>(stream)), item_(item) {}

std::array<std::uint64_t, 2> Random::block(std::uint64_t number) const noexcept {
  // The stream fills 8 bits, so the block's number has 56.
  const auto words =
      philox4x32({low_word(number), low_word(item_), high_word(item_), stream_ | high_word(number) << 8}, key_);
  return {words[0] | std::uint64_t{words[1]} << 32, words[2] | std::uint64_t{words[3]} << 32};
}

std::uint64_t Random::bits(std::uint64_t index) const noexcept {
  return block(index / 2)[index % 2];
}

double Random::uniform(std::uint64_t index) const noexcept {
  return to_unit_interval(bits(index));
}

double Random::uniform(std::uint64_t index, double low, double high) const noexcept {
  return low + (high - low) * uniform(index);
}

double Random::normal(std::uint64_t index) const noexcept {
  return inverse_normal(uniform(index));
}

void Random::fill_normal(std::span<double> values, std::uint64_t first) const noexcept {
  std::size_t i = 0;
  if (first % 2 == 1 && !values.empty()) values[i++] = normal(first);
  for (; i + 1 < values.size(); i += 2) {
    const auto [even, odd] = block((first + i) / 2);
    values[i] = inverse_normal(to_unit_interval(even));
    values[i + 1] = inverse_normal(to_unit_interval(odd));
  }
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
