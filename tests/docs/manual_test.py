"""The man page and the completions say what the program's own help says, and the shells understand them."""

import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import pages
from pages import ROOT

sys.path.insert(0, str(ROOT / "cmake" / "manual"))
import manual


def live_help(*words):
    return subprocess.run([pages.PROGRAM, *words, "--help"], capture_output=True, text=True, check=True).stdout


def shown(text):
    """A man page as man would show it, without emphasis."""
    done = subprocess.run(["groff", "-man", "-ww", "-Tutf8", "-P-cbou", "-rLL=200n"], input=text, capture_output=True, text=True, check=True)
    if done.stderr:
        raise AssertionError(done.stderr)
    return re.sub(r"\u2010|\u2212", "-", done.stdout)


def bash_words(completion, line, folder):
    """What bash would offer behind a line that ends with the word to complete."""
    words = line.split(" ")
    script = (f'source "$1"; COMP_WORDS=({" ".join(f"{word!r}" for word in words)}); COMP_CWORD={len(words) - 1}; COMPREPLY=(); _palpate; '
              'printf "%s\\n" "${COMPREPLY[@]}"')
    done = subprocess.run(["/bin/bash", "-c", script, "bash", completion], capture_output=True, text=True, cwd=folder, check=False)
    if done.stderr:
        raise AssertionError(done.stderr)
    return set(done.stdout.split())


class Manual(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        cls.commands = manual.read_all(ROOT)
        for name, text in manual.files_of(ROOT, "0.0.0").items():
            (cls.folder / pathlib.Path(name).name).write_text(text, encoding="utf-8")
            if "bash" in name:
                (cls.folder / "palpate.bash").write_text(text, encoding="utf-8")
        (cls.folder / "palpate").unlink()
        (cls.folder / "palpate").symlink_to(ROOT / "palpate")  # the launcher, beside which the plans lie
        (cls.folder / "a.mesh").write_text("", encoding="utf-8")

    def offered(self, line):
        return bash_words(self.folder / "palpate.bash", line, self.folder)

    def test_every_option_and_word_of_the_live_help_is_in_the_man_page(self):
        page = " ".join(shown((self.folder / "palpate.1").read_text(encoding="utf-8")).split())
        for name in self.commands:
            text = live_help() if name == "palpate" else live_help(name)
            for option in re.findall(r"^  (-\S+(?: [A-Z]\S*)?)", text, re.MULTILINE):
                self.assertIn(option, page, name)
            for entry in manual.read_help(name, text).options():
                if entry.names != ["-h", "--help"]:
                    self.assertIn(" ".join(entry.text.split()), page, f"{name} {entry.head}")

    def test_a_help_that_was_not_kept_is_noticed(self):
        page = " ".join(shown((self.folder / "palpate.1").read_text(encoding="utf-8")).split())
        self.assertNotIn("--no-such-option", page)
        with self.assertRaises(ValueError):
            manual.read_help("x", "no usage here")

    def test_entries_are_read_with_their_continuation_lines(self):
        help_ = manual.read_help("x", "Does it\nUsage: palpate x [OPTIONS] FILE\n\nArguments:\n  FILE                    A file\n\nOptions:\n"
                                      "  -o,--out DIR            Where, and\n                          how\n  --kind WORD:{a,b}\n"
                                      "                          One of two\n\nMore.\n")
        out, kind = help_.options()
        self.assertEqual((out.names, out.value, out.text), (["-o", "--out"], "DIR", "Where, and how"))
        self.assertEqual((kind.choices, kind.text, help_.footer), (["a", "b"], "One of two", ["More."]))

    def test_bash_offers_commands_options_choices_plans_and_files(self):
        names = set(self.commands) - {"palpate"}
        self.assertEqual(self.offered("palpate "), names | {"-h", "--help", "--version"})
        self.assertEqual(self.offered("palpate sim"), {"simplify", "simulate"})
        self.assertEqual(self.offered("palpate run --res"), {"--resume"})
        self.assertEqual(self.offered("palpate make kidney --skin "), {"coarse", "fine", "scanned"})
        self.assertEqual(self.offered("palpate list "), {"contestants", "meshes", "measures"})
        self.assertEqual(self.offered("palpate quality a"), {"a.mesh"})
        self.assertEqual(self.offered("./palpate run thesis_hist"), {"thesis_histograms"})
        for name in names:
            self.assertEqual(self.offered(f"palpate {name} --"), {word for entry in self.commands[name].options() for word in entry.names if word.startswith("--")})

    def test_zsh_and_fish_can_read_theirs(self):
        for shell, name in (("zsh", "_palpate"), ("fish", "palpate.fish")):
            program = shutil.which(shell)
            self.assertIsNotNone(program, f"{shell} is in packages.txt")
            done = subprocess.run([program, "-n", self.folder / name], capture_output=True, text=True, check=False)
            self.assertEqual((done.returncode, done.stderr), (0, ""), shell)
        done = subprocess.run(["fish", "--no-config", "-c", f"source {self.folder / 'palpate.fish'}; complete -C 'palpate run --res'"], capture_output=True, text=True,
                              env={"HOME": str(self.folder), "PATH": "/usr/bin:/bin"}, check=False)
        self.assertIn("--resume", done.stdout)

    def test_the_build_makes_them_and_installs_them_where_man_and_the_shells_look(self):
        build = pages.PROGRAM.parents[1]
        prefix = self.folder / "prefix"
        for words in (["--build", build, "--target", "palpate_manual"], ["--install", build, "--prefix", prefix, "--component", "manual"]):
            done = subprocess.run(["cmake", *words], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        found = {str(path.relative_to(prefix / "share")) for path in prefix.rglob("*") if path.is_file()}
        self.assertEqual(found, {"man/man1/palpate.1", "bash-completion/completions/palpate", "zsh/site-functions/_palpate", "fish/vendor_completions.d/palpate.fish"})

    def test_the_same_texts_give_the_same_bytes(self):
        self.assertEqual(manual.files_of(ROOT, "0.0.0"), manual.files_of(ROOT, "0.0.0"))


if __name__ == "__main__":
    unittest.main()
