// Where training takes its trials from and how they come as batches: what a trial gives depends on its number alone, a
// batch on its epoch and place, whatever the number of threads and wherever a feed begins.
#include "dataset/feed.hpp"

#include <omp.h>

#include <algorithm>
#include <numeric>
#include <set>
#include <stdexcept>

#include "base/parallel.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/tiny_protocol.hpp"

using namespace decid;
using namespace decid::dataset;
using namespace decid::test;

namespace {

sim::Protocol noisy_protocol() {
  sim::Protocol protocol = tiny_protocol();
  protocol.noise.sensor = {0.001, 0.1};
  return protocol;
}

struct Taken {
  sim::Parameters parameters;
  std::vector<float> sway;
  double height = 1.0;
  bool operator==(const Taken&) const = default;
};

/// Trial `wanted` of those that are asked for together.
Taken training_trial(const TrialSource& from, int epoch, std::vector<int> indices, std::size_t wanted = 0) {
  Taken taken;
  from.take(Part::training, epoch, indices, [&](std::size_t place, const sim::Parameters& p, const Sway& sway) {
    if (place == wanted) taken = {p, {sway.rad.begin(), sway.rad.end()}, sway.height};
  });
  return taken;
}

/// Two of its columns, four trials share the lanes.
ImageMaker two_columns(int samples, bool standardize) {
  ImageSettings settings{.window = samples / 2, .half_spectrum = true, .standardize_rows = standardize, .rows = 6};
  return {settings, samples};
}

}  // namespace

TEST_CASE("streamed trials depend on their number alone and do not repeat") {
  const auto source = stream_source(noisy_protocol(), 3, 10, 4);
  CHECK(source->trials(Part::training) == 10);
  CHECK(source->trials(Part::validation) == 4);
  const Taken first = training_trial(*source, 2, {7});
  REQUIRE(first.sway.size() == static_cast<std::size_t>(source->protocol().samples()));
  CHECK(training_trial(*source, 2, {7}) == first);
  CHECK(training_trial(*source, 2, {3, 9, 0, 7, 1, 1, 8, 2, 5}, 3) == first);
  CHECK(training_trial(*source, 3, {7}).parameters != first.parameters);
  source->take(Part::validation, 0, std::vector<int>{0},
               [&](std::size_t, const sim::Parameters& p, const Sway&) { CHECK(p != first.parameters); });
  // Another epoch length renumbers, but trial 4 + 2 * 10 + 7 stays the same.
  CHECK(training_trial(*stream_source(noisy_protocol(), 3, 27, 4), 1, {0}) == first);
  CHECK(training_trial(*stream_source(noisy_protocol(), 4, 10, 4), 2, {7}).parameters != first.parameters);
  check_error([] { stream_source(noisy_protocol(), 3, 0, 4); }, Code::setting_out_of_range, "0 training");
  check_error([] { stream_source(noisy_protocol(), 3, 10, 0); }, Code::setting_out_of_range, "0 validation");
  for (const int index : {-1, 10}) {
    const std::vector<int> wrong{index};
    check_error([&] { source->take(Part::training, 0, wrong, [](std::size_t, const auto&, const auto&) {}); },
                Code::setting_out_of_range, "0 to");
    check_error([&] { source->take(Part::validation, 0, wrong, [](std::size_t, const auto&, const auto&) {}); },
                Code::setting_out_of_range, "0 to");
  }
  // Trials that a training has not seen are the next epoch's.
  source->take(Part::unseen, 2, std::vector<int>{7}, [&](std::size_t, const sim::Parameters& p, const Sway& sway) {
    CHECK(Taken{p, {sway.rad.begin(), sway.rad.end()}} == first);
  });
}

TEST_CASE("a data set's halves are its training and its validation trials") {
  const Dataset data = generate({noisy_protocol(), 21, 0, 5});
  const auto source = stored_source(data);
  std::vector<int> halves[2];
  for (int i = 0; i < data.trials(); ++i) halves[data.split[static_cast<std::size_t>(i)]].push_back(i);
  CHECK(source->trials(Part::training) == static_cast<int>(halves[0].size()));
  CHECK(source->trials(Part::validation) == static_cast<int>(halves[1].size()));
  for (const int half : {0, 1}) {
    std::vector<int> indices(halves[half].size());
    std::iota(indices.rbegin(), indices.rend(), 0);
    std::vector<int> visits(indices.size(), 0);
    const auto take = [&](std::size_t place, const sim::Parameters& p, const Sway& sway) {
      const int trial = halves[half][static_cast<std::size_t>(indices[place])];
      ++visits[place];
      CHECK(p == data.parameters[static_cast<std::size_t>(trial)]);
      CHECK(std::ranges::equal(sway.rad, data.trial(trial)));
      CHECK(sway.height == 1.0);
    };
    source->take(half == 0 ? Part::training : Part::validation, 0, indices, take);
    CHECK(std::ranges::all_of(visits, [](int n) { return n == 1; }));
  }
  const std::vector<int> beyond{source->trials(Part::training)};
  check_error([&] { source->take(Part::training, 0, beyond, [](std::size_t, const auto&, const auto&) {}); },
              Code::setting_out_of_range);
  CHECK(source->identity() == stored_source(data)->identity());
  CHECK(source->identity() != stored_source(generate({noisy_protocol(), 21, 0, 6}))->identity());
  Dataset one_half = data;
  std::ranges::fill(one_half.split, std::uint8_t{0});
  check_error([&] { stored_source(one_half); }, Code::trials_missing);
}

TEST_CASE("trials that are encoded together have the bits that each has alone") {
  const Dataset data = generate({noisy_protocol(), 29, 0, 5});
  const int before = omp_get_max_threads();
  for (const bool standardize : {false, true}) {
    const ImageMaker images = two_columns(data.samples, standardize);
    REQUIRE(images.trials_together() == 4);
    const Scaling scaling = measure_scaling(*stored_source(data), images, 10);
    CHECK(scaling.rows.mean.empty() == !standardize);
    const Encoding encoding{images, scaling.rows};
    const auto values = static_cast<std::size_t>(images.shape().size());
    for (const int threads : {1, 3, 8}) {
      omp_set_num_threads(threads);
      for (const int count : {1, 4, 6, 29}) {
        std::vector<float> inputs(static_cast<std::size_t>(count) * values, -99.0F), alone(values);
        const auto produce = [&](const SwaySink& take) {
          parallel_for(count, [&](int i) { take(static_cast<std::size_t>(i), data.trial(i)); });
        };
        encode_all(encoding, produce, inputs);
        check_error([&] { encode_all(encoding, produce, std::span(inputs).first(inputs.size() - 1)); },
                    Code::size_mismatch);
        for (int i = 0; i < count; ++i) {
          encoding.encode(data.trial(i), alone);
          CHECK(std::ranges::equal(alone, std::span(inputs).subspan(static_cast<std::size_t>(i) * values, values)));
        }
      }
    }
  }
  omp_set_num_threads(before);
}

TEST_CASE("streamed bodies that stood before: trials of the same protocol with a longer lead-in, cut") {
  sim::Protocol protocol = tiny_protocol(), longer = protocol;
  protocol.standing_s = 4.0;
  longer.noise.vestibular.period_s = protocol.with_time_before().noise_period_s();
  longer.sequence().lead_in_s += 4.0;
  constexpr int count = 20;
  std::vector<int> indices(count);
  std::iota(indices.begin(), indices.end(), 0);
  const auto taken = [&](const sim::Protocol& of) {
    std::vector<Taken> all(count);
    stream_source(of, 3, count, 4)
        ->take(Part::training, 0, indices, [&](std::size_t place, const sim::Parameters& p, const Sway& sway) {
          all[place] = {p, {sway.rad.begin(), sway.rad.end()}, sway.height};
        });
    return all;
  };
  const std::vector<Taken> stood = taken(protocol), whole = taken(longer);
  int sways = 0;
  for (std::size_t i = 0; i < stood.size(); ++i) {
    CHECK(stood[i].parameters == whole[i].parameters);
    REQUIRE(stood[i].sway.size() == static_cast<std::size_t>(protocol.samples()));
    CHECK(std::ranges::equal(stood[i].sway, std::span(whole[i].sway).last(stood[i].sway.size())));
    sways += stood[i].sway.front() != 0.0F ? 1 : 0;  // not if the dead band hides the noise
  }
  CHECK(sways > count / 2);
  // A stored data set has them too.
  const Dataset data = generate({protocol, 10, 0, 3});
  CHECK(data.samples == protocol.samples());
  sways = 0;
  for (int i = 0; i < data.trials(); ++i) sways += data.trial(i).front() != 0.0F ? 1 : 0;
  CHECK(sways > 5);
}

TEST_CASE("streamed bodies are as tall as the protocol says, and a lighter body's parameters smaller") {
  sim::Protocol protocol = tiny_protocol();
  protocol.heights = {0.8, 1.1};
  const auto source = stream_source(protocol, 3, 200, 4);
  std::vector<int> indices(200);
  std::iota(indices.begin(), indices.end(), 0);
  std::vector<double> heights(200);
  source->take(Part::training, 0, indices,
               [&](std::size_t place, const sim::Parameters&, const Sway& sway) { heights[place] = sway.height; });
  CHECK(*std::ranges::min_element(heights) >= 0.8);
  CHECK(*std::ranges::max_element(heights) <= 1.1);
  // All of 200 uniform heights are above 0.83, or all below 1.07, once in 30 million.
  CHECK(*std::ranges::min_element(heights) < 0.83);
  CHECK(*std::ranges::max_element(heights) > 1.07);
  const Taken alone = training_trial(*source, 0, {17});
  CHECK(alone.height == heights[17]);
  sim::Protocol of_that_body = tiny_protocol();
  of_that_body.experiment.body = of_that_body.experiment.body.of_height(alone.height);
  const Taken same = training_trial(*stream_source(of_that_body, 3, 200, 4), 0, {17});
  for (std::size_t i = 0; i < same.sway.size(); ++i) CHECK(within(same.sway[i], double{alone.sway[i]}, 1e-7));
  check_error([&] { generate({protocol, 10, 0, 3}); }, Code::setting_conflict, "body_heights");

  sim::Protocol light = tiny_protocol();
  light.experiment.body.mass_kg *= 0.7;
  light.experiment.body.inertia_kgm2 *= 0.7;
  const Taken heavy = training_trial(*stream_source(tiny_protocol(), 3, 10, 4), 0, {2});
  const Taken of_light = training_trial(*stream_source(light, 3, 10, 4), 0, {2});
  CHECK(near(of_light.parameters[sim::Kp], 0.7 * heavy.parameters[sim::Kp], 1e-12));
  CHECK(of_light.parameters[sim::Delay] == heavy.parameters[sim::Delay]);
  CHECK(within(of_light.sway[300], double{heavy.sway[300]}, 1e-7));
}

TEST_CASE("streamed trials are recorded as the protocol says") {
  sim::Protocol protocol = noisy_protocol();
  protocol.conditions[sim::Condition::gain] = {.fraction = 0.5, .low = 0.0, .high = 0.3};
  protocol.conditions[sim::Condition::quantisation] = {.fraction = 1.0, .low = 0.01, .high = 0.1};
  const auto source = stream_source(protocol, 3, 10, 4);
  const std::vector<std::uint64_t> numbers{4 + 7};  // the seventh of epoch 0
  simulate_stream(sim::Simulator(protocol), 3, numbers,
                  [&](std::size_t, const sim::TrialInput& trial, std::span<double> sway) {
                    sim::record(protocol, 3, numbers[0], sway);
                    const Taken taken = training_trial(*source, 0, {7});
                    CHECK(taken.parameters == trial.parameters);
                    CHECK(taken.sway == std::vector<float>(sway.begin(), sway.end()));
                  });
}

namespace {

/// A stream that gives few trials at once, so that a feed makes several blocks an epoch.
class InSmallBlocks final : public TrialSource {
 public:
  InSmallBlocks(int trials, int at_once) : stream_(stream_source(noisy_protocol(), 3, trials, 4)), at_once_(at_once) {}
  const sim::Protocol& protocol() const override { return stream_->protocol(); }
  TrialIdentity identity() const override { return stream_->identity(); }
  int trials(Part part) const override { return stream_->trials(part); }
  int trials_at_once() const override { return at_once_; }
  void take(Part part, int epoch, std::span<const int> indices, const Take& take) const override {
    stream_->take(part, epoch, indices, take);
  }

 private:
  std::unique_ptr<TrialSource> stream_;
  int at_once_;
};

}  // namespace

TEST_CASE("a feed gives every trial of an epoch once, the same for any number of threads and wherever it begins") {
  constexpr int trials = 23, batch = 5, epochs = 3;                 // batches of 5, 5, 5, 4, 4
  const auto source = std::make_unique<InSmallBlocks>(trials, 12);  // two batches a block
  const ImageMaker images = two_columns(source->protocol().samples(), true);
  for (const int wrong : {0, -1})
    check_error([&] { measure_scaling(*source, images, wrong); }, Code::setting_out_of_range, std::to_string(wrong));
  const Scaling scaling = measure_scaling(*source, images, trials);
  const Encoding encoding{images, scaling.rows};
  const auto values = static_cast<std::size_t>(images.shape().size());
  // Each trial of each epoch: its targets and its input.
  using Example = std::pair<std::vector<float>, std::vector<float>>;
  std::vector<std::vector<Example>> fed(epochs);
  const auto read_epoch = [&](Feed& feed) {
    std::vector<Example> examples;
    for (int number = 0; number < 5; ++number) {
      const Feed::Batch next = feed.next();
      CHECK(next.trials == (number < 3 ? 5 : 4));
      REQUIRE(next.images.size() == static_cast<std::size_t>(next.trials) * values);
      REQUIRE(next.targets.size() == static_cast<std::size_t>(next.trials) * sim::single_pendulum().parameters.size());
      for (std::size_t i = 0; i < static_cast<std::size_t>(next.trials); ++i) {
        const auto target = next.targets.subspan(i * sim::single_pendulum().parameters.size(),
                                                 sim::single_pendulum().parameters.size());
        const auto image = next.images.subspan(i * values, values);
        examples.push_back({{target.begin(), target.end()}, {image.begin(), image.end()}});
      }
    }
    return examples;
  };
  Feed feed(*source, encoding, scaling.targets, batch, 9, 0, epochs);
  for (auto& epoch : fed) epoch = read_epoch(feed);

  std::set<std::vector<std::ptrdiff_t>> orders;
  for (int epoch = 0; epoch < epochs; ++epoch) {
    std::vector<Example> expected;
    for (int i = 0; i < trials; ++i) {
      const Taken taken = training_trial(*source, epoch, {i});
      const auto target = scaling.targets.scale(taken.parameters);
      std::vector<float> image(values);
      encoding.encode(taken.sway, image);
      expected.push_back({{target.begin(), target.end()}, image});
    }
    std::vector<Example> sorted = fed[static_cast<std::size_t>(epoch)];
    CHECK(sorted != expected);  // shuffled, and in each epoch otherwise
    std::vector<std::ptrdiff_t> order;
    for (const Example& example : sorted) order.push_back(std::ranges::find(expected, example) - expected.begin());
    CHECK(orders.insert(order).second);
    std::ranges::sort(sorted);
    std::ranges::sort(expected);
    CHECK(sorted == expected);
  }

  const int before = omp_get_max_threads();
  const auto one_block = stream_source(noisy_protocol(), 3, trials, 4);
  for (const int threads : {1, 2, 8}) {
    omp_set_num_threads(threads);
    Feed whole(*one_block, encoding, scaling.targets, batch, 9, 0, epochs);
    CHECK(read_epoch(whole) == fed[0]);
    Feed later(*source, encoding, scaling.targets, batch, 9, 1, epochs);
    CHECK(read_epoch(later) == fed[1]);
    CHECK(read_epoch(later) == fed[2]);
  }
  omp_set_num_threads(before);
  // From the middle of an epoch, where a batch begins.
  Feed rest(*source, encoding, scaling.targets, batch, 9, 1, epochs, {}, 15);
  for (const std::size_t first : {15U, 19U}) {
    const Feed::Batch next = rest.next();
    REQUIRE(next.trials == 4);
    for (std::size_t i = 0; i < 4; ++i)
      CHECK(std::ranges::equal(next.images.subspan(i * values, values), fed[1][first + i].second));
  }
  CHECK(read_epoch(rest) == fed[2]);
  check_error([&] { Feed(*source, encoding, scaling.targets, batch, 9, 1, epochs, {}, 20); },
              Code::setting_out_of_range, "sample 20");
  Feed no_epochs(*source, encoding, scaling.targets, batch, 9, epochs, epochs);
  check_error([&] { no_epochs.next(); }, Code::setting_out_of_range);
  Feed other(*source, encoding, scaling.targets, batch, 10, 0, 1);
  CHECK(read_epoch(other) != fed[0]);
}

TEST_CASE("a feed passes on its source's exceptions") {
  class Broken final : public TrialSource {
   public:
    const sim::Protocol& protocol() const override { return protocol_; }
    TrialIdentity identity() const override { return {}; }
    int trials(Part) const override { return 8; }
    int trials_at_once() const override { return 4; }
    void take(Part, int, std::span<const int> indices, const Take& take) const override {
      const std::vector<float> sway(static_cast<std::size_t>(protocol_.samples()));
      for (std::size_t place = 0; place < indices.size(); ++place) {
        if (++given_ > 6) throw std::runtime_error("the disk is gone");
        take(place, sim::single_pendulum().parameters.middle(), sway);
      }
    }

   private:
    sim::Protocol protocol_ = tiny_protocol();
    mutable int given_ = 0;
  };
  const Broken source;
  const ImageMaker images = two_columns(source.protocol().samples(), false);
  const RowScaling rows;
  check_error([&] { Feed(source, {images, rows}, {}, 0, 1, 0, 1); }, Code::setting_out_of_range, "0 samples");
  Feed feed(source, {images, rows}, {}, 4, 1, 0, 1);
  CHECK(feed.next().trials == 4);
  CHECK_THROWS_WITH_AS(feed.next(), "the disk is gone", std::runtime_error);
  CHECK_THROWS_WITH_AS(feed.next(), "the disk is gone", std::runtime_error);
}
