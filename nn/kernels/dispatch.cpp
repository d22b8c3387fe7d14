// The kernels of an instruction set: see base/isa.hpp for the choice.
#include <type_traits>

#include "base/kernels/table_for.hpp"
#include "nn/kernels/isa.hpp"

namespace decid::nn {

template <class T>
const Kernels<T>& kernels() {
  if constexpr (std::is_same_v<T, float>) {
    static const Kernels<float>& chosen = kernels_for(chosen_isa());
    return chosen;
  } else {
    return reference_kernels<T>();
  }
}

template const Kernels<float>& kernels();
template const Kernels<double>& kernels();

const Kernels<float>& kernels_for(Isa isa) {
  return table_for<FloatTables>(isa);
}

}  // namespace decid::nn
