// Random blocks of samples, and the comparison of every instruction set's kernels with the plain
// definitions, bit for bit (memcmp: signs of zero count). Rows beyond a plane and whole halos are compared too: no
// kernel may write there.
#pragma once

#include <doctest/doctest.h>

#include <cstdint>
#include <cstring>
#include <limits>
#include <string>
#include <vector>

#include "nn/kernels/kernels.hpp"

namespace decid::nn::testing {

/// SplitMix64: numbers for tests, the same everywhere.
class Dice {
 public:
  explicit Dice(std::uint64_t seed) : state_(seed) {}
  std::uint64_t bits() {
    std::uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  int between(int low, int high) { return low + static_cast<int>(bits() % static_cast<std::uint64_t>(high - low + 1)); }
  /// In (-1, 1); one in eight is a zero of either sign.
  float value() {
    const std::uint64_t b = bits();
    if (b % 8 == 0) return b & 8 ? -0.0F : 0.0F;
    return static_cast<float>(static_cast<std::int64_t>(b >> 40) - (1 << 23)) / static_cast<float>(1 << 23);
  }

 private:
  std::uint64_t state_;
};

enum class Fill { values, nothing };

/// At least `least`, and up to `most` rows and columns more.
inline Halo some_halo(Halo least, int most, Dice& dice) {
  const int rows = least.rows + dice.between(0, most);
  return {rows, least.columns + dice.between(0, most)};
}

/// A block of 16 samples in its own memory.
struct Block {
  std::vector<float> memory;
  TensorView<float> tensor;
  Block(Shape shape, Halo halo, Dice& dice, Fill fill, float scale = 1) {
    memory.assign(TensorView<float>::required(shape, lanes, halo), 0.0F);
    tensor = TensorView<float>(memory.data(), shape, lanes, halo);
    for (int c = 0; c < shape.channels; ++c)
      for (int i = 0; i < shape.rows; ++i)
        for (int k = 0; k < shape.columns * lanes; ++k)
          tensor.row(0, c, i)[k] = fill == Fill::values ? scale * dice.value() : -77.0F;
  }
  BlockView<float> view() const { return tensor.block(0); }
  BlockView<const float> const_view() const { return view(); }
  Plane<float> plane() const { return tensor.plane(0, 0); }
  Plane<const float> const_plane() const { return plane(); }
  void spoil_lanes(int valid) {
    for (std::size_t i = 0; i < memory.size(); ++i)
      if (static_cast<int>(i % lanes) >= valid)
        memory[i] = i % 2 == 0 ? std::numeric_limits<float>::quiet_NaN() : -1e30F;
  }
};

inline std::vector<float> random_values(std::size_t count, Dice& dice, float scale = 1) {
  std::vector<float> v(count);
  for (float& x : v) x = scale * dice.value();
  return v;
}

template <class T>
bool same_bits(const std::vector<T>& a, const std::vector<T>& b) {
  return a.size() == b.size() && (a.empty() || std::memcmp(a.data(), b.data(), a.size() * sizeof(T)) == 0);
}

/// The fast tables of this machine.
inline std::vector<const Kernels<float>*> fast_tables() {
  std::vector<const Kernels<float>*> tables;
  for (const Isa isa : available_isas())
    if (isa != Isa::reference) tables.push_back(&kernels_for(isa));
  return tables;
}

inline std::vector<const Kernels<float>*> all_tables() {
  std::vector<const Kernels<float>*> tables = fast_tables();
  tables.push_back(&reference_kernels<float>());
  return tables;
}

/// Runs `run(table)`, which returns the memory that the kernels wrote, for every table: all must equal the reference's.
template <class F>
void check_all(const std::string& what, const F& run) {
  const auto expected = run(reference_kernels<float>());
  for (const Kernels<float>* table : fast_tables()) {
    INFO(what << " on " << table->name);
    CHECK(same_bits(run(*table), expected));
  }
}

}  // namespace decid::nn::testing
