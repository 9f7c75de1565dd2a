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
"$build/bench/homing_paths" --figures "$folder"
python3 docs/figures/homing.py "$folder/homing.csv" docs/figures
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

# The drive of axis y without supply for 0.6 s, under either choice of [recovery].
awk 'BEGIN { print "time[s],x[rad],y[rad]"; for (i = 0; i <= 400; ++i) { t = i / 100; p = 1 - cos(2 * 3.14159265 * t / 2); print t "," p "," p / 2 } }' > "$folder/path.csv"
for axes in hold continue; do
  cat > "$folder/$axes.toml" <<LINE
[line]
cycle_us = 1000
[recovery]
axes = "$axes"
[path]
file = "path.csv"
[telemetry]
enabled = false
[[slave]]
name = "x"
[[slave]]
name = "y"
[[axis]]
name = "x"
max_velocity = 20
max_acceleration = 100
[[axis]]
name = "y"
max_velocity = 20
max_acceleration = 100
[[fault]]
at_ms = 1500
kind = "power-off"
slave = "y"
for_ms = 600
LINE
  "$build/driveline" run --config "$folder/$axes.toml" --virtual --no-plots --output "$folder/$axes" > /dev/null
done
gnuplot <<PLOT
set terminal svg size 760,480 font 'sans,11' background 'white' noenhanced
set output 'docs/figures/recovery.svg'
set datafile separator ','
set grid
set key outside right
set xlabel 'time in s'
set ylabel 'position in rad'
set xrange [0:5]
set multiplot layout 2,1
do for [axes in 'hold continue'] {
  set title axes
  plot '$folder/'.axes.'/axes.csv' every 10 using 1:3 with lines title 'x', '' every 10 using 1:6 with lines title 'y'
}
unset multiplot
PLOT

# The example path at 125 us: how far axis z lags, and the current that the torque needs.
"$build/driveline" run --config examples/line8.toml --duration 8 --virtual --no-telemetry --no-plots --output "$folder" > /dev/null
gnuplot <<PLOT
set terminal svg size 760,520 font 'sans,11' background 'white' noenhanced
set output 'docs/figures/tracking.svg'
set datafile separator ','
set grid
unset key
set xrange [0:8]
set multiplot layout 3,1
set lmargin 9
set rmargin 3
set ylabel 'position, rad'
plot '$folder/axes.csv' skip 1 every 4 using 1:9 with lines title 'position'
set ylabel 'following error, inc'
plot '$folder/axes.csv' skip 1 every 4 using 1:(\$10*1048576/(2*pi)) with lines title 'following error'
set ylabel 'current, A'
set xlabel 'time in s'
# Nm by the torque constant of the simulated motor, 2.4 Nm at 2.5 A (slaves/plant: MotorParameters)
plot '$folder/axes.csv' skip 1 every 4 using 1:(\$28*2.5/2.4) with lines title 'current'
unset multiplot
PLOT

"$build/driveline" plan examples/delta.jsonl --picture docs/figures/delta.svg > /dev/null

docs/figures/clocks.sh "$build"
docs/figures/feed_forward.py "$build"
docs/figures/motion.py "$build"

# Measurements at 8 kHz have many points per pixel.
python3 docs/figures/compact.py docs/figures/*.svg
