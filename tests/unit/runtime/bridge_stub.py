#!/usr/bin/env python3
"""Stands in for driveline-bridge: does what the environment variable BRIDGE_STUB says, a word for each start, the last one
again and again. `ready`: says that it publishes and waits for its end; `exit`: ends with status 3; `abort`: by signal 6 when
it has said so; `fail`: says why it cannot; `remark`: publishes and says
so with a remark; `silent`: says nothing and takes no notice of its end; `garbage`: writes nonsense
into the region for its counts; `count`: tells counts; `beat`: publishes and shows signs of life until its end."""
import mmap
import os
import signal
import socket
import struct
import sys
import time

log, words = os.environ["BRIDGE_STUB"].split(":")
with open(log, "a", encoding="utf-8") as starts:
    starts.write(f"{os.getpid()} {' '.join(sys.argv[1:])}\n")
with open(log, encoding="utf-8") as starts:
    start = len(starts.readlines()) - 1
words = words.split(",")
word = words[min(start, len(words) - 1)]
line = socket.socket(fileno=3)
RECORD = 3 * 128  # behind header and indexes, each on a cache line of its own (rt/cache_line.hpp)


def wait_for_the_end():
    while line.recv(1):
        pass


if word == "exit":
    sys.exit(3)
if word == "fail":
    line.send(b"Fno \x1b[31mway\n")
    sys.exit(1)
if word == "silent":
    time.sleep(600)
if word in ("garbage", "count"):
    counts = mmap.mmap(8, 4096)
    if word == "garbage":
        counts[:] = os.urandom(4096)
    else:
        counts[RECORD:RECORD + 40] = struct.pack("<5Q", 1, 3, 2, 1, 1)
try:
    line.send(b"Ras \x1b[31mnever\n" if word == "remark" else b"R")
except BrokenPipeError:
    sys.exit(0)  # the test is over
if word == "beat":
    counts = mmap.mmap(8, 4096)
    line.settimeout(0.001)
    for beat in range(1, sys.maxsize):
        counts[RECORD:RECORD + 8] = struct.pack("<Q", beat)
        try:
            if not line.recv(1):
                sys.exit(0)
        except TimeoutError:
            pass
if word == "abort":
    time.sleep(0.05)
    signal.signal(signal.SIGABRT, signal.SIG_DFL)
    os.abort()
wait_for_the_end()
