"""Does arrows.py see what it is there to see? Each test plants includes in a small project of its own."""
import subprocess
import tempfile
import unittest
from pathlib import Path

ARROWS = Path(__file__).with_name("arrows.py")
LAYERS = """decid_component(base base)
decid_component(sim sim base)
decid_component(nn nn base)
decid_component(image dataset/image sim)
decid_component(npz dataset/npz sim)
decid_component(identify identify image nn)
"""


class Arrows(unittest.TestCase):
    def look(self, **files):
        """Exit code and output for a project of these files ("dataset/image/a.cpp" as dataset__image__a)."""
        with tempfile.TemporaryDirectory() as folder:
            root = Path(folder)
            subprocess.run(["git", "init", "--quiet", folder], check=True)
            (root / "CMakeLists.txt").write_text(LAYERS)
            for name, text in files.items():
                name = name.replace("__", "/")
                if not name.endswith("CMakeLists.txt"):
                    name = name.removesuffix("_hpp") + (".hpp" if name.endswith("_hpp") else ".cpp")
                path = root / name
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_text(text + "\n")
            done = subprocess.run([ARROWS, root], capture_output=True, text=True)
            return done.returncode, done.stdout + done.stderr

    def check_clean(self, **files):
        code, output = self.look(**files)
        self.assertEqual(code, 0, output)
        return output

    def check_refused(self, words, **files):
        code, output = self.look(**files)
        self.assertEqual(code, 1, output)
        self.assertIn(words, output)

    def test_an_include_to_the_right_is_drawn(self):
        output = self.check_clean(identify__a='#include "dataset/image/image.hpp"\n#include "base/error.hpp"\n#include <vector>')
        self.assertRegex(output, r"identify +-> dataset/image \(1\), base \(1\)")

    def test_an_include_to_the_left_is_refused(self):
        self.check_refused('sim/a.cpp:2: "dataset/image/image.hpp"; sim may include base, sim',
                           sim__a='// A comment.\n#include "dataset/image/image.hpp"')

    def test_includes_of_neighbours_tests_and_without_the_root_are_refused(self):
        self.check_refused("dataset/image may include base, sim, dataset/image",
                           dataset__image__a='#include "dataset/npz/npz.hpp"')
        self.check_refused("nn/a.cpp:1", nn__a='  #  include "sim/fft.hpp"')
        self.check_refused("sim/a.cpp:1", sim__a='#include "tests/sim/tiny.hpp"')
        self.check_refused("is not written from the root", sim__a='#include "fft.hpp"')

    def test_tests_are_held_to_their_folder(self):
        self.check_clean(tests__sim__a='#include "sim/fft.hpp"\n#include "tests/helpers.hpp"\n#include "tests/sim/b.hpp"')
        self.check_refused("tests/base/a.cpp:1", tests__base__a='#include "sim/fft.hpp"')
        self.check_refused("tests/helpers.cpp:1", tests__helpers='#include "sim/fft.hpp"')
        self.check_refused("tests/base/a.cpp:1", tests__base__a='#include "tests/sim/tiny.hpp"')

    def test_the_program_stands_on_the_libraries(self):
        self.check_clean(tools__decid__a='#include "tools/report/figures/svg.hpp"\n#include <CLI/CLI.hpp>')
        self.check_refused("tools/report/a.cpp:1", tools__report__a='#include "tools/decid/command.hpp"')
        self.check_refused("identify/a.cpp:1", identify__a='#include "tools/report/figures/svg.hpp"')

    def test_other_libraries_have_their_place(self):
        self.check_clean(dataset__npz__a="#include <zip.h>", tools__compare__a="#include <Eigen/Dense>")
        self.check_refused("only tools/decid may include the command-line parser", identify__a="#include <CLI/CLI.hpp>")
        self.check_refused("only recording may include matio", dataset__image__a="#include <matio.h>")
        self.check_refused("only dataset/npz may include libzip", dataset__image__a="#include <zip.h>")
        self.check_refused("only tools/compare may include Eigen", nn__a="#include <Eigen/Dense>")

    def test_a_header_with_a_value_of_json_includes_its_type(self):
        self.check_refused("identify/a.hpp:3: a value of Json needs base/files/json_object.hpp",
                           identify__a_hpp='#include "base/files/json.hpp"\nstruct A {\n  Json value;\n};')
        self.check_clean(identify__detail__a_hpp='#include "base/files/json_object.hpp"\nstruct A {\n  Json value;\n};',
                         identify__detail__b_hpp='#include "base/files/json.hpp"\nJson made(const Json& from);')

    def test_an_option_in_a_librarys_message_is_refused(self):
        for line in ('throw Error(where, "is none", "give --rate");', 'f("a", "--rate", b);', '      : "two (--fill-gaps) of them";'):
            self.check_refused("sim/a.cpp:2: a library names a setting", sim__a="\n" + line)
        self.check_refused("identify/a.hpp:1", identify__a_hpp='constexpr const char* remedy = "give --seed";')
        self.check_clean(sim__a='int i = 2;  // as --rate has it\n// "--rate"\n--i;\nf("a - b", --i, "->");',
                         tools__decid__a='command.add_option("--rate");', tests__sim__a='f("--rate");')

    def test_a_private_header_is_in_detail_and_stays_in_its_library(self):
        self.check_clean(sim__a='#include "sim/detail/b.hpp"', tests__sim__a='#include "sim/detail/b.hpp"')
        self.check_refused('"sim/detail/b.hpp" is private to sim', identify__a='#include "sim/detail/b.hpp"')
        words = "sim/more/b.hpp: it is private to sim: neither installed nor included by another folder; move it to detail/"
        include = '#include "sim/more/b.hpp"'
        self.check_refused(words, sim__more__b_hpp="// Not installed.", sim__a=include)
        self.check_refused(words, sim__more__b_hpp="", sim__more__b=include)
        self.check_refused(words, sim__more__b_hpp="")
        # Tests may include private headers.
        self.check_refused(words, sim__more__b_hpp="", tests__identify__a=include)
        self.check_clean(sim__more__detail__b_hpp="", sim__a='#include "sim/more/detail/b.hpp"')

    def test_a_header_that_others_may_include_need_not_be_in_detail(self):
        include = '#include "sim/more/b.hpp"'
        for path in ("identify/a", "tools/decid/a", "bindings/web/a", "dataset/image/a"):
            self.check_clean(sim__more__b_hpp="// Not installed.", **{path: include})
        lists = "decid_library(sim\n  SOURCES a.cpp\n  HEADERS c.hpp\n          more/b.hpp{})\ndecid_computes(decid_sim)"
        for after in ("", '\n  FINDS "ZLIB 1.2.11"', " SOURCES d.cpp"):
            files = {"sim/CMakeLists.txt": lists.format(after), "sim/more/b_hpp": "", "sim/c_hpp": ""}
            self.check_clean(**files)
            self.check_refused("sim/d.hpp: it is private to sim", **files, sim__d_hpp="")
        # Another library's list installs its own.
        self.check_refused("sim/b.hpp: it is private to sim", **{"nn/CMakeLists.txt": "decid_library(nn HEADERS b.hpp)"},
                           nn__b_hpp="", sim__b_hpp="")

    def test_kernels_and_the_program_have_headers_anywhere_and_installed_ones_are_not_in_detail(self):
        self.check_clean(sim__kernels__generic_hpp="", tools__decid__a_hpp="", tests__sim__a_hpp="", bindings__web__a_hpp="")
        self.check_refused("sim/detail/b.hpp: it is installed",
                           **{"sim/CMakeLists.txt": "decid_library(sim\n  HEADERS detail/b.hpp)"}, sim__detail__b_hpp="")

    def test_a_folder_with_too_many_sources_is_refused(self):
        self.check_clean(**{f"sim__a{i}": "" for i in range(25)}, sim__more__a="")
        self.check_refused("sim: 26 sources, at most 25", **{f"sim__a{i}": "" for i in range(26)})

    def test_approx_is_refused_in_tests(self):
        self.check_refused("adds 1 to the scale", tests__sim__a="CHECK(a == Approx(b));")


if __name__ == "__main__":
    unittest.main()
