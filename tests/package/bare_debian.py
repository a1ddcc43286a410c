"""A bare Debian 12 in a folder of its own, for tests of what is installed: made by debootstrap, entered by chroot in namespaces of its own,
so that whatever is mounted or started in it ends with the command. It takes root.
"""

import os
import pathlib
import shutil
import subprocess

SUITE = "bookworm"
CERTIFICATES = "/root/certificates.crt"
# Mounts what a program expects to find, then becomes the command. Both vanish with the namespaces.
ENTER = """\
set -eu
root=$1 cache=$2
shift 2
mount -t proc proc "$root/proc"
mount --rbind /dev "$root/dev"
mount --bind "$cache" "$root/var/cache/apt/archives"
for bind in ${PALPATE_TEST_BINDS:-}; do mkdir -p "$root${bind#*:}"; mount --bind "${bind%%:*}" "$root${bind#*:}"; done
exec chroot "$@"
"""


def missing_need():
    """Why no bare Debian can be made here; empty if one can."""
    if os.geteuid() != 0:
        return "it takes root"
    for program in ("debootstrap", "unshare", "chroot", "mount"):
        if not shutil.which(program):
            return f"{program} is missing (packages.txt, use full)"
    probe = subprocess.run(["unshare", "--mount", "--pid", "--fork", "true"], capture_output=True, text=True, check=False)
    return "" if probe.returncode == 0 else f"no namespaces: {probe.stderr.strip()}"


def is_required():
    """Whether a test that needs one fails without: in the full mode, but for a user who could not make one."""
    return bool(os.environ.get("PALPATE_FULL")) and os.geteuid() == 0


class BareDebian:
    """A root folder of a minimal Debian 12. `cache` keeps the packages that were fetched, for the next one."""

    def __init__(self, folder, cache):
        self.folder, self.cache, self.binds = pathlib.Path(folder), pathlib.Path(cache).absolute(), []
        (self.cache / "partial").mkdir(parents=True, exist_ok=True)
        done = subprocess.run(["debootstrap", "--variant=minbase", f"--cache-dir={self.cache}", SUITE, self.folder], capture_output=True, text=True, check=False)
        if done.returncode != 0:
            raise RuntimeError(f"debootstrap failed: {(done.stdout + done.stderr)[-2000:]}")
        for name in ("resolv.conf", "hosts"):
            shutil.copyfile(f"/etc/{name}", self.folder / "etc" / name)
        if "NODE_EXTRA_CA_CERTS" in os.environ:  # a network whose authority this machine trusts: npm has to, as well
            shutil.copyfile(os.environ["NODE_EXTRA_CA_CERTS"], self.folder / CERTIFICATES.lstrip("/"))

    def run(self, command, user="root", cwd="/", environment=None, timeout=1800):
        """Runs a command (words, or text for sh) in it. Returns what subprocess.run does, standard error in the output."""
        words = ["/bin/sh", "-c", command] if isinstance(command, str) else [str(word) for word in command]
        home = "/root" if user == "root" else f"/home/{user}"
        clean = {"PATH": "/usr/local/sbin:/usr/local/bin:/usr/sbin:/usr/bin:/sbin:/bin", "HOME": home, "LANG": "C.UTF-8", "NO_COLOR": "1",
                 "DEBIAN_FRONTEND": "noninteractive", **({"NODE_EXTRA_CA_CERTS": CERTIFICATES} if "NODE_EXTRA_CA_CERTS" in os.environ else {}), **(environment or {})}
        enter = ["unshare", "--mount", "--pid", "--fork", "--kill-child", "/bin/sh", "-c", ENTER, "enter", self.folder, self.cache,
                 f"--userspec={user}:{user}", self.folder, "/usr/bin/env", f"--chdir={cwd}", *words]
        return subprocess.run(enter, env={**clean, "PALPATE_TEST_BINDS": " ".join(self.binds)}, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE,
                              stderr=subprocess.STDOUT, text=True, errors="replace", timeout=timeout, check=False)

    def need(self, command, **how):
        """As run; fails where the command does. Returns its output."""
        done = self.run(command, **how)
        if done.returncode != 0:
            raise AssertionError(f"{command}: exit code {done.returncode}\n{done.stdout[-4000:]}")
        return done.stdout

    def paths(self):
        """All paths in it but those of file systems that are only mounted, and of the packages' cache."""
        found = set()
        for base, folders, files in os.walk(self.folder):
            inside = "/" + os.path.relpath(base, self.folder).removeprefix(".")
            if inside in ("/proc", "/dev", "/sys", "/var/cache/apt/archives"):
                folders.clear()
                continue
            found.update(os.path.join(inside, name) for name in (*folders, *files))
        return found
