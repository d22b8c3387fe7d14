"""The package against the program, to the bit; what it refuses; arrays without copies; callbacks; threads."""
import copy
import gc
import inspect
import json
import multiprocessing
import os
import pickle
import re
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
from pathlib import Path

import numpy as np

import decid

DECID = os.environ["DECID_PROGRAM"]
SOURCE = Path(os.environ["DECID_SOURCE_DIR"])
TINY = "conv 4 7x1 stride 4x1; batchnorm; relu; globalavgpool; fc 7"


def program(*arguments):
    return subprocess.run([DECID, *map(str, arguments)], check=True, capture_output=True, text=True).stdout


def options_of(keywords):
    """The program's options of the same meaning."""
    options = []
    for name, value in keywords.items():
        if name in ("ranges", "priors"):
            for parameter, pair in value.items():
                options += ["--" + name[:-1], f"{parameter}={pair[0]},{pair[1]}"]
        elif name == "trial_column":
            options += ["--trial", value]
        elif name == "invert_sway":
            options += ["--invert", "both"]
        elif name not in ("trial", "invert_tilt"):
            options += ["--" + name.replace("_", "-")] + ([] if value is True else [value])
    return options


class WithFolder(unittest.TestCase):
    def setUp(self):
        self.maxDiff = None
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = Path(folder.name)

    def trial(self, *options):
        path = self.folder / "trial.csv"
        program("simulate", "--seed", 7, *options, "--quiet", "-o", path)
        return path

    def check_same(self, result, expected):
        """A Result is the recording's object of the program's JSON."""
        self.assertEqual([p["name"] for p in expected["parameters"]], list(result.parameters))
        for of in expected["parameters"]:
            found = result[of["name"]]
            for key in ("value", "unit", "sd", "normalized"):
                self.assertEqual(getattr(found, key), of[key], (of["name"], key))
            for key in ("interval50", "interval90", "normalized_interval90"):
                self.assertEqual(getattr(found, key), None if of[key] is None else tuple(of[key]), (of["name"], key))
        for key in ("rms_residual_deg", "variance_accounted_for"):
            self.assertEqual(getattr(result, key), expected["fit"][key])
        for key in ("peak_to_peak_deg", "response_ratio", "ood_score", "trust"):
            self.assertEqual(getattr(result, key), expected[key])
        # Messages name settings: the program's options are other names of them.
        def setting(option):
            return {"--range": "ranges", "--trial": "trial_column"}.get(option[0], option[0][2:].replace("-", "_"))

        texts = [{**warning, "text": re.sub(r"--[a-z-]+", setting, warning["text"])} for warning in expected["warnings"]]
        self.assertEqual([vars(notice) for notice in result.warnings], texts)
        size = len(expected["parameters"])
        np.testing.assert_array_equal(result.correlations[:size, :size], expected["correlations"])


class Identification(WithFolder):
    def test_every_option_has_the_bits_of_the_program(self):
        rows = np.loadtxt(self.trial(), delimiter=",", skiprows=1)
        time, sway, tilt = rows[:, :3].T
        columns = {"time": time, "sway": np.deg2rad(sway), "tilt_rad": np.deg2rad(tilt), "leg": 0.9 * sway, "trunk": 1.2 * sway,
                   "hip": 1.6 * sway, "shoulder": 2.4 * sway, "ankle": 0.1 * sway, "gappy": np.where(time == 3.07, -77.5, sway),
                   "offset": sway + 25, "minus_deg": -sway, "platform": -np.deg2rad(tilt)}
        header = ",".join(columns)
        lines = [",".join(format(value, ".9f") for value in row) for row in np.column_stack(list(columns.values()))]
        brief = ["time,sway_deg", *(f"{k / 100},{k % 7}" for k in range(60)), ""]
        for name, text in (("table", [header, *lines]), ("numbers", lines), ("sections", [*brief, "Trajectories", header, *lines]),
                           ("trials", ["subject," + header, *("s1," + line for line in lines), *("s2," + line for line in lines[:6001])]),
                           ("blocks", ["block," + header, *(f"{k // 6050}," + line for k, line in enumerate(lines))])):
            (self.folder / (name + ".csv")).write_text("\n".join([*text, ""]))
        wanted = set(inspect.signature(decid.read).parameters) | set(inspect.signature(decid.identify).parameters)
        wanted -= {"path", "recording", "reading", "mean_is_upright"}
        for name, reading, keywords in (
                ("table", {"column": "sway", "unit": "rad", "tilt_column": "tilt_rad"}, {"model": SOURCE / "models/dec2015.safetensors"}),
                ("table", {"column": 10, "unit": "deg"}, {"detrend": "offset"}),
                ("table", {"column": "gappy", "fill_gaps": 0.1, "missing": -77.5, "tilt_column": "none"}, {"begin": 0.5}),
                ("table", {"column": "minus_deg", "tilt_column": "platform", "tilt_unit": "rad", "invert_sway": True,
                           "invert_tilt": True}, {}),
                ("table", {"column": "hip", "unit": "cm", "com_height": 0.9}, {"mass": 154, "height": 1.75}),  # in pounds: a warning
                ("table", {"leg": "leg", "trunk": "trunk"}, {"detrend": "linear"}),
                ("table", {"hip": "hip", "shoulder": "shoulder", "ankle": "ankle", "unit": "cm", "height": 1.75},
                 {"mass": 70, "height": 1.75}),
                ("numbers", {"column": 2, "skip_lines": 5, "rate": 99.5, "unit": "rad", "tilt_column": 3, "tilt_unit": "rad"}, {}),
                ("sections", {"section": 2, "column": "offset"}, {"detrend": "offset"}),
                ("trials", {"trial_column": "subject", "trial": "s1", "column": "sway", "unit": "rad"}, {}),
                ("blocks", {"trial_column": "none", "column": "sway", "unit": "rad"}, {})):
            with self.subTest(name=name, reading=reading, keywords=keywords):
                path = self.folder / (name + ".csv")
                called = subprocess.run([DECID, "identify", path, "--json", "--quiet", *map(str, options_of({**reading, **keywords}))],
                                        capture_output=True, text=True)
                expected = json.loads(called.stdout)
                result = decid.identify(path, **reading | keywords)
                self.check_same(result, expected["recordings"][0])
                if result.tilt is not None:
                    self.assertEqual(vars(result.tilt), {key: expected["recordings"][0]["tilt"][key] for key in vars(result.tilt)})
                expected["body"].pop("participant", None)  # Python gives the body alone
                self.assertEqual(vars(result.body), expected["body"])
                upright = keywords.get("detrend", "none") != "none"
                again = decid.identify(decid.read(path, **reading, mean_is_upright=upright), **keywords)
                self.check_same(again, expected["recordings"][0])
            wanted -= {*reading, *keywords}
        self.assertEqual(wanted, set())
        self.assertEqual(decid.trial_names(self.folder / "trials.csv", "subject"), ["s1", "s2"])
        self.assertEqual(decid.trial_names(self.folder / "trials.csv", 1), ["s1", "s2"])
        self.assertEqual(len(decid.trial_names(self.folder / "trials.csv", "subject", skip_lines=0)), 2)
        offset = decid.Recording(sway + 25, 100, "deg", mean_is_upright=True)
        self.assertNotIn("large_sway", [notice.code for notice in offset.warnings])
        for unit, size in {"deg": np.pi / 180, "rad": 1, "mrad": 1e-3, "mm": 1e-3, "cm": 1e-2, "m": 1}.items():
            height = {"com_height": 2.5} if unit.endswith("m") else {}
            found = decid.read(self.folder / "table.csv", column="sway", unit=unit, **height).sway
            flat = columns["sway"] * size
            np.testing.assert_allclose(found, np.arcsin((flat - flat.mean()) / 2.5) if height else flat, atol=1e-9)

    def test_samples_have_the_bits_of_their_file(self):
        sway = np.genfromtxt(self.trial(), delimiter=",", names=True)["com_sway_deg"]
        path = self.folder / "samples.csv"
        np.savetxt(path, sway, fmt="%.17g", header="com_sway_deg", comments="")
        expected = json.loads(program("identify", path, "--rate", 100, "--json"))["recordings"][0]
        self.check_same(decid.identify(sway, rate=100, unit="deg"), expected)
        self.check_same(decid.identify(list(sway), 100, "deg"), expected)
        self.check_same(decid.identify(np.repeat(sway, 2)[::2], 100, "deg"), expected)  # not contiguous

    def test_simulation_has_the_bits_of_the_program(self):
        path = self.folder / "trial.csv"
        program("simulate", "--seed", 9, "--kp", 800, "--delay", 0.1, "--quiet", "-o", path)
        table = np.genfromtxt(path, delimiter=",", names=True)
        trial = decid.simulate(seed=9, Kp=800, delay=0.1)
        self.assertEqual(["%.10g" % value for value in np.rad2deg(trial.sway[:500])],
                         ["%.10g" % value for value in table["com_sway_deg"][:500]])
        np.testing.assert_allclose(np.rad2deg(trial.tilt), table["tilt_deg"], rtol=1e-9, atol=1e-12)
        self.assertEqual(trial.parameters["Kp"], 800.0)
        many = decid.simulate(seed=8, Kp=[700, 800], delay=0.1)
        self.assertEqual(many.sway.shape, (2, 12100))
        np.testing.assert_array_equal(many.sway[1], trial.sway)
        self.assertTrue(many.valid.all())

    def test_controllers_have_their_own_parameters(self):
        self.assertEqual(list(decid.controllers()), ["dec", "dec2015", "ic"])
        path = self.folder / "trial.csv"
        program("simulate", "--seed", 9, "--controller", "ic", "--weight", 0.5, "--protocol", "short", "--quiet", "-o", path)
        table = np.genfromtxt(path, delimiter=",", names=True)
        trial = decid.simulate("short", seed=9, controller="ic", W=0.5)
        self.assertEqual(list(trial.parameters), ["Kp", "Kd", "W", "Kt", "Nv", "delay"])
        self.assertEqual(["%.10g" % value for value in np.rad2deg(trial.sway[:500])],
                         ["%.10g" % value for value in table["com_sway_deg"][:500]])
        protocol = decid.Protocol("short", controller="ic")
        self.assertEqual(protocol.controller, "ic")
        self.assertEqual(protocol.settings["controller"], "ic")
        np.testing.assert_array_equal(decid.simulate(protocol, seed=9, W=0.5).sway, trial.sway)
        self.assertEqual(decid.Protocol().controller, "dec")
        for call in (lambda: decid.simulate(protocol, controller="ic"), lambda: decid.Protocol("short", "pid"),
                     lambda: decid.simulate(controller="dec2015", W=0.5)):
            with self.assertRaises(decid.Error):
                call()

    def test_a_fall_is_refused_unless_allowed(self):
        with self.assertRaisesRegex(decid.Error, "the body of trial 1 falls"):
            decid.simulate(Kp=[800, 0], Kp_pass=100)
        trials = decid.simulate(Kp=[800, 0], Kp_pass=100, allow_falls=True)
        self.assertEqual(trials.valid.tolist(), [True, False])
        self.assertTrue(np.isnan(trials.sway[1, -1]))

    def test_samples_with_a_tilt_have_the_bits_of_a_file(self):
        trial = decid.simulate(seed=7)
        sway, tilt = np.concatenate([np.zeros(250), trial.sway]), np.concatenate([np.zeros(250), np.rad2deg(trial.tilt)])
        path = self.folder / "log.csv"
        np.savetxt(path, np.column_stack([np.arange(len(sway)) / 100, sway, tilt]), fmt=["%.2f", "%.17g", "%.17g"], delimiter=",",
                   comments="", header="time,sway_rad,platform_deg")
        expected = json.loads(program("identify", path, "--json", "--tilt-column", "platform_deg"))["recordings"][0]
        for result in (decid.identify(decid.Recording(sway, 100, "rad", tilt=tilt, tilt_unit="deg")),
                       decid.identify(-sway, 100, "rad", tilt=-tilt, tilt_unit="deg", invert_sway=True, invert_tilt=True)):
            self.check_same(result, expected)
        self.assertAlmostEqual(result.tilt.delay_s, 2.5, places=3)
        self.assertIsNone(decid.Recording(sway, 100, "rad").tilt)

    def test_it_is_a_mapping_and_prints_in_a_terminal_a_notebook_and_pandas(self):
        result = decid.identify(decid.simulate(seed=7))
        self.assertEqual((list(result), len(result)), (list(result.parameters), len(result.parameters)))
        self.assertIn("Kp", result)
        with self.assertRaisesRegex(KeyError, "there is no parameter 'kp': give Kp, "):
            result["kp"]
        self.assertTrue(str(result).startswith("usable\n"))
        self.assertIn("Kp_pass", str(result))
        page = result._repr_html_()
        self.assertEqual(page.count("<tr>"), 8)
        self.assertEqual(page.count("<svg"), 7)
        low, high = result["delay"].interval90
        self.assertIn(f"{low:.5g} to {high:.5g}", page)
        rows = result.rows()
        self.assertEqual(rows[6]["interval90_low"], low)
        json.dumps(rows)
        frame = result.to_frame()
        self.assertEqual(frame.loc["delay", "interval90_high"], high)
        self.assertEqual(list(frame.index), list(result.parameters))
        changed = type(result)(**{**vars(result), "warnings": (decid.Notice("caution", "c", "<b>&"),)})
        self.assertIn("<li>caution: &lt;b&gt;&amp;</li>", changed._repr_html_())


class Fits(WithFolder):
    def test_a_fit_has_the_bits_of_the_program(self):
        golden = SOURCE / "tests/golden/0.2.0"  # a network of trials of 4 s, whose fit takes little time
        model = golden / "net.safetensors"
        path = self.trial("--protocol", golden / "protocol.json")
        draws = self.folder / "draws.npz"
        keywords = dict(model=model, protocol=golden / "protocol.json", max_draws=8, seed=3, ranges={"Kp": (300, 2000)},
                        priors={"delay": (0.12, 0.02), "Kp/mgh": (1.0, 0.2)}, moved_before=True, mass=70, height=1.75,
                        detrend="offset", prior_start=0.05, prior_gain=0.1, prior_noise=0.05)
        of_identify = inspect.signature(decid.identify).parameters
        wanted = set(inspect.signature(decid.fit).parameters) - set(of_identify) - {"progress", "controllers"}
        self.assertEqual(wanted - set(keywords), set())
        expected = json.loads(program("fit", path, *options_of(keywords), "--draws", draws, "--json", "--quiet"))["recordings"][0]
        reported = []
        found = decid.fit(path, **keywords, progress=lambda done, stage: reported.append((done, stage)))
        self.check_same(found, expected)
        for name in ("sensor_noise_deg", "start_s", "gain"):
            quantity = found.quantities[name]
            self.assertEqual([quantity.value, quantity.sd, list(quantity.interval90)],
                             [expected[name][key] for key in ("value", "sd", "interval90")])
        diagnostics = expected["diagnostics"]
        self.assertEqual({p.name: p.rhat for p in found._shown().values()}, diagnostics["rhat"])
        self.assertEqual((found.sampling.chains, found.sampling.draws, found.sampling.divergences, found.sampling.agreed),
                         tuple(diagnostics[key] for key in ("chains", "draws", "divergences", "agreed")))
        arrays = np.load(draws)
        np.testing.assert_array_equal(np.stack([found.draws[name] for name in found.parameters], axis=1), arrays["parameters"])
        np.testing.assert_array_equal(found.draws["gain"], arrays["gain"].ravel())
        # ArviZ: from_dict() takes arrays whose axes are chain and draw, and log likelihoods with a third of observations.
        for name in (*found.parameters, "sensor_noise_deg", "lp", "diverging", "energy", "acceptance_rate"):
            self.assertEqual(arrays[name].shape, (8, 8), name)
        np.testing.assert_array_equal(found.draws["Kp"], arrays["Kp"].ravel())
        self.assertEqual(arrays["diverging"].sum(), diagnostics["divergences"])
        likelihood = arrays["log_likelihood"]
        self.assertEqual(likelihood.shape, (8, len(arrays["log_likelihood_draw"]), expected["log_predictive_density"]["blocks"]))
        self.assertTrue(np.isfinite(likelihood).all())
        np.testing.assert_array_equal(arrays["log_likelihood_block"], np.arange(likelihood.shape[2]))
        np.testing.assert_array_equal(found.draws_frame()["chain"], arrays["chain"])
        self.assertEqual(reported, sorted(reported, key=lambda at: at[0]))
        self.assertEqual(reported[0][1], "annealing")
        self.assertIn("sensor_noise_deg", found.to_frame().index)

    def test_a_fit_with_the_protocol_of_another_controller_has_its_parameters(self):
        golden = SOURCE / "tests/golden/0.2.0"
        protocol = decid.Protocol(golden / "protocol.json", "dec2015")
        path = self.trial("--protocol", golden / "protocol.json")
        found = decid.fit(path, model=golden / "net.safetensors", protocol=protocol, max_draws=8)
        self.assertEqual(list(found.parameters), [info.name for info in protocol.parameters])
        self.assertEqual(list(found.quantities), ["sensor_noise_deg", "start_s", "gain"])

    def test_several_controllers_are_compared_with_the_bits_of_the_program(self):
        golden = SOURCE / "tests/golden/0.2.0"
        path = self.trial("--protocol", golden / "protocol.json")
        keywords = dict(model=golden / "net.safetensors", max_draws=8, ranges={"Kp": (300, 2000), "W": (0.2, 0.8)})
        expected = json.loads(program("fit", path, *options_of(keywords), "--controller", "ic,dec", "--json", "--quiet"))["recordings"][0]
        found = decid.fit(path, **keywords, controllers=["ic", "dec"])
        self.check_same(found, expected)
        self.assertEqual(list(found.comparison), ["ic", "dec"])
        for of in expected["controllers"]:
            compared = found.comparison[of["controller"]]
            self.assertEqual(vars(compared), {key: of[key] for key in vars(compared)})
        self.assertEqual({compared.difference == 0 for compared in found.comparison.values()}, {True, False})
        self.assertEqual(pickle.loads(pickle.dumps(found)).comparison, found.comparison)
        one = decid.fit(path, model=golden / "net.safetensors", max_draws=8, controllers="ic")
        self.assertEqual((one.comparison, list(one.parameters)), ({}, list(found.parameters)))

    def test_controllers_that_cannot_be_compared_are_refused(self):
        trial = decid.simulate(seed=7)
        of_dec2015 = decid.Protocol("default", "dec2015")
        for code, keywords in (("setting_unknown", {"controllers": ["dec", "pid"]}), ("setting_conflict", {"controllers": "dec,ic,dec"}),
                               ("setting_malformed", {"controllers": ["dec", 2015]}), ("setting_malformed", {"controllers": 2015}),
                               ("setting_conflict", {"controllers": ["dec", "ic"], "protocol": of_dec2015})):
            with self.subTest(keywords), self.assertRaises(decid.Error) as raised:
                decid.fit(trial, **keywords)
            self.assertEqual((raised.exception.code, raised.exception.where), (code, "controllers"))

    def test_what_a_callback_raises_comes_out(self):
        def end(done, stage):
            raise KeyError(stage)
        with self.assertRaisesRegex(KeyError, "annealing"):
            decid.fit(decid.simulate(seed=7), progress=end)

    def test_control_c_stops_a_fit(self):
        timer = threading.Timer(0.3, lambda: os.kill(os.getpid(), signal.SIGINT))
        timer.start()
        with self.assertRaises(KeyboardInterrupt):
            decid.fit(decid.simulate(seed=7), max_draws=100000)

    def test_other_threads_run_meanwhile(self):
        counted = []
        over = threading.Event()

        def count():
            while not over.is_set():
                counted.append(time.perf_counter())
                time.sleep(0.001)
        thread = threading.Thread(target=count)
        trial = decid.simulate(seed=7)
        thread.start()
        begin = time.perf_counter()
        decid.Dataset.make(200, seed=5)
        decid.evaluate(None, decid.Dataset.make(100, seed=6))
        decid.identify(trial)
        end = time.perf_counter()
        over.set()
        thread.join()
        # With the lock held none would have been counted within.
        self.assertGreater(sum(begin < at < end for at in counted), 10)


class Studies(WithFolder):
    def sheet(self, persons=4, options=(), columns=("", "")):
        rows = ["participant_id,group,session,file,age,height,weight" + columns[0]]
        for person in range(persons):
            for session in (1, 2):
                file = f"p{person}_{session}.csv"
                program("simulate", "--seed", 10 * person + session, *options, "--quiet", "-o", self.folder / file)
                rows.append(f"p{person},{'ab'[person % 2]},{session},{file},{60 + person},1.75,70" + columns[1])
        path = self.folder / "participants.csv"
        path.write_text("\n".join(rows) + "\n", encoding="utf-8")
        return path

    def test_a_study_is_the_json_of_the_program(self):
        path = self.sheet()
        study = decid.study(path, group=True, within=["session"], covariates=["age"])
        self.assertEqual(study.text, program("identify", "--study", path, "--group", path, "--within", "session",
                                             "--covariates", "age", "--json"))
        self.assertEqual([group["name"] for group in study.hierarchical["groups"]], ["a, 1", "a, 2", "b, 1", "b, 2"])
        self.assertEqual(len(study.hierarchical["interactions"]), 1)
        self.assertEqual(study.hierarchical["covariates"][0]["name"], "age")
        self.assertIs(study.groups, study.hierarchical)
        self.assertIs(study.comparisons, study.json["comparisons"])
        self.assertIn(["a, 1", "b, 1"], [pair["groups"] for pair in study.comparisons])
        rows = study.rows()
        self.assertEqual(len(rows), 8 * 7)
        self.assertEqual((rows[7]["participant_id"], rows[7]["session"], rows[7]["age"]), ("p0", "2", "60"))
        self.assertEqual(rows[7]["value"], study.recordings[1]["parameters"][0]["value"])
        self.assertEqual(repr(study), "Study(8 recordings, 0 with an error)")
        saved = self.folder / "saved.json"
        saved.write_text(study.text, encoding="utf-8")
        program("rerun", saved)
        (self.folder / "p0_1.csv").unlink()
        self.assertEqual(decid.study(path, within="session", covariates="age").text,
                         decid.study(path, within=["session"], covariates=["age"]).text)
        lost = decid.study(path)
        self.assertIsNone(lost.hierarchical)
        self.assertIsNone(lost.groups)
        self.assertEqual(lost.comparisons, [])
        self.assertEqual(lost.recordings[0]["code"], "file_missing")
        self.assertEqual(lost.rows()[0]["parameter"], None)
        self.assertIn("1 with an error", repr(lost))

    def test_a_small_study_has_comparisons_and_no_hierarchical_model(self):
        small = decid.study(self.sheet(persons=2), group=True)
        self.assertIsNone(small.hierarchical)
        self.assertIsNone(small.groups)
        self.assertEqual([pair["groups"] for pair in small.comparisons], [["a", "b"]])

    def test_fits_of_a_study_have_the_bits_of_the_program(self):
        brief = {"name": "tiny", "sensor_noise_deg": 0.02, "sample_rate_hz": 20,
                 "sequence": {"feedback": [0, 0, -1, 1], "start": [0, 0, 0, 1], "state_s": 0.1, "amplitude_deg": 4,
                              "offset_s": 0, "cycles": 2}}
        protocol = self.folder / "tiny.json"
        protocol.write_text(json.dumps(brief))
        path = self.sheet(1, ("--protocol", protocol), (",protocol", ",tiny.json"))
        stages = []
        study = decid.study(path, fit=True, joint="participant_id", free="theta,Nv:session", max_draws=8, seed=3,
                            progress=lambda done, stage: stages.append(done))
        self.assertEqual(study.text, program("fit", "--study", path, "--joint", "participant_id", "--free",
                                             "theta,Nv:session", "--max-draws", 8, "--seed", 3, "--json"))
        self.assertTrue(stages and 0 <= min(stages) <= max(stages) <= 1)

        compared = decid.study(path, fit=True, controllers=["ic", "dec"], max_draws=8)
        expected = program("fit", "--study", path, "--controller", "ic,dec", "--max-draws", 8, "--seed", 1, "--json")
        self.assertEqual(compared.text, expected.replace("(--range)", "(ranges)"))  # a warning, with Python's name of the setting
        self.assertEqual([one["controller"] for one in compared.json["controller_comparison"]["controllers"]], ["ic", "dec"])

        def stop(done, stage):
            raise KeyError(stage)

        with self.assertRaises(KeyError):
            decid.study(path, fit=True, max_draws=8, progress=stop)

    def test_studies_that_cannot_be_made_are_refused(self):
        path = self.sheet(1)
        for code, keywords in (("file_missing", {"sheet": self.folder / "none.csv"}),
                               ("setting_conflict", {"sheet": path, "joint": "participant_id"})):
            with self.subTest(keywords), self.assertRaises(decid.Error) as raised:
                decid.study(**keywords)
            self.assertEqual(raised.exception.code, code)


class Sets(WithFolder):
    def test_a_data_set_is_the_programs(self):
        path, mine, straight = (self.folder / name for name in ("program.npz", "mine.npz", "straight.npz"))
        program("dataset", "--count", 40, "--base", 30, "--seed", 99, "--quiet", "-o", path)
        data = decid.Dataset.make(40, base=30, seed=99)
        data.write(mine)
        self.assertEqual(mine.read_bytes(), path.read_bytes())
        done = []
        on_disk = decid.Dataset.make(40, base=30, seed=99, path=straight, progress=lambda part, stage: done.append(part))
        self.assertEqual(straight.read_bytes(), path.read_bytes())
        self.assertEqual(done[-1], 1.0)
        arrays = np.load(path)
        for dataset in (data, on_disk, decid.Dataset.read(path)):
            self.assertEqual(len(dataset), 40)
            for name in ("sway", "parameters", "group", "split"):
                np.testing.assert_array_equal(getattr(dataset, name), arrays[name])
                self.assertEqual(getattr(dataset, name).dtype, arrays[name].dtype)
        self.assertEqual(data.names[0], "Kp")

    def test_evaluation_is_the_programs(self):
        path = self.folder / "data.npz"
        program("dataset", "--count", 40, "--seed", 99, "--quiet", "-o", path)
        expected = json.loads(program("evaluate", "--data", path, "--json"))
        found = decid.evaluate(None, path)
        for key in ("trials", "mse", "matlab_loss", "mse_per_parameter", "coverage50", "coverage90", "log_score"):
            self.assertEqual(getattr(found, key), expected[key])

    def test_training_is_the_programs(self):
        data, architecture, model = (self.folder / name for name in ("data.npz", "architecture", "model.safetensors"))
        program("dataset", "--count", 40, "--seed", 5, "--quiet", "-o", data)
        architecture.write_text(TINY)
        options = ["--architecture", architecture, "--epochs", 2, "--batch", 10, "--lr", 0.02, "--momentum", 0.5,
                   "--weight-decay", 0.001, "--seed", 3, "--quiet", "--json", "-o", model]
        keywords = dict(architecture=TINY, epochs=2, batch=10, learning_rate=0.02, momentum=0.5, weight_decay=0.001, seed=3)
        expected = json.loads(program("train", "--data", data, *options))
        epochs, batches = [], []
        trained = decid.train(decid.Dataset.read(data), **keywords, on_epoch=epochs.append,
                              on_batch=lambda *at: batches.append(at))
        self.assertEqual(trained.sha256, expected["weights_sha256"])
        self.assertEqual([epoch.epoch for epoch in epochs], [1, 2])
        self.assertEqual(epochs[1].validation_mse, expected["validation_mse"])
        self.assertEqual(batches, [(1, 10, 20), (1, 20, 20), (2, 10, 20), (2, 20, 20)])
        self.assertEqual(decid.train(data, **keywords).sha256, trained.sha256)
        mine = self.folder / "mine.safetensors"
        trained.save(mine)
        self.assertEqual(mine.read_bytes(), model.read_bytes())
        self.assertEqual(decid.Model(mine).sha256, trained.sha256)

        streamed = json.loads(program("train", "--stream", "--stream-trials", 40, "--validation-trials", 20, *options[:-1],
                                      self.folder / "streamed.safetensors"))
        again = decid.train("default", **keywords, stream_trials=40, validation_trials=20)
        self.assertEqual(again.sha256, streamed["weights_sha256"])

    def test_a_callback_ends_a_training(self):
        def end(epoch):
            raise StopIteration
        with self.assertRaises(StopIteration):
            decid.train("default", architecture=TINY, epochs=50, batch=20, stream_trials=40, validation_trials=20,
                        on_epoch=end)


class Networks(unittest.TestCase):
    def test_layers_and_weights_are_the_files(self):
        model = decid.Model()
        data = (SOURCE / "models/built_in.safetensors").read_bytes()
        size = int.from_bytes(data[:8], "little")
        header = json.loads(data[8:8 + size])
        weights = model.network.weights
        named = {name: of for name, of in header.items() if name.startswith("layers.")}
        self.assertEqual(set(weights), set(named))
        for name, of in named.items():
            first, last = of["data_offsets"]
            expected = np.frombuffer(data[8 + size + first:8 + size + last], "<f4").reshape(of["shape"])
            np.testing.assert_array_equal(weights[name], expected)
        self.assertEqual("\n".join(layer.text for layer in model.network.layers), header["__metadata__"]["architecture"])
        self.assertEqual(model.network.layers[-1].output_shape, (72, 1, 1))
        self.assertIn("conv", repr(model.network))
        self.assertIn("<td>", model.network._repr_html_())

    def test_arrays_are_views_that_keep_their_owner(self):
        weights = decid.Model().network.weights
        one = weights["layers.0.weight"]
        self.assertIs(one.flags.owndata, False)
        self.assertIs(one.flags.writeable, False)
        with self.assertRaises(ValueError):
            one.setflags(write=True)
        copy = one.copy()
        del weights
        gc.collect()
        np.testing.assert_array_equal(one, copy)
        data = decid.Dataset.make(4, seed=3)
        self.assertEqual(data.sway.ctypes.data, data.sway.ctypes.data)
        sway = data.sway
        kept = sway.copy()
        del data
        gc.collect()
        np.testing.assert_array_equal(sway, kept)

    def test_models_and_protocols_are_pickled_and_copied(self):
        for copied in (lambda value: pickle.loads(pickle.dumps(value)), copy.copy, copy.deepcopy):
            for protocol in (decid.Protocol("short"), decid.Protocol("default", "dec2015"), decid.Model().protocol):
                again = copied(protocol)
                self.assertEqual(again.settings, protocol.settings)
                np.testing.assert_array_equal(again.tilt, protocol.tilt)
            model = copied(decid.Model())
            self.assertEqual(model.sha256, decid.Model().sha256)
            self.assertEqual(copied(model.network).layers, model.network.layers)
            self.assertEqual(decid.identify(decid.simulate(seed=7), model=model)["Kp"], decid.identify(decid.simulate(seed=7))["Kp"])
        result = decid.identify(decid.simulate(seed=7))
        self.assertEqual(pickle.loads(pickle.dumps(result)).parameters, result.parameters)

    def test_protocols(self):
        default, short = decid.Protocol(), decid.Protocol("short")
        self.assertEqual((default.samples, default.rate, short.samples), (12100, 100.0, 6370))
        self.assertEqual(decid.Model().protocol.samples, 12100)
        self.assertEqual([info.name for info in short.parameters], ["Kp", "Kd", "Kp_pass", "Kd_pass", "Nv", "theta", "delay"])
        self.assertEqual(short.settings["name"], "short")
        self.assertEqual(short.tilt.shape, (6370,))


class Refusals(WithFolder):
    def refused(self, code, call, *arguments, **keywords):
        with self.assertRaises(decid.Error) as caught:
            call(*arguments, **keywords)
        error = caught.exception
        self.assertEqual(error.code, code)
        self.assertEqual(str(error), f"{error.where}: {error.problem}; {error.remedy}")
        self.assertTrue(error.remedy)

    def test_paths_that_are_not_utf8(self):
        from decid import nn
        path = self.folder / os.fsdecode(b"\xff.csv")
        for given in (path, str(path), os.fsencode(path)):
            self.refused("file_missing", decid.read, given)
            self.refused("file_missing", decid.identify, given)
            self.refused("file_missing", decid.study, given)
            self.refused("file_missing", decid.Model, given)
            with self.assertRaises(decid.Error) as caught:
                nn.load(given)
            self.assertEqual(os.fsencode(caught.exception.where), os.fsencode(path))
        expected = decid.read(self.trial()).sway
        (self.folder / "trial.csv").rename(path)
        for given in (path, str(path), os.fsencode(path)):
            np.testing.assert_array_equal(decid.read(given).sway, expected)

    def test_texts_paths_and_functions_that_c_cannot_take(self):
        sway = decid.simulate(seed=7).sway
        cut, refused = str(self.folder / "a\0b"), lambda *given, **named: self.refused("setting_malformed", *given, **named)
        model = decid.Model()
        for path in (cut, os.fsencode(cut), "\ud800"):
            for call in (decid.read, decid.identify, decid.study, decid.Model, decid.Protocol, decid.Dataset.read, decid.train, model.save):
                refused(call, path)
            refused(decid.trial_names, path, "subject")
            refused(decid.Dataset.make, 20, path=path)
        self.assertEqual(list(self.folder.iterdir()), [])
        for call in (decid.read, decid.study, decid.Protocol, decid.Dataset.read, decid.train, model.save):
            refused(call, None)
        recording = self.trial()
        for text in ("x\0y", "\udcff"):
            for name in ("column", "tilt_column", "section", "trial_column", "trial", "leg", "hip"):
                refused(decid.read, recording, **{name: text})
            refused(decid.Protocol, "default", text)
            refused(decid.simulate, controller=text)
            refused(decid.fit, sway, 100, "rad", controllers=text)
            refused(decid.fit, sway, 100, "rad", controllers=[text])
            refused(decid.fit, sway, 100, "rad", ranges={text: (0, 1)})
            for name in ("joint", "free", "within", "covariates"):
                refused(decid.study, "no.tsv", **{name: text})
            for name in ("preset", "architecture", "head", "schedule"):
                refused(decid.train, "default", **{name: text})
        self.refused("setting_unknown", decid.identify, sway, 100, ["deg"])
        for number in (10**400, 10**5000):
            refused(decid.identify, sway, 100, "rad", mass=number, height=1.8)
            self.refused("value_invalid", decid.identify, [number] * 12000, 100, "rad")
        refused(decid.fit, sway, 100, "rad", progress=3)
        with self.assertRaisesRegex(decid.Error, "^progress: is 3;"):
            decid.fit(sway, 100, "rad", progress=3)
        refused(decid.study, "no.tsv", progress=3)
        refused(decid.Dataset.make, 20, progress=3)
        refused(decid.train, "default", on_batch=3)
        refused(decid.train, "default", on_epoch="print")

    def test_bad_input(self):
        sway = decid.simulate(seed=7).sway
        self.refused("file_missing", decid.read, "no.csv")
        self.refused("setting_missing", decid.identify, sway)
        self.refused("setting_out_of_range", decid.identify, self.trial(), unit="cm", com_height=1.9, mass=70, height=1.75)
        self.refused("setting_missing", decid.Recording, sway, 100, None)
        self.refused("setting_unknown", decid.identify, sway, 100, "grad")
        self.refused("setting_unknown", decid.identify, sway, 100, "rad", detrend="no")
        self.refused("setting_conflict", decid.identify, decid.Recording(sway, 100, "rad"), 100)
        self.refused("setting_unknown", decid.simulate, kp=900)
        self.refused("size_mismatch", decid.simulate, Kp=np.full((2, 2), 900.0))
        self.refused("setting_out_of_range", decid.train, "default", epochs=0)
        self.refused("setting_unknown", decid.train, "default", image={"no": 1})
        self.refused("setting_conflict", decid.identify, sway, 100, "rad", fill_gaps=0.1)
        with self.assertRaisesRegex(TypeError, "heigth"):
            decid.identify(sway, 100, "rad", mass=70, heigth=1.75)
        values = np.sin(np.arange(12000) / 50)
        self.refused("value_missing", decid.identify, np.ma.masked_array(values, mask=np.arange(12000) < 3), 100, "deg")
        self.assertEqual(len(decid.Recording(np.ma.masked_array(values), 100, "deg").sway), 12000)
        self.refused("value_invalid", decid.Recording, values + 1j, 100, "deg")

    def test_values_of_other_types_and_shapes(self):
        sway = decid.simulate(seed=7).sway
        short = sway[:2000]
        for name, code, call in (
                ("sway", "size_mismatch", lambda: decid.identify(sway[None], 100, "rad")),
                ("sway", "value_invalid", lambda: decid.identify(["a"], 100, "rad")),
                ("unit", "unit_unknown", lambda: decid.Recording(sway, 100, "cm")),
                ("rate", "setting_out_of_range", lambda: decid.Recording(sway, np.nan, "rad")),
                ("rate", "setting_out_of_range", lambda: decid.Recording(sway, 0, "rad")),
                ("rate", "setting_malformed", lambda: decid.Recording(sway, "fast", "rad")),
                ("height", "setting_missing", lambda: decid.identify(sway, 100, "rad", mass=70)),
                ("mass", "setting_out_of_range", lambda: decid.identify(sway, 100, "rad", mass=0, height=1.7)),
                ("begin", "setting_malformed", lambda: decid.identify(sway, 100, "rad", begin="now")),
                ("begin", "setting_out_of_range", lambda: decid.identify(sway, 100, "rad", begin=np.nan)),
                ("com_height", "setting_out_of_range", lambda: decid.read("no.csv", com_height=0)),
                ("fill_gaps", "setting_out_of_range", lambda: decid.read("no.csv", fill_gaps=61)),
                ("threads", "setting_out_of_range", lambda: decid.set_threads(0)),
                ("threads", "setting_malformed", lambda: decid.set_threads(1.5)),
                ("seed", "setting_out_of_range", lambda: decid.simulate(seed=-1)),
                ("seed", "setting_out_of_range", lambda: decid.simulate(seed=2**64)),
                ("seed", "setting_malformed", lambda: decid.simulate(seed=1.5)),
                ("seed", "setting_malformed", lambda: decid.fit(short, 100, "rad", seed=1.0)),
                ("seed", "setting_out_of_range", lambda: decid.Dataset.make(4, seed=-1)),
                ("count", "setting_malformed", lambda: decid.Dataset.make(4.0)),
                ("epochs", "setting_malformed", lambda: decid.train("default", epochs=1.5)),
                ("max_draws", "setting_malformed", lambda: decid.fit(short, 100, "rad", max_draws=8.5)),
                ("max_draws", "setting_out_of_range", lambda: decid.fit(short, 100, "rad", max_draws=7)),
                ("priors", "setting_malformed", lambda: decid.fit(short, 100, "rad", priors={"delay": 0.1})),
                ("priors", "setting_malformed", lambda: decid.fit(short, 100, "rad", priors={"delay": ("a", 1)})),
                ("ranges", "setting_malformed", lambda: decid.fit(short, 100, "rad", ranges=[("delay", 0, 1)])),
                ("invert_sway", "setting_malformed", lambda: decid.Recording(sway, 100, "rad", invert_sway="no")),
                ("invert_tilt", "setting_malformed", lambda: decid.read("no.csv", invert_tilt="no")),
                ("moved_before", "setting_malformed", lambda: decid.fit(sway, 100, "rad", moved_before="no")),
                ("group", "setting_malformed", lambda: decid.study("no.tsv", group="group")),
                ("fit", "setting_malformed", lambda: decid.study("no.tsv", fit=0.5)),
                ("allow_falls", "setting_malformed", lambda: decid.simulate(allow_falls="no")),
                ("tilt", "value_invalid", lambda: decid.Recording(sway, 100, "rad", tilt=np.arange(len(sway)).astype("m8[ms]"))),
                ("simulate", "size_mismatch", lambda: decid.simulate(Kp=[800, 900], delay=[0.1, 0.11, 0.12])),
                ("Kp", "value_invalid", lambda: decid.simulate(Kp="much")),
                ("Kp", "value_invalid", lambda: decid.simulate(Kp=900 + 1j)),
                ("Kp", "value_missing", lambda: decid.simulate(Kp=np.ma.masked_less([800.0, 900.0], 850)))):
            with self.subTest(name=name):
                self.refused(code, call)
                with self.assertRaisesRegex(decid.Error, f"^{name}: "):
                    call()

    def test_messages_name_the_arguments_of_python(self):
        with self.assertRaises(decid.Error) as caught:
            decid.identify(self.trial(), tilt_column="none", begin=500)
        self.assertIn(" begin ", caught.exception.remedy)

    def test_a_tilt_in_memory(self):
        trial = decid.simulate(seed=7)
        self.refused("size_mismatch", decid.identify, trial.sway, 100, "rad", tilt=trial.tilt[:-1])
        self.refused("size_mismatch", decid.Recording, trial.sway, 100, "rad", tilt=0.1)
        self.refused("value_missing", decid.Recording, trial.sway, 100, "rad", tilt=np.ma.masked_less(trial.tilt, 0))
        self.refused("unit_unknown", decid.Recording, trial.sway, 100, "rad", tilt=trial.tilt, tilt_unit="mm")
        self.refused("setting_unknown", decid.Recording, trial.sway, 100, "rad", tilt=trial.tilt, tilt_unit="grad")
        self.refused("setting_missing", decid.identify, trial.sway, 100, "rad", invert_tilt=True)
        self.refused("setting_conflict", decid.identify, trial.sway, 100, "rad", tilt=trial.tilt, fill_gaps=0.1)
        self.refused("setting_conflict", decid.identify, decid.Recording(trial.sway, 100, "rad"), tilt=trial.tilt)
        self.refused("setting_conflict", decid.identify, self.trial(), tilt=trial.tilt)
        for lines in (-1, -7):
            self.refused("setting_out_of_range", decid.read, self.folder / "trial.csv", skip_lines=lines)
            self.refused("setting_out_of_range", decid.trial_names, self.folder / "trial.csv", "subject", skip_lines=lines)

    def test_a_fork_is_refused_and_a_process_of_its_own_is_not(self):
        decid.set_threads(2)
        decid.identify(decid.simulate(seed=7))
        with self.assertRaisesRegex(decid.Error, "forked"):
            with multiprocessing.get_context("fork").Pool(1) as pool:
                pool.apply(decid.Protocol)
        code = "import decid, os; decid.simulate(); print(decid.identify(decid.simulate(seed=7)).trust)"
        self.assertEqual(subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True).stdout,
                         "usable\n")

    def test_a_fork_of_one_thread_computes(self):
        code = '''
import multiprocessing
import decid.nn
decid.set_threads(1)
trial = decid.simulate(seed=7)
expected = decid.identify(trial)["Kp"].value

net = decid.nn.Network((1, 6, 6), "fc 3")
net.initialise(1)
inputs = [[[[1.0] * 6] * 6]]
outputs = net.predict(inputs).tolist()

def identify(threads):
    decid.set_threads(threads)
    assert net.predict(inputs).tolist() == outputs
    return decid.identify(trial)["Kp"].value

with multiprocessing.get_context("fork").Pool(1) as pool:
    for threads in (1, 2):
        assert pool.apply_async(identify, (threads,)).get(60) == expected
print("same")
'''
        done = subprocess.run([sys.executable, "-c", code], check=True, capture_output=True, text=True, timeout=120,
                              env={**os.environ, "OMP_NUM_THREADS": "2"})
        self.assertEqual(done.stdout, "same\n")

    def test_errors_are_of_their_thread(self):
        texts = {}

        def load(name):
            try:
                decid.Model(name)
            except decid.Error as error:
                texts[name] = error.where
        threads = [threading.Thread(target=load, args=(f"none{i}",)) for i in range(8)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
        self.assertEqual(texts, {f"none{i}": f"none{i}" for i in range(8)})


class Public(unittest.TestCase):
    def test_everything_public_has_a_docstring(self):
        for name in decid.__all__:
            self.assertTrue(getattr(decid, name).__doc__, name)

    def test_the_version_is_the_programs(self):
        self.assertIn(decid.__version__, program("--version"))


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])
