// Limits of the machine, measured beside each kernel in the same run: the peak of fused multiply-adds and the bandwidth
// of memory. One thread unless said otherwise, CPU time.
#pragma once

#include <omp.h>

#include <algorithm>
#include <chrono>
#include <cstddef>
#include <ctime>
#include <string>
#include <utility>
#include <vector>

#include "nn/kernels/kernels.hpp"
#include "nn/tensor.hpp"

#if defined(__x86_64__)
#include <immintrin.h>
#elif defined(__aarch64__)
#include <arm_neon.h>
#endif

namespace decid::bench {

/// CPU time of this thread: what other programs take from the core does not count.
inline double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

inline double wall_seconds() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

/// Calls step(x) `rounds` times for each independent chain, each in a register. Constant indices keep g++ from leaving
/// the array in memory.
template <class Value, class Step, std::size_t... chain>
[[gnu::always_inline]] inline void run_chains(int rounds, Value first, const Step& step,
                                              std::index_sequence<chain...>) {
  Value x[] = {(static_cast<void>(chain), first)...};
  for (int r = 0; r < rounds; ++r) (step(x[chain]), ...);
}

// Each runs `rounds` times 12 independent chains (2 ports x 4 or 5 cycles of latency need 8 or 10) and returns the
// floating-point operations. The asm keeps the compiler from seeing through the values.
#if defined(__x86_64__)
[[gnu::target("avx512f")]] inline double fma_burst_avx512(int rounds) {
  __m512 acc[12], a = _mm512_set1_ps(0.999F), b = _mm512_set1_ps(0.001F);
  for (__m512& x : acc) x = _mm512_set1_ps(1);
  for (int r = 0; r < rounds; ++r)
    for (__m512& x : acc) {
      x = _mm512_fmadd_ps(x, a, b);
      asm volatile("" : "+v"(x));
    }
  return 2.0 * 16 * 12 * rounds;
}
[[gnu::target("avx2,fma")]] inline double fma_burst_avx2(int rounds) {
  __m256 acc[12], a = _mm256_set1_ps(0.999F), b = _mm256_set1_ps(0.001F);
  for (__m256& x : acc) x = _mm256_set1_ps(1);
  for (int r = 0; r < rounds; ++r)
    for (__m256& x : acc) {
      x = _mm256_fmadd_ps(x, a, b);
      asm volatile("" : "+x"(x));
    }
  return 2.0 * 8 * 12 * rounds;
}
/// Without fused multiply-adds the peak is that of a multiplication and an addition.
inline double fma_burst_baseline(int rounds) {
  const __m128 a = _mm_set1_ps(0.999F), b = _mm_set1_ps(0.001F);
  const auto step = [&](__m128& x) {
    x = _mm_add_ps(_mm_mul_ps(x, a), b);
    asm volatile("" : "+x"(x));
  };
  run_chains(rounds, _mm_set1_ps(1), step, std::make_index_sequence<12>());
  return 2.0 * 4 * 12 * rounds;
}
#elif defined(__aarch64__)
inline double fma_burst_neon(int rounds) {
  float32x4_t acc[24], a = vdupq_n_f32(0.001F), b = vdupq_n_f32(0.5F);
  for (float32x4_t& x : acc) x = vdupq_n_f32(1);
  for (int r = 0; r < rounds; ++r)
    for (float32x4_t& x : acc) {
      x = vfmaq_f32(x, a, b);
      asm volatile("" : "+w"(x));
    }
  return 2.0 * 4 * 24 * rounds;
}
#endif

/// One burst with the instructions of a set of kernels; for the reference those that every processor has.
inline double fma_burst([[maybe_unused]] const std::string& isa, int rounds) {
#if defined(__x86_64__)
  if (isa == "avx512") return fma_burst_avx512(rounds);
  if (isa == "avx2") return fma_burst_avx2(rounds);
  return fma_burst_baseline(rounds);
#elif defined(__aarch64__)
  return fma_burst_neon(rounds);
#endif
}

/// The tenth percentile: as good as the best, except that the best is at times a jump of a virtual machine's clock.
inline double best_of(std::vector<double> values) {
  std::sort(values.begin(), values.end());
  return values.empty() ? 0 : values[values.size() / 10];
}

/// Best of the bursts so far, GFLOP/s. Call measure() between repetitions of what it is compared with, so that both
/// see the same clock frequency and the same neighbours.
class FmaPeak {
 public:
  explicit FmaPeak(std::string isa) : isa_(std::move(isa)) {}
  void measure() {
    const double start = cpu_seconds();
    const double operations = fma_burst(isa_, 200000);
    nanoseconds_a_flop_.push_back((cpu_seconds() - start) / operations * 1e9);
  }
  double best() const { return 1 / best_of(nanoseconds_a_flop_); }

 private:
  std::string isa_;
  std::vector<double> nanoseconds_a_flop_;
};

/// Peaks of all threads at once, each on its own CPU time, GFLOP/s.
class TeamPeak {
 public:
  explicit TeamPeak(int threads) : peaks_(static_cast<std::size_t>(threads), FmaPeak(nn::kernels<float>().name)) {}
  void measure() {
#pragma omp parallel num_threads(static_cast <int>(peaks_.size()))
    peaks_[static_cast<std::size_t>(omp_get_thread_num())].measure();
  }
  double best() const {
    double sum = 0;
    for (const FmaPeak& peak : peaks_) sum += peak.best();
    return sum;
  }

 private:
  std::vector<FmaPeak> peaks_;
};

/// Best of the sweeps y = y + k x so far over arrays far larger than a cache, in large pages as tensors are, GB/s. Each
/// value moves 12 bytes and no more: y is read anyway, where a triad's target is read unasked and not counted.
class Bandwidth {
 public:
  Bandwidth() {
    for (nn::AlignedBuffer<float>* buffer : {&x_, &y_}) {
      buffer->reserve(values);
      std::fill_n(buffer->data(), values, 1.0F);
    }
  }
  void measure() {
    // Four floats at a time: the build turns automatic vectorisation off, and single floats do not saturate memory.
    using Four [[gnu::vector_size(16), gnu::may_alias]] = float;
    const Four k = {3, 3, 3, 3};
    const auto* const x = reinterpret_cast<const Four*>(x_.data());
    auto* const y = reinterpret_cast<Four*>(y_.data());
    const double start = cpu_seconds();
    for (std::size_t i = 0; i < values / 4; ++i) y[i] = y[i] + k * x[i];
    asm volatile("" : : "r"(y) : "memory");
    nanoseconds_a_byte_.push_back((cpu_seconds() - start) / (12.0 * values) * 1e9);
  }
  double best() const { return 1 / best_of(nanoseconds_a_byte_); }

 private:
  static constexpr std::size_t values = 24U << 20U;  // 96 MB each
  nn::AlignedBuffer<float> x_, y_;
  std::vector<double> nanoseconds_a_byte_;
};

}  // namespace decid::bench
