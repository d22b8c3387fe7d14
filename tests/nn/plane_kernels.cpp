// Every instruction set's elementwise kernels, pools and sums over planes against the plain definitions, NaN,
// infinities and zeros of both signs included; activation and pool in one against one after the other.
#include <bit>
#include <cmath>
#include <limits>

#include "tests/nn/kernel_checks.hpp"

using namespace decid;
using namespace decid::nn;
using namespace decid::nn::testing;

namespace {

/// Equal, or both NaN: which NaN comes out of two differs between processors.
bool same_values(const std::vector<float>& a, const std::vector<float>& b) {
  for (std::size_t i = 0; i < a.size(); ++i)
    if (std::bit_cast<std::uint32_t>(a[i]) != std::bit_cast<std::uint32_t>(b[i]) &&
        !(std::isnan(a[i]) && std::isnan(b[i])))
      return false;
  return true;
}

/// The plane of one block into another's, of the same shape.
void copy(const Block& from, const Block& to) {
  const Plane<float> src = from.plane(), dst = to.plane();
  for (int i = 0; i < src.rows; ++i)
    for (int j = 0; j < src.columns * lanes; ++j) dst.data[i * dst.row + j] = src.data[i * src.row + j];
}

}  // namespace

TEST_CASE("batch normalisation, ReLU") {
  Dice dice(700);
  for (const Shape shape : {Shape{1, 1, 1}, Shape{1, 13, 13}, Shape{1, 6, 1}, Shape{1, 4, 27}, Shape{1, 31, 110}})
    for (int repeat = 0; repeat < 4; ++repeat) {
      const Block x(shape, some_halo({}, 2, dice), dice, Fill::values),
          dy(shape, some_halo({}, 2, dice), dice, Fill::values);
      check_all("sums", [&](const Kernels<float>& k) {
        std::vector<double> sums(4 * lanes, 0.125);  // added to, not overwritten
        k.batchnorm_sums(x.const_plane(), 0.37F, sums.data());
        k.batchnorm_backward_sums(x.const_plane(), dy.const_plane(), -0.21F, sums.data() + 2 * lanes);
        return sums;
      });
      check_all("apply", [&](const Kernels<float>& k) {
        const Block y(shape, Halo{1, 1}, dice, Fill::nothing), dx(shape, Halo{1, 1}, dice, Fill::nothing);
        k.activation_forward({1.3F, -0.4F, false, Pooling::none}, {}, x.const_plane(), y.plane());
        k.batchnorm_backward_apply(x.const_plane(), dy.const_plane(), 0.9F, -0.1F, 0.03F, dx.plane());
        std::vector<float> all = y.memory;
        all.insert(all.end(), dx.memory.begin(), dx.memory.end());
        return all;
      });
      check_all("relu", [&](const Kernels<float>& k) {
        Block y = x, dx = dy;
        Plane<float> value = y.plane(), diff = dx.plane();
        value.data = y.memory.data() + (x.plane().data - x.memory.data());
        diff.data = dx.memory.data() + (dy.plane().data - dy.memory.data());
        k.relu_forward(value);
        k.relu_backward({value.data, value.row, value.rows, value.columns}, diff);
        y.memory.insert(y.memory.end(), dx.memory.begin(), dx.memory.end());
        return y.memory;
      });
    }
}

TEST_CASE("statistics pooling") {
  Dice dice(850);
  for (int trial = 0; trial < 20; ++trial) {
    const Shape shape{1, dice.between(1, 14), dice.between(1, 9)};
    const Block x(shape, Halo{trial % 3, trial % 2}, dice, Fill::values), y({4, 1, 1}, Halo{}, dice, Fill::values);
    const Plane<const float> source = x.const_plane();
    INFO(shape.rows << "x" << shape.columns);
    check_all("forward", [&](const Kernels<float>& k) {
      std::vector<float> out(2 * lanes);
      k.statistics_pool_forward(source, 1e-5F, out.data(), out.data() + lanes);
      return out;
    });
    check_all("backward", [&](const Kernels<float>& k) {
      const Block diff(shape, Halo{1, 1}, dice, Fill::nothing);
      std::vector<float> stddev(lanes, 0.75F);
      k.statistics_pool_backward(source, y.tensor.row(0, 0, 0), stddev.data(), y.tensor.row(0, 2, 0),
                                 y.tensor.row(0, 3, 0), diff.plane());
      return diff.memory;
    });
  }
}

TEST_CASE("elementwise kernels and NaN, infinity, zero, subnormal") {
  constexpr float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  const std::vector<float> special = {0.0F, -0.0F, inf, -inf, nan, 1e-40F, -1e-40F, 1.0F, -1.0F, 3e38F, -3e38F, 1e-45F};
  std::vector<float> a(12 * 12 * lanes), b(a.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    a[i] = special[i % 12];
    b[i] = special[i / 12 % 12];
  }
  const auto run = [&](const Kernels<float>& k) {
    std::vector<float> out;
    const auto keep = [&](const std::vector<float>& v) { out.insert(out.end(), v.begin(), v.end()); };
    const auto plane = [](auto& v) { return Plane<float>{v.data(), 12 * lanes, 12, 12}; };
    const auto input = [](const auto& v) { return Plane<const float>{v.data(), 12 * lanes, 12, 12}; };
    std::vector<float> y = a;
    k.relu_forward(plane(y));
    keep(y);
    y = b;
    k.relu_backward(input(a), plane(y));
    keep(y);
    k.activation_forward({-2.0F, 1.0F, true, Pooling::none}, {}, input(a), plane(y));
    keep(y);
    y = b;
    k.batchnorm_backward_apply(input(a), input(y), 0.5F, -3.0F, 1e-40F, plane(y));  // in place
    keep(y);
    const PoolShape pool{1, 12, 12, 5, 6, 3, 2, 2, 2};
    const BlockView<const float> source{a.data(), 0, 12 * lanes}, diff{b.data(), 0, 6 * lanes};
    y.assign(a.size(), -77.0F);
    k.max_pool_forward(pool, source, {y.data(), 0, 6 * lanes});
    keep(y);
    k.max_pool_backward(pool, source, diff, {y.data(), 0, 12 * lanes});
    keep(y);
    return out;
  };
  const std::vector<float> expected = run(reference_kernels<float>());
  for (const Kernels<float>* table : fast_tables()) {
    INFO(table->name);
    CHECK(same_values(run(*table), expected));
  }
}

TEST_CASE("pooling") {
  Dice dice(900);
  for (int trial = 0; trial < 40; ++trial) {
    const bool usual = trial % 4 == 0;
    const int kr = usual ? 2 : dice.between(1, 5), kc = usual ? 2 : dice.between(1, 5);
    const int sr = usual ? 2 : dice.between(1, 6), sc = usual ? 2 : dice.between(1, 6);
    const int rows = dice.between(kr, 14), columns = dice.between(kc, 14), channels = dice.between(1, 3);
    const PoolShape s{channels, rows, columns, (rows - kr) / sr + 1, (columns - kc) / sc + 1, kr, kc, sr, sc};
    // Few different values: ties for the largest, and both zeros.
    Block x({channels, rows, columns}, Halo{trial % 3, trial % 2}, dice, Fill::values);
    for (float& v : x.memory) v = std::trunc(v * 3);
    const Block dy({channels, s.dst_rows, s.dst_columns}, Halo{trial % 2, trial % 3}, dice, Fill::values);
    INFO("window " << kr << "x" << kc << " stride " << sr << "x" << sc << " of " << rows << "x" << columns);
    check_all("forward", [&](const Kernels<float>& k) {
      const Block mean(dy.tensor.shape(), Halo{1, 1}, dice, Fill::nothing),
          max(dy.tensor.shape(), Halo{}, dice, Fill::nothing);
      k.average_pool_forward(s, x.const_view(), mean.view());
      k.max_pool_forward(s, x.const_view(), max.view());
      std::vector<float> all = mean.memory;
      all.insert(all.end(), max.memory.begin(), max.memory.end());
      return all;
    });
    check_all("backward", [&](const Kernels<float>& k) {
      const Block mean(x.tensor.shape(), Halo{1, 1}, dice, Fill::nothing),
          max(x.tensor.shape(), Halo{2, 1}, dice, Fill::nothing);
      k.average_pool_backward(s, dy.const_view(), mean.view());
      k.max_pool_backward(s, x.const_view(), dy.const_view(), max.view());
      std::vector<float> all = mean.memory;
      all.insert(all.end(), max.memory.begin(), max.memory.end());
      return all;
    });
  }
}

TEST_CASE("a NaN in any place of a window is the maximum, alone and behind an activation") {
  Dice dice(925);
  constexpr float inf = std::numeric_limits<float>::infinity(), nan = std::numeric_limits<float>::quiet_NaN();
  for (const auto& window : {std::pair{2, 2}, {1, 2}, {3, 3}, {4, 1}}) {
    const int kr = window.first, kc = window.second;         // clang 14 captures no structured bindings
    const PoolShape s{1, kr, 2 * kc, 1, 2, kr, kc, kr, kc};  // two windows: with and without a NaN
    for (int place = 0; place < kr * kc; ++place)
      for (const float beside : {-1.0F, 0.0F, 2.0F, inf, -inf}) {
        const int lane = dice.between(0, lanes - 1);
        Block x({1, kr, 2 * kc}, Halo{}, dice, Fill::values);
        for (int i = 0; i < kr * kc; ++i) x.tensor.at(lane, 0, i / kc, i % kc) = beside;
        x.tensor.at(lane, 0, place / kc, place % kc) = nan;
        const Block dy({1, 1, 2}, Halo{}, dice, Fill::values);
        for (const Kernels<float>* table : all_tables()) {
          INFO(table->name << ", window " << kr << "x" << kc << ", place " << place << ", beside " << beside);
          const auto check = [&](const Block& y) {
            for (int n = 0; n < lanes; ++n)
              for (int j = 0; j < 2; ++j) CHECK(std::isnan(y.tensor.at(n, 0, 0, j)) == (n == lane && j == 0));
          };
          const Block y({1, 1, 2}, Halo{}, dice, Fill::nothing), dx(x.tensor.shape(), Halo{}, dice, Fill::nothing);
          table->max_pool_forward(s, x.const_view(), y.view());
          check(y);
          table->max_pool_backward(s, x.const_view(), dy.const_view(), dx.view());
          for (int i = 0; i < kr * kc; ++i)
            CHECK(dx.tensor.at(lane, 0, i / kc, i % kc) == (i == place ? dy.tensor.at(lane, 0, 0, 0) : 0.0F));
          for (const bool relu : {false, true}) {
            const Activation<float> a{1.5F, 0.25F, relu, Pooling::max};
            table->activation_forward(a, s, x.const_plane(), y.plane());
            check(y);
            table->activation_backward(a, s, x.const_plane(), dy.const_plane(), dx.plane());
            for (int i = 0; i < kr * kc; ++i)  // ReLU passes on nothing of a NaN
              CHECK(dx.tensor.at(lane, 0, i / kc, i % kc) ==
                    (i == place && !relu ? dy.tensor.at(lane, 0, 0, 0) : 0.0F));
          }
        }
      }
  }
}

TEST_CASE("activation and pool in one: the bits of scale and shift, ReLU and pool one after the other") {
  Dice dice(950);
  for (int trial = 0; trial < 60; ++trial) {
    const bool usual = trial % 3 == 0;
    const int kr = usual ? 2 : dice.between(1, 5), kc = usual ? 2 : dice.between(1, 5);
    const int rows = dice.between(kr, 14), columns = dice.between(kc, 14);
    const int sr = dice.between(kr, kr + 1), sc = dice.between(kc, kc + 1);
    const PoolShape s{1, rows, columns, (rows - kr) / sr + 1, (columns - kc) / sc + 1, kr, kc, sr, sc};
    Block x({1, rows, columns}, Halo{trial % 3, trial % 2}, dice, Fill::values);
    for (float& v : x.memory) v = std::trunc(v * 3);
    const Block dy({1, s.dst_rows, s.dst_columns}, Halo{trial % 2, trial % 3}, dice, Fill::values);
    const Block whole_dy({1, rows, columns}, Halo{trial % 2, trial % 3}, dice, Fill::values);
    for (const Pooling pooling : {Pooling::none, Pooling::average, Pooling::max})
      for (const bool relu : {false, true}) {
        const Activation<float> a{-1.5F, 0.75F, relu, pooling};
        const Kernels<float>& plain = reference_kernels<float>();
        const Block& diff_dst = pooling == Pooling::none ? whole_dy : dy;

        // One after the other.
        Block values({1, rows, columns}, Halo{}, dice, Fill::nothing);
        plain.activation_forward({a.scale, a.shift, false, Pooling::none}, {}, x.const_plane(), values.plane());
        for (std::size_t i = 0; i < values.memory.size(); ++i) {
          const float v = x.plane().data[static_cast<std::ptrdiff_t>(i) / (columns * lanes) * x.plane().row +
                                         static_cast<std::ptrdiff_t>(i) % (columns * lanes)];
          REQUIRE(values.memory[i] == std::fma(v, a.scale, a.shift));
        }
        if (relu) plain.relu_forward(values.plane());
        const Block pooled(diff_dst.tensor.shape(), Halo{}, dice, Fill::nothing);
        const Block diff({1, rows, columns}, Halo{}, dice, Fill::nothing);
        if (pooling == Pooling::none) {
          copy(values, pooled);
          copy(diff_dst, diff);
        } else if (pooling == Pooling::average) {
          plain.average_pool_forward(s, values.const_view(), pooled.view());
          plain.average_pool_backward(s, diff_dst.const_view(), diff.view());
        } else {
          plain.max_pool_forward(s, values.const_view(), pooled.view());
          plain.max_pool_backward(s, values.const_view(), diff_dst.const_view(), diff.view());
        }
        if (relu) plain.relu_backward(values.const_plane(), diff.plane());

        for (const Kernels<float>* table : all_tables()) {
          INFO(table->name << ", pooling " << static_cast<int>(pooling) << ", relu " << relu << ", window " << kr << "x"
                           << kc);
          const Block y(diff_dst.tensor.shape(), Halo{}, dice, Fill::nothing),
              dx({1, rows, columns}, Halo{}, dice, Fill::nothing);
          table->activation_forward(a, s, x.const_plane(), y.plane());
          table->activation_backward(a, s, x.const_plane(), diff_dst.const_plane(), dx.plane());
          CHECK(same_bits(y.memory, pooled.memory));
          CHECK(same_bits(dx.memory, diff.memory));
        }
      }
  }
}

TEST_CASE("tanh, sigmoid and GELU have the bits of the scalar formulas") {
  std::vector<float> values;
  const float infinity = std::numeric_limits<float>::infinity();
  for (const float special : {0.0F, 1e-45F, 1e-38F, 0.46875F, 4.0F, 5.6568542F, 0.66291261F, 20.0F, 26.5F, 37.4766594F,
                              349.99997F, 350.0F, 700.0F, 1e30F, std::numeric_limits<float>::max(), infinity})
    for (const float sign : {1.0F, -1.0F})
      for (const float to : {0.0F, infinity}) {
        values.push_back(sign * special);
        values.push_back(std::nextafter(sign * special, to));
      }
  values.push_back(std::numeric_limits<float>::quiet_NaN());
  for (int i = -40000; i <= 40000; ++i) values.push_back(static_cast<float>(i) * 0.001F);
  Dice dice(910);
  while (values.size() < 250000 || values.size() % (3 * lanes) != 0)  // of any size, also without a meaning
    values.push_back(std::bit_cast<float>(static_cast<std::uint32_t>(dice.bits())));
  const int columns = static_cast<int>(values.size()) / (3 * lanes);
  const Plane<const float> src{values.data(), columns * lanes, 3, columns};
  const auto outputs = [&](const Kernels<float>& k, const auto& run) {
    std::vector<float> out(values.size(), -77.0F);
    run(k, Plane<float>{out.data(), src.row, src.rows, src.columns});
    return out;
  };
  const auto check_same = [&](const auto& run) {
    const std::vector<float> plain = outputs(reference_kernels<float>(), run);
    for (const Kernels<float>* table : fast_tables()) {
      CAPTURE(table->name);
      CHECK(same_values(outputs(*table, run), plain));
    }
  };
  for (const Sigmoid kind : {Sigmoid::tanh, Sigmoid::logistic, Sigmoid::gelu})
    check_same([&](const Kernels<float>& k, Plane<float> dst) { k.sigmoid_forward(kind, src, dst); });
  const std::vector<float> slopes = random_values(values.size(), dice, 2);
  const Plane<const float> diff{slopes.data(), src.row, src.rows, src.columns};
  check_same([&](const Kernels<float>& k, Plane<float> dst) { k.gelu_backward(src, diff, dst); });
}
