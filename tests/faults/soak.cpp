// The C interface used for a long time in one process: memory and open files must stay what they were after a warm-up.
//   soak SOURCE_FOLDER SECONDS     prints a line every tenth of the time; fails if memory grew by 4 MB, what is in use
//   of it by 256 KB, or a file stays open
#include <malloc.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iterator>
#include <string>

#include "decid.h"

namespace {

namespace fs = std::filesystem;

/// Memory that is the process's own, not the files that it maps.
long resident_kb() {
  long pages = 0, resident = 0, shared = 0;
  std::FILE* file = std::fopen("/proc/self/statm", "r");
  if (file == nullptr || std::fscanf(file, "%ld %ld %ld", &pages, &resident, &shared) != 3) std::abort();
  std::fclose(file);
  return (resident - shared) * (::sysconf(_SC_PAGESIZE) / 1024);
}

/// Returns the memory that was allocated and not freed; the C library keeps the rest of the heap for later calls.
long used_kb() {
  const struct mallinfo2 info = ::mallinfo2();
  return static_cast<long>((info.uordblks + info.hblkhd) / 1024);
}

long open_files() {
  return static_cast<long>(std::distance(fs::directory_iterator("/proc/self/fd"), fs::directory_iterator()));
}

void require(decid_status status) {
  if (status == DECID_OK) return;
  std::fprintf(stderr, "soak: %s\n", decid_error_text());
  std::exit(1);
}

/// Data set, training, evaluation, identification, fit, and a file that is refused.
void round(const fs::path& golden, const fs::path& mat, const fs::path& scratch, uint64_t seed) {
  decid_protocol* protocol = nullptr;
  decid_dataset* dataset = nullptr;
  decid_model *trained = nullptr, *model = nullptr, *none = nullptr;
  decid_recording *recording = nullptr, *other = nullptr;
  decid_result *identified = nullptr, *fitted = nullptr;
  require(decid_protocol_load((golden / "protocol.json").c_str(), &protocol));
  decid_dataset_options few;
  decid_dataset_defaults(&few, sizeof few);
  few.count = 64;
  few.seed = seed;
  require(decid_dataset_make(protocol, &few, &dataset));
  require(decid_dataset_write(dataset, (scratch / "data.npz").c_str()));
  decid_train_options training;
  decid_train_defaults(&training, sizeof training);
  training.architecture = "conv 4 3x3 pad 1x1\nbatchnorm\nrelu\nglobalavgpool\nfc 7";
  training.head = "point";
  training.image = R"({"window": 10, "half_spectrum": true, "channels": ["log_modulus"]})";
  training.epochs = 2;
  require(decid_train(dataset, nullptr, &training, &trained));
  require(decid_model_save(trained, (scratch / "model.safetensors").c_str()));
  require(decid_model_load((scratch / "model.safetensors").c_str(), &model));
  require(decid_recording_read((golden / "trial.csv").c_str(), nullptr, &recording));
  decid_read_options column;
  decid_read_defaults(&column, sizeof column);
  column.column = "COM_x";
  require(decid_recording_read(mat.c_str(), &column, &other));
  require(decid_identify(model, recording, nullptr, &identified));
  decid_fit_options fit;
  decid_fit_defaults(&fit, sizeof fit);
  fit.max_draws = 8;
  fit.seed = seed;
  require(decid_fit(model, recording, &fit, &fitted));
  if (decid_model_load(mat.c_str(), &none) != DECID_BAD_INPUT) std::abort();
  decid_result_free(fitted);
  decid_result_free(identified);
  decid_recording_free(other);
  decid_recording_free(recording);
  decid_model_free(model);
  decid_model_free(trained);
  decid_dataset_free(dataset);
  decid_protocol_free(protocol);
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return 2;
  const fs::path root = argv[1], golden = root / "tests/golden/0.2.0";
  const double seconds = std::atof(argv[2]);
  std::string folder = fs::temp_directory_path() / "decid-soak-XXXXXX";
  if (::mkdtemp(folder.data()) == nullptr) return 1;
  constexpr long max_growth_kb = 4096, max_used_growth_kb = 256;
  constexpr int warm_up = 5;
  long first_kb = 0, first_used = 0, first_files = 0, kb = 0, used = 0, files = 0, rounds = 0;
  const auto begin = std::chrono::steady_clock::now();
  const auto elapsed = [&] { return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count(); };
  double said = 0.0;
  while (rounds < 2 * warm_up || elapsed() < seconds) {
    // Both kinds of 7.3 and 5 in turn: the former is read in a child.
    const char* const mat = rounds % 2 == 0 ? "v5.mat" : "v73_h5py.mat";
    round(golden, root / "tests/recording/mat" / mat, folder, static_cast<uint64_t>(rounds));
    ++rounds;
    kb = resident_kb();
    used = used_kb();
    files = open_files();
    if (rounds == warm_up) {
      first_kb = kb;
      first_used = used;
      first_files = files;
    }
    if (elapsed() < said) continue;
    said += 0.1 * seconds;
    std::printf("%6.0f s, %6ld rounds: %ld KB, %ld in use, %ld files\n", elapsed(), rounds, kb, used, files);
    std::fflush(stdout);
  }
  std::error_code ignored;
  fs::remove_all(folder, ignored);
  std::printf("%ld rounds in %.0f s: memory %+ld KB, in use %+ld KB, files %+ld\n", rounds, elapsed(), kb - first_kb,
              used - first_used, files - first_files);
  return kb - first_kb <= max_growth_kb && used - first_used <= max_used_growth_kb && files == first_files ? 0 : 1;
}
