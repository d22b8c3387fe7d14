"""Does source_words.py find the words and openings that it is there to find?"""
import sys
import unittest
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent))
import source_words as words  # noqa: E402
from words import WORDS  # noqa: E402

BANNED = next(iter(WORDS))


def found(source):
    return [(number, complaint) for number, passage in words.passages(source) for complaint in words.complaints(passage)]


class Words(unittest.TestCase):
    def test_comments_and_messages_are_read(self):
        for source in ("/// It begins anew.", "int i;  ///< begun anew", 'Error(a, "begin it anew", b);', "// It begins so\n// many times."):
            self.assertEqual(len(found(source)), 1, source)
        self.assertEqual(found("\n\n/// Whether it is one.\nint i;")[0][0], 3)

    def test_code_and_single_words_of_json_are_not(self):
        self.assertEqual(found('told(anew);\njson["contraction"] = 1;\n#include "a.hpp"\n/// Returns the value.\n'), [])

    def test_comments_of_other_languages_are_read(self):
        for form, suffix in (("x = 1  # begun %s", ".py"), ('"""Begins\n%s."""', ".py"), ("/* Begins\n   %s. */", ".c"),
                             ("int begin(void); /* %s */", ".h"), ("%% Begins %s.", ".m"), ("f();  // %s", ".js")):
            self.assertEqual(len(found(words.with_slashes(form % BANNED, suffix))), 1, form)
        self.assertEqual(found(words.with_slashes(BANNED + " = 1", ".py")), [])

    def test_elementary_functions_of_the_system_are_found_where_bits_must_be_the_same(self):
        call = "return std::pow(10.0, x) + std::exp(y);"
        self.assertEqual([number for number, _ in words.library_functions("sim/frf.cpp", "\n" + call)], [2, 2])
        self.assertEqual(list(words.library_functions("tests/sim/frf.cpp", call)), [])
        self.assertEqual(list(words.library_functions("sim/frf.cpp", "decid::exp(x); std::sqrt(x); std::log2(x);  // std::exp(x)")), [])

    def test_json_is_printed_with_a_rule_for_other_bytes(self):
        self.assertEqual([number for number, _ in words.raw_json("tools/decid/a.cpp", "\nout << json.dump(2);")], [2])
        self.assertEqual(list(words.raw_json("tests/a.cpp", "json.dump(2);")), [])
        self.assertEqual(list(words.raw_json("tools/a.cpp", "json.dump(1, ' ', false, replace); json.dump();  // no .dump(2)")), [])

    def test_a_source_that_a_comment_names_exists(self):
        ends = words.path_ends(["sim/fft.hpp", "sim/fft.cpp"])
        self.assertEqual(list(words.missing_files("// See fft.hpp and sim/fft.cpp.\nf();  // as nn/fft.hpp", ends)),
                         [(2, "there is no nn/fft.hpp")])
        self.assertEqual(list(words.missing_files('#include "nn/a.hpp"\n// of <a.hpp>, */a.hpp', ends)), [])

    def test_an_address_is_no_comment(self):
        self.assertEqual(found('f("https://example.org/anew");'), [])


if __name__ == "__main__":
    unittest.main()
