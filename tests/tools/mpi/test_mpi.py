"""Several processes write the bytes that one writes; a process that ends, ends all, and loses nothing.
DECID_PROGRAM: the program; DECID_MPIRUN: the mpirun of its MPI, Open MPI's or MPICH's."""
import hashlib
import json
import os
import pathlib
import re
import signal
import subprocess
import tempfile
import time
import unittest

PROGRAM = os.environ["DECID_PROGRAM"]
MPIRUN = os.environ["DECID_MPIRUN"]
ENVIRONMENT = dict(os.environ, OMPI_ALLOW_RUN_AS_ROOT="1", OMPI_ALLOW_RUN_AS_ROOT_CONFIRM="1")
# "mpirun (Open MPI) 4.1.4", "mpiexec (OpenRTE) 4.1.4"
IS_OPEN_MPI = re.search("Open MPI|OpenRTE", subprocess.run([MPIRUN, "--version"], capture_output=True, text=True).stdout)
RANKS = (1, 2, 3, 5, 16)
# tests/golden/bits.cpp holds what it makes.
GOLDEN = ["train", "--stream", "--preset", "small", "--stream-trials", "128", "--validation-trials", "32", "--epochs", "2",
          "--seed", "5", "--quiet"]
LONG = ["train", "--stream", "--preset", "small", "--stream-trials", "96", "--validation-trials", "8", "--epochs", "30",
        "--batch", "48", "--seed", "7", "--quiet"]
RANK = "${OMPI_COMM_WORLD_RANK:-$PMI_RANK}"


def mpirun(ranks):
    return [MPIRUN, *(["--oversubscribe"] if IS_OPEN_MPI else []), "-n", str(ranks)] if ranks else []


def sha256(path):
    return hashlib.sha256(pathlib.Path(path).read_bytes()).hexdigest()


def descendants(pid):
    """Processes below one, by their numbers."""
    parents = {}
    for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
        try:
            parents[int(stat.parent.name)] = int(stat.read_text().rpartition(")")[2].split()[1])
        except OSError:
            continue
    found = [pid]
    for parent in found:
        found += [child for child, of in parents.items() if of == parent]
    return found[1:]


class Processes(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory(prefix="decid-mpi-")
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        # Open MPI fails if another mpirun removes the sessions' common folder while it makes its own.
        sessions = tempfile.TemporaryDirectory(prefix="decid-ompi-", ignore_cleanup_errors=True)
        self.addCleanup(sessions.cleanup)
        self.environment = dict(ENVIRONMENT, OMPI_MCA_orte_tmpdir_base=sessions.name)

    def command(self, ranks, arguments, before=""):
        """before: what a shell at each rank does first."""
        if not before:
            return [*mpirun(ranks), PROGRAM, *arguments]
        return [*mpirun(ranks), "sh", "-c", before + '; exec "$0" "$@"', PROGRAM, *arguments]

    def start(self, ranks, arguments, before=""):
        process = subprocess.Popen(self.command(ranks, arguments, before), cwd=self.folder, env=self.environment,
                                   stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        self.addCleanup(process.kill)
        return process

    def run_decid(self, ranks, arguments, before="", fails=False):
        process = self.start(ranks, arguments, before)
        out, err = process.communicate(timeout=600)  # CTest has the limit
        self.assertEqual(process.returncode != 0, fails, f"{ranks} ranks, {arguments}: {err}")
        return out, err

    def lines_of(self, err):
        """Returns decid's own messages, without mpirun's."""
        return [line for line in err.splitlines() if line.startswith("decid: ")]

    def wait_for(self, process, condition):
        while not condition():
            self.assertIsNone(process.poll(), "it ended before")
            time.sleep(0.005)

    def programs_of(self, process):
        """The ranks' own numbers."""
        def is_program(pid):
            try:
                return os.path.realpath(f"/proc/{pid}/exe") == os.path.realpath(PROGRAM)
            except OSError:
                return False
        return [pid for pid in descendants(process.pid) if is_program(pid)]

    def same_files(self, arguments, names, ranks=RANKS):
        """Files that `arguments` make, {} standing for the number of ranks in their names."""
        def make(count):
            self.run_decid(count, [argument.format(count) for argument in arguments])
            return [sha256(self.folder / name.format(count)) for name in names]
        alone = make(0)
        for count in ranks:
            self.assertEqual(make(count), alone, f"{count} ranks")
        return alone

    # The same bytes.

    def test_train(self):
        hashes = self.same_files([*GOLDEN, "--threads", "1", "-o", "m{}.safetensors"],
                                 ["m{}.safetensors", "m{}.safetensors.log.csv"])
        self.assertEqual(hashes[1], "844458f238b6bb5d09e76500fbefa32d5138d49018d3b3b7c88db127a6c4d654")

    def test_train_batches_that_do_not_divide(self):
        (self.folder / "net.txt").write_text("conv 4 5x5 stride 4\nbatchnorm\nrelu\nfc 36\n")
        self.same_files(["train", "--stream", "--preset", "small", "--stream-trials", "250", "--validation-trials", "16",
                         "--epochs", "2", "--batch", "100", "--head", "mixture 1", "--architecture", "net.txt",
                         "--patience", "1", "--average", "0.9", "--quiet", "-o", "m{}.safetensors"], ["m{}.safetensors"],
                        (2, 3))

    def test_dataset(self):
        self.same_files(["dataset", "--count", "300", "--base", "200", "--seed", "3", "--protocol", "short", "--quiet",
                         "--threads", "1", "-o", "d{}.npz"], ["d{}.npz"])

    def test_train_on_a_data_set_and_evaluate(self):
        self.run_decid(0, ["dataset", "--count", "120", "--seed", "3", "--quiet", "-o", "d.npz"])
        train = ["train", "--data", "d.npz", "--preset", "small", "--epochs", "2", "--quiet", "-o", "m{}.safetensors"]
        self.same_files(train, ["m{}.safetensors"], (2, 3))
        evaluate = ["evaluate", "--data", "d.npz", "--json", "--quiet"]
        alone = self.run_decid(0, evaluate)[0]
        self.assertIn('"mse"', alone)
        for count in (2, 5):
            self.assertEqual(self.run_decid(count, evaluate)[0], alone)

    def recordings(self, count):
        for i in range(count):
            self.run_decid(0, ["simulate", "--seed", str(i), "--kp", str(600 + 30 * i), "--quiet", "-o", f"r{i}.csv"])
        return [f"r{i}.csv" for i in range(count)]

    def test_identify(self):
        files = self.recordings(7)
        (self.folder / files[3]).write_text("nothing\n")
        outputs = ["-o", "i.json", "--report", "i.html", "--table", "i.csv"]
        alone = None
        for count in (0, 1, 3, 16):
            out, err = self.run_decid(count, ["identify", *files, *outputs, "--quiet", "--threads", "1"], fails=True)
            made = [out, *(sha256(self.folder / name) for name in ("i.json", "i.html", "i.csv"))]
            alone = alone or made
            self.assertEqual(made, alone, f"{count} ranks")
            self.assertEqual(len(self.lines_of(err)), 2, err)  # the recording, and how many failed
            self.assertIn("1 of 7 recordings failed", err)

    def without_seconds(self, text):
        return re.sub(r'"seconds[a-z_]*": [0-9.e-]+|[0-9.]+ s\n', "", text)

    def test_fits_of_recordings(self):
        files = self.recordings(3)
        made = ["f.json", "f.csv", "f.npz", "f.html"]
        arguments = ["fit", *files, "--max-draws", "8", "-o", "f.json", "--table", "f.csv", "--draws", "f.npz",
                     "--report", "f.html", "--quiet", "--threads", "1"]
        hashes = set()
        for count in (0, 2):
            self.run_decid(count, arguments)
            hashes.add(tuple(sha256(self.folder / name) for name in made))
        self.assertEqual(len(hashes), 1)

    def test_fits_joint(self):
        (self.folder / "p.json").write_text(json.dumps({
            "name": "tiny", "sensor_noise_deg": 0.02, "sample_rate_hz": 20,
            "sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1], "state_s": 0.1, "amplitude_deg": 4, "offset_s": 0,
                         "cycles": 2}}))
        lines = ["participant_id,session,file"]
        for i in range(5):
            self.run_decid(0, ["simulate", "--protocol", "p.json", "--seed", str(i), "--quiet", "-o", f"r{i}.csv"])
            lines.append(f"P{i // 2},{i % 2},r{i}.csv")
        (self.folder / "s.csv").write_text("\n".join(lines) + "\n")
        arguments = ["fit", "--study", "s.csv", "--joint", "participant_id", "--protocol", "p.json", "--max-draws", "8",
                     "-o", "f.json", "--draws", "f.npz", "--quiet", "--threads", "1"]
        made = set()
        for count in (0, 2, 3):
            self.run_decid(count, arguments)
            made.add(tuple(sha256(self.folder / name) for name in ("f.json", "f.npz")))
        self.assertEqual(len(made), 1)
        refused = [*arguments, "--within", "session"]
        out, err = self.run_decid(2, refused, fails=True)
        self.assertEqual(len(self.lines_of(err)), 1, err)

    def test_fits_calibrated(self):
        arguments = ["calibrate", "--trials", "3", "--max-draws", "8", "--quiet", "--json", "--threads", "1"]
        self.assertEqual(len({self.without_seconds(self.run_decid(count, arguments)[0]) for count in (0, 2)}), 1)

    def test_fits_compared(self):
        arguments = ["compare", "--trials", "2", "--max-draws", "8", "--starts", "1", "--simulations", "7000", "--quiet",
                     "--json", "--threads", "1"]
        self.assertEqual(len({self.without_seconds(self.run_decid(count, arguments)[0]) for count in (0, 2)}), 1)

    def test_instruction_sets_may_differ(self):
        before = f"if [ {RANK} = 0 ]; then export DECID_ISA=reference; fi"
        arguments = [argument for argument in GOLDEN if argument != "--quiet"]
        err = self.run_decid(2, [*arguments, "-o", "m.safetensors"], before)[1]
        self.assertIn("note: rank 0 computes with reference, rank 1 with", err)
        self.run_decid(0, [*GOLDEN, "-o", "alone.safetensors"])
        self.assertEqual(sha256(self.folder / "m.safetensors"), sha256(self.folder / "alone.safetensors"))

    def test_selftest(self):
        found = json.loads(self.run_decid(3, ["selftest", "--mpi", "--json"])[0])
        self.assertTrue(found["ok"])
        self.assertEqual(sum("3 ranks together" in check["of"] for check in found["checks"]), 3)
        err = self.run_decid(0, ["selftest", "--mpi"], fails=True)[1]
        self.assertIn("--mpi: needs several processes", err)

    # Ranks that have been started differently, and errors: one line, by one rank.

    def refused(self, ranks, arguments, fragments, before=""):
        out, err = self.run_decid(ranks, arguments, before, fails=True)
        self.assertEqual(out, "")
        self.assertEqual(len(self.lines_of(err)), 1, err)
        for fragment in fragments:
            self.assertIn(fragment, self.lines_of(err)[0])

    def test_protocol_files_differ(self):
        for rank, cycles in enumerate((1, 1, 2)):
            folder = self.folder / f"host{rank}"
            folder.mkdir()
            (folder / "mine.json").write_text('{"sequence": {"cycles": %d}}\n' % cycles)
        arguments = ["dataset", "--count", "10", "--protocol", "mine.json", "-o", str(self.folder / "d.npz")]
        self.refused(3, arguments, ["mine.json: differs: rank 0 on", "rank 2 on", "SHA-256"], f"cd host{RANK}")
        self.assertFalse((self.folder / "d.npz.partial").exists())

    def test_commands_differ(self):
        self.refused(2, ["dataset", "--count", "10", "-o", "d.npz"], ["the command: differs", "--seed 1"],
                     f'set -- "$@" --seed {RANK}')

    def test_an_error_of_all_is_said_once(self):
        self.refused(3, ["dataset", "--count", "10", "--protocol", "none.json", "-o", "d.npz"], ["none.json"])
        self.refused(3, ["train", "--stream", "-o", "no/folder/m.safetensors"], ["no/folder"])
        self.refused(2, ["train", "--speed", "-o", "m.safetensors"], ["--speed"])

    def test_other_commands_are_rank_0s(self):
        out, _ = self.run_decid(3, ["info", "--json"])
        self.assertEqual(out, self.run_decid(0, ["info", "--json"])[0])

    # A rank that ends, ends all ranks; work done until then is kept.

    def test_a_rank_is_killed(self):
        self.run_decid(0, [*LONG, "-o", "straight.safetensors"])
        process = self.start(3, [*LONG, "--threads", "1", "-o", "m.safetensors"])
        self.wait_for(process, (self.folder / "m.safetensors.checkpoint").exists)
        os.kill(self.programs_of(process)[-1], signal.SIGKILL)
        killed = time.monotonic()
        _, err = process.communicate(timeout=60)
        self.assertLess(time.monotonic() - killed, 20)
        self.assertNotEqual(process.returncode, 0)
        self.assertRegex(err, "(?i)signal 9|killed|KILLED BY SIGNAL|EXIT CODE: 9")
        self.run_decid(0, [*LONG, "-o", "m.safetensors"])
        self.assertEqual(sha256(self.folder / "m.safetensors"), sha256(self.folder / "straight.safetensors"))

    def stop(self, ranks, signal_number, arguments):
        checkpoint = self.folder / "m.safetensors.checkpoint"
        age = lambda: checkpoint.stat().st_mtime_ns if checkpoint.exists() else 0
        before = age()
        process = self.start(ranks, arguments)
        self.wait_for(process, lambda: age() != before)  # an epoch is done
        for pid in self.programs_of(process):  # as SLURM does
            os.kill(pid, signal_number)
        _, err = process.communicate(timeout=60)
        self.assertIn("stopped; the same command, with --resume or without, continues after epoch", err)
        self.assertEqual(len(self.lines_of(err)), 1, err)

    def test_signals_leave_a_checkpoint_for_any_number_of_ranks(self):
        self.run_decid(0, [*LONG, "-o", "straight.safetensors"])
        self.stop(2, signal.SIGTERM, [*LONG, "--threads", "1", "-o", "m.safetensors"])
        self.stop(3, signal.SIGUSR1, [*LONG, "--threads", "1", "--stop-at-usr1", "-o", "m.safetensors"])
        self.run_decid(5, [*LONG, "--threads", "1", "--resume", "-o", "m.safetensors"])
        self.assertEqual(sha256(self.folder / "m.safetensors"), sha256(self.folder / "straight.safetensors"))
        self.assertFalse((self.folder / "m.safetensors.stopped").exists())

    def test_a_data_set_goes_on_with_other_ranks(self):
        arguments = ["dataset", "--count", "6000", "--protocol", "short", "--quiet", "--threads", "1", "-o"]
        self.run_decid(0, [*arguments, "alone.npz"])
        process = self.start(2, [*arguments, "d.npz"])
        journal = self.folder / "d.npz.partial.journal"
        self.wait_for(process, lambda: journal.exists() and journal.stat().st_size > 100_000)
        for pid in self.programs_of(process):
            os.kill(pid, signal.SIGKILL)
        process.communicate(timeout=60)
        self.assertFalse((self.folder / "d.npz").exists())
        self.run_decid(3, [*arguments, "d.npz"])
        self.assertEqual(sha256(self.folder / "d.npz"), sha256(self.folder / "alone.npz"))

    def test_a_full_disk_of_one_rank(self):
        arguments = ["dataset", "--count", "3000", "--protocol", "short", "--quiet", "--threads", "1", "-o"]
        # ulimit counts blocks of 512 bytes; the set has 75 MB.
        before = f"if [ {RANK} = 1 ]; then ulimit -f 60000; fi"
        _, err = self.run_decid(2, [*arguments, "d.npz"], before, fails=True)
        self.assertEqual(len(self.lines_of(err)), 1, err)
        self.assertIn("rank 1 on", self.lines_of(err)[0])
        self.assertIn("d.npz.partial", self.lines_of(err)[0])
        self.run_decid(2, [*arguments, "d.npz"])
        self.run_decid(0, [*arguments, "alone.npz"])
        self.assertEqual(sha256(self.folder / "d.npz"), sha256(self.folder / "alone.npz"))


if __name__ == "__main__":
    unittest.main()
