// Model files and checkpoints, as they are and with the hash of their content set right. One that is read can be
// written, and then has the same bytes whenever it is read and written again.
#include "identify/network/model.hpp"

#include "identify/training/checkpoint.hpp"
#include "nn/safetensors.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace decid;

namespace {

void read(std::string_view bytes) {
  fuzz::accepts([&] {
    const std::string once = to_bytes(model_from_bytes(bytes, "model"));
    REQUIRE_THAT(to_bytes(model_from_bytes(once, "model")) == once);
  });
  fuzz::accepts([&] {
    Checkpoint checkpoint;
    model_from_bytes(bytes, "checkpoint", &checkpoint);
  });
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string_view bytes = fuzz::to_text(data, size);
  read(bytes);
  fuzz::accepts([&] {
    nn::TensorFile file = nn::from_safetensors(bytes, "tensors");
    file.metadata[nn::content_hash_key] = nn::content_sha256(file);
    read(nn::to_safetensors(file));
  });
  return 0;
}
