"""Goal: the scripts do what their help says, and fail with words that help.

Method: deploy/install-packages with stand-ins for dpkg-query, apt-get, id and sudo first on PATH,
which record what they were asked to do; the other scripts with wrong arguments.
"""

import os
import pathlib
import re
import subprocess
import tempfile
import unittest

TOP = pathlib.Path(__file__).resolve().parents[2]
PACKAGES = (TOP / "deploy/packages.txt").read_text()

STAND_INS = {
    # A package is installed if the file of its name is in $STATE.
    "dpkg-query": '[ -e "$STATE/${!#}" ] && echo installed',
    # Knows no package before `update`; can never install one named in $UNAVAILABLE.
    "apt-get": '''
echo "apt-get $*" >> "$STATE/calls"
case " $* " in
  *" update "*) touch "$STATE/lists"; exit 0 ;;
esac
[ -e "$STATE/lists" ] || exit 100
for word in "$@"; do
  case $word in
    -* | install) ;;
    *) [ "$word" = "$UNAVAILABLE" ] || touch "$STATE/$word" ;;
  esac
done''',
    "id": 'echo "$STAND_IN_UID"',
    "sudo": 'echo sudo >> "$STATE/calls"; exec "$@"',
}


def packages(group):
    section = re.search(rf"\[{group}\]\n(.*?)(?=\n\[|\Z)", PACKAGES, re.DOTALL).group(1)
    return [line.split()[0] for line in section.splitlines() if line.strip()]


class InstallPackages(unittest.TestCase):
    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.state = pathlib.Path(temporary.name, "state")
        self.programs = pathlib.Path(temporary.name, "bin")
        self.state.mkdir()
        self.programs.mkdir()
        for name, body in STAND_INS.items():
            self.stand_in(name, body)

    def stand_in(self, name, body):
        file = self.programs / name
        file.write_text(f"#!/bin/bash\n{body}\n")
        file.chmod(0o755)

    def run_script(self, *groups, uid="0", unavailable="", path=os.environ["PATH"]):
        return subprocess.run(
            ["/bin/bash", str(TOP / "deploy/install-packages"), *groups], check=False, text=True,
            capture_output=True,
            env={"PATH": f"{self.programs}:{path}", "STATE": str(self.state),
                 "STAND_IN_UID": uid, "UNAVAILABLE": unavailable})

    def calls(self):
        file = self.state / "calls"
        return file.read_text().splitlines() if file.exists() else []

    def test_installs_what_is_missing_and_updates_the_lists_only_if_needed(self):
        first, *others = packages("run")
        (self.state / first).touch()
        done = self.run_script("run")
        self.assertEqual(done.returncode, 0, done.stderr)
        self.assertTrue(all((self.state / name).exists() for name in others))
        self.assertNotIn(first, self.calls()[0].split())
        self.assertEqual(sum(" update" in call for call in self.calls()), 1)

        (self.state / others[0]).unlink()
        self.assertEqual(self.run_script("run").returncode, 0)
        self.assertEqual(sum(" update" in call for call in self.calls()), 1)

    def test_does_nothing_when_all_is_there(self):
        for name in packages("build"):
            (self.state / name).touch()
        self.assertEqual(self.run_script("build", uid="1000").returncode, 0)
        self.assertEqual(self.calls(), [])

    def test_all_groups_are_the_default(self):
        self.assertEqual(self.run_script().returncode, 0)
        for group in ("build", "run", "test"):
            self.assertTrue(all((self.state / name).exists() for name in packages(group)))

    def test_names_what_cannot_be_installed(self):
        missing = packages("test")[0]
        done = self.run_script("test", unavailable=missing)
        self.assertEqual(done.returncode, 1)
        self.assertIn(f"could not install: {missing}\n", done.stderr)

    def test_uses_sudo_only_if_not_root(self):
        self.assertEqual(self.run_script("run", uid="1000").returncode, 0)
        self.assertIn("sudo", self.calls())

    def test_names_what_is_missing_without_rights(self):
        (self.programs / "sudo").unlink()
        for name in ("awk", "dirname", "grep"):
            self.stand_in(name, f'exec /usr/bin/{name} "$@"')
        done = self.run_script("run", uid="1000", path="")
        self.assertEqual(done.returncode, 1)
        self.assertIn(f"missing: {' '.join(packages('run'))}", done.stderr)
        self.assertEqual(self.calls(), [])

    def test_refuses_an_unknown_group(self):
        done = self.run_script("runs")
        self.assertEqual(done.returncode, 1)
        self.assertIn("unknown group 'runs'", done.stderr)

    def test_every_package_has_a_reason_and_is_named_once(self):
        names = []
        for line in PACKAGES.splitlines():
            if line and line[0] not in "#[":
                self.assertRegex(line, r"^[a-z0-9.+-]+ +# \w")
                names.append(line.split()[0])
        self.assertEqual(len(names), len(set(names)))


class Arguments(unittest.TestCase):
    def run_script(self, *arguments):
        return subprocess.run([str(TOP / arguments[0]), *arguments[1:]], check=False, text=True,
                              capture_output=True)

    def test_help(self):
        for script in ("tests/run", "deploy/quickstart", "deploy/install-packages"):
            done = self.run_script(script, "--help")
            self.assertEqual(done.returncode, 0)
            self.assertIn(f"  {script} [", done.stdout)

    def test_wrong_arguments_are_named(self):
        for arguments in (("tests/run", "--lnog"), ("tests/run", "--preset"),
                          ("deploy/quickstart", "--fast")):
            done = self.run_script(*arguments)
            self.assertNotEqual(done.returncode, 0)
            self.assertIn(arguments[1], done.stderr)


if __name__ == "__main__":
    unittest.main()
