// Data sets whose sway stays in their file.
#include "dataset/npz/npz.hpp"
#include "sim/protocol/protocol_json.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/tiny_protocol.hpp"

using namespace decid;
using namespace decid::dataset;
using namespace decid::test;

namespace fs = std::filesystem;

TEST_CASE("a stored data set reads its sway from the file") {
  const TemporaryFolder folder;
  const Dataset data = generate({tiny_protocol(), 40, 30, 3});
  write_npz(folder / "a.npz", data);
  const StoredDataset stored(folder / "a.npz"), in_memory(data);
  CHECK_FALSE(stored.in_memory());
  CHECK(in_memory.in_memory());
  CHECK(stored.about().sway.empty());
  CHECK(stored.about().parameters == data.parameters);
  CHECK(stored.about().group == data.group);
  CHECK(stored.about().split == data.split);
  CHECK(stored.about().samples == 400);
  CHECK(to_json(stored.about().protocol) == to_json(data.protocol));
  std::vector<float> a(400), b(400);
  for (const int i : {0, 17, 39}) {
    stored.read(i, a);
    in_memory.read(i, b);
    CHECK(std::equal(a.begin(), a.end(), data.trial(i).begin()));
    CHECK(a == b);
  }
  for (const StoredDataset* data_set : {&stored, &in_memory}) {
    std::vector<std::vector<float>> taken(3);
    const auto keep = [&](std::size_t place, std::span<const float> sway) {
      taken[place].assign(sway.begin(), sway.end());
    };
    const auto expected = [&](int trial) {
      return std::vector<float>(data.trial(trial).begin(), data.trial(trial).end());
    };
    data_set->take(37, 3, keep);
    for (const int i : {0, 1, 2}) CHECK(taken[static_cast<std::size_t>(i)] == expected(37 + i));
    data_set->take(std::vector<int>{5, 0, 39}, keep);
    CHECK(taken == std::vector<std::vector<float>>{expected(5), expected(0), expected(39)});
    check_error([&] { data_set->take(38, 3, keep); }, Code::setting_out_of_range);
    for (const int i : {-1, 40}) check_error([&] { data_set->read(i, a); }, Code::setting_out_of_range, "0 to");
    std::vector<float> wrong(399);
    check_error([&] { data_set->read(0, wrong); }, Code::size_mismatch, "399 samples");
    wrong.resize(401);
    check_error([&] { data_set->read(0, wrong); }, Code::size_mismatch, "401 samples");
  }
  // The members in another order: into memory.
  const std::string script =
      "import sys, numpy as np\nd = dict(np.load(sys.argv[1]))\n"
      "np.savez(sys.argv[2], group=d['group'], **{k: d[k] for k in d if k != 'group'})\n";
  write_text(folder / "save.py", script);
  if (std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") == 0) {
    const std::string command = "/usr/bin/python3 " + (folder / "save.py").string() + " " +
                                (folder / "a.npz").string() + " " + (folder / "b.npz").string();
    REQUIRE(std::system(command.c_str()) == 0);
    const StoredDataset other(folder / "b.npz");
    CHECK(other.in_memory());
    CHECK(other.about().sway == data.sway);
  }
  // Damage: a bit that only the checksum shows, an invalid value, and an end that is cut off while in use.
  std::string content = read_text(folder / "a.npz");
  content[1000] = static_cast<char>(content[1000] ^ 1);
  write_text(folder / "c.npz", content);
  check_error([&] { StoredDataset(folder / "c.npz"); }, Code::file_damaged, "c.npz");
  content.replace(1000, 4, std::string("\x00\x00\xc0\x7f", 4));
  write_text(folder / "c.npz", content);
  check_error([&] { StoredDataset(folder / "c.npz"); }, Code::file_damaged, "sway of trial 0");
  fs::resize_file(folder / "a.npz", 3000);
  check_error([&] { stored.read(39, a); }, Code::file_damaged, "a.npz");
}
