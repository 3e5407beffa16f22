#!/bin/bash
# How many of the lane loops (librt/render/lanes_*: RTI_EACH_LANE) each compiler here makes vectors of, at each instruction set.
#   tests/bench/lanes.sh         prints CSV; GCC and Clang are asked by their own reports (-fopt-info-vec-optimized, -Rpass=loop-vectorize)
set -euo pipefail
export LC_ALL=C
cd "$(dirname "$0")/../.."
report=$(mktemp)
trap 'rm -f "$report"' EXIT

flags() {
  case $1 in
    sse42) echo "-msse4.2" ;;
    avx2) echo "-mavx2 -mbmi -mbmi2" ;;
    avx512_vbmi2) echo "-mavx512f -mavx512vl -mavx512bw -mavx512dq -mpopcnt -mbmi -mbmi2 -mlzcnt -mavx512vbmi2 -mprefer-vector-width=512" ;;
    avx512) echo "-mavx512f -mavx512vl -mavx512bw -mavx512dq -mpopcnt -mbmi -mbmi2 -mlzcnt -mprefer-vector-width=512" ;;
    *) echo "" ;;
  esac
}

echo "compiler,isa,file,loops,vectorised"
for cc in gcc clang; do
  command -v $cc >/dev/null || continue
  ask=-fopt-info-vec-optimized
  [ $cc = clang ] && ask=-Rpass=loop-vectorize
  for isa in generic sse42 avx2 avx512 avx512_vbmi2; do
    for file in librt/render/lanes_{around,camera,lamp,light,path,placed,sort,surface,texture,whitted}.c librt/render/lanes_{classic,corners,shadow}.h; do
      case $file in # a header's loops are made where it is included
        *classic.h) made=librt/render/lanes_path.c ;;
        *corners.h) made=librt/render/lanes_surface.c ;;
        *shadow.h) made=librt/render/lanes_lamp.c ;;
        *) made=$file ;;
      esac
      # shellcheck disable=SC2046
      $cc -D_POSIX_C_SOURCE=200809L -DRTI_ISA=generic -Ilibrt/include -std=c11 -O3 -DNDEBUG -fPIC -ffp-contract=off -fno-math-errno \
        -fno-trapping-math $(flags $isa) -c "$made" -o /dev/null $ask 2>"$report"
      # A loop counts when a report names a line between its head and the next function's end; inlined bodies are named by the kernel's lines, so
      # the head's line (GCC) or the body's (Clang) is looked for in this file.
      awk -v cc=$cc -v isa=$isa -v file="$file" '
        FNR == NR { if ($0 ~ /loop vectorized|vectorized loop/ && index($0, file ":") == 1) { split($0, p, ":"); seen[p[2]] = 1 } next }
        /RTI_EACH_LANE(_INNER)?\([ki]\)/ { head[++n] = FNR; open = n }
        /^}/ { if (n) last[n] = FNR }
        END {
          for (i = 1; i <= n; i++) {
            end = i < n ? head[i + 1] - 1 : last[n]
            for (l = head[i]; l <= end; l++) if (seen[l]) { done++; break }
          }
          printf "%s,%s,%s,%d,%d\n", cc, isa, file, n, done
        }' "$report" "$file"
    done
  done
done
