#!/usr/bin/env bash
# Make everything that wroll_fem needs on Debian 12 or 13: packages by apt, .venv, the project itself.
# Safe to run again; answers at once when nothing is missing. EXTRAS picks the optional parts of pyproject.toml.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

extras="${EXTRAS:-dev,view,lab}"
system_python=/usr/bin/python3 # not a pyenv or conda python: dolfinx lives with Debian's
stamp=.venv/.wroll-setup
packages=(
    python3-dolfinx-real python3-petsc4py-real python3-slepc4py-real python3-mpi4py python3-scipy
    python3-h5py python3-h5py-mpi python3-venv python3-dev gcc libc6-dev make ca-certificates
    libopenblas0-pthread # three times the speed of the reference BLAS in the time loop
    libgl1 libegl1 libglu1-mesa libxft2 libxcursor1 libxinerama1
    libjs-mathjax # formulas of the site without a network (make docs)
)
# the tests look at reports in a browser; the shell alone is 109 MB to fetch, all of chromium 150 MB and an init system
if [[ ",$extras," == *,dev,* ]] && ! command -v chromium >/dev/null; then packages+=(chromium-headless-shell); fi

fail() {
    echo "setup: $*" >&2
    exit 1
}

state() { # what the installed environment depends on
    { cat pyproject.toml tools/setup.sh; grep "^__version__" wroll_fem/__init__.py; pwd; echo "$extras"; "$system_python" --version; debian_version numpy; } 2>/dev/null | sha256sum
}

debian_version() { # version of a Python package of Debian, seen from Debian's Python alone
    "$system_python" -I -c "import $1; print($1.__version__)"
}

missing_packages() {
    local package
    for package in "${packages[@]}"; do
        dpkg-query -W -f='${db:Status-Status}' "$package" 2>/dev/null | grep -qx installed || echo "$package"
    done
}

install_packages() {
    local missing as_root=()
    mapfile -t missing < <(missing_packages)
    [ "${#missing[@]}" -eq 0 ] && return
    command -v apt-get >/dev/null || fail "these Debian packages are missing and there is no apt-get: ${missing[*]}"
    if [ "$(id -u)" -ne 0 ]; then
        command -v sudo >/dev/null || fail "run as root or install sudo; missing packages: ${missing[*]}"
        as_root=(sudo)
    fi
    echo "setup: installing ${missing[*]}"
    "${as_root[@]}" apt-get update -q
    "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive apt-get install -qy --no-install-recommends "${missing[@]}"
}

make_venv() {
    .venv/bin/python -m pip --version >/dev/null 2>&1 && return # no pip: interrupted, or of an older Debian
    echo "setup: making .venv"
    "$system_python" -m venv --clear --system-site-packages .venv
}

install_project() {
    # numpy and scipy stay Debian's: dolfinx is compiled against them
    local constraints=.venv/constraints.txt name
    for name in numpy scipy; do
        echo "$name==$(debian_version "$name")"
    done >"$constraints"
    echo "setup: installing wroll_fem with extras $extras"
    .venv/bin/python -m pip install -q -c "$constraints" -e ".[$extras]"
}

check() {
    .venv/bin/python - <<'PYTHON'
import importlib.util, pathlib, sys

venv = pathlib.Path(sys.prefix)
for name in ("h5py", "netCDF4", "dolfinx", "petsc4py", "slepc4py", "mpi4py", "numpy", "scipy"):
    found = importlib.util.find_spec(name)
    inside = found is not None and found.origin is not None and pathlib.Path(found.origin).is_relative_to(venv)
    if inside:
        sys.exit(f"setup: {name} in .venv comes from PyPI and clashes with Debian's dolfinx; "
                 f"run: .venv/bin/python -m pip uninstall -y {name}")
    if found is None and name != "netCDF4":
        sys.exit(f"setup: {name} is missing")
try:
    import dolfinx, h5py  # in this order: two HDF5 libraries in one process show here
    from slepc4py import SLEPc
except Exception as error:
    sys.exit(f"setup: the installed FEniCSx does not work: {type(error).__name__}: {error}")
PYTHON
}

if [ -f "$stamp" ] && [ -x .venv/bin/wroll ] && [ "$(cat "$stamp")" = "$(state)" ]; then
    exit 0
fi
install_packages
make_venv
install_project
check
echo "setup: compiling the kernels"
.venv/bin/python tools/compile_kernels.py
state >"$stamp"
echo "setup: done"
