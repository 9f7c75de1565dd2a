#!/usr/bin/env bash
# Makes the figures of the documents anew: docs/figures/make.sh [build folder]
set -euo pipefail
cd "$(dirname "$0")/../.."
build=${1:-build}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
# Eight clocks, up to 48 ppm off each other, from the first cycle on.
"$build/driveline" dc --config examples/line8-dc.toml --virtual --duration 1.2 --no-plots --output "$folder" > "$folder/table"
cat "$folder/table"
gnuplot <<PLOT
set terminal svg size 760,300 font 'sans,11' background 'white' noenhanced
set output 'docs/figures/clocks.svg'
set datafile separator ','
set grid
set key outside right
set xlabel 'time since the cycle began in s'
set ylabel 'difference in ns'
plot for [i=3:9] '$folder/clocks.csv' using 1:i with lines title columnheader(i)
PLOT
