// Replaces the kernels of relaxed vectors in a program for engines without them: such an engine rejects a program that
// contains one of these instructions.
#include "base/kernels/kernels.hpp"
#include "base/math/exact_fma.hpp"
#include "base/math/relaxed.hpp"
#include "dataset/image/kernels/image.hpp"
#include "nn/kernels/isa.hpp"
#include "posterior/kernels/kernels.hpp"
#include "sim/kernels/kernels.hpp"

namespace decid {

bool relaxed_fuses() {
  return false;
}
double relaxed_fma(double a, double b, double c) {
  return slow_fma(a, b, c);
}
const RandomKernels& RandomTables::relaxed() {
  return wasm();
}
const sim::SimulatorKernels& sim::SimulatorTables::relaxed() {
  return wasm();
}
const dataset::ImageKernels& dataset::ImageTables::relaxed() {
  return wasm();
}
const nn::Kernels<float>& nn::FloatTables::relaxed() {
  return wasm();
}
const posterior::Kernels& posterior::Tables::relaxed() {
  return wasm();
}

}  // namespace decid
