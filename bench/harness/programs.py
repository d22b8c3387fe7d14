"""The benchmark programs: builds them in a folder of their own, lists what they measure, and measures one at a time."""
import json
import os
import re
from dataclasses import dataclass
from pathlib import Path

from harness.project import Failed, run

SUITES = ("bench_sim", "bench_nn_kernels", "bench_nn_network", "bench_stream", "bench_posterior", "bench_identify")
ISAS = ("reference", "baseline", "avx2", "avx512", "neon")


# Kernels' sources, and the benchmarks that run them. A source that no row names is shared by its folder's.
KERNELS = {
    "nn/kernels/generic_conv.hpp": "conv2d/.*/(forward|backward_src)/",
    "nn/kernels/generic_conv_gradient.hpp": "conv2d/.*/backward_weight/",
    "nn/kernels/generic_single.hpp": "forward_channels_in_lanes",
    "nn/kernels/generic_dense.hpp": "dense/",
    "nn/kernels/generic_pool.hpp": "pool_",
    "nn/kernels/generic_activation.hpp": "activation|relu",
    "nn/kernels/generic_statistics.hpp": "plane/",
    "nn/kernels/generic_plane.hpp": "plane/",
    "nn/kernels/": "conv2d|plane|dense",
    "sim/kernels/generic_fft.hpp": "fft|noise|image",
    "sim/kernels/pendulums.hpp": "/trials",
    "sim/kernels/generic_pendulums.hpp": "/trials",
    "sim/kernels/": "/trials|fft|noise|image",
    "dataset/image/kernels/": "image",
    "base/kernels/": "noise",
    "posterior/kernels/": "posterior",
}
KERNEL_SUITES = ("bench_nn_kernels", "bench_sim", "bench_posterior")


def touched_kernels(paths):
    """The regular expression of the benchmarks of those kernels that lie at these paths; None if there are none."""
    found = set()
    for path in paths:
        rows = [name for name in KERNELS if path.startswith(name)]
        if rows and not path.endswith("reference.cpp"):
            found.add(KERNELS[max(rows, key=len)])
    return re.compile("|".join(sorted(found))) if found else None


def build(source, folder, suites=(*SUITES, "bench_scaling")):
    """A release build of some benchmark programs of `source`, as many of them as it has; the log is beside the folder.
    Warnings are no errors: at -O3 g++ 12 warns wrongly of copies of std::variant (-Wmaybe-uninitialized)."""
    folder.mkdir(parents=True, exist_ok=True)
    log = folder.with_name(folder.name + ".log")
    try:
        log_text = run(["cmake", "-S", source, "-B", folder, "-DCMAKE_BUILD_TYPE=Release", "-DDECID_BENCHMARKS=ON",
                        "-DDECID_TESTS=OFF", "-DDECID_WARNINGS_AS_ERRORS=OFF"])
        known = set(re.findall(r"\w+", run(["cmake", "--build", folder, "--target", "help"])))
        programs = [name for name in suites if name in known]
        log_text += run(["cmake", "--build", folder, "-j", os.cpu_count(), "--target", *programs])
        log.write_text(log_text, encoding="utf-8")
    except Failed as error:
        log.write_text(str(error) + "\n", encoding="utf-8")
        raise Failed(f"{source}: does not build; see {log}") from error


@dataclass(frozen=True)
class Benchmark:
    program: str
    name: str


class Programs:
    """The benchmarks of one build folder, with one instruction set."""

    def __init__(self, folder, isa=None, suites=SUITES):
        self.folder = Path(folder) / "bench"
        self.listed = [Benchmark(suite, name) for suite in suites if (self.folder / suite).exists()
                       for name in run([self.folder / suite, "--benchmark_list_tests=true"]).split()]
        if not self.listed:
            raise Failed(f"{self.folder}: holds no benchmarks; is it a build with -DDECID_BENCHMARKS=ON?")
        present = [name for name in ISAS if any(b.name.startswith(name + "/") for b in self.listed)]
        self.isa = isa or os.environ.get("DECID_ISA") or (present[-1] if present else "")
        if present and self.isa not in present:
            raise Failed(f"instruction set '{self.isa}': not among {', '.join(present)}")

    def choose(self, pattern):
        """Returns benchmarks of the instruction set, or of none, whose names match the regular expression."""
        others = tuple(name + "/" for name in ISAS if name != self.isa)
        return [b for b in self.listed if not b.name.startswith(others) and (pattern is None or pattern.search(b.name))]

    def measure(self, benchmark, seconds):
        """Runs one benchmark for `seconds`, threads kept on their cores. Returns the context and the entry of Google
        Benchmark's report."""
        escaped = re.sub(r"([.+*?^$(){}|\[\]\\])", r"\\\1", benchmark.name)
        log_text = run([self.folder / benchmark.program, f"--benchmark_filter=^{escaped}$", "--benchmark_format=json",
                        f"--benchmark_min_time={seconds:g}"],
                       {"DECID_ISA": self.isa, "OMP_PROC_BIND": "true", "OMP_PLACES": "cores"})
        result = json.loads(log_text)
        entry = result["benchmarks"][0]
        if entry.get("error_occurred"):
            raise Failed(f"{benchmark.name}: {entry['error_message']}")
        return result["context"], entry
