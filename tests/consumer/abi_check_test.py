#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""packaging/abi_check.sh on small libraries: it lets pass what is the same or only more, and stops what would break a program.
Usage: abi_check_test.py SCRIPT CXX"""
import pathlib
import shutil
import subprocess
import sys
import tempfile

HEADER = "struct Wrench {{ double force[3]; {member} }};\ndouble sum(const Wrench& w);\n{more}"
SOURCE = '#include "wrench.h"\ndouble sum(const Wrench& w) {{ return w.force[0] + w.force[1] + w.force[2]; }}\n{more}'
MORE = "double twice(double x)"


def install(prefix, cxx, member="", more=False, soname="libsmall.so.0.1"):
    for folder in ("include", "lib"):
        (prefix / folder).mkdir(parents=True)
    (prefix / "include/wrench.h").write_text(HEADER.format(member=member, more=MORE + ";\n" if more else ""))
    source = prefix / "small.cpp"
    source.write_text(SOURCE.format(more=MORE + " { return 2 * x; }\n" if more else ""))
    library = prefix / "lib" / (soname + ".0")
    subprocess.run([cxx, "-g", "-shared", "-fPIC", f"-I{prefix}/include", f"-Wl,-soname,{soname}", source, "-o", library], check=True)
    (prefix / "lib" / soname).symlink_to(library.name)
    return prefix


def commit(checkout, subject):
    subprocess.run(["git", "-C", checkout, "add", "-A"], check=True)
    who = ["-c", "user.name=test", "-c", "user.email=test@example.org"]
    subprocess.run(["git", "-C", checkout, *who, "commit", "-q", "-m", subject], check=True)
    return subprocess.run(["git", "-C", checkout, "rev-parse", "HEAD"], check=True, capture_output=True, text=True).stdout.strip()


def main():
    script, cxx = sys.argv[1:]
    if not shutil.which("abidiff"):
        print("skipped: no abidiff (apt-get install abigail-tools)")
        return 77
    wrong = []
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        old, larger = install(folder / "old", cxx), install(folder / "larger", cxx, more=True)
        cases = {"the same": (old, install(folder / "same", cxx), 0),
                 "a function more": (old, larger, 0),
                 "a function less": (larger, old, 1),
                 "a larger struct": (old, install(folder / "struct", cxx, member="double torque[3];"), 1),
                 "a larger struct under another soname": (
                     old, install(folder / "soname", cxx, member="double torque[3];", soname="libsmall.so.0.2"), 0)}
        for case, (before, after, expected) in cases.items():
            done = subprocess.run(["bash", script, "--installed", before, after], capture_output=True, text=True)
            if done.returncode != expected:
                wrong.append(f"{case}: status {done.returncode}, expected {expected}\n{done.stdout}{done.stderr}")
        if subprocess.run(["bash", script, "--installed", old], capture_output=True).returncode != 2:
            wrong.append("one prefix is not refused as wrong usage")
        checkout = folder / "checkout"
        (checkout / "packaging").mkdir(parents=True)
        shutil.copy(script, checkout / "packaging")
        subprocess.run(["git", "init", "-q", checkout], check=True)
        done = subprocess.run(["bash", checkout / "packaging" / pathlib.Path(script).name, "--release"], capture_output=True, text=True)
        if done.returncode != 77 or "no release yet" not in done.stderr:
            wrong.append(f"a checkout without a release: status {done.returncode}, expected 77\n{done.stderr}")
        commits = []
        for version in ("0.1.0", "0.2.0"):
            (checkout / "CMakeLists.txt").write_text("cmake_minimum_required(VERSION 3.25)\n"
                                                     f"project(BulletHaptics VERSION {version} LANGUAGES NONE)\n"
                                                     "install(FILES CMakeLists.txt DESTINATION share)\n")
            commits.append(commit(checkout, version))
        (checkout / "CMakeLists.txt").write_text((checkout / "CMakeLists.txt").read_text() + "# later\n")
        commit(checkout, "later")
        done = subprocess.run(["bash", checkout / "packaging" / pathlib.Path(script).name, "--release"], capture_output=True, text=True)
        if done.returncode != 0 or f"against {commits[1]}" not in done.stdout:
            wrong.append("without tags the commit that set the version is not the base: "
                         f"status {done.returncode}\n{done.stdout}{done.stderr}")
    print("\n".join(wrong))
    return bool(wrong)


sys.exit(main())
