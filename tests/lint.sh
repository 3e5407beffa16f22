#!/bin/sh
# Reads the sources with what is installed of luacheck, clang-format, shellcheck and clang-tidy. The last line says what was run.
# clang-tidy takes the compile commands of out-release, and minutes: it runs with LIBRT_FULL=1 or when asked for. usage: lint.sh [--tidy]
set -u
cd "$(dirname "$0")/.." || exit 1
ran=
bad=0
have() { command -v "$1" >/dev/null 2>&1; }
# files PATTERN...: the tracked files of these patterns, one a line; in an unpacked archive, all that are there.
files() {
    if git rev-parse --git-dir >/dev/null 2>&1; then
        git ls-files -- "$@"
        return
    fi
    for pattern in "$@"; do
        find . -path './out*' -prune -o -path "./$pattern" -type f -print
    done
}

if have luacheck && [ -n "$(files '*.lua' '*.luacheckrc')" ]; then
    ran="$ran luacheck"
    files '*.lua' | xargs luacheck -q || bad=1
fi
if have clang-format; then
    ran="$ran clang-format"
    # Headers keep their one-line functions and hand-set columns of comments, which clang-format 14 would break up.
    files '*.c' | xargs clang-format --dry-run --Werror || bad=1
fi
if have shellcheck; then
    ran="$ran shellcheck"
    { files '*.sh' && echo .ci/run; } | xargs shellcheck || bad=1
fi
if have clang-tidy && [ -f out-release/compile_commands.json ] && { [ "${1:-}" = --tidy ] || [ "${LIBRT_FULL:-0}" != 0 ]; }; then
    ran="$ran clang-tidy"
    commands=$(mktemp -d) || exit 1
    sed 's/ -fno-ipa-cp-clone//g' out-release/compile_commands.json >"$commands/compile_commands.json" # GCC alone knows it
    files 'librt/*.c' 'lua/*.c' 'examples/*.c' | xargs -P "${JOBS:-2}" -n 8 clang-tidy --quiet -p "$commands" --warnings-as-errors='*' || bad=1
    rm -r "$commands"
fi
[ -n "$ran" ] || ran=" nothing (no linter is installed)"
if [ "$bad" -eq 0 ]; then
    echo "clean:$ran"
else
    echo "not clean:$ran"
    exit 1
fi
