"""Make, once, a small Debian that carries a windowed Blender, and run commands in it.

The wheels the other tests use have no window. Debian's newest suite has one that does, so a chroot of it
is built with debootstrap in the user's cache folder and kept. Everything that mounts runs in a private
mount and process namespace: whatever happens, nothing stays mounted and nothing keeps running.
"""

from __future__ import annotations

import os
import platform
import shlex
import shutil
import subprocess
import sys
import time
from pathlib import Path

SUITES = ("sid", "testing")  # the stable one has 4.3, older than what the extension asks for
OLDEST_BLENDER = "4.5"
PACKAGES = (
    "blender python3-numpy python3-cattr python3-requests python3-zstandard xvfb xauth imagemagick "
    "libgl1-mesa-dri libglx-mesa0 libegl1"
)
BUILD_LIMIT_S = 1800
KEYRING = "/usr/share/keyrings/debian-archive-keyring.gpg"

# runs in the namespace; the target gets its final name only when all of it has worked
BUILD_SCRIPT = """
set -eu
debootstrap --variant=minbase --keyring="$KEYRING" --cache-dir="$CACHE" --include=ca-certificates \
    "$SUITE" "$TARGET" "$MIRROR"
apt-config dump --format '%f "%v";%n' Acquire::http Acquire::https Acquire::Check-Valid-Until \
    Acquire::Check-Date > "$TARGET/etc/apt/apt.conf.d/90machine"
echo 'Acquire::Languages "none"; APT::Install-Recommends "false";' > "$TARGET/etc/apt/apt.conf.d/91small"
printf 'force-unsafe-io\\npath-exclude /usr/share/doc/*\\npath-exclude /usr/share/man/*\\n' \
    > "$TARGET/etc/dpkg/dpkg.cfg.d/small"
printf '#!/bin/sh\\nexit 101\\n' > "$TARGET/usr/sbin/policy-rc.d"
chmod +x "$TARGET/usr/sbin/policy-rc.d"
echo "deb $MIRROR $SUITE main" > "$TARGET/etc/apt/sources.list"
cp -L /etc/resolv.conf "$TARGET/etc/resolv.conf" || true
mount -t proc proc "$TARGET/proc"
mount --rbind /dev "$TARGET/dev"
mount --bind "$CACHE" "$TARGET/var/cache/apt/archives"
chroot "$TARGET" apt-get update
version=$(chroot "$TARGET" apt-cache policy blender | sed -n 's/ *Candidate: //p')
echo "windowed Blender in $SUITE: $version"
chroot "$TARGET" dpkg --compare-versions "$version" ge "$OLDEST"
DEBIAN_FRONTEND=noninteractive chroot "$TARGET" apt-get install -y $PACKAGES
chroot "$TARGET" blender --version
rm -rf "$CACHE"/*
mv -T "$TARGET" "$DONE"
"""


class Unavailable(Exception):
    """This machine cannot show a Blender window; the message says why."""


def private(script: str, limit_s: int, *, offline: bool = False) -> list[str]:
    """Wrap a shell script into namespaces of its own; at the limit they end with all that runs in them."""
    limit = ["timeout", "--foreground", "--signal=KILL", str(limit_s)]
    net = ["--net"] if offline else []
    return [*limit, "unshare", "--mount", "--pid", *net, "--fork", "--kill-child", "sh", "-c", script]


def cache_folder() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "dimple"


def mirror() -> str:
    """Read the Debian mirror from this machine's own apt sources.

    Raises:
        Unavailable: no source for the running release.
    """
    release = platform.freedesktop_os_release().get("VERSION_CODENAME", "")
    form = ["--format", "$(RELEASE) $(COMPONENT) $(REPO_URI)", "Created-By: Packages"]
    listed = subprocess.run(["apt-get", "indextargets", *form], capture_output=True, text=True).stdout
    lines = [line.split(maxsplit=2) for line in listed.splitlines()]
    uris = [uri.rstrip("/") for suite, part, uri in lines if suite in (release, "sid") and part == "main"]
    if not uris:
        raise Unavailable(f"apt on this machine names no mirror of Debian's {release!r} main")
    # other people's archives may use the same names; debootstrap checks the signature in any case
    return next((uri for uri in uris if uri.endswith("/debian")), uris[0])


def require_machine() -> None:
    """Check what cannot be installed, then install what can.

    Raises:
        Unavailable: not Linux, not Debian, not root, no namespaces, or a package that does not install.
    """
    if sys.platform != "linux":
        raise Unavailable(f"a Debian chroot needs Linux, this is {sys.platform}")
    try:
        distribution = platform.freedesktop_os_release().get("ID")
    except OSError:
        distribution = None
    if distribution != "debian" or not shutil.which("apt-get"):
        raise Unavailable(f"the chroot is made with Debian's own tools, this is {distribution or 'unknown'}")
    if os.geteuid() != 0:
        raise Unavailable("making and entering a chroot needs root")
    if subprocess.run(private("true", 10), capture_output=True).returncode:
        raise Unavailable("this machine lets nobody make a mount namespace (a container without the right?)")


def install_debootstrap(log: Path) -> None:
    """Install debootstrap by apt where it is missing."""
    if shutil.which("debootstrap"):
        return
    print("window: installing debootstrap", flush=True)
    with log.open("ab") as out:
        for command in (["update"], ["install", "-y", "--no-install-recommends", "debootstrap"]):
            subprocess.run(["timeout", "600", "apt-get", *command], stdout=out, stderr=out)
    if not shutil.which("debootstrap"):
        raise Unavailable(f"debootstrap is missing and apt could not install it (see {log})")


def build(suite: str, folder: Path, log: Path, lock: int) -> bool:
    """Build one suite's chroot at folder/root; an interrupted try is thrown away, its downloads are kept.

    The worker keeps the lock: where this process is killed, the next run waits for it and takes its result.
    """
    target, debs = folder / "root.partial", folder / "debs"
    subprocess.run(["rm", "-rf", "--one-file-system", target], check=True)
    debs.mkdir(parents=True, exist_ok=True)
    names = {"SUITE": suite, "TARGET": str(target), "DONE": str(folder / "root"), "MIRROR": mirror()}
    names |= {"CACHE": str(debs), "KEYRING": KEYRING, "PACKAGES": PACKAGES, "OLDEST": OLDEST_BLENDER}
    started = time.monotonic()
    print(f"window: building a Debian {suite} with Blender, once, a few minutes; log: {log}", flush=True)
    with log.open("ab") as out:
        script, names = private(BUILD_SCRIPT, BUILD_LIMIT_S), os.environ | names | {"LC_ALL": "C.UTF-8"}
        worker = subprocess.Popen(script, stdout=out, stderr=out, env=names, pass_fds=[lock])
        while worker.poll() is None:
            time.sleep(0.5)
            if sys.stdout.isatty():
                print(f"\r  {last_line(log):<78.78}", end="", flush=True)
    print(f"  {suite}: {time.monotonic() - started:.0f} s, {'done' if worker.returncode == 0 else 'failed'}")
    return worker.returncode == 0


def last_line(log: Path) -> str:
    with log.open("rb") as text:
        text.seek(max(0, log.stat().st_size - 400))
        lines = text.read().decode(errors="replace").split("\n")
    return next((line.strip() for line in reversed(lines) if line.strip()), "")


def chroot_folder() -> Path:
    """Return the root of a chroot with a windowed Blender, building it first where needed.

    Raises:
        Unavailable: it cannot be built here.
    """
    require_machine()
    import fcntl  # not on Windows, where the line above has already said no

    cache = cache_folder()
    cache.mkdir(parents=True, exist_ok=True)
    with (cache / "window.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)  # a second run waits for the first one's build
        for suite in SUITES:
            root = cache / f"window-{suite}" / "root"
            if (root / "usr/bin/blender").exists():
                return root
        failures = []
        for suite in SUITES:
            folder = cache / f"window-{suite}"
            folder.mkdir(exist_ok=True)
            log = folder / "build.log"
            log.write_bytes(b"")
            install_debootstrap(log)
            if build(suite, folder, log, lock.fileno()):
                return folder / "root"
            failures.append(f"{suite}: {last_line(log)}")
    raise Unavailable(f"no Debian suite gave a Blender {OLDEST_BLENDER} or newer: {'; '.join(failures)}")


def run_inside(
    root: Path, command: str, *, files: dict[str, Path], environment: dict[str, str], log: Path, limit_s: int
) -> int:
    """Run a shell command inside the chroot, off the network, with files and folders bound under /mnt.

    Args:
        files: name under /mnt -> file or folder outside; folders can be written.
        log: takes what the command prints.
        limit_s: [s] of wall time; then it is killed.

    Returns:
        Its exit code, 137 when it was killed at the limit.
    """
    lines = [f"set -eu; cd {shlex.quote(str(root))}; mount -t proc proc proc; mount --rbind /dev dev"]
    lines += ["mount -t tmpfs tmpfs tmp; mount -t tmpfs tmpfs mnt; mkdir -m 1777 tmp/.X11-unix"]
    for name, path in files.items():
        make = "mkdir" if path.is_dir() else "touch"
        lines.append(f"{make} mnt/{name}; mount --bind {shlex.quote(str(path.resolve()))} mnt/{name}")
    lines.append(f"exec chroot . sh -c {shlex.quote(command)}")
    names = {"PATH": "/usr/sbin:/usr/bin:/sbin:/bin", "HOME": "/tmp", "LC_ALL": "C.UTF-8"} | environment
    with log.open("wb") as out:
        script = private("\n".join(lines), limit_s, offline=True)
        return subprocess.run(script, stdout=out, stderr=out, stdin=subprocess.DEVNULL, env=names).returncode
