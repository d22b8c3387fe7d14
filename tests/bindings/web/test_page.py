#!/usr/bin/env python3
"""decid.html in headless Chromium, from a file, without a network: what it finds is the program's, byte for byte.

    test_page.py CHROMIUM DECID PAGE.html
"""
import base64
import http.server
import json
import pathlib
import re
import struct
import subprocess
import sys
import tempfile
import threading
import unittest
import zlib

from chromium import Chromium

HERE = pathlib.Path(__file__).resolve().parent
browser_program, decid, page = sys.argv[1:4]
page = pathlib.Path(page).resolve()
for needed in (page, pathlib.Path(decid)):
    if not needed.is_file():
        sys.exit(f"test_page.py: there is no {needed}; tools/build release and tools/build web make it")


def run_decid(folder, *arguments):
    return subprocess.run([decid, *arguments], cwd=folder, capture_output=True, text=True, check=False)


def matrix(name, values, compress=False):
    """A column of doubles as an element of a MAT-file of version 5."""
    def element(kind, data):
        return struct.pack("<II", kind, len(data)) + data + bytes(-len(data) % 8)
    body = (element(6, struct.pack("<II", 6, 0)) + element(5, struct.pack("<ii", len(values), 1)) +
            element(1, name.encode()) + element(9, struct.pack(f"<{len(values)}d", *values)))
    whole = struct.pack("<II", 14, len(body)) + body
    if not compress:
        return whole
    packed = zlib.compress(whole)
    return struct.pack("<II", 15, len(packed)) + packed


def mat5(columns, compress=False):
    header = b"MATLAB 5.0 MAT-file".ljust(124) + struct.pack("<H", 0x100) + b"IM"
    return header + b"".join(matrix(name, values, compress) for name, values in columns.items())


def mat4(columns):
    return b"".join(struct.pack("<5i", 0, len(values), 1, 0, len(name) + 1) + name.encode() + b"\0" +
                    struct.pack(f"<{len(values)}d", *values) for name, values in columns.items())


class Page(unittest.TestCase):
    flags, fragment, kernels = (), "", "relaxed"

    @classmethod
    def setUpClass(cls):
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = pathlib.Path(cls.scratch.name)
        for seed in (3, 4):
            run_decid(cls.folder, "simulate", "--quiet", "--seed", str(seed), "-o", f"trial{seed}.csv")
        rows = [line.split(",") for line in (cls.folder / "trial3.csv").read_text().splitlines()[1:]]
        columns = {name: [float(row[i]) for row in rows] for i, name in enumerate(("time", "COM_x", "tilt_deg"))}
        (cls.folder / "v4.mat").write_bytes(mat4(columns))
        (cls.folder / "v5.mat").write_bytes(mat5(columns))
        (cls.folder / "v7.mat").write_bytes(mat5(columns, compress=True))
        (cls.folder / "bad.csv").write_text("time,sway\n0,1\n1,x\n")
        cls.chromium = Chromium(browser_program, cls.flags)

    @classmethod
    def tearDownClass(cls):
        cls.chromium.close()
        cls.scratch.cleanup()

    def setUp(self):
        self.open()

    def open(self, width=1200):
        self.chromium.call("Emulation.setDeviceMetricsOverride", width=width, height=812, deviceScaleFactor=1, mobile=False)
        self.chromium.call("Page.navigate", url="about:blank")
        self.chromium.events.clear()
        self.chromium.call("Page.navigate", url=page.as_uri() + self.fragment)
        self.chromium.wait("document.body?.dataset.ready === 'yes'")
        self.assertEqual(self.chromium.evaluate("document.body.dataset.kernels"), self.kernels)

    def tearDown(self):
        self.assertEqual(self.chromium.complaints(), [])
        self.assertIsNone(self.chromium.evaluate("document.body.dataset.error ?? null"))

    def drop(self, files, done="identify"):
        """Drops (name, content) pairs as a person does; returns once they are answered."""
        self.start_drop(files)
        self.wait_for(done)

    def start_drop(self, files):
        given = json.dumps([[name, base64.b64encode(content).decode()] for name, content in files])
        self.chromium.evaluate("delete document.body.dataset.done")
        self.chromium.evaluate("""{
          const transfer = new DataTransfer();
          for (const [name, content] of %s)
            transfer.items.add(new File([Uint8Array.from(atob(content), c => c.charCodeAt(0))], name));
          at("drop").dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true, cancelable: true }));
        }""" % given)

    def problems(self):
        return self.chromium.evaluate("at('problems').textContent")

    def press(self, key, code, text=""):
        for kind in ("keyDown", "keyUp"):
            self.chromium.call("Input.dispatchKeyEvent", type=kind, key=key, code=key, windowsVirtualKeyCode=code, text=text)

    def type_in(self, field, text):
        """Writes a field's text as a person does, and leaves the field."""
        self.chromium.evaluate(f"at('{field}').focus(); at('{field}').select()")
        if text:
            self.chromium.call("Input.insertText", text=text)
        else:
            self.press("Delete", 46)
        self.press("Tab", 9)

    def choose(self, field, value):
        self.chromium.evaluate(f"at('{field}').value = '{value}'; at('{field}').dispatchEvent(new Event('change', {{ bubbles: true }}))")

    def drop_paths(self, *paths):
        """Drops files and folders of the system."""
        self.chromium.evaluate("delete document.body.dataset.done, delete document.body.dataset.taken")
        data = {"items": [], "files": [str(path) for path in paths], "dragOperationsMask": 1}
        for kind in ("dragEnter", "dragOver", "drop"):
            self.chromium.call("Input.dispatchDragEvent", type=kind, x=600, y=250, data=data)

    def wait_for(self, command):
        self.chromium.wait(f"document.body.dataset.done?.startsWith('{command} ')", 800)

    def read(self, *names):
        return [(name, (self.folder / name).read_bytes()) for name in names]

    def result(self, kind):
        return base64.b64decode(self.chromium.evaluate(
            f"btoa(Array.from(results.get(outputs.{kind}), c => String.fromCharCode(c)).join(''))"))

    def program_results(self, command, *arguments):
        outputs = [self.folder / f"program.{kind}" for kind in ("json", "html", "csv")]
        for output in outputs:
            output.unlink(missing_ok=True)
        run_decid(self.folder, command, *arguments, "-o", outputs[0], "--report", outputs[1], "--table", outputs[2])
        return [output.read_bytes() for output in outputs]

    def check_same(self, command, *arguments):
        for kind, expected in zip(("json", "html", "csv"), self.program_results(command, *arguments)):
            self.assertEqual(self.result(kind), expected, kind)


class Answers(Page):
    def test_a_dropped_recording_is_answered_as_by_the_program(self):
        self.drop(self.read("trial3.csv"))
        self.check_same("identify", "trial3.csv")

    def test_the_report_is_drawn(self):
        self.drop(self.read("trial3.csv"))
        self.chromium.wait("document.body.dataset.report !== undefined")
        self.assertGreater(int(self.chromium.evaluate("document.body.dataset.report")), 3)

    def test_options_reach_the_program_and_numbers_may_have_a_comma_or_a_point(self):
        self.chromium.evaluate("at('detrend').value = 'offset'")
        self.type_in("mass", "76,5")
        self.type_in("height", " 1.75 ")
        self.drop(self.read("trial4.csv"))
        self.check_same("identify", "trial4.csv", "--mass", "76.5", "--height", "1.75", "--detrend", "offset")

    def test_what_is_no_number_is_refused_at_its_field(self):
        for text in ("76,5 kg", "1.234,5", "1e2", "seventy", ","):
            with self.subTest(text):
                self.chromium.evaluate(f"at('mass').value = '{text}'; at('height').value = '1.75'")
                self.start_drop(self.read("trial4.csv"))
                self.chromium.wait("document.body.dataset.refused === 'true'")
                self.assertIn(f'Weight (kg): "{text}"', self.chromium.evaluate("at('problems').textContent"))
                self.assertEqual(self.chromium.evaluate("document.activeElement.id"), "mass")
                self.assertEqual(self.chromium.evaluate("at('mass').getAttribute('aria-invalid')"), "true")
                self.chromium.evaluate("document.body.dataset.refused = ''")
        self.chromium.evaluate("at('mass').value = '455'")
        self.drop(self.read("trial4.csv"))
        self.assertIn("1 to 250", self.chromium.evaluate("at('problems').textContent"))


class Uses(Page):
    def test_mat_files(self):
        for name in ("v4.mat", "v5.mat", "v7.mat"):
            with self.subTest(name):
                self.drop(self.read(name))
                self.check_same("identify", name)

    def test_bad_files_are_refused_and_cost_the_others_nothing(self):
        self.drop(self.read("trial3.csv", "bad.csv", "trial4.csv"))
        self.check_same("identify", "trial3.csv", "bad.csv", "trial4.csv")
        self.assertIn("bad.csv", self.chromium.evaluate("at('problems').textContent"))
        self.drop(self.read("bad.csv"))
        self.assertIn("bad.csv: line 3", self.chromium.evaluate("at('problems').textContent"))
        hdf5 = (b"MATLAB 7.3 MAT-file".ljust(124) + b"\x00\x02IM").ljust(512, b"\0") + b"\x89HDF\r\n\x1a\n"
        self.drop([("new.mat", hdf5)])
        self.assertIn("-v7", self.chromium.evaluate("at('problems').textContent"))
        self.drop([("set.npz", b"PK\x03\x04 and so on")])
        self.assertIn("set.npz: is an archive of NumPy arrays", self.chromium.evaluate("at('problems').textContent"))

    def test_a_hundred_at_once(self):
        content = (self.folder / "trial3.csv").read_bytes()
        self.drop([("trial.csv", content)] * 100)
        recordings = json.loads(self.result("json"))["recordings"]
        self.assertEqual(len(recordings), 100)
        self.assertEqual(len({recording["file"] for recording in recordings}), 100)
        self.assertEqual(len({json.dumps(recording["parameters"]) for recording in recordings}), 1)

    def test_hostile_names(self):
        content = (self.folder / "trial3.csv").read_bytes()
        names = ["<img src=x onerror=parent.document.title='bad'>.csv", "</script><script>document.title='bad'</script>.csv",
                 "--report=x.csv", "-", "*.csv", "a b;c'd\"e.csv"]
        self.drop([(name, content) for name in names])
        found = [recording["file"] for recording in json.loads(self.result("json"))["recordings"]]
        self.assertEqual(found, [name if not name.startswith("-") else "./" + name for name in names])
        self.assertNotIn("bad", self.chromium.evaluate("document.title"))
        self.assertEqual(self.chromium.evaluate("document.querySelectorAll('img').length"), 0)
        self.drop([(names[0], content)])
        self.assertEqual(self.chromium.evaluate("at('bar-title').textContent"), names[0])

    def test_pasted_and_simulated(self):
        text = (self.folder / "trial3.csv").read_text()
        self.chromium.evaluate(f"at('pasted').value = {json.dumps(text)}; at('identify-pasted').click()")
        self.wait_for("identify")
        self.assertEqual(json.loads(self.result("json"))["recordings"][0]["file"], "pasted.csv")
        self.chromium.evaluate("delete document.body.dataset.done; at('again').click(); at('example').click()")
        self.wait_for("identify")
        self.assertEqual(json.loads(self.result("json"))["recordings"][0]["file"], "simulated.csv")

    def test_a_fit_shows_how_far_it_is_and_can_be_cancelled(self):
        self.drop(self.read("trial3.csv"))
        self.chromium.evaluate("at('fit').click()")
        self.chromium.wait("at('progress').hasAttribute('value')", 120)
        self.assertRegex(self.chromium.evaluate("at('status').textContent"), "^Analysing: [0-9]+%, about [0-9]+ (s|min [0-9]+ s|min) left$")
        self.chromium.evaluate("at('cancel').click()")
        self.chromium.wait("at('work').hidden", 5)
        self.drop(self.read("trial4.csv"))
        self.check_same("identify", "trial4.csv")

    def test_keys_alone(self):
        reached = []
        for _ in range(8):
            self.press("Tab", 9)
            reached.append(self.chromium.evaluate("document.activeElement.id || document.activeElement.tagName"))
        self.assertEqual(reached, ["files", "SUMMARY", "mass", "height", "controller", "SUMMARY", "SUMMARY", "example"])
        self.press("Enter", 13, "\r")
        self.wait_for("identify")
        self.assertEqual(self.chromium.evaluate("document.activeElement.id"), "bar-title")
        self.press("Tab", 9)
        self.assertEqual(self.chromium.evaluate("document.activeElement.id"), "again")

    def test_widths_names_and_contrast(self):
        checks = (HERE.parents[1] / "tools/report/layout_checks.js").read_text()
        for width in (375, 900, 1200):
            for scheme in ("light", "dark"):
                with self.subTest(width=width, scheme=scheme):
                    self.chromium.call("Emulation.setEmulatedMedia", features=[{"name": "prefers-color-scheme", "value": scheme}])
                    self.open(width)
                    for answered in (False, True):
                        if answered:
                            self.drop(self.read("trial3.csv"))
                        found = self.chromium.evaluate(
                            "new Promise(resolve => { addEventListener('message', event => resolve(event.data), { once: true }); "
                            + checks.replace('addEventListener("load", () => setTimeout(', "(").replace(", 1000));", ")();") + " })")
                        self.assertEqual(found, "none")
        self.chromium.call("Emulation.setEmulatedMedia", features=[])


class Drops(Page):
    """Files and folders of the system; what cannot be read is said."""

    @classmethod
    def setUpClass(cls):
        super().setUpClass()
        study = cls.folder / "study"
        (study / "later" / ".hidden").mkdir(parents=True)
        trial = (cls.folder / "trial3.csv").read_bytes()
        for name in ("b.csv", "A.CSV", "later/c.txt", ".d.csv", "later/.hidden/e.csv", "later/notes.docx"):
            (study / name).write_bytes(trial)
        cls.recordings = ["study/A.CSV", "study/b.csv", "study/later/c.txt"]
        (cls.folder / "empty" / "within").mkdir(parents=True)
        (cls.folder / "many").mkdir()
        for number in range(1001):
            (cls.folder / "many" / f"{number}.csv").touch()

    def without(self, *calls):
        for call in calls:
            self.chromium.evaluate(f"delete DataTransferItem.prototype.{call}, 0")

    def refused(self, *paths):
        """Returns the page's message for a drop that it rejects."""
        self.drop_paths(*paths)
        self.chromium.wait("document.body.dataset.taken === '0'", 20)
        self.assertTrue(self.chromium.evaluate("at('work').hidden && recordings.length === 0"))
        return self.problems()

    def test_a_folder_gives_the_recordings_in_it_and_in_its_folders(self):
        self.drop_paths(self.folder / "study", self.folder / "trial4.csv")
        self.wait_for("identify")
        self.check_same("identify", *self.recordings, "trial4.csv")

    def test_names_of_recordings_are_the_program_s(self):
        said = run_decid(self.folder, "identify", "empty").stderr
        self.assertEqual(self.chromium.evaluate("at('files').accept").split(","), re.findall(r"\.[a-z0-9]+\b", said))

    def test_a_folder_by_entries(self):
        """As browsers without handles read it. Chromium has these for a page of a server only."""
        content = page.read_bytes()

        class Server(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                self.send_response(200)
                self.send_header("Content-Type", "text/html")
                self.end_headers()
                self.wfile.write(content if self.path == "/decid.html" else b"")

            def log_message(self, *_):
                pass

        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Server)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        self.chromium.call("Page.navigate", url=f"http://127.0.0.1:{server.server_port}/decid.html")
        self.chromium.wait("document.body?.dataset.ready === 'yes'")
        self.without("getAsFileSystemHandle")
        self.drop_paths(self.folder / "study")
        self.wait_for("identify")
        server.shutdown()
        self.check_same("identify", *self.recordings)

    def test_what_cannot_be_read_is_said(self):
        self.assertIn("empty: the folder holds no recording", self.refused(self.folder / "empty"))
        self.assertIn("more than 1000 recordings", self.refused(self.folder / "many"))
        self.without("getAsFileSystemHandle")
        self.assertIn("study: the browser does not read this folder", self.refused(self.folder / "study"))
        self.without("webkitGetAsEntry")
        self.assertIn("study: the browser does not read this file", self.refused(self.folder / "study"))
        self.chromium.evaluate("largestBytes = 1e4, 0")
        self.assertIn("more than 0.01 MB", self.refused(self.folder / "trial3.csv"))

    def test_a_folder_that_holds_nothing_costs_the_others_nothing(self):
        self.drop_paths(self.folder / "empty", self.folder / "trial3.csv")
        self.wait_for("identify")
        self.check_same("identify", "trial3.csv")
        self.assertIn("empty: the folder holds no recording", self.problems())

    def test_text_is_no_file(self):
        self.chromium.evaluate("""{
          const transfer = new DataTransfer();
          transfer.setData("text/plain", "0,1");
          at("drop").dispatchEvent(new DragEvent("drop", { dataTransfer: transfer, bubbles: true, cancelable: true }));
        }""")
        self.assertIn("No file was dropped", self.problems())

    def test_a_drop_during_a_fit_is_answered_and_the_fit_goes_on(self):
        self.drop(self.read("trial3.csv"))
        self.chromium.evaluate("at('fit').click()")
        self.start_drop(self.read("trial4.csv"))
        self.assertIn("trial4.csv", self.problems())
        self.assertEqual(self.chromium.evaluate("[at('work').hidden, working.command, recordings[0][0]]"), [False, "fit", "trial3.csv"])
        self.chromium.evaluate("at('cancel').click()")
        self.assertIn("trial4.csv", self.problems())
        self.drop(self.read("trial4.csv"))
        self.assertEqual(self.problems(), "")


class Changes(Page):
    """Settings that are changed after an answer."""

    def seen(self):
        """Returns three flags: a result is visible, it is marked as an earlier one, the page computes."""
        return self.chromium.evaluate("[!at('report').hidden && !at('bar').hidden, !at('stale').hidden, !at('work').hidden]")

    def changed(self, change):
        """Changes a setting by this script, and returns what is seen before the new answer."""
        self.chromium.evaluate("delete document.body.dataset.done")
        self.chromium.evaluate(change + "; at('settings').dispatchEvent(new Event('change'))")
        return self.seen()

    def note(self):
        return self.chromium.evaluate("at('stale-note').textContent")

    def test_the_same_recordings_are_answered_again(self):
        self.drop(self.read("trial3.csv"))
        self.chromium.evaluate("delete document.body.dataset.done; at('settings').open = true")
        before = self.result("json")
        self.type_in("mass", "76,5")
        self.assertEqual(self.seen(), [True, True, False])
        self.assertIn("Give both weight and height", self.note())
        self.type_in("height", "1.80")
        self.wait_for("identify")
        self.assertEqual(self.seen(), [True, False, False])
        self.check_same("identify", "trial3.csv", "--mass", "76.5", "--height", "1.80")
        self.assertTrue(self.chromium.evaluate("at('settings').open"))
        self.assertEqual(self.changed("at('mass').value = at('height').value = ''"), [True, True, True])
        self.wait_for("identify")
        self.assertEqual(self.result("json"), before)

    def test_an_earlier_answer_stays_and_is_marked(self):
        self.drop(self.read("trial3.csv"))
        before = self.result("html")
        self.assertEqual(self.changed("at('unit').value = 'mm'"), [True, True, True])
        self.wait_for("identify")
        self.assertIn("mm declares com_sway_deg a length", self.problems())
        self.assertEqual(self.seen(), [True, True, False])
        self.assertIn("Earlier result: trial3.csv, no settings. Now chosen: trial3.csv, Unit of the sway mm.", self.note())
        self.assertEqual(self.result("html"), before)
        # Resetting the unit shows the choices that depend on it again.
        self.assertEqual(self.changed("at('unit').value = ''"), [True, False, False])
        self.assertEqual(self.problems(), "")
        self.drop(self.read("bad.csv"))
        self.assertEqual(self.seen(), [True, True, False])
        self.assertIn("Earlier result: trial3.csv, no settings. Now chosen: bad.csv, no settings.", self.note())
        self.assertEqual(self.chromium.evaluate("at('bar-title').textContent"), "trial3.csv")
        self.drop(self.read("trial4.csv"))
        self.assertEqual(self.seen(), [True, False, False])
        self.check_same("identify", "trial4.csv")

    def test_other_recordings_are_chosen_beside_the_answer(self):
        self.drop(self.read("trial3.csv"))
        self.chromium.evaluate("at('again').click()")
        self.assertEqual(self.seen(), [True, False, False])
        self.assertTrue(self.chromium.evaluate("at('drop').checkVisibility()"))
        self.drop(self.read("trial4.csv"))
        self.assertFalse(self.chromium.evaluate("at('drop').checkVisibility()"))

    def test_a_corrected_number_is_answered(self):
        self.chromium.evaluate("at('rate').value = '1OO'")
        self.start_drop(self.read("trial4.csv"))
        self.chromium.wait("document.body.dataset.refused === 'true'")
        self.assertEqual(self.chromium.evaluate("document.activeElement.id"), "rate")
        self.type_in("rate", "100,0")
        self.wait_for("identify")
        self.check_same("identify", "trial4.csv", "--rate", "100.0")

    def test_a_fit_begins_again(self):
        self.drop(self.read("trial3.csv"))
        self.chromium.evaluate("at('fit').click()")
        self.assertEqual(self.changed("at('detrend').value = 'offset'"), [True, True, True])
        self.assertEqual(self.chromium.evaluate("working.command"), "fit")
        self.assertEqual(self.changed("0"), [True, True, True])
        self.chromium.evaluate("at('cancel').click()")
        self.assertEqual(self.seen(), [True, True, False])
        self.assertIn("Now chosen: trial3.csv, Remove offset or drift offset.", self.note())
        self.chromium.evaluate("at('renew').click()")
        self.wait_for("identify")
        self.check_same("identify", "trial3.csv", "--detrend", "offset")


class Controllers(Page):
    """The choice of a controller acts on the detailed analysis only."""

    def setUp(self):
        super().setUp()
        # Few draws, and what the program is called with.
        self.chromium.evaluate("""{
          const whole = run;
          window.calls = [];
          run = (args, files) => {
            calls.push(args.slice(1, args.indexOf("-o")));
            return whole(args[0] === "fit" ? [...args, "--max-draws", "8"] : args, files);
          };
        }""")

    def calls(self):
        return self.chromium.evaluate("calls")

    def minutes(self):
        """Returns the time that the button states."""
        return int(re.search(r"([0-9]+) min", self.chromium.evaluate("at('fit').textContent"))[1])

    def test_the_chosen_controller_is_fitted(self):
        self.drop(self.read("trial3.csv"))
        quick = self.result("json")
        own = self.minutes()
        self.choose("controller", "dec2015")
        # The quick answer has no choice, so it stays.
        self.assertEqual(self.chromium.evaluate("[working === null, at('stale').hidden]"), [True, True])
        self.drop(self.read("trial3.csv"))
        self.assertEqual(self.result("json"), quick)
        self.chromium.evaluate("delete document.body.dataset.done; at('fit').click()")
        self.wait_for("fit")
        self.assertEqual(self.calls(), [["trial3.csv"], ["trial3.csv"], ["trial3.csv", "--controller", "dec2015"]])
        self.assertIn("controller", self.chromium.evaluate("answered.state"))
        found = json.loads(self.result("json"))
        self.assertEqual([found["controller"], found["arguments"]], ["dec2015", ["--controller=dec2015", "--max-draws=8", "trial3.csv"]])
        self.assertTrue({"S", "G_f", "G_g", "G_q"} <= {one["name"] for one in found["recordings"][0]["parameters"]})
        self.check_same("fit", "trial3.csv", "--controller", "dec2015", "--max-draws", "8")
        # Another choice begins the analysis again; the earlier result states its own controller.
        self.choose("controller", "dec,dec2015,ic")
        self.assertEqual(self.chromium.evaluate("[working?.command, at('stale').hidden]"), ["fit", False])
        self.assertEqual(self.calls()[-1], ["trial3.csv", "--controller", "dec,dec2015,ic"])
        self.assertIn("dec2015", self.chromium.evaluate("at('stale-note').textContent"))
        self.assertGreater(self.minutes(), own)
        self.chromium.evaluate("at('cancel').click()")
        self.choose("controller", "dec2015")
        self.assertEqual(self.chromium.evaluate("[working === null, at('stale').hidden]"), [True, True])

    def test_messages_name_the_field(self):
        self.assertNotIn("--", self.chromium.evaluate("translator([])('give --controller ic')"))
        self.assertNotIn("\u2039", self.chromium.evaluate("translator([])('give --controller ic')"))


class Messages(Page):
    """No message names an option of the command line: a page has fields."""

    def table(self, header, row=lambda t: f"{t},0.1", rows=200, rate=100):
        return (header + "\n" + "".join(row(k / rate) + "\n" for k in range(rows))).encode()

    def trial(self, change):
        """A simulated recording, its rows changed: change(row number, [time, sway, tilt])."""
        lines = (self.folder / "trial3.csv").read_text().splitlines()
        rows = [change(number, line.split(",")) for number, line in enumerate(lines[1:])]
        return "\n".join([lines[0], *(",".join(row) for row in rows if row)]).encode()

    def check(self, content, fields=None, name="r.csv"):
        for field, value in (fields or {}).items():
            self.chromium.evaluate(f"at('{field}').value = {json.dumps(value)}")
        self.chromium.evaluate("results = new Map()")
        self.drop([(name, content)])
        for field in fields or {}:
            self.chromium.evaluate(f"at('{field}').value = ''")
        said = self.problems()
        shown = self.chromium.evaluate("""!results.has(outputs.html) ? "" : shownReport(results.get(outputs.html), answered.names)
          .match(/<script type="application.json"[^>]*>[^<]*/g).join("")""")
        self.assertNotIn("--", said)
        self.assertNotIn("--", shown)
        self.assertNotEqual(said + shown, "")
        return said or shown

    def test_errors(self):
        sway = (self.folder / "trial3.csv").read_bytes()
        cases = {
            "no sway": (self.table("time,load_kg"), {}),
            "several": (self.table("time,x,y", lambda t: f"{t},{t % 1},{t % 2}"), {}),
            "constant": (self.table("time,sway_deg"), {}),
            "no time": (self.table("sway_deg", lambda t: f"{t % 1}"), {}),
            "backwards": (self.table("time,sway_deg", lambda t: f"{-t},{t % 1}"), {}),
            "uneven": (self.table("time,sway_deg", lambda t: f"{t * t},{t % 1}"), {}),
            "fast": (self.table("time,sway_deg", lambda t: f"{t * 1e-6},{t % 1}"), {}),
            "slow": (self.table("time,sway_deg", lambda t: f"{t * 1e4},{t % 1}"), {}),
            "short": (self.table("time,sway_deg", lambda t: f"{t},{t % 1}"), {}),
            "flat": (self.table("time,sway_deg", lambda t: f"{t},{100 * t}"), {}),
            "offset": (self.table("time,sway_deg", lambda t: f"{t},{100 + t}"), {}),
            "length": (self.table("time,sway_mm", lambda t: f"{t},{t % 1}"), {}),
            "gap": (self.table("time,sway_deg", lambda t: f"{t},{'' if t == 0.5 else t % 1}"), {}),
            "text": (self.table("time,sway_deg", lambda t: f"{t},{'x' if t == 0.5 else t % 1}"), {}),
            "ragged": (self.table("time,sway_deg", lambda t: f"{t},{t % 1}" + (",1" if t == 0.5 else "")), {}),
            "another table": (self.table("time,sway_deg", lambda t: f"{t},{t % 1}") + b"\nForces\nx,y\n1,2\n", {}),
            "response": (b"frequency_hz,gain,phase_deg\n0.1,1,2\n0.2,1,2\n", {}),
            "ankle": (self.table("time,ankle_angle", lambda t: f"{t},{t % 1}"), {}),
            "no such column": (sway, {"column": "hip"}),
            "time as sway": (sway, {"column": "1"}),
            "no such tilt": (sway, {"tilt-column": "hip"}),
            "sway as tilt": (sway, {"tilt-column": "2"}),
            "no tilt": (self.table("time,sway_deg", lambda t: f"{t},{t % 1}"), {"invert": "tilt"}),
            "a length": (sway, {"unit": "mm"}),
            "no length": (sway, {"com-height": "0,9"}),
            "far": (sway, {"com-height": "0,01", "unit": "m"}),
            "height": (sway, {"com-height": "9"}),
            "rate": (sway, {"rate": "0"}),
            "begin": (sway, {"begin": "1000"}),
            "begin and tilt": (sway, {"begin": "1", "tilt-column": "tilt_deg"}),
            "before": (sway, {"begin": "-1"}),
            "gaps": (sway, {"fill-gaps": "1000"}),
            "mass": (sway, {"mass": "70"}),
            "tall": (sway, {"mass": "70", "height": "175"}),
            "data set": (b"PK\x03\x04 and so on", {}, "set.npz"),
        }
        for case, arguments in cases.items():
            with self.subTest(case):
                self.check(*arguments)
                self.assertFalse(self.chromium.evaluate("results.has(outputs.html)"), "this is an answer, not an error")

    def test_fields_and_what_a_page_lacks_are_named(self):
        self.assertIn("\u201cUnit of the sway\u201d", self.check(self.table("time,load_kg")))
        several = self.check(self.table("time,x,y", lambda t: f"{t},{t % 1},{t % 2}"))
        self.assertIn("\u201cSway column\u201d", several)
        self.assertIn("\u2039leg\u203a", several)
        self.assertIn("only in the program decid, not in this page", several)
        # Names of files are no options.
        self.drop([("a --rate b.csv", self.table("time,load_kg"))])
        self.assertIn("a --rate b.csv: ", self.problems())

    def test_warnings_in_the_report(self):
        def large(_, row):
            return [row[0], str(30 * float(row[1])), *row[2:]]

        def inverted(_, row):
            return [*row[:2], str(-float(row[2]))]

        def jumps(number, row):
            return [row[0], str(float(row[1]) + 3 * (number // 3000 % 2)), *row[2:]]
        for change in (large, inverted, jumps):
            with self.subTest(change.__name__):
                self.check(self.trial(change))
        for setting in ({"invert": "tilt"}, {"unit": "rad"}):
            with self.subTest(setting):
                self.check((self.folder / "trial3.csv").read_bytes(), setting)
        longer = self.trial(lambda number, row: [f"{float(row[0]) + 30:.2f}", *row[1:]])
        self.check(longer, {"tilt-column": "none"})

    def test_a_failed_recording_among_others(self):
        self.drop(self.read("trial3.csv") + [("x.csv", self.table("time,x,y", lambda t: f"{t},{t % 1},{t % 2}"))])
        self.assertIn("x.csv", self.problems())
        self.assertNotIn("--", self.problems())
        self.assertTrue(b"--column" in self.result("html"))  # a failure does not print pages
        shown = self.chromium.evaluate("shownReport(results.get(outputs.html), answered.names)")
        self.assertTrue("\u201cSway column\u201d" in shown and "--column" not in shown)


class Nothing_leaves(Page):
    """A server that must never be asked, and a page that is made to try."""

    def test_the_page_is_small(self):
        self.assertLess(page.stat().st_size, 4_200_000)

    def test_nothing_can_be_sent(self):
        asked = []

        class Listener(http.server.BaseHTTPRequestHandler):
            def do_GET(self):
                asked.append(self.path)
                self.send_response(200)
                self.end_headers()

            do_POST = do_GET

            def log_message(self, *_):
                pass

        server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Listener)
        threading.Thread(target=server.serve_forever, daemon=True).start()
        at = f"http://127.0.0.1:{server.server_port}/"
        self.drop(self.read("trial3.csv"))
        attempts = {
            "fetch": f"fetch('{at}fetch').then(() => 'sent', () => 'refused')",
            "beacon": f"navigator.sendBeacon('{at}beacon', 'x') ? 'queued' : 'refused'",
            "socket": f"new Promise(resolve => {{ try {{ const s = new WebSocket('ws://127.0.0.1:{server.server_port}/s'); "
                      "s.onopen = () => resolve('sent'); s.onerror = () => resolve('refused'); } catch { resolve('refused'); } })",
            "events": f"new Promise(resolve => {{ const s = new EventSource('{at}events'); s.onopen = () => resolve('sent'); s.onerror = () => resolve('refused'); }})",
            "image": f"new Promise(resolve => {{ const i = new Image(); i.onload = () => resolve('sent'); i.onerror = () => resolve('refused'); i.src = '{at}image'; }})",
            "script": f"new Promise(resolve => {{ const s = document.createElement('script'); s.onload = () => resolve('sent'); s.onerror = () => resolve('refused'); s.src = '{at}script'; document.head.append(s); }})",
            "style": f"new Promise(resolve => {{ const s = document.createElement('link'); s.rel = 'stylesheet'; s.onload = () => resolve('sent'); s.onerror = () => resolve('refused'); s.href = '{at}style'; document.head.append(s); }})",
            "form": f"{{ const f = document.createElement('form'); f.action = '{at}form'; f.method = 'post'; document.body.append(f); f.submit(); f.remove(); 'refused' }}",
            "frame": f"{{ const f = document.createElement('iframe'); f.src = '{at}frame'; document.body.append(f); setTimeout(() => f.remove(), 1000); 'refused' }}",
            "report's frame": f"{{ at('report').src = '{at}report'; 'refused' }}",
            "navigation": f"{{ location.href = '{at}navigation'; 'refused' }}",
        }
        for name, attempt in attempts.items():
            with self.subTest(name):
                self.assertIn(self.chromium.evaluate(attempt), ("refused", "queued"))
        # The worker, too.
        self.assertEqual(self.chromium.evaluate(
            f"new Promise(resolve => {{ const w = new Worker(URL.createObjectURL(new Blob([`fetch('{at}worker')"
            ".then(() => postMessage('sent'), () => postMessage('refused'))`]))); w.onmessage = e => resolve(e.data); })"), "refused")
        # The report's own frame, which may not leave either.
        self.chromium.evaluate("new Promise(resolve => setTimeout(resolve, 1500))")
        server.shutdown()
        self.assertEqual(asked, [])
        self.assertTrue(self.chromium.evaluate("location.protocol === 'file:' && at('setup') !== null"))
        self.chromium.events.clear()  # it has complained, as it should


class Without_relaxed_vectors(Answers):
    """The programs whose multiply-add is computed exactly, where the browser has relaxed vectors or not."""
    fragment, kernels = "#plain", "wasm"

    def test_the_changes_make_every_byte_of_the_second_program(self):
        packed = {name: re.search(f'id="{name}">(.*?)</script>', page.read_text())[1] for name in ("relaxed", "plain")}
        self.chromium.evaluate("""(async () => {
          const parts = [];
          for (const [id, text] of Object.entries(%s)) {
            const part = document.createElement("p");
            Object.assign(part, { id, textContent: text, hidden: true });
            document.body.append(part);
            parts.push(new Uint8Array(await unpacked(id)));
          }
          let text = "";
          for (const byte of changed(...parts)) text += String.fromCharCode(byte);
          document.body.dataset.made = btoa(text);
        })(), 0""" % json.dumps(packed))
        self.chromium.wait("document.body.dataset.made !== undefined")
        made = base64.b64decode(self.chromium.evaluate("document.body.dataset.made"))
        self.assertTrue(made == (page.parent / "tools/decid_plain").read_bytes())


class Same_bits(Page):
    def test_trainings_have_the_pinned_bits_in_the_browser_too(self):
        tests = base64.b64encode((page.parent / "tests/bindings/web/test_web").read_bytes()).decode()
        self.chromium.evaluate("""(async () => {
          const module = await WebAssembly.compile(Uint8Array.from(atob("%s"), c => c.charCodeAt(0)));
          const said = [];
          for (const isa of ["relaxed", "wasm", "reference"]) {
            const own = new Worker(workerAddress);
            own.postMessage({ module, model: new Uint8Array(), environment: ["DECID_ISA=" + isa] });
            own.postMessage({ args: ["--test-case=training: pinned bits*"], files: [] });
            const { code, out } = await new Promise(resolve => { own.onmessage = ({ data }) => resolve(data); });
            said.push([code, /1 passed.*0 failed/.test(out)]);
            own.terminate();
          }
          document.body.dataset.trained = JSON.stringify(said);
        })(), 0""" % tests)
        self.chromium.wait("document.body.dataset.trained !== undefined")
        self.assertEqual(json.loads(self.chromium.evaluate("document.body.dataset.trained")), [[0, True]] * 3)


class Fits(Page):
    """Minutes: only a whole fit has the program's bytes. Two recordings have a journal, which one has not."""

    def test_a_fit_of_two_recordings_is_the_program_s(self):
        self.drop(self.read("trial3.csv", "trial4.csv"))
        self.chromium.evaluate("delete document.body.dataset.done; at('fit').click()")
        self.wait_for("fit")
        self.assertEqual(self.problems(), "")
        self.check_same("fit", "trial3.csv", "trial4.csv")


def load_tests(loader, _, __):
    """Page itself has no tests."""
    kinds = [globals()[name] for name in sys.argv[4:]] or [Answers, Uses, Drops, Changes, Controllers, Messages, Nothing_leaves, Without_relaxed_vectors, Same_bits, Fits]
    return unittest.TestSuite(loader.loadTestsFromTestCase(kind) for kind in kinds)


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])
