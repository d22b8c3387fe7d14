// The kernels of an instruction set: see base/isa.hpp for the choice.
#include <type_traits>

#include "nn/kernels/isa.hpp"

namespace decid::nn {

template <class T>
const Kernels<T>& kernels() {
  if constexpr (std::is_same_v<T, float>) {
    static const Kernels<float>& chosen = kernels_of(chosen_isa());
    return chosen;
  } else {
    return reference_kernels<T>();
  }
}

template const Kernels<float>& kernels();
template const Kernels<double>& kernels();

const Kernels<float>& kernels_of(Isa isa) {
  switch (isa) {
#if defined(__x86_64__)
    case Isa::baseline:
      return baseline_kernels();
    case Isa::avx2:
      return avx2_kernels();
    case Isa::avx512:
      return avx512_kernels();
#elif defined(__aarch64__)
    case Isa::neon:
      return neon_kernels();
#endif
    default:
      return reference_kernels<float>();
  }
}

}  // namespace decid::nn
