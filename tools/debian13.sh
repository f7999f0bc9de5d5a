#!/usr/bin/env bash
# Run the tests on Debian 13 (dolfinx 0.9) in a chroot made by debootstrap; `make test-debian13`.
# The chroot is kept in $DEBIAN13 (default ~/.cache/wroll_fem/debian13); a machine that cannot make one says so and goes on.
# Arguments are passed to pytest in place of the default ones.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

root="${DEBIAN13:-$HOME/.cache/wroll_fem/debian13}"
mirror="${DEBIAN_MIRROR:-http://deb.debian.org/debian}"

skip() {
    echo "test-debian13: skipped: $*"
    exit 0
}

[ "$(id -u)" = 0 ] || skip "a chroot needs root"
command -v debootstrap >/dev/null || skip "debootstrap is not installed (apt install debootstrap)"

if [ ! -f "$root/.made" ]; then
    rm -rf "$root"
    mkdir -p "$root"
    echo "test-debian13: making a Debian 13 in $root (a few minutes)"
    debootstrap --variant=minbase --include=ca-certificates,git trixie "$root" "$mirror" >"$root.log" 2>&1 ||
        skip "debootstrap failed; the last line of $root.log: $(tail -n 1 "$root.log")"
    touch "$root/.made"
fi

mounts=()
unmount() {
    local place
    for place in "${mounts[@]}"; do umount -l "$place"; done
}
trap unmount EXIT
bind() { # directory of this machine, inside the chroot too
    [ -d "$1" ] || return 0
    mkdir -p "$root$1"
    mount --bind "$1" "$root$1" 2>/dev/null || skip "this machine does not let $1 be mounted in a chroot"
    mounts+=("$root$1")
}
bind /proc
bind /dev
bind /opt # package indexes of this machine, where it has any
cp -L /etc/resolv.conf /etc/hosts "$root/etc/"
for file in /etc/pip.conf /etc/ssl/certs/ca-certificates.crt; do
    if [ -f "$file" ]; then cp -L "$file" "$root$file"; fi
done

rm -rf "$root/work"
git clone -q . "$root/work"
if [ -d "$root/venv" ]; then mv "$root/venv" "$root/work/.venv"; fi # keeps what pip has installed
words=("$@")
[ ${#words[@]} -gt 0 ] || words=(-q -n 2 -m "not slow")
status=0
chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 OMP_NUM_THREADS=1 \
    PIP_CERT="${PIP_CERT:-}" PIP_FIND_LINKS="${PIP_FIND_LINKS:-}" \
    bash -c 'cd /work && apt-get update -q >/dev/null && tools/setup.sh && .venv/bin/wroll info && exec .venv/bin/python -m pytest "$@"' \
    bash "${words[@]}" || status=$?
if [ -d "$root/work/.venv" ]; then mv "$root/work/.venv" "$root/venv"; fi
exit $status
