#!/bin/sh
# Bring the clone's own environment up to date: `tools/setup.sh run` or `tools/setup.sh test`.
#
# "run" is what the product needs; "test" adds the tools and the system packages of tools/apt-packages.txt.
# Nothing outside the clone is touched, except that missing system packages are installed when this is root
# or sudo needs no password. A second call with nothing changed does nothing and needs no network.
set -eu
cd "$(dirname "$0")/.."

need=${1:-run}
case $need in
    run) extras='' ;;
    test) extras='[test]' ;;
    *) echo "usage: tools/setup.sh run|test" >&2; exit 2 ;;
esac
python=${PYTHON:-python3}

say() { printf '%s\n' "pcaccess: $*" >&2; }

# What would have to be installed with apt. A line of the list is "package [command]  # why": a command that
# is already there will do, wherever it came from.
missing_packages() {
    sed -e 's/#.*//' tools/apt-packages.txt | while read -r package command; do
        [ -n "$package" ] || continue
        if [ -n "$command" ] && command -v "$command" >/dev/null 2>&1; then continue; fi
        status=$(dpkg-query -W -f '${Status}' "$package" 2>/dev/null || true)
        [ "$status" = "install ok installed" ] || printf ' %s' "$package"
    done
}

install_packages() {
    if ! command -v dpkg-query >/dev/null 2>&1; then
        say "this is not a Debian system; tools/apt-packages.txt lists what the tests use"
        return
    fi
    packages=$(missing_packages)
    [ -n "$packages" ] || return 0
    say "installing system packages:$packages"
    if [ "$(id -u)" = 0 ]; then as_root=''
    elif sudo -n true 2>/dev/null; then as_root='sudo -n'
    else
        say "these system packages are missing. Install them, then try again:"
        say "    sudo apt-get update && sudo apt-get install -y --no-install-recommends$packages"
        exit 1
    fi
    # Unquoted on purpose: a list of packages, and a prefix that may be empty.
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get update -qq
    $as_root env DEBIAN_FRONTEND=noninteractive apt-get install -y -qq --no-install-recommends $packages
}

check_python() {
    if ! command -v "$python" >/dev/null 2>&1; then
        say "$python is missing: sudo apt-get install -y python3 python3-venv"
        exit 1
    fi
    if ! "$python" -c 'import sys; sys.exit(sys.version_info < (3, 11))'; then
        say "$("$python" --version) is too old: pcaccess needs 3.11 or newer (PYTHON=python3.12 make ... names another)"
        exit 1
    fi
    # Debian ships venv without ensurepip unless python3-venv is installed.
    if ! "$python" -c 'import ensurepip, venv' >/dev/null 2>&1; then
        say "python3 has no venv. Install it, then try again: sudo apt-get install -y python3-venv"
        exit 1
    fi
}

# The stamp holds what the environment was made from: contents, not file times, so that git checkouts do not
# reinstall; the place of the clone, because an editable install remembers it; and the Python.
fingerprint() {
    { pwd; "$python" -c 'import sys; print(sys.version, sys.prefix)'; cat pyproject.toml constraints.txt; } | cksum
}

is_current() { [ -f "$1" ] && [ "$(cat "$1")" = "$now" ] && .venv/bin/python -c 'import pcaccess' 2>/dev/null; }

[ "$need" = run ] || install_packages
check_python
now=$(fingerprint)
if is_current ".venv/.stamp-test" || is_current ".venv/.stamp-$need"; then exit 0; fi

if ! .venv/bin/python -c 'import pip, sys; sys.exit(sys.prefix == sys.base_prefix)' >/dev/null 2>&1; then
    say "making .venv"
    rm -rf .venv
    "$python" -m venv .venv
fi
rm -f .venv/.stamp-*
say "installing pcaccess$extras into .venv (once; a minute or two)"
.venv/bin/python -m pip install --disable-pip-version-check --use-pep517 --quiet -c constraints.txt -e ".$extras"
printf '%s\n' "$now" >".venv/.stamp-$need"
