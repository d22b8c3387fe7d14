// Tests of nn/training/all_reduce.hpp: what any number of ranks have at the end are the bits of tree_sum over the whole
// batch.
#include "nn/training/all_reduce.hpp"

#include <doctest/doctest.h>

#include <string>

#include "base/math/random.hpp"
#include "nn/kernels/kernels.hpp"
#include "tests/thread_ranks.hpp"

using namespace decid;
using namespace decid::nn;

namespace {

/// `size` numbers of a block of the batch; whatever order they are added in shows.
template <class T>
std::vector<T> part(int block, std::size_t size, std::uint64_t layer) {
  const Random random(17, Stream{3}, layer * 1000 + static_cast<std::uint64_t>(block));
  std::vector<T> values;
  for (std::size_t i = 0; i < size; ++i) values.push_back(static_cast<T>(random.uniform(i) - 0.4));
  return values;
}

/// Returns the parts of some blocks, one after the other.
template <class T>
std::vector<T> parts(const std::vector<int>& blocks, std::size_t size, std::uint64_t layer) {
  std::vector<T> all(blocks.empty() ? size : 0);
  for (const int block : blocks) {
    const std::vector<T> one = part<T>(block, size, layer);
    all.insert(all.end(), one.begin(), one.end());
  }
  return all;
}

template <class T>
std::vector<T> alone(int blocks, std::size_t size, std::uint64_t layer) {
  std::vector<int> every;
  for (int b = 0; b < blocks; ++b) every.push_back(b);
  std::vector<T> sum = parts<T>(every, size, layer);
  tree_sum(sum.data(), blocks, size, size);
  sum.resize(size);
  return sum;
}

}  // namespace

TEST_CASE("AllReduce: sums and gradients of any number of ranks have the bits of one") {
  const std::vector<std::size_t> layers[] = {{7, 1}, {5000, 3}, {1}, {1025}};  // sent whole, and in shards
  for (const int ranks : {1, 2, 3, 5})
    for (const int batch : {1, 40, 16 * 8, 16 * 13 - 5}) {
      const std::string which = std::to_string(ranks) + " ranks, batch " + std::to_string(batch);
      const int blocks = (batch + 15) / 16;
      std::vector<std::string> wrong(static_cast<std::size_t>(ranks));
      test::with_ranks(ranks, [&](Communicator& own) {
        std::string& text = wrong[static_cast<std::size_t>(own.rank())];
        AllReduce<float> all_reduce(own);
        for (int step = 0; step < 2; ++step) {  // memory of the first step is used again
          all_reduce.set_batch(batch);
          const std::vector<int>& mine = all_reduce.partition().blocks;
          std::vector<double> sums = parts<double>(mine, 6, 99);
          all_reduce.sum(sums.data(), 6);
          sums.resize(6);
          if (sums != alone<double>(blocks, 6, 99)) text += " sum";
          std::vector<std::vector<std::vector<float>>> from, to;
          for (const std::vector<std::size_t>& sizes : layers) {
            from.emplace_back();
            to.emplace_back();
            for (std::size_t p = 0; p < sizes.size(); ++p) {
              from.back().push_back(parts<float>(mine, sizes[p], from.size() * 10 + p));
              to.back().emplace_back(sizes[p]);
            }
          }
          for (std::size_t l = 0; l < from.size(); ++l) {
            std::vector<AllReduce<float>::Gradient> gradients;
            for (std::size_t p = 0; p < from[l].size(); ++p) gradients.push_back({from[l][p].data(), to[l][p]});
            all_reduce.start(gradients);
            if (own.rank() % 2 == 0) all_reduce.progress();
          }
          all_reduce.finish();
          for (std::size_t l = 0; l < to.size(); ++l)
            for (std::size_t p = 0; p < to[l].size(); ++p)
              if (to[l][p] != alone<float>(blocks, to[l][p].size(), (l + 1) * 10 + p))
                text += " gradient " + std::to_string(l) + "." + std::to_string(p);
        }
      });
      for (const std::string& text : wrong) {
        INFO(which);
        CHECK(text.empty());
      }
    }
}

TEST_CASE("Communicator: ranges, texts and messages reach all ranks") {
  std::vector<std::string> wrong(4);
  test::with_ranks(4, [&](Communicator& own) {
    std::string& text = wrong[static_cast<std::size_t>(own.rank())];
    std::vector<int> values(22);
    const RankRange range = rank_range(11, own.rank(), own.size());
    for (std::size_t i = 2 * range.first; i < 2 * (range.first + range.count()); ++i)
      values[i] = static_cast<int>(i) + 1;
    gather_ranges(own, 11, 2, values);
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values[i] != static_cast<int>(i) + 1) text += " value";
    if (broadcast_text(&own, own.is_root() ? "the root's" : "another") != "the root's") text += " broadcast";
    const std::vector<std::string> texts = gather_texts(&own, std::string(static_cast<std::size_t>(own.rank()), 'x'));
    if (texts != std::vector<std::string>{"", "x", "xx", "xxx"}) text += " texts";
    own.send((own.rank() + 1) % 4, std::to_string(own.rank()));
    std::optional<Communicator::Message> message;
    while (!message) message = own.poll();
    if (message->from != (own.rank() + 3) % 4 || message->bytes != std::to_string(message->from)) text += " message";
  });
  for (const std::string& text : wrong) CHECK(text.empty());
  CHECK(broadcast_text(nullptr, "alone") == "alone");
  CHECK(gather_texts(nullptr, "alone") == std::vector<std::string>{"alone"});
}
