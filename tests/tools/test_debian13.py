"""The Debian archive of `make test-debian13` comes from the machine's own apt sources."""

from __future__ import annotations

import os
import subprocess
from pathlib import Path

import pytest
from support.paths import ROOT

DEB822 = """\
Enabled: no
Types: deb
URIs: file:{folder}/off
Suites: trixie
Components: main

# a comment
Types: deb deb-src
URIs: {mirror}
Suites: bookworm
 bookworm-updates
Components: main contrib
Signed-By: /usr/share/keyrings/debian-archive-keyring.gpg
"""
ONE_LINE = """\
# deb file:{folder}/off bookworm main
deb-src file:{folder}/off bookworm main
deb file:{folder}/off bookworm-security main
deb file:{folder}/off jammy main
deb [arch=amd64 signed-by=/usr/share/keyrings/x.gpg] {mirror}/ bookworm main  # the mirror
"""


def printed(folder: Path, **environment: str) -> str:
    command = [str(ROOT / "tools" / "debian13.sh"), "--print-mirror"]
    everything = {key: value for key, value in os.environ.items() if key != "DEBIAN_MIRROR"}
    everything |= {"APT_SOURCES": str(folder / "apt"), **environment}
    done = subprocess.run(command, env=everything, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def write(folder: Path, name: str, text: str) -> str:
    """Write a list of sources, and archives with Debian 13 for all that it names; returns the mirror."""
    for archive in ("debian", "off"):
        (folder / archive / "dists" / "trixie").mkdir(parents=True)
        (folder / archive / "dists" / "trixie" / "Release").touch()
    mirror = f"file:{folder}/debian"
    path = folder / "apt" / name
    path.parent.mkdir(parents=True)
    path.write_text(text.format(folder=folder, mirror=mirror), encoding="utf-8")
    return mirror


@pytest.mark.parametrize(
    ("name", "text"),
    [("sources.list.d/debian.sources", DEB822), ("sources.list", ONE_LINE)],
    ids=["deb822", "one-line"],
)
def test_the_mirror_is_that_of_the_sources(name: str, text: str, tmp_path: Path) -> None:
    assert printed(tmp_path) == "http://deb.debian.org/debian"  # no sources
    mirror = write(tmp_path, name, text)
    assert printed(tmp_path) == mirror
    assert printed(tmp_path, DEBIAN_MIRROR="http://mirror.example/debian") == "http://mirror.example/debian"


def test_an_archive_without_debian_13_is_not_taken(tmp_path: Path) -> None:
    write(tmp_path, "sources.list", ONE_LINE)
    (tmp_path / "debian" / "dists" / "trixie" / "Release").unlink()
    assert printed(tmp_path) == "http://deb.debian.org/debian"
