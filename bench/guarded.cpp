// Small fixed pieces of work whose instructions tools/bench-gate counts under valgrind, one name a run: kernels of the
// network, steps of whole networks, loops of the simulator, transforms, images, and a recording's way to its result.
//   bench_guarded              the names
//   bench_guarded NAME         does the work once
// AVX2 kernels, one thread. Only what happens inside guarded_work counts, not what prepares it.
#include <omp.h>

#include <cstdio>
#include <functional>
#include <map>
#include <memory>
#include <string>

#include "bench/dataset/recorded_file.hpp"
#include "bench/nn/networks.hpp"
#include "bench/nn/planes.hpp"
#include "bench/sim/trials.hpp"
#include "dataset/image/image.hpp"
#include "identify/study/study_results.hpp"
#include "identify/training/presets.hpp"
#include "nn/predictor.hpp"
#include "posterior/density/density.hpp"
#include "sim/double_pendulum.hpp"
#include "sim/fft.hpp"
#include "sim/noise.hpp"
#include "sim/streams.hpp"

using Work = std::function<void()>;

/// valgrind's --toggle-collect counts within this function.
extern "C" [[gnu::noinline]] void guarded_work(const Work& work) {
  work();
  asm volatile("");  // no tail call: the way out is seen
}

namespace {

using namespace decid;
using namespace decid::bench;

constexpr Isa isa = Isa::avx2;

/// Makes its memory, and hands back what is to be counted.
using Prepare = std::function<Work()>;
using Guarded = std::map<std::string, Prepare>;

/// Few and many channels, strides, padding on one side, planes that no tile divides.
constexpr Conv guarded_convs[] = {
    same("16-32@14", 16, 32, 14, 3, 1),
    same("2-8@30", 2, 8, 30, 3, 1),
    same("16-16@27,5x5/2", 16, 16, 27, 5, 2),
    {"4-48@256x1,7x1/2", {4, 256, 1, 48, 128, 1, 7, 1, 2, 1, 3, 0}},
};

void add_kernels(Guarded& all) {
  constexpr const char* directions[] = {"forward", "backward_src", "backward_weight"};
  for (const Conv& conv : guarded_convs)
    for (int d = 0; d < 3; ++d)
      all[std::string("conv2d/") + conv.name + "/" + directions[d]] = [&conv, d]() -> Work {
        const auto run = std::make_shared<ConvRun>(conv.shape);
        return [run, d] { run->run_batch(kernels_for(isa), static_cast<Direction>(d)); };
      };
  for (const PlaneKernel& kernel : plane_kernels)
    all[std::string("plane/") + kernel.name] = [&kernel]() -> Work {
      struct Memory {
        Batch x{{16, 40, 40}, {1, 1}}, dy{{16, 40, 40}, {1, 1}}, pooled{{16, 20, 20}, {1, 1}};
      };
      const auto m = std::make_shared<Memory>();
      return [m, &kernel] {
        for (int b = 0; b < blocks; ++b)
          for (int c = 0; c < 16; ++c) kernel.run(kernels_for(isa), m->x, m->dy, m->pooled, b, c);
      };
    };
}

/// Layers, loss and optimiser with everything between the kernels.
void add_networks(Guarded& all) {
  static constexpr NamedNetwork small{
      "small",
      {2, 28, 28},
      "conv 8 3x3 pad 1; batchnorm; relu; maxpool 2; conv 16 3x3 pad 1; batchnorm; relu; avgpool 2; fc 32; relu; fc 7"};
  all["network/training_step"] = []() -> Work {
    const auto training = std::make_shared<Training>(small, 32);
    return [training] { training->step(); };
  };
  all["network/inference"] = []() -> Work {
    const auto predictor = std::make_shared<nn::Predictor>(initialised(small), 32);
    const auto images =
        std::make_shared<std::vector<float>>(some_values(static_cast<std::size_t>(32 * small.input.size())));
    return [predictor, images] {
      std::vector<float> outputs(static_cast<std::size_t>(32 * predictor->inference().output_shape().size()));
      predictor->run(*images, outputs);
    };
  };
  all["network/single"] = []() -> Work {
    const auto predictor = std::make_shared<nn::Predictor>(initialised(best_network), 1);
    const auto image =
        std::make_shared<std::vector<float>>(some_values(static_cast<std::size_t>(best_network.input.size())));
    return [predictor, image] {
      std::vector<float> output(static_cast<std::size_t>(predictor->inference().output_shape().size()));
      predictor->run(*image, output);
    };
  };
}

void add_simulator(Guarded& all) {
  for (const bool noise : {false, true})
    all[noise ? "sim/trials" : "sim/trials_without_noise"] = [noise]() -> Work {
      const auto simulator = std::make_shared<sim::Simulator>(sim::short_protocol(), isa);
      return [simulator, noise] {
        simulator->run_all(
            20, [noise](int i) { return make_trial(i, noise); }, [](int, const sim::Outcome&, std::span<double>) {});
      };
    };
  all["sim/double_pendulum"] = []() -> Work {
    const auto simulator = std::make_shared<sim::DoubleSimulator>(sim::short_protocol());
    return [simulator] {
      const auto samples = static_cast<std::size_t>(simulator->samples());
      std::vector<double> com(samples), leg(samples), trunk(samples);
      simulator->run(sim::default_double_parameters(simulator->segments()),
                     Random(1, sim::streams::vestibular_noise, 0), {com, leg, trunk});
    };
  };
  all["sim/vestibular_noise"] = []() -> Work {
    const auto protocol = std::make_shared<sim::Protocol>(sim::default_protocol());
    const auto maker = std::make_shared<sim::VestibularNoiseMaker>(*protocol);
    return [protocol, maker] {
      const std::vector<double> nv(sim::fft_lanes, 0.5);
      std::vector<Random> random;
      for (std::uint64_t i = 0; i < nv.size(); ++i) random.emplace_back(1, sim::streams::vestibular_noise, i);
      std::vector<double> rates((static_cast<std::size_t>(protocol->samples()) + 1) * nv.size());
      maker->velocity_lanes(nv, random, rates, isa);
    };
  };
  all["sim/sensor_noise"] = []() -> Work {
    return [values = std::vector<double>(12100)]() mutable {
      Random(1, sim::streams::sensor_noise, 0).fill_normal(values, 1, isa);
    };
  };
  for (const int length : {110, 6050})
    all["fft/" + std::to_string(length)] = [length]() -> Work {
      const auto fft = std::make_shared<sim::RealFft>(length);
      return [fft] {
        constexpr std::size_t lanes = sim::fft_lanes;
        const int repeats = 12100 / fft->length();
        std::vector<double> in(static_cast<std::size_t>(fft->length()) * lanes, 0.5),
            out(static_cast<std::size_t>(2 * fft->bins()) * lanes),
            work(2 * static_cast<std::size_t>(fft->work_length()) * lanes);
        for (int i = 0; i < repeats; ++i) fft->forward_lanes(in, out, work, isa);
      };
    };
}

void add_posterior(Guarded& all) {
  using posterior::Density;
  all["posterior/gradient"] = []() -> Work {
    const auto density = std::make_shared<Density>(sim::default_protocol(), posterior::Priors{}, isa);
    const auto work = std::make_shared<Density::Workspace>(*density);
    const auto size = static_cast<std::size_t>(density->size()) * posterior::lanes;
    std::vector<float> sway_rad = some_values(12100);
    for (float& value : sway_rad) value *= 1e-3F;
    return [density, work, size, observation = density->observe(sway_rad)] {
      AlignedVector<double> x(size, 0.1), gradient(size);
      std::vector<double> potential(posterior::lanes);
      density->evaluate(observation, x, gradient, potential, *work);
    };
  };
}

void add_files(Guarded& all) {
  for (const char* preset : {"paper", "best"})
    all[std::string("image/") + preset] = [preset]() -> Work {
      constexpr int samples = 12100;
      const auto maker = std::make_shared<dataset::ImageMaker>(preset_named(preset).image, samples);
      return [maker, sway_rad = some_values(samples)] {
        std::vector<float> image(static_cast<std::size_t>(maker->shape().size()));
        maker->make(sway_rad, image, isa);
      };
    };
  all["file/read_recording"] = []() -> Work {
    const auto file = std::make_shared<RecordedFile>();
    return [file] { recording::read_recording(file->path(), {}); };
  };
  // Quoted cells have no fixed places in their row: a search for each of them would read a wide row whole.
  all["file/read_quoted"] = []() -> Work {
    constexpr int rows = 1000, columns = 100;
    const auto folder = std::make_shared<ScratchFolder>();
    std::string text = "\"time\"";
    for (int c = 1; c < columns; ++c) text += format(",\"c%d\"", c);
    for (int k = 0; k < rows; ++k) {
      text += format("\n\"%.2f\"", 0.01 * k);
      for (int c = 1; c < columns; ++c) text += format(",\"%d\"", (k * (c + 3)) % 7);
    }
    const std::string path = (folder->path() / "recording.csv").string();
    write_file(path, text + "\n");
    return [folder, path] { recording::read_recording(path, {.column = "c99"}); };
  };
  all["file/identify"] = []() -> Work {
    const auto file = std::make_shared<RecordedFile>();
    const auto model = std::make_shared<Model>(built_in_model());
    return [file, model] { identify_plan(*model, "the model", make_plan({file->path()}, {})); };
  };
}

int run(int argc, char** argv) {
  Guarded all;
  add_kernels(all);
  add_networks(all);
  add_simulator(all);
  add_posterior(all);
  add_files(all);
  if (argc == 1) {
    for (const auto& [name, prepare] : all) std::printf("%s\n", name.c_str());
    return 0;
  }
  const auto found = all.find(argv[1]);
  if (argc != 2 || found == all.end())
    throw Error(Code::setting_unknown, "bench_guarded", "takes one name, and knows what it prints without",
                "choose one of those");
  if (chosen_isa() != isa)
    throw Error(Code::not_supported, "bench_guarded", "counts instructions of AVX2", "set DECID_ISA=avx2");
  omp_set_num_threads(1);
  const Work work = found->second();
#pragma omp parallel
  {}
  guarded_work(work);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  try {
    return run(argc, argv);
  } catch (const Error& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 2;
  }
}
