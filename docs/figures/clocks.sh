#!/usr/bin/env bash
# Makes the figures of docs/distributed_clocks.md but the first anew: docs/figures/clocks.sh [build folder]
# Needs the program bench/dc (ninja bench_dc) and gnuplot.
set -euo pipefail
cd "$(dirname "$0")/../.."
build=${1:-build}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT
"$build/bench/dc" --figures "$folder"

style="set datafile separator ','
set grid lc rgb '#d0d0d0'
set border lc rgb '#606060'
set key outside right
set style line 1 lw 1.6 lc rgb '#0060ad'
set style line 2 lw 1.6 lc rgb '#dd181f'
set style line 3 lw 1.6 lc rgb '#2e8b2e'
set style line 4 lw 1.6 lc rgb '#b8860b'
set style line 5 lw 1.6 lc rgb '#7b3fa0'
set style line 6 lw 1.6 lc rgb '#606060'"
# draw NAME HEIGHT COMMANDS
draw() {
  gnuplot <<PLOT
set terminal svg size 760,$2 font 'sans,11' background 'white' noenhanced
set output 'docs/figures/$1.svg'
$style
$3
PLOT
}

draw lock_in 320 "
set xlabel 'time in ms'
set ylabel 'phase error, % of the period'
set xrange [0:400]
set yrange [-0.3:1.05]
plot '$folder/lock_in_125.csv' skip 1 using 1:(\$2/100) with lines ls 1 title '125 us', \
     '$folder/lock_in_250.csv' skip 1 using 1:(\$2/100) with lines ls 2 title '250 us', \
     '$folder/lock_in_1000.csv' skip 1 using 1:(\$2/100) with lines ls 3 title '1 ms', \
     '$folder/lock_in_4000.csv' skip 1 using 1:(\$2/100) with lines ls 4 title '4 ms', \
     '$folder/lock_in_10000.csv' skip 1 using 1:(\$2/100) with lines ls 5 title '10 ms'"

draw disturbed 640 "
set multiplot layout 5,1 margins 0.09,0.97,0.09,0.985 spacing 0.03
set key inside right bottom
set xrange [0:1]
set yrange [-40:40]
set ytics 20
set format x ''
set ylabel 'ns'
plot '$folder/disturbed_quiet.csv' skip 1 using 1:2 with lines ls 1 title 'undisturbed'
plot '$folder/disturbed_receive_jitter.csv' skip 1 using 1:2 with lines ls 2 title 'receive times +-20 ns'
plot '$folder/disturbed_temperature.csv' skip 1 using 1:2 with lines ls 3 title 'speeds wander by 1 ppm/s'
plot '$folder/disturbed_wake_jitter.csv' skip 1 using 1:2 with lines ls 4 title 'measured wake-up latency'
set format x
set xlabel 'time in s'
plot '$folder/disturbed_loss.csv' skip 1 using 1:2 with lines ls 5 title '1 % of the frames lost'
unset multiplot"

# Bands: least and greatest of every 16 cycles. The time ends with the data, what happened has its line and its name.
event="set autoscale xfix
set key outside right samplen 1.5
set arrow from 0.2, graph 0 to 0.2, graph 1 nohead lc rgb '#dd181f' dt 2 front"
draw takeover 460 "
set multiplot layout 3,1 margins 0.09,0.82,0.11,0.97 spacing 0.05
$event
set yrange [-20:20]
set ytics 10
set format x ''
set ylabel 'ns'
set label 1 'the reference clock is switched off' at 0.22, graph 0.88 tc rgb '#dd181f' font ',9'
plot '$folder/takeover.csv' skip 1 using 1:2:3 with filledcurves fc rgb '#0060ad' title 'slave 3'
unset label 1
plot '$folder/takeover.csv' skip 1 using 1:4:5 with filledcurves fc rgb '#dd8818' title 'slave 4'
set format x
set xlabel 'time in s'
plot '$folder/takeover.csv' skip 1 using 1:6:7 with filledcurves fc rgb '#2e8b2e' title 'slave 5'
unset multiplot"

draw ring 620 "
set multiplot layout 3,1 margins 0.10,0.82,0.085,0.97 spacing 0.07
$event
set style fill transparent solid 0.7 noborder
set ylabel 'in front, ns'
set yrange [-20:20]
set ytics 10
set label 1 'the cable in front of slave 8 breaks' at 0.22, graph 0.90 tc rgb '#dd181f' font ',9'
plot for [i=1:3] '$folder/ring_led.csv' skip 1 using 1:2*i:2*i+1 with filledcurves fc rgb word('#0060ad #dd8818 #2e8b2e', i) title 'slave '.word('1 4 7', i)
unset label 1
set ylabel 'behind, led, ns'
plot for [i=1:3] '$folder/ring_led.csv' skip 1 using 1:2*i+6:2*i+7 with filledcurves fc rgb word('#dd181f #b8860b #7b3fa0', i) title 'slave '.word('8 11 15', i)
set ylabel 'behind, free, ns'
set yrange [*:50]
set ytics 200
set xlabel 'time in s'
plot for [i=1:3] '$folder/ring_free.csv' skip 1 using 1:2*i+6:2*i+7 with filledcurves fc rgb word('#dd181f #b8860b #7b3fa0', i) title 'slave '.word('8 11 15', i)
unset multiplot"

# One cycle: what lies where.
draw cycle 300 "
unset grid
unset border
unset xtics
unset ytics
unset key
set xrange [-24:150]
set yrange [-0.6:4.6]
set arrow from -5,0 to 148,0 lc rgb '#606060'
set label 'time' at 140,-0.3
set arrow from 0,-0.1 to 0,4.3 nohead dt 2 lc rgb '#606060'
set arrow from 125,-0.1 to 125,4.3 nohead dt 2 lc rgb '#606060'
set label 'grid' at 1,4.35
set label 'grid + period' at 126,4.35
set label 'master' at -24,3.5
set object 1 rect from 0,3.2 to 9,3.8 fc rgb '#e0e0e0' fs border lc rgb '#606060'
set label 'wake' at 1,3.5
set object 2 rect from 9,3.2 to 18,3.8 fc rgb '#9ecae1' fs border lc rgb '#606060'
set label 'send' at 10,3.5
set object 3 rect from 44,3.2 to 58,3.8 fc rgb '#a1d99b' fs border lc rgb '#606060'
set label 'work' at 47,3.5
set label 'reference' at -24,2.4
set object 4 rect from 20,2.1 to 36,2.7 fc rgb '#9ecae1' fs border lc rgb '#606060'
set label 'frame' at 24,2.4
set arrow from 20,2.0 to 20,0 nohead dt 3 lc rgb '#606060'
set arrow from 80,2.9 to 80,0 nohead lw 2 lc rgb '#dd181f'
set label 'SYNC0' at 75,3.05 tc rgb '#dd181f'
set arrow from 20,1.75 to 80,1.75 heads size 2,15 lc rgb '#0060ad'
set label 'frame_lead: held by the master' at 28,1.95 tc rgb '#0060ad'
set label 'slave n' at -24,1.0
set object 5 rect from 24,0.7 to 40,1.3 fc rgb '#9ecae1' fs border lc rgb '#606060'
set label 'frame' at 28,1.0
set arrow from 98,1.5 to 98,0 nohead lw 2 lc rgb '#dd181f'
set label 'SYNC0 + shift' at 93,1.65 tc rgb '#dd181f'
set arrow from 40,0.5 to 98,0.5 heads size 2,15 lc rgb '#2e8b2e'
set label 'SYNC0 margin: 1C32h:11, :12' at 42,0.28 tc rgb '#2e8b2e'
plot NaN"
