#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Builds trees of damaged copies of mesh files by a built program, with its importer: damaged_files.py IST FILE... [--runs N] [--seed N].

The same seed makes the same damages: bytes changed, the end cut off, a span removed, doubled or overwritten by another. The script
reports each damage on which the program ends otherwise than with 0 or 1, has a report of a sanitizer, takes too long, refuses it and
leaves a file, or writes a tree that `ist check` refuses. Copies that are reported are kept in the folder of --keep. Reports in assimp are
listed and do not count, because it runs in a process of its own."""
import argparse
import collections
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import tempfile


def damaged(data, rng):
    data = bytearray(data)
    for _ in range(rng.choice((1, 1, 1, 2, 4))):
        if not data:
            break
        begin = rng.randrange(len(data))
        end = min(len(data), begin + int(2 ** rng.uniform(0, 12)))
        kind = rng.choice(("bit", "byte", "digit", "cut", "remove", "double", "overwrite"))
        if kind == "bit":
            data[begin] ^= 1 << rng.randrange(8)
        elif kind == "byte":
            data[begin] = rng.randrange(256)
        elif kind == "digit":
            # A number with another digit is what a text format believes.
            digits = [m.start() for m in re.finditer(rb"\d", bytes(data[begin:begin + 4096]))]
            if digits:
                data[begin + rng.choice(digits)] = ord(rng.choice("0123456789-e"))
        elif kind == "cut":
            del data[begin:]
        elif kind == "remove":
            del data[begin:end]
        elif kind == "double":
            data[end:end] = data[begin:end]
        else:
            other = rng.randrange(len(data))
            data[begin:end] = data[other:other + end - begin]
    return bytes(data)


def processor_seconds():
    """Of the programs that have ended: another program that is busy does not count."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def complaint(args, path, folder):
    """What is wrong about one run, or nothing; and its outcome in a word."""
    out = folder / "out.ist"
    command = [args.ist, "build", path, "-o", out, "--spheres", str(args.spheres), "--threads", "1", "--json"]
    if args.only_read:
        command = [args.ist, args.only_read, "surface", "stated", path]
    limit = int(10 * args.seconds)  # so that how long a slow one takes is known
    run = subprocess.run(command, capture_output=True, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 1)))
    if run.returncode in (-signal.SIGXCPU, -signal.SIGKILL):
        # The importer limits itself, and ist says so.
        return (None, "out of time") if args.only_read else (f"no end after {limit} s of processor time", "hang")
    errors = run.stderr.decode(errors="replace")
    for mark in ("ERROR: AddressSanitizer", "runtime error:", "ERROR: LeakSanitizer"):
        if mark in errors:
            frames = [line for line in errors[errors.index(mark):].splitlines() if re.match(r"\s+#\d+ ", line)]
            frames = [line for line in frames if "libasan" not in line and "sanitizer" not in line]
            where = "assimp" if frames and "libassimp" in frames[0] else "ours"
            return f"{where}: " + next(line for line in errors.splitlines() if mark in line), "report"
    if run.returncode not in (0, 1):
        return f"code {run.returncode}: {errors[-300:]}", "crash"
    left = [entry.name for entry in folder.iterdir() if entry not in (path, out)]
    if left or (run.returncode == 1 and out.exists()):
        return f"left behind: {left or out.name}", "left"
    if run.returncode == 1:
        return None, "refused"
    if args.only_read:
        return None, "answered"
    check = subprocess.run([args.ist, "check", out], capture_output=True)
    out.unlink()
    return (None, "built") if check.returncode == 0 else ("tree refused: " + check.stderr.decode(errors="replace")[-300:], "bad tree")


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("ist")
    parser.add_argument("files", nargs="+", type=pathlib.Path)
    parser.add_argument("--runs", type=int, default=200, help="damages of each file")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first damage")
    parser.add_argument("--spheres", type=int, default=100)
    parser.add_argument("--seconds", type=float, default=20, help="longest processor time of a run")
    parser.add_argument("--only-read", metavar="VERSION", help="IST is the program bullethaptics-import of this release")
    parser.add_argument("--keep", type=pathlib.Path, help="folder for the copies that are reported")
    args = parser.parse_args()
    wrong = 0
    for file in args.files:
        data = file.read_bytes()
        outcomes, longest = collections.Counter(), 0
        for run in range(args.first, args.first + args.runs):
            with tempfile.TemporaryDirectory() as name:
                folder = pathlib.Path(name)
                path = folder / ("damaged" + file.suffix)
                path.write_bytes(damaged(data, random.Random(f"{args.seed} {file.name} {run}")))
                begin = processor_seconds()
                what, outcome = complaint(args, path, folder)
                took = processor_seconds() - begin
                if not what and took > args.seconds:
                    what, outcome = f"took {took:.0f} s", "slow"
                outcomes[outcome] += 1
                longest = max(longest, took)
                if what:
                    wrong += not what.startswith("assimp")
                    print(f"{file.name} damage {run}: {what}", flush=True)
                    if args.keep:
                        args.keep.mkdir(parents=True, exist_ok=True)
                        shutil.copy(path, args.keep / f"{file.stem}_{run}{file.suffix}")
        print(f"{file.name}: " + ", ".join(f"{count} {word}" for word, count in sorted(outcomes.items())) + f"; longest {longest:.1f} s",
              flush=True)
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
