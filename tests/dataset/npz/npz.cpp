// Data sets on disk: round trips to the bit, both ways between this program and NumPy, and damaged files.
#include "dataset/npz/npz.hpp"

#include <sys/resource.h>

#include <csignal>
#include <cstdlib>
#include <limits>

#include "sim/protocol/protocol_json.hpp"
#include "tests/helpers.hpp"
#include "tests/sim/made_up_body.hpp"

using namespace decid;
using namespace decid::dataset;
using namespace decid::test;

namespace {

/// Small, and of odd values: nothing here asks whether the trials were ever simulated.
Dataset small_dataset(int trials = 5) {
  Dataset data;
  data.protocol = tiny_protocol();
  data.protocol.noise.sensor = {0.001, 0.1};
  data.protocol.experiment.body.mass_kg = 70.0 + 1.0 / 3.0;
  data.seed = 0xFFFFFFFFFFFFFFFEu;
  data.samples = data.protocol.samples();
  for (int i = 0; i < trials; ++i) {
    for (int k = 0; k < data.samples; ++k) data.sway.push_back(1.0f / static_cast<float>(3 + i + k) - 0.01f);
    sim::Parameters parameters = sim::single_pendulum().parameters.middle();
    for (double& value : parameters) value += 1.0 / (7.0 + i);
    data.parameters.push_back(parameters);
    data.group.push_back(i == 4 ? 1 : i);
    data.split.push_back(static_cast<std::uint8_t>(i == 1 || i == 4));
  }
  return data;
}

void check_equal(const Dataset& a, const Dataset& b) {
  CHECK(to_json(a.protocol) == to_json(b.protocol));
  CHECK(a.seed == b.seed);
  CHECK(a.samples == b.samples);
  CHECK(a.sway == b.sway);
  CHECK(a.parameters == b.parameters);
  CHECK(a.group == b.group);
  CHECK(a.split == b.split);
}

void require_numpy() {
  static const bool found = std::system("/usr/bin/python3 -c 'import numpy' 2>/dev/null") == 0;
  REQUIRE_MESSAGE(found, "this test needs NumPy for /usr/bin/python3: tools/setup --check installs it");
}

/// Runs Python with numpy as np and `path` set; false if it fails.
bool python(const std::filesystem::path& script, const std::filesystem::path& path, const std::string& code) {
  write_text(script, "import json, sys\nimport numpy as np\npath = sys.argv[1]\n" + code);
  return std::system(("/usr/bin/python3 '" + script.string() + "' '" + path.string() + "'").c_str()) == 0;
}

}  // namespace

TEST_CASE("a data set comes back to the bit, and equal sets are equal files") {
  const TemporaryFolder folder;
  const Dataset data = small_dataset();
  write_npz(folder / "a.npz", data);
  check_equal(read_npz(folder / "a.npz"), data);
  CHECK(folder.files() == 1);

  // Equal bytes also in another time zone and over an older file.
  write_text(folder / "b.npz", "an older file");
  const char* zone = std::getenv("TZ");
  const std::string before = zone ? zone : "";
  setenv("TZ", "Pacific/Kiritimati", 1);
  write_npz(folder / "b.npz", data);
  if (zone) {
    setenv("TZ", before.c_str(), 1);
  } else {
    unsetenv("TZ");
  }
  const std::string a = read_text(folder / "a.npz"), b = read_text(folder / "b.npz");
  CHECK(a == b);
  CHECK(a.substr(10, 4) == std::string("\x00\x00\x21\x00", 4));  // midnight, 1 January 1980
  CHECK(folder.files() == 2);

  Dataset other = data;
  other.seed = 1;
  write_npz(folder / "b.npz", other);
  CHECK_FALSE(a == read_text(folder / "b.npz"));
}

TEST_CASE("NumPy reads what decid writes") {
  require_numpy();
  const TemporaryFolder folder;
  write_npz(folder / "a.npz", small_dataset());
  CHECK(python(folder / "check.py", folder / "a.npz", R"(
data = np.load(path)
assert sorted(data.files) == ['decid.json', 'group', 'parameters', 'split', 'sway'], data.files
sway = data['sway']
assert sway.dtype == np.float32 and sway.shape == (5, 400), (sway.dtype, sway.shape)
assert (sway == np.float32(1) / (3 + np.arange(5)[:, None] + np.arange(400)).astype(np.float32) - np.float32(.01)).all()
parameters = data['parameters']
assert parameters.dtype == np.float64 and parameters.shape == (5, 7)
assert parameters[2, 4] == .5 + 1 / 9, parameters[2]
assert data['group'].dtype == np.int32 and data['group'].tolist() == [0, 1, 2, 3, 1]
assert data['split'].dtype == np.uint8 and data['split'].tolist() == [0, 1, 0, 0, 1]
text = data['decid.json']
assert text.shape == () and text.dtype.kind == 'S'
about = json.loads(text.item())
assert about['format'] == 1 and about['seed'] == 2**64 - 2
assert about['parameters'] == ['Kp', 'Kd', 'Kp_pass', 'Kd_pass', 'Nv', 'theta', 'delay']
assert about['protocol']['body']['mass_kg'] == 70 + 1 / 3
assert about['protocol']['sensor_noise_deg'] == [.001, .1]
)"));
}

TEST_CASE("decid reads what NumPy writes, stored, deflated, or in header format 2.0") {
  require_numpy();
  const TemporaryFolder folder;
  const Dataset data = small_dataset();
  for (const std::string save : {"np.savez(path, **arrays)", "np.savez_compressed(path, **arrays)",
                                 "np.savez(path, notes=np.array(['mine']), **arrays)",
                                 "import zipfile\n"
                                 "with zipfile.ZipFile(path, 'w') as archive:\n"
                                 "  for name, array in arrays.items():\n"
                                 "    with archive.open(name + '.npy', 'w') as file:\n"
                                 "      np.lib.format.write_array(file, np.asarray(array), version=(2, 0))"}) {
    INFO(save);
    write_npz(folder / "a.npz", data);
    REQUIRE(python(folder / "save.py", folder / "a.npz", "arrays = dict(np.load(path))\n" + save + "\n"));
    check_equal(read_npz(folder / "a.npz"), data);
  }
  // 80 MB of zeros in 80 kB.
  REQUIRE(python(folder / "save.py", folder / "a.npz",
                 "arrays = dict(np.load(path))\narrays['sway'] = np.zeros((250_000, 80), np.float32)\n"
                 "np.savez_compressed(path, **arrays)\n"));
  check_error([&] { read_npz(folder / "a.npz"); }, Code::file_unsupported, "a.npz");
}

TEST_CASE("a data set from before the noise had a period of its own keeps the trial's length") {
  require_numpy();
  const TemporaryFolder folder;
  write_npz(folder / "a.npz", small_dataset());
  CHECK(read_npz(folder / "a.npz").protocol.noise_period_s() == 8.0);
  REQUIRE(python(folder / "save.py", folder / "a.npz", R"(
arrays = dict(np.load(path))
about = json.loads(arrays['decid.json'].item())
assert about['protocol']['vestibular_noise'].pop('period_s') == 8
arrays['decid.json'] = np.array(json.dumps(about).encode())
np.savez(path, **arrays)
)"));
  CHECK(read_npz(folder / "a.npz").protocol.noise_period_s() == 4.0);
}

TEST_CASE("arrays that do not belong into a data set are refused by name") {
  require_numpy();
  const TemporaryFolder folder;
  struct Case {
    const char* change;
    Code code;
    const char* fact;
  };
  const Case cases[] = {
      {"del arrays['sway']", Code::file_unsupported, "'sway'"},
      {"del arrays['split']", Code::file_unsupported, "'split'"},
      {"del arrays['decid.json']", Code::file_unsupported, "'decid.json'"},
      {"arrays['sway'] = arrays['sway'].astype('f8')", Code::file_unsupported, "type <f8"},
      {"arrays['sway'] = arrays['sway'].astype('>f4')", Code::file_unsupported, "type >f4"},
      {"arrays['sway'] = np.asfortranarray(arrays['sway'])", Code::file_unsupported, "sway"},
      {"arrays['sway'] = arrays['sway'].ravel()", Code::file_unsupported, "2000"},
      {"arrays['sway'] = arrays['sway'][:, :399]", Code::file_damaged, "'tiny'"},
      {"arrays['sway'] = arrays['sway'][:4]", Code::file_damaged, "sway and parameters"},
      {"arrays['sway'] = arrays['sway'][:, :0]", Code::file_damaged, "sway and parameters"},
      {"for k in ['sway', 'parameters', 'group', 'split']: arrays[k] = arrays[k][:0]", Code::file_damaged, "a.npz"},
      {"arrays['sway'][3, 17] = np.nan", Code::file_damaged, "trial 3"},
      {"arrays['parameters'][2, 6] = np.inf", Code::file_damaged, "trial 2"},
      {"arrays['parameters'] = arrays['parameters'][:, :6]", Code::file_unsupported, "5 x 6"},
      {"arrays['parameters'] = arrays['parameters'].astype('f4')", Code::file_unsupported, "type <f4"},
      {"arrays['group'] = arrays['group'].astype('i8')", Code::file_unsupported, "type <i8"},
      {"arrays['group'][0] = 5", Code::file_damaged, "trial 0, 5"},
      {"arrays['group'][0] = -1", Code::file_damaged, "trial 0, -1"},
      {"arrays['group'][0] = 4", Code::file_damaged, "trial 0, 4"},
      {"arrays['group'] = arrays['group'][:4]", Code::file_damaged, "group"},
      {"arrays['split'] = arrays['split'][:4]", Code::file_damaged, "split"},
      {"arrays['split'] = arrays['split'][:, None]", Code::file_unsupported, "5 x 1"},
      {"arrays['split'][4] = 2", Code::file_damaged, "trial 4 is 2"},
      {"arrays['sway'] = np.zeros(5, 'f4,i4')", Code::file_damaged, "sway"},
      {"arrays['decid.json'] = np.array('{}')", Code::file_unsupported, "type <U2"},
      {"arrays['decid.json'] = np.array(b'{')", Code::setting_malformed, "line 1"},
      {"about['format'] = 2", Code::file_unsupported, "format 2"},
      {"about['extra'] = 2", Code::setting_unknown, "'extra'"},
      {"del about['protocol']", Code::setting_missing, "'protocol'"},
      {"del about['seed']", Code::setting_missing, "'seed'"},
      {"about['seed'] = -1", Code::setting_malformed, "'seed'"},
      {"about['parameters'].reverse()", Code::file_unsupported, "decid.json"},
      {"about['protocol']['sample_rate_hz'] = 200.", Code::file_damaged, "'tiny'"},
      {"about['protocol']['sample_rate'] = 100.", Code::setting_unknown, "'sample_rate'"},
  };
  // One Python for all: starting it is what takes the time.
  std::string script = "import os\noriginal = dict(np.load(path))\n";
  int number = 0;
  for (const Case& c : cases) {
    script +=
        "arrays = {k: v.copy() for k, v in original.items()}\nabout = json.loads(arrays['decid.json'].item())\n" +
        std::string(c.change) +
        "\nif about != json.loads(original['decid.json'].item()): arrays['decid.json'] = np.array(json.dumps(about)"
        ".encode())\nnp.savez(os.path.dirname(path) + '/a.npz-" +
        std::to_string(number++) + ".npz', **arrays)\n";
  }
  write_npz(folder / "a.npz", small_dataset());
  REQUIRE(python(folder / "save.py", folder / "a.npz", script));
  number = 0;
  for (const Case& c : cases) {
    INFO(c.change);
    const std::string name = "a.npz-" + std::to_string(number++) + ".npz";
    check_error([&] { read_npz(folder / name.c_str()); }, c.code, c.fact);
  }
}

TEST_CASE("files that are no archives, or are cut off, are refused") {
  const TemporaryFolder folder;
  check_error([&] { read_npz(folder / "none.npz"); }, Code::file_missing, "none.npz");
  check_error([&] { read_npz(folder.path()); }, Code::file_unreadable, "is a folder");
  write_text(folder / "text.npz", "time,sway\n0,1\n");
  check_error([&] { read_npz(folder / "text.npz"); }, Code::file_damaged, "text.npz");
  write_text(folder / "empty.npz", "");
  check_error([&] { read_npz(folder / "empty.npz"); }, Code::file_damaged, "empty.npz");

  write_npz(folder / "a.npz", small_dataset());
  const std::string whole = read_text(folder / "a.npz");
  for (const std::size_t size : {std::size_t{1}, std::size_t{30}, whole.size() / 3, whole.size() / 2,
                                 whole.size() - 200, whole.size() - 22, whole.size() - 1}) {
    CAPTURE(size);
    write_text(folder / "cut.npz", whole.substr(0, size));
    check_error([&] { read_npz(folder / "cut.npz"); }, Code::file_damaged, "cut.npz");
  }
}

TEST_CASE("damaged bytes are detected") {
  const TemporaryFolder folder;
  write_npz(folder / "a.npz", small_dataset());
  const std::string whole = read_text(folder / "a.npz");
  const auto damaged = [&](std::size_t position, char value) {
    std::string content = whole;
    content[position] = value;
    return write_text(folder / "damaged.npz", content);
  };
  // A value of the sway: only the checksum can show it.
  const std::size_t magic = whole.find("\x93NUMPY");
  REQUIRE(magic != std::string::npos);
  check_error([&] { read_npz(damaged(magic + 1000, '\x01')); }, Code::file_damaged, "damaged.npz");
  check_error([&] { read_npz(damaged(magic, 'x')); }, Code::file_damaged);
  check_error([&] { read_npz(damaged(magic + 6, '\x03')); }, Code::file_unsupported, "3.0");
  check_error([&] { read_npz(damaged(magic + 9, '\x7f')); }, Code::file_damaged);
  check_error([&] { read_npz(damaged(magic + 10, '[')); }, Code::file_damaged);
  // A shape that no file of this size can hold is refused before any memory is asked for.
  const std::size_t shape = whole.find("(5, 400)");
  REQUIRE(shape != std::string::npos);
  check_error([&] { read_npz(damaged(shape + 1, '9')); }, Code::file_damaged, "9 x");
  // Sizes in the directory at the archive's end: 2^31 bytes of sway.
  const std::size_t entry = whole.find("PK\x01\x02");
  REQUIRE(entry != std::string::npos);
  std::string content = whole;
  for (const std::size_t field : {20u, 24u}) content.replace(entry + field, 4, std::string("\x00\x00\x00\x80", 4));
  write_text(folder / "large.npz", content);
  check_error([&] { read_npz(folder / "large.npz"); }, Code::file_damaged, "large.npz");
  // Any one byte (a name's, say, or a date's): either the file still reads as the same data, or there is an Error;
  // nothing else may happen.
  int refused = 0;
  for (std::size_t position = 0; position < whole.size(); position += position < 400 || position > 30000 ? 7 : 997) {
    damaged(position, static_cast<char>(whole[position] ^ 0x55));
    Dataset read = small_dataset();
    try {
      read = read_npz(folder / "damaged.npz");
    } catch (const Error& error) {
      ++refused;
      CHECK_FALSE(error.remedy().empty());
    }
    check_equal(read, small_dataset());
  }
  CHECK(refused > 50);
}

TEST_CASE("data that the reader would refuse is not written") {
  const TemporaryFolder folder;
  Dataset data = small_dataset();
  data.sway[7] = std::numeric_limits<float>::quiet_NaN();
  check_error([&] { write_npz(folder / "a.npz", data); }, Code::file_damaged, "sway of trial 0");
  data = small_dataset();
  data.split.pop_back();
  check_error([&] { write_npz(folder / "a.npz", data); }, Code::file_damaged, "a.npz");
  check_error([&] { write_npz(folder / "a.npz", Dataset{}); }, Code::file_damaged, "a.npz");
  CHECK(folder.files() == 0);
}

TEST_CASE("a failure to write leaves the old file and nothing else") {
  const TemporaryFolder folder;
  check_error([&] { write_npz(folder / "no" / "a.npz", small_dataset()); }, Code::file_unwritable, "a.npz");
  check_error([&] { write_npz("/dev/null", small_dataset()); }, Code::file_unwritable, "/dev/null");
  write_text(folder / "a.npz", "old");
  // A limit on the size of files stands for a full disk.
  rlimit before{};
  REQUIRE(getrlimit(RLIMIT_FSIZE, &before) == 0);
  const auto handler = std::signal(SIGXFSZ, SIG_IGN);
  rlimit tight = before;
  for (const rlim_t limit : {rlim_t{100}, rlim_t{5000}, rlim_t{9000}}) {
    tight.rlim_cur = limit;
    REQUIRE(setrlimit(RLIMIT_FSIZE, &tight) == 0);
    const std::string message = message_of([&] { write_npz(folder / "a.npz", small_dataset(20)); });
    REQUIRE(setrlimit(RLIMIT_FSIZE, &before) == 0);
    CHECK(contains(message, "cannot be written: "));
    CHECK(contains(message, "too large"));  // as the system says it
  }
  std::signal(SIGXFSZ, handler);
  CHECK(read_text(folder / "a.npz") == "old");
  CHECK(folder.files() == 1);
}

TEST_CASE("a data set of a made-up body has its fourteen parameters, by their names") {
  const TemporaryFolder folder;
  Dataset data = small_dataset();
  data.protocol.experiment.body_model = &made_up_body();
  check_error([&] { write_npz(folder / "a.npz", data); }, Code::file_damaged, "0 do");
  for (std::size_t i = 0; i < data.parameters.size(); ++i)
    data.parameters[i] = base_trial(made_up_body().parameters, 9, i).parameters;
  write_npz(folder / "a.npz", data);
  const Dataset read = read_npz(folder / "a.npz");
  check_equal(read, data);
  CHECK(read.protocol.experiment == data.protocol.experiment);
  CHECK(StoredDataset(folder / "a.npz").about().parameters == data.parameters);
  require_numpy();
  CHECK(python(folder / "read.py", folder / "a.npz",
               "with np.load(path) as data:\n"
               "    assert data['parameters'].shape == (5, 14)\n"
               "    about = json.loads(bytes(data['decid.json']))\n"
               "    assert about['parameters'] == ['gain_%d' % i for i in range(1, 15)]\n"));
}
