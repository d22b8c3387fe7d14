"""A build folder whose one benchmark program is a script that says what the test wants, and refusals of tools."""
import subprocess
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

NAMES = ["avx2/conv2d/one/forward/manual_time", "avx2/plane/two/manual_time", "baseline/conv2d/one/forward/manual_time",
         "net/training/threads:2/manual_time"]


def build(folder, times, log):
    """times: milliseconds of each run in turn, of every benchmark. Each run writes the folder's name into `log`."""
    folder = Path(folder)
    (folder / "bench").mkdir(parents=True)
    (folder / "CMakeFiles/3.25").mkdir(parents=True)
    (folder / "CMakeFiles/3.25/CMakeCXXCompiler.cmake").write_text(
        'set(CMAKE_CXX_COMPILER_ID "GNU")\nset(CMAKE_CXX_COMPILER_VERSION "12.2.0")\n', encoding="utf-8")
    program = folder / "bench/bench_sim"
    program.write_text(f"""#!/usr/bin/python3
import json, os, re, sys
from pathlib import Path
names, times, count, log = {NAMES!r}, {list(times)!r}, Path({str(folder / "count")!r}), Path({str(log)!r})
if "--benchmark_list_tests=true" in sys.argv:
    print(*names, sep="\\n")
    sys.exit(0)
name = next(n for n in names for a in sys.argv if a.startswith("--benchmark_filter=") and re.search(a[19:], n))
run = int(count.read_text()) if count.exists() else 0
count.write_text(str(run + 1))
with log.open("a") as file:
    file.write({folder.name!r} + " " + os.environ["DECID_ISA"] + " " + name + "\\n")
print(json.dumps({{"context": {{"date": "2024-01-01", "host_name": "h", "executable": "e"}}, "benchmarks": [
    {{"name": name, "run_name": name, "run_type": "iteration", "iterations": 1, "real_time": times[run % len(times)],
      "cpu_time": 1.0, "time_unit": "ms", "%peak": 50.0}}]}}))
""", encoding="utf-8")
    program.chmod(0o755)
    return folder


def refused(test, tool, *words):
    """Returns the errors of a program of tools/ that refuses the words with exit code 2 and prints nothing else."""
    done = subprocess.run([ROOT / "tools" / tool, *words], capture_output=True, text=True, check=False)
    test.assertEqual(done.returncode, 2, done.stderr)
    test.assertEqual(done.stdout, "")
    return done.stderr
