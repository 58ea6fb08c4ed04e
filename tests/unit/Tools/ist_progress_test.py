#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Progress, interruption and failed writes of the ist command. Usage: ist_progress_test.py PATH_TO_IST"""
import fcntl
import os
import pty
import re
import resource
import signal
import struct
import subprocess
import sys
import tempfile
import termios
import time

IST = sys.argv[1]
CUBE = """v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1
f 1 4 3 2\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n"""
STAGES = ["import", "repair", "packing", "cells", "surface", "field", "tree", "write"]
failures = []


def expect(condition, what):
    if not condition:
        failures.append(what)


def build(folder, output, *options):
    return [IST, "build", os.path.join(folder, "cube.obj"), "-o", output, *options]


def lines_every_ten_per_cent(folder):
    out = os.path.join(folder, "lines.ist")
    text = subprocess.run(build(folder, out, "--spheres", "300"), capture_output=True, text=True).stderr
    shown = [re.fullmatch(r"(\w+) (\d+) %", line) for line in text.splitlines()]
    expect(all(shown), "only progress on stderr: " + text)
    stages = [m[1] for m in shown]
    expect(list(dict.fromkeys(stages)) == STAGES, f"stages in order: {stages}")
    for stage in STAGES:
        steps = [int(m[2]) for m in shown if m[1] == stage]
        expect(steps == sorted(set(steps)) and all(s % 10 == 0 for s in steps), f"{stage}: {steps}")
        expect(steps[-1:] == [100], f"{stage} ends: {steps}")
    quiet = subprocess.run(build(folder, out, "--spheres", "50", "--quiet"), capture_output=True, text=True)
    expect(quiet.stdout == "" and quiet.stderr == "", "--quiet says nothing")


def read_until(terminal, pattern):
    """The first match in what is written to the terminal, or None when that ends."""
    text = ""
    while True:
        try:
            more = os.read(terminal, 4096).decode()
        except OSError:  # the other end is closed
            return None
        text += more
        if match := re.search(pattern, text):
            return match[0]
        if not more:
            return None


def bar_with_the_time_left(folder):
    """One bar of the whole build stands on a terminal and keeps to its width. The time left comes after half a second.

    A narrow terminal has no bar.
    """
    leader, follower = pty.openpty()
    process = None
    for columns, bar in [(70, r"\[#* *\] +"), (44, " *")]:
        fcntl.ioctl(leader, termios.TIOCSWINSZ, struct.pack("4H", 24, columns, 0, 0))
        if not process:
            process = subprocess.Popen(build(folder, os.path.join(folder, "bar.ist"), "--spheres", "100000", "--threads", "1"),
                                       stdout=subprocess.DEVNULL, stderr=follower)
            os.close(follower)
        line = read_until(leader, rf"(?<=\r)packing +{bar}\d+ %  \d+ (s|min \d\d s|h \d\d min) left(?=\x1b)")
        expect(line and len(line) < columns, f"a bar with the time left in {columns} columns: {line}")
    process.send_signal(signal.SIGINT)
    # Nobody reads the terminal any more: closing it keeps the command from waiting for that.
    os.close(leader)
    expect(process.wait() == 130, "130 after the interruption")


def a_bar_of_a_stage_where_the_end_is_not_known(folder):
    leader, follower = pty.openpty()
    process = subprocess.Popen(build(folder, os.path.join(folder, "bar.ist"), "--min-radius", "0.002", "--threads", "1"),
                               stdout=subprocess.DEVNULL, stderr=follower)
    os.close(follower)
    expect(read_until(leader, r" left of this stage"), "the time left of a stage")
    process.send_signal(signal.SIGINT)
    os.close(leader)
    process.wait()


def one_line_for_the_whole_build(folder):
    leader, follower = pty.openpty()
    process = subprocess.Popen(build(folder, os.path.join(folder, "bar.ist"), "--spheres", "300"),
                               stdout=subprocess.DEVNULL, stderr=follower)
    os.close(follower)
    text = ""
    try:
        while more := os.read(leader, 4096).decode():
            text += more
    except OSError:
        pass
    os.close(leader)
    expect(process.wait() == 0, "built")
    shares = [int(share) for share in re.findall(r"(\d+) %", text)]
    expect(text.count("\n") == 1 and shares == sorted(shares) and shares[-1] == 100, f"one line that ends at 100 %: {text!r}")


def interruption(folder, number):
    out = os.path.join(folder, "interrupted.ist")
    for stage, *options in [["import", "--spheres", "3000"], ["repair", "--spheres", "3000", "--repair", "wrap"],
                            ["packing", "--spheres", "500000"], ["cells", "--spheres", "3000"]]:
        process = subprocess.Popen(build(folder, out, *options), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        for line in process.stderr:
            if line.startswith(stage):
                process.send_signal(number)
                break
        stdout, stderr = process.communicate()
        expect(process.returncode == 130, f"{stage}: exit {process.returncode} after signal {number}")
        expect("interrupted; nothing was written" in stderr, f"{stage}: {stderr}")
        expect(stdout == "", f"{stage}: no report")
    # As a terminal does it: the process that reads the mesh has it, too.
    process = subprocess.Popen(build(folder, out), stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
    process.stderr.readline()
    os.killpg(process.pid, number)
    stderr = process.communicate()[1]
    expect(process.returncode == 130 and "interrupted; nothing was written" in stderr,
           f"a group: exit {process.returncode} after signal {number}: {stderr}")
    expect(not [f for f in os.listdir(folder) if f.startswith("interrupted")], "an interrupted build leaves no file")


def interrupted_reading(folder, number):
    """Of a mesh that nobody writes: by the signal to all processes, as a terminal sends it, and to the first alone."""
    pipe, cube = os.path.join(folder, "pipe.obj"), os.path.join(folder, "lines.ist")
    os.mkfifo(pipe)
    for files in [[pipe, cube], [cube, pipe]]:
        for send in [os.killpg, os.kill]:
            process = subprocess.Popen([IST, "tune", *files, "--error", "0.2"],
                                       stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, start_new_session=True)
            time.sleep(0.5)
            send(process.pid, number)
            stdout, stderr = process.communicate()
            expect(process.returncode == 130, f"tune, reading: exit {process.returncode} after signal {number}: {stderr}")
            expect(stderr == "ist: interrupted\n" and stdout == "", f"tune, reading: {stdout} {stderr}")
    os.remove(pipe)


def interrupted_tuning(folder, number):
    """Between builds and while it measures, too: builds of 1,000, 3,000 ... spheres take turns with measurements."""
    cube = os.path.join(folder, "cube.obj")
    for seconds in [1, 1.7, 2.9]:
        process = subprocess.Popen([IST, "tune", cube, cube, "--error", "0.001", "--max-spheres", "10000000"],
                                   stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        time.sleep(seconds)
        process.send_signal(number)
        stdout, stderr = process.communicate()
        expect(process.returncode == 130, f"tune: exit {process.returncode} after signal {number}: {stderr}")
        expect("interrupted" in stderr and stdout == "", f"tune: {stdout} {stderr}")


def small_files():
    resource.setrlimit(resource.RLIMIT_FSIZE, (5000, 5000))


def failed_writes(folder):
    def fails(what, wanted, command, **how):
        result = subprocess.run(command, capture_output=True, text=True, **how)
        expect(result.returncode == 1, f"{what}: exit {result.returncode}")
        expect(wanted in result.stderr, f"{what}: {result.stderr}")

    before = sorted(os.listdir(folder))
    asset, cube = os.path.join(folder, "lines.ist"), ["--spheres", "300", "--quiet"]
    fails("a file too large", "too large", build(folder, os.path.join(folder, "cut.ist"), *cube), preexec_fn=small_files)
    fails("pack too large", "too large", [IST, "pack", asset, "-o", os.path.join(folder, "cut.ista")],
          preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100)))
    fails("leaves too large", "too large", [IST, "export", asset, "--leaves", os.path.join(folder, "cut.csv")], preexec_fn=small_files)
    fails("no folder", "No such file", build(folder, os.path.join(folder, "none", "a.ist"), *cube))
    fails("a folder", "directory", build(folder, folder, *cube))
    if os.path.exists("/dev/full"):
        fails("a full device", "No space left", build(folder, "/dev/full", *cube))
        with open("/dev/full", "w") as full:
            result = subprocess.run([IST, "info", asset, "--json"], stdout=full, stderr=subprocess.PIPE, text=True)
        expect(result.returncode == 1 and "standard output" in result.stderr, "a report that cannot be printed is an error")
    if os.geteuid() != 0:
        locked = os.path.join(folder, "locked")
        os.mkdir(locked, 0o500)
        fails("no permission", "Permission denied", build(folder, os.path.join(locked, "a.ist"), *cube))
        os.rmdir(locked)
    expect(sorted(os.listdir(folder)) == before, f"failed writes leave nothing: {os.listdir(folder)}")


with tempfile.TemporaryDirectory() as folder:
    with open(os.path.join(folder, "cube.obj"), "w") as mesh:
        mesh.write(CUBE)
    lines_every_ten_per_cent(folder)
    failed_writes(folder)
    bar_with_the_time_left(folder)
    a_bar_of_a_stage_where_the_end_is_not_known(folder)
    one_line_for_the_whole_build(folder)
    for number in [signal.SIGINT, signal.SIGTERM]:
        interruption(folder, number)
        interrupted_reading(folder, number)
        interrupted_tuning(folder, number)

print("\n".join("FAILED " + f for f in failures) or "all passed")
sys.exit(1 if failures else 0)
