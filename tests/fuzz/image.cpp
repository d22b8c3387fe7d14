// Settings of images as JSON, of experiments of some lengths; those that are accepted can be written and read back.
#include "dataset/image/image.hpp"

#include "sim/protocol/protocol.hpp"
#include "tests/fuzz/fuzz.hpp"

using namespace decid;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const sim::Protocol protocol = sim::short_protocol();
  fuzz::accepts([&] {
    const auto settings = dataset::image_settings_from_json(std::string(fuzz::to_text(data, size)), "image");
    REQUIRE_THAT(dataset::image_settings_from_json(dataset::to_json(settings), "written") == settings);
    const dataset::ImageMaker images(settings, protocol.experiment);
    std::vector<float> image(static_cast<std::size_t>(images.shape().size()));
    const std::vector<float> sway(static_cast<std::size_t>(protocol.samples()), 0.01F);
    images.make(sway, image);
  });
  return 0;
}
