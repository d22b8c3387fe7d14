"""The check of the pages is red where it has to be. Usage: test_check_docs.py"""

import pathlib
import tempfile
import unittest

import check_docs


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
        path.parent.mkdir(exist_ok=True)
        path.write_text(text, encoding="utf-8")

    def problems(self):
        return check_docs.check(self.root)[0]

    def test_sound_pages_pass(self):
        self.assertEqual(check_docs.check(self.root), ([], 2))

    def test_a_link_to_no_file(self):
        self.write("docs/page.md", "[gone](gone.md) ![picture](picture.png)")
        self.assertEqual(self.problems(), ["docs/page.md: the link gone.md leads nowhere",
                                           "docs/page.md: the link picture.png leads nowhere"])

    def test_a_link_out_of_the_project(self):
        self.write("docs/page.md", "[up](../../)")
        self.assertEqual(self.problems(), ["docs/page.md: the link ../../ leads nowhere"])

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

    def test_the_length_of_the_readme(self):
        readme = (self.root / "README.md").read_text(encoding="utf-8")
        longest = readme + "x" * (check_docs.README_LIMIT_BYTES - len(readme))
        self.write("README.md", longest)
        self.assertEqual(self.problems(), [])
        self.write("README.md", longest + "x")
        self.assertEqual(self.problems(), ["README.md: 9217 bytes, at most 9216; move text to docs/"])

    def test_warnings_are_listed(self):
        self.write("dataset/a.cpp", 'add_caution(\n    recording.warnings, "small", "is small");\n'
                                    'warnings.insert(at, {Severity::info, "noted", text});')
        self.write("docs/recordings.md", "| `small` | info, caution | |\n")
        self.write("docs/page.md", "[recordings](recordings.md)")
        self.assertEqual(self.problems(), ["docs/recordings.md: the warning noted (info) is not listed",
                                           "docs/recordings.md: no source gives the warning small (info)"])


if __name__ == "__main__":
    unittest.main()
