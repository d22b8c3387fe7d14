// The kernels of random numbers, one table per instruction set. All compute the same bits.
#pragma once

#include <cstdint>

#include "base/isa.hpp"

namespace decid {

/// The position in a stream of random numbers: the key and the counter of Philox, see random.cpp.
struct NormalsRequest {
  std::uint32_t key[2];
  std::uint32_t stream;
  std::uint64_t item;
  std::uint64_t first_block;  ///< below 2^56
};

struct RandomKernels {
  /// Computes out[2 i] and out[2 i + 1], the normal deviates of block first_block + i.
  void (*normals)(const NormalsRequest& request, std::int64_t blocks, double* out);
};

const RandomKernels& random_kernels(Isa isa);

/// Gives table_for access to the tables.
struct RandomTables {
  static const RandomKernels& reference();
  static const RandomKernels& baseline();
  static const RandomKernels& avx2();
  static const RandomKernels& avx512();
  static const RandomKernels& neon();
  static const RandomKernels& wasm();
  static const RandomKernels& relaxed();
};

}  // namespace decid
