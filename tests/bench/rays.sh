#!/bin/sh
# The tables of the goals for rays, and their CSV files in tests/bench/results, named by the machine. usage: rays.sh RAYS [NAME [OPTIONS...]]
#
# RAYS is the benchmark, out-release/tests/bin/rays. NAME is what the machine is called; else its processor and
# its number of CPUs. OPTIONS go to every run behind the others, as --builders auto,high or --repeats 11. LIBRT_SCENES names the folder of meshes.
#   1. one thread, 640x480: all sets, Embree MEDIUM and HIGH, ROBUST beside it, plain arrays beside blocks      rays-NAME.csv
#   2. one thread, 1920x1080: primary and shadow                                                                rays-1080-NAME.csv
#   3. threads 1, 2, 4 ... by wall time, with the summed rate of as many processes: primary, diffuse, sponza    rays-threads-NAME.csv
# Timings decide nothing here; an idle machine makes them worth keeping.
set -eu
export LC_ALL=C
rays=${1:?usage: rays.sh RAYS [NAME [OPTIONS...]]}
shift
name=${1:-}
[ $# -eq 0 ] || shift
results=$(cd "$(dirname "$0")" && pwd)/results
if [ -z "$name" ]; then
    name=$(sed -n 's/^model name[^:]*: //p' /proc/cpuinfo | head -n 1 | tr '[:upper:]' '[:lower:]' |
        sed 's/([a-z]*)//g; s/@.*//; s/cpu//g; s/processor//g; s/[^a-z0-9]\{1,\}/-/g; s/^-//; s/-$//')
    name=${name:-unknown}-$(getconf _NPROCESSORS_ONLN)cpus
fi
echo "machine: $name, $(uptime | sed 's/.*load average/load average/')"
"$rays" --preset embree --machine "$name" -o "$results/rays-$name.csv" "$@"
"$rays" --preset embree-1080 --machine "$name" -o "$results/rays-1080-$name.csv" "$@"
"$rays" sponza --preset embree-threads --sets primary,diffuse --machine "$name" -o "$results/rays-threads-$name.csv" "$@"
echo "load average at the end:$(uptime | sed 's/.*load average://')"
