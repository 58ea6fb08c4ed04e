#!/usr/bin/env python3
# SPDX-License-Identifier: Zlib
"""Runs the blocks of a page that begin with ```sh, as one script in an empty folder.

Usage: run_shell.py PAGE FOLDER_OF_COMMANDS...
Exit code 0 if every command of the blocks ends with 0. `! COMMAND` must fail.
"""
import os
import pathlib
import re
import subprocess
import sys
import tempfile


def main() -> int:
    page, *folders = sys.argv[1:]
    blocks = re.findall(r"^```sh\n(.*?)^```$", pathlib.Path(page).read_text(encoding="utf-8"), re.M | re.S)
    if not blocks:
        print(f"{page} has no block of commands")
        return 1
    # With -e alone, a command behind ! could succeed unnoticed.
    script = re.sub(r"^! (.*?)( +#.*)?$", r"if \1; then exit 1; fi", "set -ex\n" + "".join(blocks), flags=re.M)
    environment = dict(os.environ, PATH=os.pathsep.join([*folders, os.environ["PATH"]]))
    with tempfile.TemporaryDirectory() as folder:
        return subprocess.run(["bash", "-c", script], cwd=folder, env=environment, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
