#!/usr/bin/env bash
# Run the tests on Debian 13 (dolfinx 0.9) in a chroot made by debootstrap: `make test-debian13`.
# The chroot is kept in $DEBIAN13 (default ~/.cache/wroll_fem/debian13). A machine that cannot make one skips the tests.
# Mirror: $DEBIAN_MIRROR, or the first Debian archive of the machine's own apt sources that has Debian 13.
# Arguments replace the default ones of pytest; `--print-mirror` alone prints the mirror.
set -euo pipefail
cd "$(dirname "${BASH_SOURCE[0]}")/.."

root="${DEBIAN13:-$HOME/.cache/wroll_fem/debian13}"
release=trixie
apt_sources="${APT_SOURCES:-/etc/apt}" # folder of sources.list and sources.list.d

skip() {
    echo "test-debian13: skipped: $*"
    exit 0
}

apt_entries() { # "URI suite component..." of every package source of apt, both formats
    local file
    for file in "$apt_sources"/sources.list.d/*.sources; do
        [ -f "$file" ] || continue
        awk 'function flush(u, s) {
                 if (types ~ /(^| )deb( |$)/ && enabled != "no")
                     for (u = 1; u <= split(uris, U, " "); u++)
                         for (s = 1; s <= split(suites, S, " "); s++) print U[u], S[s], components
                 types = uris = suites = components = enabled = key = ""
             }
             /^#/ { next }
             /^[ \t]*$/ { flush(); next }
             /^[^ \t]/ { key = tolower($1); sub(/^[^:]*:[ \t]*/, "") }
             { gsub(/^[ \t]+|[ \t\r]+$/, "") }
             key == "types:" { types = types " " $0 }
             key == "uris:" { uris = uris " " $0 }
             key == "suites:" { suites = suites " " $0 }
             key == "components:" { components = components " " $0 }
             key == "enabled:" { enabled = tolower($0) }
             END { flush() }' "$file"
    done
    for file in "$apt_sources"/sources.list "$apt_sources"/sources.list.d/*.list; do
        [ -f "$file" ] || continue
        sed -E 's/#.*//; s/\[[^]]*\]//' "$file" | awk '$1 == "deb" { $1 = ""; print substr($0, 2) }'
    done
}

archives() { # URIs of Debian archives: component main, a suite of Debian itself; the official layout (.../debian) first
    local uri suite components list
    apt_entries | while read -r uri suite components; do
        [[ " $components " == *" main "* ]] || continue
        case "$suite" in
        stable | testing | unstable | sid | oldstable | bookworm | trixie | forky) ;;
        *) continue ;;
        esac
        if [[ "$uri" == mirror+file:* ]]; then # a list of mirrors, as on cloud images
            list="${uri#mirror+file:}"
            [ -f "$list" ] || continue
            uri="$(grep -m 1 -oE '^[a-z+]+:[^[:space:]]+' "$list" || true)"
        fi
        [[ "$uri" == http://* || "$uri" == https://* || "$uri" == file:* ]] || continue
        uri="${uri%/}"
        case "$uri" in
        */debian) echo "1 $uri" ;;
        *) echo "2 $uri" ;;
        esac
    done | sort -s -k 1,1 | cut -d ' ' -f 2 | awk '!seen[$0]++'
}

has_release() {
    local file status=0
    if [[ "$1" == file:* ]]; then
        [ -f "${1#file:}/dists/$release/Release" ]
        return
    fi
    file="$(mktemp)"
    /usr/lib/apt/apt-helper -o Acquire::Retries=1 download-file "$1/dists/$release/Release" "$file" >/dev/null 2>&1 || status=$?
    rm -f "$file"
    return $status
}

mirror_of_this_machine() {
    local uri
    for uri in $(archives); do
        if has_release "$uri"; then
            echo "$uri"
            return
        fi
    done
    echo http://deb.debian.org/debian
}

mirror="${DEBIAN_MIRROR:-}"
if [ "${1:-}" = --print-mirror ]; then
    echo "${mirror:-$(mirror_of_this_machine)}"
    exit
fi

[ "$(id -u)" = 0 ] || skip "a chroot needs root"
command -v debootstrap >/dev/null || skip "debootstrap is not installed (apt install debootstrap)"

if [ ! -f "$root/.made" ]; then
    rm -rf "$root"
    mkdir -p "$root"
    mirror="${mirror:-$(mirror_of_this_machine)}"
    echo "test-debian13: making a Debian 13 in $root from $mirror (a few minutes)"
    debootstrap --variant=minbase --include=ca-certificates,git "$release" "$root" "$mirror" >"$root.log" 2>&1 ||
        skip "debootstrap failed; the last line of $root.log: $(tail -n 1 "$root.log")"
    if [[ "$mirror" == file:* ]]; then echo "${mirror#file:}" >"$root/.mirror"; fi
    touch "$root/.made"
fi

mounts=()
unmount() {
    local i
    for ((i = ${#mounts[@]} - 1; i >= 0; i--)); do umount -l "${mounts[i]}" || true; done # the last first: they nest
}
trap unmount EXIT
bind() { # directory of this machine, at the same path inside the chroot
    [ -d "$1" ] || return 0
    mkdir -p "$root$1"
    mount --bind "$1" "$root$1" 2>/dev/null || skip "this machine does not let $1 be mounted in a chroot"
    mounts+=("$root$1")
}
copy() { # file of this machine, at the same path inside the chroot
    mkdir -p "$root$(dirname "$1")"
    cp -L "$1" "$root$1"
}
bind /proc
bind /dev
bind /dev/pts # terminals for the tests of the progress bars
if [ -f "$root/.mirror" ]; then bind "$(cat "$root/.mirror")"; fi # an archive on a disk of this machine
copy /etc/resolv.conf
copy /etc/hosts

# proxies of apt, settings of pip, and the local files and folders (indexes, certificates) that those name
apt-config dump | grep -iE '^Acquire::[^ ]*prox[^ ]* "..*"' >"$root/etc/apt/apt.conf.d/90proxy" || true
settings=() named=()
while IFS='=' read -r -d '' name value; do
    case "$name" in
    PIP_* | http_proxy | https_proxy | no_proxy | HTTP_PROXY | HTTPS_PROXY | NO_PROXY | SSL_CERT_FILE | REQUESTS_CA_BUNDLE)
        settings+=("$name=$value") named+=("$value")
        ;;
    esac
done < <(env -0)
for file in /etc/pip.conf /etc/ssl/certs/ca-certificates.crt; do
    if [ -f "$file" ]; then copy "$file"; fi
done
if [ -f /etc/pip.conf ]; then named+=("$(cut -d = -f 2- /etc/pip.conf)"); fi
for path in $(printf '%s\n' "${named[@]}" | grep -oE '(^|[[:space:],]|file://)/[^[:space:],]+' | sed -E 's,^[[:space:],]+,,; s,^file://,,' | sort -u); do
    if [ -d "$path" ]; then bind "$path"; elif [ -f "$path" ]; then copy "$path"; fi
done

rm -rf "$root/work"
git clone -q . "$root/work"
if [ -d "$root/venv" ]; then mv "$root/venv" "$root/work/.venv"; fi # keeps what pip has installed
words=("$@")
[ ${#words[@]} -gt 0 ] || words=(-q -n 2 -m "not slow")
status=0
chroot "$root" /usr/bin/env -i PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 OMP_NUM_THREADS=1 "${settings[@]}" \
    bash -c 'cd /work && apt-get update -q >/dev/null && tools/setup.sh && .venv/bin/wroll info && exec .venv/bin/python -m pytest "$@"' \
    bash "${words[@]}" || status=$?
if [ -d "$root/work/.venv" ]; then mv "$root/work/.venv" "$root/venv"; fi
exit $status
