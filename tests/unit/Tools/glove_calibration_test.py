#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Runs `devicebridge calibrate` on a glove of 18 sensors behind a pseudo terminal. Arguments: the command, the file to write."""
import json
import os
import pty
import subprocess
import sys
import threading
import time
import tty

command, output = sys.argv[1:]
ours, theirs = pty.openpty()
tty.setraw(theirs)
values = [60] * 18
ending = False


def stream():
    sending = False
    os.set_blocking(ours, False)
    while not ending:
        try:
            for byte in os.read(ours, 100):
                sending = byte == ord("S") or (sending and byte != 3)
        except BlockingIOError:
            pass
        if sending:
            try:
                os.write(ours, b"S" + bytes(values) + b"\0")
            except BlockingIOError:
                pass
        time.sleep(0.002)


glove = threading.Thread(target=stream)
glove.start()
try:
    run = subprocess.Popen([command, "calibrate", "glove:" + os.ttyname(theirs), "-o", output],
                           stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert "flat" in run.stderr.readline()
    run.stdin.write("\n")
    run.stdin.flush()
    assert "fist" in run.stderr.readline()
    values = [160] * 18
    run.stdin.write("\n")
    run.stdin.flush()
    assert run.wait(60) == 0, run.stderr.read()
    sensors = json.load(open(output))["sensors"]
    assert len(sensors) == 22
    assert sensors["index_knuckle"]["offset"] == 60
    assert abs(sensors["index_knuckle"]["gain"] * 100 - 1.5707963) < 1e-6  # a quarter turn over 100 steps
    info = subprocess.run([command, "info", f"glove:{os.ttyname(theirs)}?calibration={output}", "--json"],
                          capture_output=True, text=True, timeout=60)
    assert info.returncode == 0, info.stderr
    assert json.loads(info.stdout)["sensed"] == ["hand"]
finally:
    ending = True
    glove.join()
