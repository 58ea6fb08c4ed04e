#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""What one system has and another lacks stands in folders called Platform: only files there include headers of POSIX or of Windows, and
only they ask the compiler for the system. Each such folder has a source of the same name for every system.
"""
import pathlib
import re
import sys

ROOTS = ("BulletISTCollision", "BulletHapticForce", "TestSupport", "DeviceBridge", "demos")
# Headers of POSIX and of Linux that C++ does not have, and those of Windows.
HEADERS = re.compile(
    r"<((sys|linux|arpa|net|netinet)/.*|(unistd|fcntl|dlfcn|link|pthread|sched|termios|poll|spawn|netdb|dirent|glob|ftw|pwd|grp|semaphore"
    r"|signal|strings|utime|syslog|time|windows|winsock2?|ws2tcpip|io|direct|process|psapi)\.h)>", re.IGNORECASE)
MACROS = re.compile(r"\b(__linux__|__unix__|__APPLE__|_WIN32|_WIN64|__MINGW\w+)\b")
EXCEPTIONS = (
    "BulletHapticForce/Preload/",  # stands before functions of other libraries, as Linux's loader lets it
    "DeviceBridge/Drivers/Spnav/",  # the daemon of Linux, with a socket of the file system
    "DeviceBridge/Drivers/OpenXr/OpenXrSession.h",  # <time.h>, whose timespec OpenXR's own header names
    "DeviceBridge/Plugins/devicebridge_plugin.h",  # C, for makers of plug-ins: says how a function is exported
)


def faults_of_file(path, text):
    for number, line in enumerate(text.splitlines(), 1):
        header = re.match(r"\s*#\s*include\s+(<[^>]+>)", line)
        if header and HEADERS.match(header.group(1)):
            yield f"{path}:{number}: only files in a folder Platform may include {header.group(1)}"
        macro = re.match(r"\s*#\s*(el)?if", line) and MACROS.search(line)
        if macro:
            yield f"{path}:{number}: only files in a folder Platform may ask for {macro.group(1)}"


def faults(root):
    folders = set()
    for base in ROOTS:
        for file in sorted((root / base).rglob("*")):
            path = file.relative_to(root).as_posix()
            if file.is_dir() and file.name == "Platform":
                folders.add(file)
            if file.suffix in (".h", ".cpp", ".c") and "/Platform/" not in path and not path.startswith(EXCEPTIONS):
                yield from faults_of_file(path, file.read_text())
    for folder in sorted(folders):
        posix, windows = ({f.name for f in (folder / system).glob("*.cpp")} for system in ("Posix", "Windows"))
        for name in sorted(posix ^ windows):
            yield f"{folder.relative_to(root)}: {name} is missing in {'Windows' if name in posix else 'Posix'}"


if __name__ == "__main__":
    found = list(faults(pathlib.Path(sys.argv[1])))
    print("\n".join(found) or "headers and macros of systems are only in folders Platform")
    sys.exit(1 if found else 0)
