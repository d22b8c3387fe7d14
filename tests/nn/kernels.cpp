// Every instruction set's convolutions, fully connected layers and optimiser against the plain definitions, over many
// geometries; the emulated fused multiply-add against the C library's; the choice of kernels by name.
#include "nn/kernels/kernels.hpp"

#include <doctest/doctest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <sstream>

#include "base/error.hpp"
#include "nn/kernels/isa.hpp"
#include "nn/kernels/vec.hpp"
#include "tests/nn/kernel_checks.hpp"

using namespace decid;
using namespace decid::nn;
using namespace decid::nn::testing;

namespace {

std::string text(const Conv2dShape& s) {
  std::ostringstream out;
  out << s.src_channels << "-" << s.dst_channels << " @ " << s.src_rows << "x" << s.src_columns << ", kernel "
      << s.kernel_rows << "x" << s.kernel_columns << ", stride " << s.stride_rows << "x" << s.stride_columns << ", pad "
      << s.pad_rows << "x" << s.pad_columns;
  return out.str();
}

struct Pair {
  int rows, columns;
};

Conv2dShape conv_shape(int src_channels, int dst_channels, Pair size, Pair kernel, Pair stride, Pair pad) {
  return {src_channels,
          size.rows,
          size.columns,
          dst_channels,
          (size.rows + 2 * pad.rows - kernel.rows) / stride.rows + 1,
          (size.columns + 2 * pad.columns - kernel.columns) / stride.columns + 1,
          kernel.rows,
          kernel.columns,
          stride.rows,
          stride.columns,
          pad.rows,
          pad.columns};
}

/// All three directions of one convolution, over all channels in one call and in uneven groups. scale: of the values;
/// small ones make subnormal sums.
void check_conv(const Conv2dShape& s, std::uint64_t seed, float scale = 1) {
  Dice dice(seed);
  const int valid = dice.between(1, lanes);
  const Block src({s.src_channels, s.src_rows, s.src_columns}, some_halo(src_halo(s), 2, dice), dice, Fill::values,
                  scale);
  const Block diff_dst({s.dst_channels, s.dst_rows, s.dst_columns}, some_halo(diff_halo(s), 2, dice), dice,
                       Fill::values, scale);
  const auto weights = static_cast<std::size_t>(s.dst_channels * s.src_channels * s.kernel_rows * s.kernel_columns);
  const std::vector<float> weight = random_values(weights, dice, scale);
  const std::vector<float> bias = random_values(static_cast<std::size_t>(s.dst_channels), dice, scale * scale);
  Block spoiled_src = src, spoiled_diff = diff_dst;
  spoiled_src.tensor = TensorView<float>(spoiled_src.memory.data(), src.tensor.shape(), lanes, src.tensor.halo());
  spoiled_diff.tensor =
      TensorView<float>(spoiled_diff.memory.data(), diff_dst.tensor.shape(), lanes, diff_dst.tensor.halo());
  spoiled_src.spoil_lanes(valid);
  spoiled_diff.spoil_lanes(valid);
  const Halo dst_halo = some_halo({}, 3, dice), own_halo = some_halo({}, 3, dice);

  check_all("forward " + text(s), [&](const Kernels<float>& k) {
    const Block dst({s.dst_channels, s.dst_rows, s.dst_columns}, dst_halo, dice, Fill::nothing);
    const int split = &k == &reference_kernels<float>() ? 0 : s.dst_channels / 3;
    k.conv2d_forward(s, src.const_view(), weight.data(), bias.data(), dst.view(), 0, split);
    k.conv2d_forward(s, src.const_view(), weight.data(), bias.data(), dst.view(), split, s.dst_channels);
    return dst.memory;
  });
  check_all("backward src " + text(s), [&](const Kernels<float>& k) {
    const Block diff_src({s.src_channels, s.src_rows, s.src_columns}, own_halo, dice, Fill::nothing);
    const int split = &k == &reference_kernels<float>() ? 0 : s.src_channels / 2;
    k.conv2d_backward_src(s, diff_dst.const_view(), weight.data(), diff_src.view(), 0, split);
    k.conv2d_backward_src(s, diff_dst.const_view(), weight.data(), diff_src.view(), split, s.src_channels);
    return diff_src.memory;
  });
  check_all("backward weight " + text(s), [&](const Kernels<float>& k) {
    std::vector<float> gradient(weights + bias.size(), -77.0F);
    const int split = &k == &reference_kernels<float>() ? 0 : s.dst_channels / 3;
    const Block& x = &k == &reference_kernels<float>() || valid == lanes ? src : spoiled_src;
    const Block& dy = &k == &reference_kernels<float>() || valid == lanes ? diff_dst : spoiled_diff;
    for (const auto& [first, last] : {Pair{0, split}, Pair{split, s.dst_channels}})
      k.conv2d_backward_weight(s, x.const_view(), dy.const_view(), valid, gradient.data(), gradient.data() + weights,
                               first, last);
    return gradient;
  });

  // A band of rows at a time: rows of the same bits.
  const int rows = dice.between(1, s.dst_rows);
  const auto for_each_band = [&](const auto& body) {
    for (int row = 0; row < s.dst_rows; row += rows) {
      BlockView<const float> band = src.const_view();
      band.data += (row * s.stride_rows - s.pad_rows) * band.row;
      body(make_band(s, std::min(rows, s.dst_rows - row)), band, row);
    }
  };
  for (const Kernels<float>* table : all_tables()) {
    INFO(text(s) << " in bands of " << rows << " on " << table->name);
    const Block whole({s.dst_channels, s.dst_rows, s.dst_columns}, dst_halo, dice, Fill::nothing), bands = whole;
    table->conv2d_forward(s, src.const_view(), weight.data(), bias.data(), whole.view(), 0, s.dst_channels);
    BlockView<float> dst = whole.view();
    dst.data = const_cast<float*>(bands.memory.data()) + (dst.data - whole.memory.data());
    for_each_band([&](const Conv2dShape& band, BlockView<const float> x, int row) {
      const BlockView<float> y{dst.data + row * dst.row, dst.channel, dst.row};
      table->conv2d_forward(band, x, weight.data(), bias.data(), y, 0, s.dst_channels);
    });
    CHECK(same_bits(bands.memory, whole.memory));
  }
}

}  // namespace

TEST_CASE("convolutions: chosen geometries") {
  check_conv(conv_shape(3, 5, {13, 13}, {3, 3}, {1, 1}, {1, 1}), 1);
  check_conv(conv_shape(2, 16, {14, 14}, {3, 3}, {1, 1}, {1, 1}), 2);
  check_conv(conv_shape(17, 17, {6, 7}, {3, 3}, {1, 1}, {1, 1}), 3);
  check_conv(conv_shape(33, 2, {5, 4}, {3, 3}, {1, 1}, {1, 1}), 4);   // several blocks of taps
  check_conv(conv_shape(2, 33, {4, 31}, {3, 3}, {2, 2}, {1, 1}), 5);  // several groups of channels
  check_conv(conv_shape(7, 3, {11, 9}, {5, 5}, {2, 2}, {2, 2}), 6);
  check_conv(conv_shape(2, 3, {15, 12}, {11, 3}, {2, 1}, {5, 1}), 7);
  check_conv(conv_shape(3, 2, {9, 8}, {5, 1}, {1, 3}, {4, 0}), 8);
  check_conv(conv_shape(3, 4, {7, 8}, {1, 1}, {3, 2}, {0, 0}), 9);  // positions no tap reaches
  check_conv(conv_shape(1, 1, {1, 1}, {1, 1}, {1, 1}, {0, 0}), 10);
  check_conv(conv_shape(2, 5, {1, 1}, {3, 3}, {3, 1}, {1, 2}), 11);
  check_conv(conv_shape(1, 2, {20, 20}, {17, 19}, {1, 2}, {16, 3}), 12);  // one channel's taps exceed a block
  check_conv(conv_shape(1, 1, {3, 150}, {2, 2}, {1, 1}, {0, 1}), 13);     // rows longer than a block of positions
}

TEST_CASE("convolutions: one column, whose rows lie side by side or not") {
  for (std::uint64_t seed = 0; seed < 8; ++seed) {
    check_conv(conv_shape(3, 6, {41, 1}, {15, 1}, {2, 1}, {7, 0}), 400 + seed);
    check_conv(conv_shape(17, 5, {20, 1}, {5, 1}, {3, 2}, {2, 0}), 420 + seed);
    check_conv(conv_shape(2, 4, {9, 1}, {4, 3}, {1, 1}, {0, 1}), 440 + seed);
  }
}

// Sanitizers see the same loops in fewer of them; a release build has all.
#ifdef DECID_SANITIZED
constexpr std::uint64_t random_geometries = 24;
#else
constexpr std::uint64_t random_geometries = 90;
#endif

TEST_CASE("convolutions: random geometries") {
  Dice dice(20260101);
  constexpr int channels[] = {1, 2, 3, 5, 7, 16, 17};
  for (std::uint64_t trial = 0; trial < random_geometries; ++trial) {
    Conv2dShape s{};
    long long work = 0;
    do {
      const Pair kernel{dice.between(1, trial % 3 == 0 ? 11 : 5), dice.between(1, trial % 3 == 0 ? 11 : 5)};
      const Pair pad{dice.between(0, kernel.rows - 1), dice.between(0, kernel.columns - 1)};
      const Pair size{dice.between(1, 20), dice.between(1, 20)};
      s = conv_shape(channels[dice.between(0, 6)], channels[dice.between(0, 6)], size, kernel,
                     {dice.between(1, 3), dice.between(1, 3)}, pad);
      work = static_cast<long long>(s.src_channels) * s.dst_channels * s.src_rows * s.src_columns * kernel.rows *
             kernel.columns;
      if (size.rows + 2 * pad.rows < kernel.rows || size.columns + 2 * pad.columns < kernel.columns) work = 0;
    } while (work == 0 || work > 150000);
    check_conv(s, trial + 100);
  }
}

// Kernels take 256 or 1152 taps at once.
TEST_CASE("convolutions: blocks of taps that are full") {
  check_conv(conv_shape(2, 3, {16, 17}, {16, 16}, {1, 1}, {0, 0}), 41);
  check_conv(conv_shape(1, 2, {34, 34}, {34, 34}, {1, 1}, {0, 0}), 42);
}

TEST_CASE("convolutions: subnormal sums") {
  check_conv(conv_shape(4, 5, {7, 7}, {3, 3}, {1, 1}, {1, 1}), 31, 3e-21F);
  check_conv(conv_shape(4, 5, {7, 7}, {3, 3}, {2, 1}, {1, 1}), 32, 1e-22F);
}

TEST_CASE("fully connected") {
  struct Case {
    Shape shape;
    int outputs;
  };
  for (const Case& layer : {Case{{3, 5, 6}, 7}, {{1, 1, 1}, 1}, {{17, 3, 9}, 21}, {{128, 1, 1}, 7}, {{2, 4, 1}, 8}}) {
    const Shape shape = layer.shape;
    const int outputs = layer.outputs;
    Dice dice(static_cast<std::uint64_t>(outputs) + 500);
    const int valid = dice.between(1, lanes);
    const auto values = static_cast<std::size_t>(shape.size()), count = static_cast<std::size_t>(outputs);
    const Block src(shape, some_halo({}, 2, dice), dice, Fill::values);
    const std::vector<float> weight = random_values(values * count, dice), bias = random_values(count, dice),
                             diff = random_values(count * lanes, dice);
    const int split = outputs / 3;
    check_all("forward", [&](const Kernels<float>& k) {
      std::vector<float> dst(count * lanes);
      k.fully_connected_forward(shape, src.const_view(), weight.data(), bias.data(), dst.data(), 0, split);
      k.fully_connected_forward(shape, src.const_view(), weight.data(), bias.data(), dst.data(), split, outputs);
      return dst;
    });
    check_all("backward src", [&](const Kernels<float>& k) {
      const Block diff_src(shape, Halo{1, 1}, dice, Fill::nothing);
      k.fully_connected_backward_src(shape, outputs, diff.data(), weight.data(), diff_src.view(), 0,
                                     shape.channels / 2);
      k.fully_connected_backward_src(shape, outputs, diff.data(), weight.data(), diff_src.view(), shape.channels / 2,
                                     shape.channels);
      return diff_src.memory;
    });
    check_all("backward weight", [&](const Kernels<float>& k) {
      std::vector<float> gradient((values + 1) * count, -77.0F);
      for (const auto& [first, last] : {Pair{0, split}, Pair{split, outputs}})
        k.fully_connected_backward_weight(shape, src.const_view(), diff.data(), valid, gradient.data(),
                                          gradient.data() + values * count, first, last);
      return gradient;
    });
  }
}

TEST_CASE("optimiser's step of any length") {
  for (const std::size_t count : {0U, 1U, 3U, 4U, 15U, 16U, 17U, 100U, 1001U}) {
    Dice dice(count);
    const std::vector<float> gradient = random_values(count, dice), velocity = random_values(count, dice),
                             value = random_values(count, dice);
    check_all("sgd", [&](const Kernels<float>& k) {
      std::vector<float> v = velocity, p = value;
      k.sgd_step(count, 0.1F, 0.9F, 1e-4F, gradient.data(), v.data(), p.data());
      v.insert(v.end(), p.begin(), p.end());
      return v;
    });
  }
}

#if defined(__x86_64__) || defined(__wasm__)
TEST_CASE("emulated fused multiply-add of the baseline") {
  Dice dice(1100);
  const auto any = [&] { return std::bit_cast<float>(static_cast<std::uint32_t>(dice.bits())); };
  long long wrong = 0;
  for (int trial = 0; trial < 500000; ++trial) {
    float a[4], b[4], c[4], result[4];
    for (int l = 0; l < 4; ++l) {
      a[l] = any();
      b[l] = any();
      c[l] = any();
      const float product = a[l] * b[l];
      switch (trial % 8) {
        case 1:  // cancellation to a few bits, or to zero
          c[l] = -product;
          break;
        case 2:  // near half a unit in the last place of c: the ties that double rounding gets wrong
          a[l] = 1.0F + std::ldexp(static_cast<float>(dice.between(0, 3)), -23);
          b[l] = std::ldexp(1.0F, -24) + std::ldexp(static_cast<float>(dice.between(-2, 2)), -47);
          c[l] = static_cast<float>(dice.between(-1, 1)) + std::ldexp(static_cast<float>(dice.between(0, 7)), -23);
          break;
        case 3:  // subnormal results, ties among them
          a[l] = std::ldexp(static_cast<float>(dice.between(-9, 9)), -75);
          b[l] = std::ldexp(static_cast<float>(dice.between(-9, 9)), -76);
          c[l] = std::ldexp(static_cast<float>(dice.between(-9, 9)), -149);
          break;
        case 4:  // everyday values
          a[l] = dice.value();
          b[l] = dice.value();
          c[l] = dice.value();
          break;
        case 5:  // products far below c
          a[l] = std::ldexp(dice.value(), -70);
          b[l] = std::ldexp(dice.value(), -70);
          c[l] = std::ldexp(static_cast<float>(dice.between(-9, 9)), -149 + dice.between(0, 30));
          break;
        default:
          break;
      }
    }
    Vec::store(result, Vec::fma(Vec::load(a), Vec::load(b), Vec::load(c)));
    for (int l = 0; l < 4; ++l) {
      const float expected = std::fma(a[l], b[l], c[l]);
      const bool same = std::isnan(expected)
                            ? std::isnan(result[l])
                            : std::bit_cast<std::uint32_t>(expected) == std::bit_cast<std::uint32_t>(result[l]);
      wrong += !same;
    }
  }
  CHECK(wrong == 0);
}
#endif

TEST_CASE("kernels of each instruction set") {
  for (const Isa isa : available_isas()) CHECK(kernels_for(isa).name == std::string(name(isa)));
  CHECK(&kernels<float>() == &kernels_for(chosen_isa()));
  CHECK(kernels<double>().name == std::string("reference"));
}
