// Streams of random numbers: equal numbers would give two purposes the same random numbers.
#include "identify/detail/streams.hpp"

#include <set>
#include <vector>

#include "posterior/streams.hpp"
#include "sim/streams.hpp"
#include "tests/helpers.hpp"
#include "tools/compare/streams.hpp"

using namespace decid;

TEST_CASE("every stream of random numbers has a number of its own, from 1 on without a gap") {
  const std::vector<Stream> all{Stream::weights,
                                Stream::shuffle,
                                Stream::augmentation,
                                Stream::dropout,
                                sim::streams::base_parameters,
                                sim::streams::child_parameters,
                                sim::streams::vestibular_noise,
                                sim::streams::child_noise,
                                sim::streams::sensor_noise,
                                sim::streams::recording,
                                sim::streams::body,
                                posterior::streams::chains,
                                posterior::streams::particles,
                                posterior::streams::design,
                                streams::cohort,
                                streams::predictive,
                                iterative::search_stream,
                                iterative::noise_stream};
  std::set<std::uint32_t> numbers;
  for (const Stream stream : all) numbers.insert(static_cast<std::uint32_t>(stream));
  CHECK(numbers.size() == all.size());
  CHECK(*numbers.begin() == 1);
  CHECK(*numbers.rbegin() == all.size());
}
