"""The checks of the pages are red where they have to be. Usage: test_check_docs.py"""

import pathlib
import tempfile
import unittest

import check_docs
import examples
import tutorials
import words


class CheckDocs(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name).resolve()
        self.write("README.md", "# Title\n\n[page](docs/page.md) [web](https://example.org/none)\n")
        self.write("docs/page.md", "# The page\n\n## How it *works*, briefly\n\n[back](../README.md) [here](#the-page)\n")

    def tearDown(self):
        self.folder.cleanup()

    def write(self, name, text):
        path = self.root / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def problems(self):
        return check_docs.check(self.root)[0]

    def test_sound_pages_pass(self):
        self.assertEqual(check_docs.check(self.root), ([], 2))

    def test_links_to_no_file_and_out_of_the_project(self):
        self.write("docs/page.md", "[gone](gone.md) ![picture](picture.png) [up](../../)")
        self.assertEqual(self.problems(), [f"docs/page.md: the link {link} leads nowhere" for link in ("gone.md", "picture.png", "../../")])

    def test_headings(self):
        self.write("CHANGES.md", "[x](docs/page.md#how-it-works-briefly) [y](docs/page.md#how-it-fails)")
        self.assertEqual(self.problems(),
                         ["CHANGES.md: the link docs/page.md#how-it-fails names no heading of its page"])

    def test_code_holds_no_links(self):
        self.write("docs/page.md", "`[a](b)`\n\n    [c](d)\n\n```cpp\n[](int x) { return [e](f); }\n```\n")
        self.assertEqual(self.problems(), [])

    def test_pages_are_reached_through_others(self):
        self.write("docs/far.md", "far")
        self.assertEqual(self.problems(), ["docs/far.md: README.md does not lead to it"])
        self.write("docs/page.md", "[far](far.md)")
        self.assertEqual(self.problems(), [])

    def test_a_hash_that_no_source_has(self):
        self.write("docs/page.md", "[bits](develop/determinism.md)")
        self.write("docs/develop/determinism.md", f"`{'1' * 64}` `{'2' * 64}`")
        self.write("tests/bits.cpp", f'CHECK(sha256(bytes) == "{"1" * 64}");')
        self.assertEqual(self.problems(), [f"docs/develop/determinism.md: no source or test has the SHA-256 {'2' * 64}"])

    def test_the_length_of_the_readme(self):
        readme = (self.root / "README.md").read_text(encoding="utf-8")
        self.write("README.md", readme + "x" * (check_docs.README_LIMIT_BYTES - len(readme) + 1))
        self.assertEqual(self.problems(), ["README.md: 9217 bytes, at most 9216; move text to docs/"])

    def test_the_limits_of_shelves(self):
        self.write("docs/page.md", "[quick](start/quickstart.md) [guide](guide/any.md)")
        self.write("docs/start/quickstart.md", "line\n" * 81)
        self.write("docs/guide/any.md", "line\n" * 81)
        self.assertEqual(self.problems(), ["docs/start/quickstart.md: 81 lines, at most 80; move text to another page"])

    def test_sources_that_pages_name_exist(self):
        self.write("sim/fft.hpp", "")
        self.write("docs/page.md", "`sim/fft.hpp` `sim/gone.hpp` `other/gone.hpp` `<decid/sim/gone.hpp>`")
        self.assertEqual(self.problems(), ["docs/page.md: there is no sim/gone.hpp"])

    def test_words_and_figures_of_pages(self):
        self.write("docs/page.md", "# What is it?\n\nIt runs anew in 5 % of cases. `anew` is code.\n")
        self.assertEqual(self.problems(), ["docs/page.md: 'anew': write again",
                                           "docs/page.md: 'anew in 5 %': no blank before %"])

    def test_warnings_are_listed(self):
        self.write("dataset/a.cpp", 'add_caution(\n    recording.warnings, "small", "is small");\n'
                                    'warnings.insert(at, {Severity::info, "noted", text});\n'
                                    'warnings.push_back({severity, "computed", text});'
                                    'add_warning(warnings, is_far ? Severity::caution : Severity::info, "far", text);')
        self.write("docs/guide/warnings.md", "| `small` | info, caution | |\n| `computed` | invalid | |\n"
                                             "| `far` | info, invalid | |\n")
        self.write("docs/page.md", "[warnings](guide/warnings.md)")
        self.assertEqual(self.problems(), ["docs/guide/warnings.md: the warning far (caution) is not listed",
                                           "docs/guide/warnings.md: the warning noted (info) is not listed",
                                           "docs/guide/warnings.md: no source gives the warning far (invalid)",
                                           "docs/guide/warnings.md: no source gives the warning small (info)"])

    def test_errors_are_named_thrown_and_listed(self):
        self.write("base/error.hpp", "enum class Code {\n  lost,\n  broken,\n};\n")
        self.write("base/error.cpp", 'names[] = {"lost", "other"};')
        self.write("sim/a.cpp", "throw Error(Code::lost, where, problem, remedy);")
        self.write("docs/reference/errors.md", "| `lost` | |\n| `gone` | |\n")
        self.write("docs/page.md", "[errors](reference/errors.md)")
        self.assertEqual(self.problems(), ["base/error.cpp: the names are not those of Code, in its order",
                                           "docs/reference/errors.md: the error broken is not listed",
                                           "docs/reference/errors.md: the error gone does not exist",
                                           "base/error.hpp: no source throws the error broken"])


class Words(unittest.TestCase):
    def test_banned_words(self):
        self.assertEqual(words.complaints("decid reads the file. What is this? The offset is what the sensor adds."), [])
        self.assertEqual(words.complaints("It is so\nmany times dearer, in place of the old one."),
                         ["'so many': write this many, the number of", "'dearer': write more expensive",
                          "'in place of': write instead of"])
        self.assertEqual(words.complaints("A renewed, endearing newspaper"), [])

    def test_openings(self):
        self.assertEqual(words.complaints("Of each trial the mean. It is. Those two are left."),
                         ["sentence opens with 'Of': put the subject first ('Of each trial the mean.')",
                          "sentence opens with 'Those': repeat the noun ('Those two are left.')"])


class Examples(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.root = pathlib.Path(self.folder.name)
        for name, text in (("tests/bindings/c/symbols.txt", "decid_one@@DECID_1\ndecid_two@@DECID_1\n"),
                           ("CMakeLists.txt", "decid_component(base base)\ndecid_component(sim sim base)\n")):
            (self.root / name).parent.mkdir(parents=True, exist_ok=True)
            (self.root / name).write_text(text, encoding="utf-8")

    def tearDown(self):
        self.folder.cleanup()

    def problems(self, c, cpp, compiler="/bin/true"):
        for name, text in (("c.md", c), ("cpp.md", cpp)):
            page = self.root / "docs/reference" / name
            page.parent.mkdir(parents=True, exist_ok=True)
            page.write_text(text, encoding="utf-8")
        return examples.check(self.root, compiler, compiler)[0]

    def test_functions_and_components_without_an_example(self):
        both = "# `base`\n\n```cpp\na\n```\n\n# Other, `sim`\n\n```cpp\nb\n```\n"
        self.assertEqual(self.problems("```c\ndecid_one(decid_two(1));\n```\n", both), [])
        self.assertEqual(self.problems("```c\ndecid_one(); /* decid_two() */ decid_two_more();\n```\n`decid_two()`", both),
                         ["docs/reference/c.md: no example calls decid_two"])
        self.assertEqual(self.problems("```c\ndecid_one(decid_two());\n```\n", "# `base`\n# Other\n```cpp\n`sim`\n```\n# `sim`\n"),
                         [f"docs/reference/cpp.md: no heading with an example names the component {name}" for name in ("base", "sim")])

    def test_a_block_has_the_scope_of_the_blocks_before_it(self):
        self.assertEqual(examples.unit_of(["#include <a.h>\nint a;\n", "static int f(int x) {\n  return x;\n}\nint b = f(a);\n"]),
                         "#include <a.h>\nstatic int f(int x) {\n  return x;\n}\nvoid page(void);\nvoid page(void) {\n"
                         "int a;\n{\nint b = f(a);\n}}\n")

    def test_a_compiler_that_refuses(self):
        self.assertEqual(examples.compile_problem(["int a;\n"], "/bin/true", ".c", self.root, "c99", self.root), "")
        self.assertIn("-fsyntax-only", examples.compile_problem(["int a;\n"], self.refusing(), ".c", self.root, "c99", self.root))

    def refusing(self):
        compiler = self.root / "compiler"
        compiler.write_text("#!/bin/sh\necho \"$@\"\nexit 1\n", encoding="utf-8")
        compiler.chmod(0o755)
        return compiler


class Tutorials(unittest.TestCase):
    def setUp(self):
        self.folder = tempfile.TemporaryDirectory()
        self.page = pathlib.Path(self.folder.name, "page.md")

    def tearDown(self):
        self.folder.cleanup()

    def run_page(self, text, update=False):
        self.page.write_text(text, encoding="utf-8")
        return tutorials.run(self.page, "/bin/echo", update)

    def test_a_page_whose_output_is_right(self):
        self.assertIsNone(self.run_page("```sh\ndecid one; echo two\n```\n\n```text\n...\ntwo\n```\n```sh\ntest ! -e x\n```\n"))

    def test_a_line_that_is_not_printed_and_a_command_that_fails(self):
        self.assertIn("no line 'two'", self.run_page("```sh\ndecid one\n```\n```text\ntwo\n```\n"))
        self.assertIn("exit code 3", self.run_page("```sh\nexit 3\n```\n"))

    def test_update_writes_the_output(self):
        self.assertIsNone(self.run_page("a\n```sh\ndecid one\n```\n```text\ntwo\n```\nb\n", update=True))
        self.assertEqual(self.page.read_text(encoding="utf-8"), "a\n```sh\ndecid one\n```\n```text\none\n```\nb\n")


if __name__ == "__main__":
    unittest.main()
